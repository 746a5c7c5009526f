/// A 64-bit fingerprint of bytes: multiply and shift, eight bytes at a time.
#include "base/digest.h"

#include <string.h>

/// Every bit of a word reaches every bit of the result (the finaliser of SplitMix64, Steele et al. 2014).
static uint64_t mix(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

static uint64_t little_endian(const unsigned char *at, size_t n) {
  uint64_t word = 0;
  for (size_t i = 0; i < n; i++) word |= (uint64_t)at[i] << (8 * i);
  return word;
}

uint64_t lth_digest(const void *data, size_t size, uint64_t seed) {
  const unsigned char *at = data;
  uint64_t digest = mix(seed ^ 0x9E3779B97F4A7C15u);
  for (size_t left = size; left > 0;) {
    size_t n = left < 8 ? left : 8;
    digest = mix(digest * 3 + little_endian(at, n)); // odd factor: no word of data is lost
    at += n;
    left -= n;
  }
  return mix(digest ^ (uint64_t)size);
}

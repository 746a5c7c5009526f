/// Numbers in binary files of either byte order, from and to unaligned bytes.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

static inline uint64_t lth_bytes_unsigned(const char *at, int n, bool is_big_endian) {
  uint64_t value = 0;
  for (int i = 0; i < n; i++)
    value |= (uint64_t)(unsigned char)at[is_big_endian ? n - 1 - i : i] << (8 * i);
  return value;
}

static inline uint32_t lth_bytes_u32(const char *at, bool is_big_endian) {
  return (uint32_t)lth_bytes_unsigned(at, 4, is_big_endian);
}

static inline float lth_bytes_f32(const char *at, bool is_big_endian) {
  uint32_t bits = lth_bytes_u32(at, is_big_endian);
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static inline double lth_bytes_f64(const char *at, bool is_big_endian) {
  uint64_t bits = lth_bytes_unsigned(at, 8, is_big_endian);
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/// Little endian, as all binary files here are written.
static inline void lth_bytes_put_u32(uint32_t value, char *at) {
  for (int i = 0; i < 4; i++) at[i] = (char)(value >> (8 * i) & 0xff);
}

static inline void lth_bytes_put_f32(float value, char *at) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  lth_bytes_put_u32(bits, at);
}

/// Fuzz target: .mhd and .mha files.
#include "fuzz_volume.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_volume("mhd", data, size);
}

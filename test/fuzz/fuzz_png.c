/// Fuzz target: .png files.
#include "fuzz_volume.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_volume("png", data, size);
}

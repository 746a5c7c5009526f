/// Fuzz target: .off files.
#include "fuzz_surface.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_surface("off", data, size);
}

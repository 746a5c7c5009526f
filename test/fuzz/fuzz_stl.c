/// Fuzz target: .stl files.
#include "fuzz_surface.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_surface("stl", data, size);
}

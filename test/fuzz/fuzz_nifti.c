/// Fuzz target: .nii and .nii.gz files.
#include "fuzz_volume.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  return fuzz_volume("nii", data, size);
}

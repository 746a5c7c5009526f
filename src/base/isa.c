/// Which instruction set this processor has.
#include "base/isa.h"

LthIsa lth_isa(void) {
#ifdef LTH_X86_LEVELS
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") ||
      !__builtin_cpu_supports("bmi") || !__builtin_cpu_supports("bmi2"))
    return LTH_ISA_BASE;
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512cd"))
    return LTH_ISA_V4;
  return LTH_ISA_V3;
#else
  return LTH_ISA_BASE;
#endif
}

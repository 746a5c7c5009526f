/// The block kernels of the instruction sets: blocks of 16 x 16 and of 8 x 8 x 8 cells.
#include "disc/staggered/staggered_fast.h"

#define TABLES(isa) extern const LthFastKernels lth_fast_kernels_2d_##isa, lth_fast_kernels_3d_##isa
TABLES(base);
#ifdef LTH_X86_LEVELS
TABLES(v3);
TABLES(v4);
#endif

const LthFastKernels *lth_fast_kernels_for(int dim, LthIsa isa) {
  static const LthFastKernels *const all[LTH_N_ISAS][2] = {
      [LTH_ISA_BASE] = {&lth_fast_kernels_2d_base, &lth_fast_kernels_3d_base},
#ifdef LTH_X86_LEVELS
      [LTH_ISA_V3] = {&lth_fast_kernels_2d_v3, &lth_fast_kernels_3d_v3},
      [LTH_ISA_V4] = {&lth_fast_kernels_2d_v4, &lth_fast_kernels_3d_v4},
#endif
  };
  return isa > lth_isa() ? NULL : all[isa][dim == 3];
}

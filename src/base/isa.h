/// Instruction sets that kernels of fixed register widths are compiled for, one file each; LTH_CLONES (clones.h) leaves
/// the width to the compiler.
#pragma once

#if defined(__x86_64__)
#define LTH_X86_LEVELS // cmake/lithe_options.cmake compiles for them
#endif

/// In the order of register widths: 16, 32 and 64 bytes.
typedef enum LthIsa { LTH_ISA_BASE, LTH_ISA_V3, LTH_ISA_V4, LTH_N_ISAS } LthIsa;

/// The widest that this build holds and this processor has.
LthIsa lth_isa(void);

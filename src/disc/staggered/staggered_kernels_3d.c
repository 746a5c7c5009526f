/// The block kernels in 3D: blocks of 8 x 8 x 8 cells.
#define DIM 3
#define SUFFIX 3d
#include "disc/staggered/staggered_blocks.h"

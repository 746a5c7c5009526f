/// The block kernels in 2D: blocks of 16 x 16 cells.
#define DIM 2
#define SUFFIX 2d
#include "disc/staggered/staggered_blocks.h"

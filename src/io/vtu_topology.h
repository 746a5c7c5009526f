/// The compressed cells and faces of a VTU file, kept between the files of a moving body.
#pragma once

#include "io/vtu.h"
#include "io/vtu_block.h"

#define LTH_VTU_TOPOLOGY_ARRAYS 5

/// connectivity, offsets, types, faces, faceoffsets, in this order.
struct LthVtuTopology {
  LthVtuBlock block[LTH_VTU_TOPOLOGY_ARRAYS];
};

/// Bodies made of mapped blocks: their surface as a file to slice, and conforming meshes of them as files.
#pragma once

#include "study/study_run.h"

/// Place x of `at` in the unit cube of a block. Blocks meet where they give the same places.
typedef void (*LthBlockMap)(int block, const double at[3], double x[3]);

typedef struct LthBlockModel {
  int n_blocks;
  LthBlockMap map;
  int cells[3]; ///< of a block along its axes at level 1
  bool is_flat; ///< finer levels have as many along the third
} LthBlockModel;

/// Write the body's outer sides as quadrilaterals, FOLDER/<name>.obj, with `level` times the cells of level 1.
LitheStatus lth_block_model_surface(LthStudyRun *run, const LthBlockModel *model, int level,
                                    const char *name);

/// Write FOLDER/<name>.msh: hexahedra with 8 (order 1) or 27 nodes (order 2), whose edges are curved with the map.
LitheStatus lth_block_model_mesh(LthStudyRun *run, const LthBlockModel *model, int level, int order,
                                 const char *name);

/// The head of a `.vtu` file: how its values are written, and which arrays it has.
#pragma once

#include "io/vtu_array.h"

typedef enum LthVtuSection {
  LTH_VTU_ELSEWHERE,
  LTH_VTU_POINTS,
  LTH_VTU_CELLS,
  LTH_VTU_POINT_DATA,
  LTH_VTU_CELL_DATA
} LthVtuSection;

typedef struct LthVtuHead {
  LthVtuCoding coding;
  LitheCount n_points, n_cells;
  LitheIndex n_arrays;
  LitheCount cap_arrays, cap_sections;
  LthVtuSource *arrays;    ///< (n_arrays)
  LthVtuSection *sections; ///< (n_arrays)
} LthVtuHead;

LitheStatus lth_vtu_head_parse(LitheCtx *ctx, const char *name, const char *data, size_t size,
                               LthVtuHead *head);
void lth_vtu_head_free(LitheCtx *ctx, LthVtuHead *head);

/// An array by section and name (NULL: the first); NULL where there is none.
const LthVtuSource *lth_vtu_find(const LthVtuHead *head, LthVtuSection section, const char *name);

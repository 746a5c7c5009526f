/// What VTK's XML files of all kinds have in common: tags, arrays, the appended section.
#pragma once

#include "io/vtu_block.h"

#include <stdio.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
#define LTH_VTK_BYTE_ORDER "BigEndian"
#else
#define LTH_VTK_BYTE_ORDER "LittleEndian"
#endif

/// A cell or point array of a file.
typedef struct LthVtuArray {
  const char *name;
  int components; ///< 1, 3, 9, or 6: a symmetric tensor xx yy zz yz zx xy (VTK's order in the file)
  const double *data; ///< (n x components); NULL: rows are computed as they are written
  void (*value)(const void *self, LitheCount row, double *to); ///< by this; thread-safe
  const void *self;
} LthVtuArray;

/// An array of values that are there.
static inline LthVtuArray lth_vtk_array(const char *name, int components, const double *data) {
  return (LthVtuArray){.name = name, .components = components, .data = data};
}

#define LTH_VTK_COMPONENTS 9 ///< most of an array

/// A row of an array; where it is computed, `to` is room for it.
static inline const double *lth_vtk_row(const LthVtuArray *array, LitheCount row,
                                        double to[LTH_VTK_COMPONENTS]) {
  if (array->data) return array->data + row * array->components;
  array->value(array->self, row, to);
  return to;
}

/// Place in the file of component k of `components`: that of ours.
int lth_vtk_component(int components, int k);

/// Convert n rows to floats and compress them, piece by piece.
LitheStatus lth_vtk_encode_array(LitheCtx *ctx, LitheCount n, const LthVtuArray *array,
                                 LthVtuBlock *block);
LitheStatus lth_vtk_encode_rows(LitheCtx *ctx, LitheCount n, int components, const double *data,
                                LthVtuBlock *block);

/// `<VTKFile type="...">`, and what closes it.
void lth_vtk_put_opening(FILE *out, const char *type);
void lth_vtk_put_end(FILE *out);

void lth_vtk_put_time(FILE *out, double time); ///< the file's TimeValue [s]

/// One DataArray element, or those of a section; `offset` moves on by the blocks' bytes.
void lth_vtk_put_array(FILE *out, const char *type, const char *name, int components,
                       const LthVtuBlock *block, LitheCount *offset);
void lth_vtk_put_arrays(FILE *out, const char *section, int n, const LthVtuArray *arrays,
                        const LthVtuBlock *blocks, LitheCount *offset);

/// Open the appended section; blocks then follow in the order of their tags.
void lth_vtk_put_appended(FILE *out);
void lth_vtk_put_block(FILE *out, const LthVtuBlock *block);

/// Growing a polygon soup point by point and polygon by polygon: what all surface readers share.
#pragma once

#include "geometry/surface.h"
#include "io/text.h"

typedef struct LthSoupBuilder {
  LitheCtx *ctx;
  const char *name; ///< of the file, for messages
  LthSoup *soup;    ///< arrays have room to grow; counts are kept right
  LitheCount n_corners;
  LitheCount point_cap, off_cap, corner_cap, corner_uv_cap, uv_cap, group_cap, poly_group_cap;
  LitheIndex *group_slots; ///< open hash table of group names: index + 1, 0 free
  LitheCount n_group_slots;
  LitheIndex group; ///< of polygons to come, -1 while the file has named none
} LthSoupBuilder;

LitheStatus lth_soup_builder_open(LitheCtx *ctx, const char *name, LthSoupBuilder *builder);
/// Free everything, also the soup if it was not taken.
void lth_soup_builder_close(LthSoupBuilder *builder);

LitheStatus lth_soup_add_point(LthSoupBuilder *builder, const double x[3]);
LitheStatus lth_soup_add_uv(LthSoupBuilder *builder, const double uv[2]);
/// A corner of the polygon being built; `uv` is -1 where it has none.
LitheStatus lth_soup_add_corner(LthSoupBuilder *builder, LitheIndex point, LitheIndex uv);
LitheStatus lth_soup_end_polygon(LthSoupBuilder *builder);
/// Polygons to come belong to the group of this name.
LitheStatus lth_soup_set_group(LthSoupBuilder *builder, LthWord name);

/// Hand the soup over. LITHE_BAD_INPUT where it has no polygons.
LitheStatus lth_soup_builder_take(LthSoupBuilder *builder, LthSoup **soup);

/// The readers: all parse a whole file in memory and fill the builder.
LitheStatus lth_obj_parse(LthSoupBuilder *builder, const char *data, size_t size);
LitheStatus lth_stl_parse(LthSoupBuilder *builder, const char *data, size_t size);
LitheStatus lth_ply_parse(LthSoupBuilder *builder, const char *data, size_t size);
LitheStatus lth_off_parse(LthSoupBuilder *builder, const char *data, size_t size);

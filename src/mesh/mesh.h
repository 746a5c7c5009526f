/// The polyhedral mesh: planar face pieces, each owned by exactly one cell (boundary) or two.
#pragma once

#include "base/ctx.h"
#include "geometry/moments.h"
#include "geometry/surface.h"

/// A named set of cells or of boundary faces, from a mesh file (`where: {label: name}`).
typedef struct LthMeshGroup {
  char *name;
  LitheIndex tag; ///< number in the file, -1: none
  bool of_cells;  ///< else of boundary faces
  LitheIndex n;
  LitheIndex *member; ///< ascending
} LthMeshGroup;

/// Immutable once built; safe to read from many threads. Conventions, once and completely:
/// a face has loops; its outer loops run counter-clockwise seen from outside face_cell[2f] (the owner),
/// holes clockwise; face_normal points out of the owner, into the neighbour face_cell[2f + 1], which is
/// -1 beyond the boundary. owner < neighbour for inner faces. Two cells may share several faces (of
/// different planes, or apart in one plane). face_tag is the surface triangle a boundary face was cut from, else -1.
typedef struct LthMesh {
  LitheIndex n_points, n_faces, n_cells;
  double *points;              ///< [m]                                        (n_points x 3)
  LitheIndex n_surface_points; ///< the first points are those of the sliced surface, in its order
  uint8_t
      *point_rank; ///< number of grid planes through a point: 2 and 3 are coarse nodes (n_points)
  LitheIndex *face_loop_off; ///< (n_faces + 1) loops of a face
  LitheIndex *loop_off;      ///< (n_loops + 1) points of a loop
  LitheIndex *loop_point;    ///< (loop_off[n_loops])
  LitheIndex *face_cell;     ///< owner, neighbour or -1                     (n_faces x 2)
  double *face_normal;       ///< unit                                       (n_faces x 3)
  double *face_area;         ///< [m^2]                                      (n_faces)
  double *face_centroid;     ///< [m]                                        (n_faces x 3)
  LitheIndex *face_tag;      ///< (n_faces)
  LitheIndex *cell_face_off; ///< (n_cells + 1) faces of a cell, ascending
  LitheIndex *cell_face;
  double *cell_volume;   ///< [m^3]                                      (n_cells)
  double *cell_centroid; ///< [m]                                        (n_cells x 3)
  double *cell_box;      ///< bounding box min, max [m]                  (n_cells x 6)
  double cell_size;      ///< typical edge of a full cell [m]
  LitheIndex n_merged;   ///< slivers that were merged into a neighbour
  LthMeshGroup *groups;  ///< empty but for meshes from files
  LitheIndex n_groups;
} LthMesh;

void lth_mesh_destroy(LitheCtx *ctx, LthMesh **mesh);

/// Smallest box along the axes that holds the mesh [m].
void lth_mesh_bounds(const LthMesh *mesh, double min[3], double max[3]);

/// The loops of face f.
LthFaceView lth_mesh_face(const LthMesh *mesh, LitheIndex f);

/// The boundary as polygons of its own points, outward; every face one polygon. For meshes whose faces have one
/// loop each, as those from files have. Free with lth_soup_destroy().
LitheStatus lth_mesh_boundary_soup(LitheCtx *ctx, const LthMesh *mesh, LthSoup **soup);

/// Parts that hang together through inner faces: that of each cell (n_cells), numbered by their first cells; and how many.
LitheStatus lth_mesh_parts(LitheCtx *ctx, const LthMesh *mesh, LitheIndex *part, LitheIndex *n);

/// +1 where face f's normal points out of cell, -1 where it points in.
static inline double lth_mesh_side(const LthMesh *mesh, LitheIndex f, LitheIndex cell) {
  return mesh->face_cell[2 * f] == cell ? 1.0 : -1.0;
}

/// What a mesh is built from; everything is copied. Areas, normals, centroids, volumes, boxes and the
/// cell-to-face lists are computed.
typedef struct LthMeshDef {
  LitheIndex n_points, n_faces, n_cells, n_surface_points;
  const double *points;
  const uint8_t *point_rank; ///< NULL: all 3
  const LitheIndex *face_loop_off, *loop_off, *loop_point, *face_cell;
  const LitheIndex *face_tag; ///< NULL: all -1
  double cell_size;
  LitheIndex n_merged;
} LthMeshDef;

/// Build and check a mesh. LITHE_BAD_INPUT: a cell that is not closed or has no volume (names it).
LitheStatus lth_mesh_create(LitheCtx *ctx, const LthMeshDef *def, LthMesh **mesh);

/// Lists of a definition, of lth_alloc().
typedef struct LthMeshLists {
  double *points;
  LitheIndex *face_loop_off, *loop_off, *loop_point, *face_cell;
} LthMeshLists;

/// The same of lists that become the mesh's own: those of `def` are not read, the others are copied. `lists` is empty then, also
/// after a failure.
LitheStatus lth_mesh_create_of(LitheCtx *ctx, const LthMeshDef *def, LthMeshLists *lists,
                               LthMesh **mesh);

/// A regular grid of planes.
typedef struct LthGrid {
  double min[3], max[3]; ///< [m]
  LitheIndex cells[3];
} LthGrid;

/// Position of plane k of an axis; first and last exactly min and max.
double lth_grid_plane(const LthGrid *grid, int axis, LitheIndex k);

/// Hexahedra of a grid (its whole box is the body), and six tetrahedra to each cell (Kuhn).
LitheStatus lth_mesh_hexahedra(LitheCtx *ctx, const LthGrid *grid, LthMesh **mesh);
LitheStatus lth_mesh_tetrahedra(LitheCtx *ctx, const LthGrid *grid, LthMesh **mesh);

/// Cut the solid inside `surface` into polyhedra by the planes of `grid` (Kaufmann et al. 2009, section
/// 9.2). Parts of the solid beyond the grid's box belong to the outermost cells. Cells that hold several
/// separate pieces give several elements. Elements below `sliver` times a full cell's volume are merged
/// into the neighbour with the largest common face (0 keeps all but those of no volume).
LitheStatus lth_mesh_slice(LitheCtx *ctx, const LthSurface *surface, const LthGrid *grid,
                           double sliver, LthMesh **mesh);

/// What `lithe mesh` reports.
typedef struct LthMeshQuality {
  LitheIndex n_elements, n_faces, n_inner_faces, n_boundary_faces, n_merged, n_components;
  double volume, surface_area, min_volume, max_volume;
  double max_gap;    ///< largest |sum of area normal| of an element over its area
  double max_aspect; ///< largest ratio of box edges
} LthMeshQuality;

LitheStatus lth_mesh_quality(LitheCtx *ctx, const LthMesh *mesh, LthMeshQuality *quality);

/// A polyhedral mesh that changes: cells are split by planes, parted along faces and merged, at a cost that is
/// proportional to what is touched (Kaufmann et al. 2009, sections 9.2 to 9.6; docs/develop/topology.md).
#pragma once

#include "base/archive.h"
#include "mesh/mesh.h"
#include "mesh/piece.h"

/// Tag of the faces that cut k = 0, 1, 2, ... made: LTH_TAG_CUT - k.
#define LTH_TAG_CUT (-2)

/// A planar face piece. Its outer loops run counter-clockwise about the normal, holes clockwise.
typedef struct LthTopologyFace {
  double plane[4]; ///< unit normal out of cell[0], height of the plane above LthTopology.origin
  double area, centroid[3];
  LitheIndex cell[2]; ///< cell[1]: -1 beyond the boundary
  LitheIndex tag;     ///< as LthMesh.face_tag, or LTH_TAG_CUT - k
  LitheIndex source;  ///< face of the mesh it began in, -1: none
  LitheIndex n_loops, n_corners;
  LitheCount block; ///< loop offsets, then corners, in LthTopology.pool
  bool is_live;
  bool is_line; ///< has no area: kept to close its cells, and in no mesh
} LthTopologyFace;

/// A polyhedron: the sum of the boundaries of its faces is zero, edge by edge.
typedef struct LthTopologyCell {
  double volume, area, centroid[3], box[6];
  LitheIndex source; ///< cell of the mesh it (or the largest part of it) began in
  LitheIndex n_faces, room;
  LitheCount block; ///< its faces, in LthTopology.pool
  bool is_live;
  bool is_new, is_changed; ///< in births or changed_cells of the log
  LitheIndex
      before; ///< of new cells: record that it was a part of before the log began, -1: parts of several
  LitheIndex into; ///< of dead cells: record that it was merged into, -1 if it was split
} LthTopologyCell;

/// A cell was made of (a part of) another; merged cells have one entry for each they were made of.
typedef struct LthTopologyBirth {
  LitheIndex cell, parent;
} LthTopologyBirth;

/// What happened since lth_topology_forget(), in order. Records of cells and faces keep their numbers for life;
/// those of dead ones stay readable, and are not given to others, until they are forgotten.
typedef struct LthTopologyLog {
  LthTopologyBirth *births;
  LitheIndex *dead_cells, *dead_faces;
  LitheIndex *changed_cells; ///< alive and of the same shape, but with other faces; once each
  LitheIndex n_births, n_dead_cells, n_dead_faces, n_changed_cells;
  LitheCount births_cap, dead_cells_cap, dead_faces_cap, changed_cells_cap;
} LthTopologyLog;

typedef struct LthTopologyWork LthTopologyWork;

/// Points, faces and cells as records with stable numbers; numbers without a live record are free. Points stay
/// where they are for life; cells on two sides of a cut share them. Where memory is out in the middle of an
/// operation nothing but destroying it is allowed.
typedef struct LthTopology {
  double *points;        ///< [m]                                             (n_points x 3)
  uint8_t *point_rank;   ///< as LthMesh.point_rank; planes that cut count as grid planes (n_points)
  LitheIndex *point_use; ///< number of corners at a point                   (n_points)
  LitheIndex n_points, n_surface_points;
  LthTopologyFace *faces;
  LthTopologyCell *cells;
  LitheIndex n_faces, n_cells;           ///< records, free ones as well
  LitheIndex n_live_faces, n_live_cells; ///< without lines
  LitheIndex *pool;
  LitheCount n_pool, n_waste;
  double origin[3];
  double rounding;  ///< of the largest coordinate [m]
  double off_plane; ///< no corner is farther from the plane of its face, but for rounding [m]
  double cell_size; ///< typical edge [m]
  double volume;    ///< when it was made [m^3]; operations keep it
  double area;      ///< of the boundary when it was made [m^2]; kept but for faces of cuts
  LthTopologyLog log;
  LitheCount points_cap, point_rank_cap, point_use_cap, faces_cap, cells_cap, pool_cap;
  LthTopologyWork *work;
} LthTopology;

/// Begin with a mesh; nothing of it is kept. Records have the numbers of the mesh.
LitheStatus lth_topology_create(LitheCtx *ctx, const LthMesh *mesh, LthTopology **topology);
void lth_topology_destroy(LitheCtx *ctx, LthTopology **topology);

/// The loops of a face; valid until the next operation.
LthFaceView lth_topology_face(const LthTopology *topology, LitheIndex face);

/// The faces of a cell (n_faces); valid until the next operation.
static inline const LitheIndex *lth_topology_cell_faces(const LthTopology *t, LitheIndex cell) {
  return t->pool + t->cells[cell].block;
}

/// +1 where the face's normal points out of the cell, -1 where it points in.
static inline double lth_topology_side(const LthTopology *t, LitheIndex face, LitheIndex cell) {
  return t->faces[face].cell[0] == cell ? 1.0 : -1.0;
}

/// Clear the log and let the numbers of dead records be used again.
LitheStatus lth_topology_forget(LitheCtx *ctx, LthTopology *topology);

/// The record that a cell was (a part of) before the log began, -1 where it has parts of several.
static inline LitheIndex lth_topology_before(const LthTopology *t, LitheIndex cell) {
  return t->cells[cell].is_new ? t->cells[cell].before : cell;
}

/// The live record that a cell is, or was merged into; -1 where it was split.
static inline LitheIndex lth_topology_now(const LthTopology *t, LitheIndex cell) {
  while (cell >= 0 && !t->cells[cell].is_live) cell = t->cells[cell].into;
  return cell;
}

/// What a split made: births first ... first + n - 1 of the log, below the plane the first n_below of them.
typedef struct LthSplit {
  LitheIndex first, n,
      n_below; ///< n = 0: the plane missed the cell, or would have cut off a part without volume
} LthSplit;

/// Split a cell by a plane into its connected parts on either side. `tag` -1: they stay joined by the new
/// faces; LTH_TAG_CUT - k: they are parted. Points closer to the plane than 1e-13 of the cell, or than
/// rounding, count as on it and do not move. Neighbours get new corners on their edges and several faces
/// in place of one, but keep their shape. A plane that misses changes nothing.
LitheStatus lth_topology_split(LitheCtx *ctx, LthTopology *topology, LitheIndex cell,
                               const LthPlane *plane, LitheIndex tag, LthSplit *split);

/// Part two cells along an inner face: two boundary faces with `tag`. `pair` (may be NULL) receives them.
LitheStatus lth_topology_separate(LitheCtx *ctx, LthTopology *topology, LitheIndex face,
                                  LitheIndex tag, LitheIndex pair[2]);

/// What a cut of many cells did.
typedef struct LthCut {
  LitheIndex n_split;     ///< cells that were split
  LitheIndex n_separated; ///< inner faces that were parted
  double area;            ///< of one side of the cut [m^2]
} LthCut;

/// Cut all given cells: by planes[0], or where `n_planes` is n by one plane each (a plane in deformed space, taken
/// back to rest by the map of each cell, lth_dg_plane_to_rest()). With tag LTH_TAG_CUT - k no inner face is left
/// between what lies below and above: faces in the plane, and those where the planes of neighbours do not
/// meet, are parted. With tag -1 the cells are divided only. Cells that the plane misses stay whole.
LitheStatus lth_topology_cut(LitheCtx *ctx, LthTopology *topology, LitheIndex n,
                             const LitheIndex *cells, LitheIndex n_planes, const LthPlane *planes,
                             LitheIndex tag, LthCut *cut);

/// True if two cells may become one: they share a face, and no cut has parted them.
bool lth_topology_may_merge(const LthTopology *topology, LitheIndex a, LitheIndex b);

/// Take cells away. No inner face may be left between them and cells that stay (lth_topology_separate()). Volume and
/// surface are from now on those of what stays.
LitheStatus lth_topology_remove(LitheCtx *ctx, LthTopology *topology, LitheIndex n,
                                const LitheIndex *cells);

/// Make two cells that may merge one; `*merged` is its record. Common faces vanish; faces to the same
/// neighbour that lie side by side in the same plane become one; corners that no edge needs are taken out.
LitheStatus lth_topology_merge(LitheCtx *ctx, LthTopology *topology, LitheIndex a, LitheIndex b,
                               LitheIndex *merged);

/// Merge those of the given cells (NULL: all) that are smaller than `volume` [m^3] into the neighbour with the
/// largest common face, smallest first. Those whose neighbours are all beyond a cut stay. `*n_merged` counts.
LitheStatus lth_topology_merge_slivers(LitheCtx *ctx, LthTopology *topology, LitheIndex n,
                                       const LitheIndex *cells, double volume,
                                       LitheIndex *n_merged);

/// Divide a cell by three planes through its centroid along its box, or by one plane through its centroid; as
/// lth_topology_split(), children are the births from split->first on that are alive.
LitheStatus lth_topology_split_eight(LitheCtx *ctx, LthTopology *topology, LitheIndex cell,
                                     LthSplit *split);
LitheStatus lth_topology_split_two(LitheCtx *ctx, LthTopology *topology, LitheIndex cell,
                                   const double normal[3], LthSplit *split);

/// Check every invariant of the given cells and their faces (NULL: of all, and that volume and surface are as they
/// were to 1e-12). LITHE_BAD_INPUT says what is wrong; it would be an error of the operations.
LitheStatus lth_topology_check(LitheCtx *ctx, const LthTopology *topology, LitheIndex n,
                               const LitheIndex *cells);

/// All of a topology whose log is empty, as bytes: the same records, and the same numbers for those to come. Reading
/// replaces what is there.
void lth_topology_archive(LthTopology *topology, LthArchive *archive);

/// The given cells (NULL: all) as a mesh. Faces to other cells are boundary faces there. `cell_record` and `face_record`
/// (may be NULL) receive the records of its cells and faces; the caller frees them. Where all are taken, the
/// points of the surface come first, as in the mesh that it began with.
LitheStatus lth_topology_mesh(LitheCtx *ctx, const LthTopology *topology, LitheIndex n,
                              const LitheIndex *cells, LthMesh **mesh, LitheIndex **cell_record,
                              LitheIndex **face_record);

/// Give the mesh that lth_topology_mesh() made the groups of the mesh `first` that the topology began with: parts of
/// cells and of boundary faces belong to the groups of the whole ones.
LitheStatus lth_topology_groups(LitheCtx *ctx, const LthTopology *topology, const LthMesh *first,
                                const LitheIndex *cell_record, const LitheIndex *face_record,
                                LthMesh *mesh);

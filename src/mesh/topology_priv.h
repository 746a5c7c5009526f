/// What the files of the topology share.
///   topology.c         creation, destruction, the log
///   topology_record.c  records of points, faces and cells
///   topology_split.c   splitting a cell: order of steps, and what becomes of its faces
///   topology_points.c  signs of points, new points on edges
///   topology_clip.c    faces to chains below and above the plane, the cap
///   topology_trace.c   chains to loops, loops to parts with their holes
///   topology_parts.c   parts to connected cells; cavities
///   topology_divide.c  new corners on the edges of neighbours
///   topology_cut.c     cuts of many cells, parting along faces
///   topology_merge.c   merging cells, slivers; topology_join.c: what is left of their faces
///   topology_remove.c  cells that are taken away; topology_section.c: a plane through a cell
///   topology_mesh.c    the mesh of now
///   topology_check.c   invariants
///   topology_archive.c all of it as bytes
#pragma once

#include "base/tensor.h"
#include "mesh/topology.h"

/// A face below this share of the area of a cell at it is a line.
#define TOPOLOGY_NO_FACE 1e-15

/// Directed edges, from and to.
typedef struct TopologyChain {
  LitheIndex *edge; ///< (n x 2)
  LitheCount n, cap;
} TopologyChain;

/// Where the boundary of a face passes the plane: sign +1 upwards.
typedef struct TopologyCrossing {
  double key[3]; ///< place along the cut, by the coordinates in order of their extent
  LitheIndex point, sign;
} TopologyCrossing;

/// A piece of a face, or of the cap, that a split makes.
typedef struct TopologyPart {
  LitheIndex face;                ///< record that it is a part of, -1: of the cap
  LitheIndex first_loop, n_loops; ///< in LthTopologyWork; n_loops 0: the whole face
  int side;                       ///< 0 below, 1 above, 2 cap
  LitheIndex cell[2];             ///< new cells below and above, as numbers of the split; -1
  double area;
} TopologyPart;

/// One cell of a split.
typedef struct TopologyPiece {
  double volume, area, centroid[3], box[6];
  int side;
  LitheIndex record;
} TopologyPiece;

/// An edge of a part seen from one side of it.
typedef struct TopologyEdge {
  uint64_t key; ///< both ends
  LitheIndex node;
  int direction; ///< +1: from the lower number to the higher, about the outward normal
} TopologyEdge;

/// Scratch that operations share.
struct LthTopologyWork {
  // signs of points for the plane in hand
  double plane[4];
  double reach;
  uint32_t stamp, *point_stamp, cell_stamp;
  int8_t *point_sign;
  double *point_height;
  LitheCount point_stamp_cap, point_sign_cap, point_height_cap;

  // new points on edges: open addressing, entries of other stamps are free
  uint64_t *cut_key;
  LitheIndex *cut_point;
  uint32_t *cut_stamp, cut_now;
  LitheCount cut_cap, n_cuts;

  // chains of the face in hand, and of the cap
  TopologyChain chain[2], cap, divider;
  TopologyCrossing *cross;
  LitheIndex *queue;
  LitheCount n_cross, cross_cap, queue_cap;

  // tracing
  LitheIndex *trace_edge, *raw_off, *raw_corner, *raw_outer;
  bool *trace_used;
  double *raw_area;
  LitheCount trace_cap, used_cap, raw_off_cap, raw_corner_cap, raw_outer_cap, raw_area_cap;
  LitheIndex n_raw;

  // parts and their loops
  TopologyPart *parts;
  LitheIndex *loop_off, *corner;
  LitheIndex n_parts, n_loops, n_corners;
  LitheCount parts_cap, loop_off_cap, corner_cap;

  // connected cells
  TopologyPiece *pieces;
  LitheIndex n_pieces, n_ridges;
  LitheIndex *set;
  TopologyEdge *edges;
  double *angle;
  LitheCount pieces_cap, set_cap, edges_cap, angle_cap;

  // lists of cells and faces
  LitheIndex *list, *fresh; ///< fresh: new points of the split in hand
  uint32_t *cell_seen, *face_seen;
  int8_t *cell_side;
  LitheCount n_fresh;
  double cap_area; ///< of all caps since it was set to 0 [m^2]
  LitheCount list_cap, fresh_cap, cell_seen_cap, face_seen_cap, cell_side_cap;

  // numbers + 1 in the mesh in the making, all 0 between meshes
  LitheIndex *mesh_cell, *mesh_point;
  LitheCount mesh_cell_cap, mesh_point_cap;

  // numbers to be used again, and points that may have become free
  LitheIndex *free_faces, *free_cells, *free_points, *loose_points;
  LitheCount n_free_faces, n_free_cells, n_free_points, n_loose_points;
  LitheCount free_faces_cap, free_cells_cap, free_points_cap, loose_points_cap;
};

static inline uint64_t lth_topology_edge_key(LitheIndex a, LitheIndex b) {
  return a < b ? (uint64_t)(uint32_t)a << 32 | (uint32_t)b
               : (uint64_t)(uint32_t)b << 32 | (uint32_t)a;
}

static inline LitheIndex *lth_topology_loops(const LthTopology *t, const LthTopologyFace *face) {
  return t->pool + face->block;
}

/// The cell on the other side of a face.
static inline LitheIndex lth_topology_across(const LthTopology *t, LitheIndex face,
                                             LitheIndex cell) {
  const LthTopologyFace *f = t->faces + face;
  return f->cell[f->cell[0] == cell];
}

// topology_record.c

LitheStatus lth_topology_add_point(LitheCtx *ctx, LthTopology *t, const double x[3],
                                   LitheIndex *point);
/// Give back a point that has no corners.
LitheStatus lth_topology_drop_point(LitheCtx *ctx, LthTopology *t, LitheIndex point);

/// Add a face with the plane, cells, tag and source of `like`; `loop_off` and `corner` as in LthFaceView;
/// `is_turned` runs loops backwards. It enters its cells' lists and is measured. `*face` is its record.
LitheStatus lth_topology_add_face(LitheCtx *ctx, LthTopology *t, const LthTopologyFace *like,
                                  LitheIndex n_loops, const LitheIndex *loop_off,
                                  const LitheIndex *corner, bool is_turned, LitheIndex *face);

/// Replace a face's loops in place.
LitheStatus lth_topology_set_loops(LitheCtx *ctx, LthTopology *t, LitheIndex face,
                                   LitheIndex n_loops, const LitheIndex *loop_off,
                                   const LitheIndex *corner);

/// Let a face die; it leaves the lists of its live cells but of `except`.
LitheStatus lth_topology_end_face(LitheCtx *ctx, LthTopology *t, LitheIndex face,
                                  LitheIndex except);

LitheStatus lth_topology_add_cell(LitheCtx *ctx, LthTopology *t, LitheIndex source, LitheIndex room,
                                  LitheIndex *cell);
LitheStatus lth_topology_end_cell(LitheCtx *ctx, LthTopology *t, LitheIndex cell);
LitheStatus lth_topology_list_face(LitheCtx *ctx, LthTopology *t, LitheIndex cell, LitheIndex face);
LitheStatus lth_topology_note_birth(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                    LitheIndex parent);
/// Note that the faces of a cell that is not new changed.
LitheStatus lth_topology_note_change(LitheCtx *ctx, LthTopology *t, LitheIndex cell);

/// A line may be a face beside cells that became smaller.
void lth_topology_judge_line(LthTopology *t, LitheIndex face);

/// Volume, area, centroid and box from its faces.
void lth_topology_measure_cell(LthTopology *t, LitheIndex cell);

/// Begin visiting cells and faces anew; room for all records.
LitheStatus lth_topology_begin_visit(LitheCtx *ctx, LthTopology *t);

/// True the first time a cell (face) is asked for in this visit.
static inline bool lth_topology_visit_cell(LthTopology *t, LitheIndex cell) {
  LthTopologyWork *w = t->work;
  bool is_new = w->cell_seen[cell] != w->cell_stamp;
  w->cell_seen[cell] = w->cell_stamp;
  return is_new;
}
static inline bool lth_topology_visit_face(LthTopology *t, LitheIndex face) {
  LthTopologyWork *w = t->work;
  bool is_new = w->face_seen[face] != w->cell_stamp;
  w->face_seen[face] = w->cell_stamp;
  return is_new;
}

// topology_points.c

/// A second try takes points this much farther away for points on the plane. A face that is off its plane by d changes
/// the volume by d times its area when it is divided; more than this would show in the twelfth digit.
#define LTH_TOPOLOGY_WIDEN 8

/// Take a plane in hand: signs and cuts of others are forgotten. `reach` [m]: closer points are on it.
void lth_topology_take_plane(LthTopology *t, const double plane[4], double reach);
/// Forget new points on edges.
void lth_topology_forget_cuts(LthTopology *t);
/// Normal and height above the origin.
void lth_topology_plane(const LthTopology *t, const LthPlane *plane, double out[4]);
/// How close to a plane a point of a cell counts as on it.
double lth_topology_reach(const LthTopology *t, LitheIndex cell, const double plane[4]);

/// Signs of a cell's points; -1 or +1 where all of them are on one side (or on the plane), else 0.
LitheStatus lth_topology_classify(LitheCtx *ctx, LthTopology *t, LitheIndex cell, int *side);

/// The point in which an edge meets the plane in hand, the same for all that ask.
LitheStatus lth_topology_cut_edge(LitheCtx *ctx, LthTopology *t, LitheIndex a, LitheIndex b,
                                  LitheIndex *point);

/// The new point of an edge in the plane in hand, -1: it has none.
LitheIndex lth_topology_find_cut(const LthTopology *t, LitheIndex a, LitheIndex b);

// topology_clip.c

/// The cell's faces as parts below and above, and the cap's chain and dividers. `*is_clean` is false where a
/// cut does not come out as polygons.
LitheStatus lth_topology_clip(LitheCtx *ctx, LthTopology *t, LitheIndex cell, bool *is_clean);

// topology_trace.c

LitheStatus lth_topology_chain_add(LitheCtx *ctx, TopologyChain *chain, LitheIndex from,
                                   LitheIndex to);

/// Trace `chain` (edges that cancel are taken out) and then the edges of `divider` (may be NULL; kept as they are) to
/// parts about `normal`, which get `face` and `side`. `*is_clean` becomes false where a hole has no loop around it.
LitheStatus lth_topology_trace(LitheCtx *ctx, LthTopology *t, TopologyChain *chain,
                               const TopologyChain *divider, const double normal[3],
                               LitheIndex face, int side, bool *is_clean);

/// Remove opposite edges from a chain.
void lth_topology_cancel(TopologyChain *chain);

/// A part as a face; `plane` is that of the split.
LthFaceView lth_topology_part(const LthTopology *t, const TopologyPart *part);

// topology_parts.c

/// Connected cells on either side from the parts, measured. `*is_clean` is false where one of them has no volume.
LitheStatus lth_topology_connect(LitheCtx *ctx, LthTopology *t, LitheIndex cell, bool *is_clean);

// topology_divide.c

/// Put the new points of `cell`'s edges into the loops of all faces around these edges.
LitheStatus lth_topology_divide_edges(LitheCtx *ctx, LthTopology *t, LitheIndex cell);

// topology_split.c

/// Split by the plane in hand.
LitheStatus lth_topology_split_in_hand(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                       LitheIndex tag, LthSplit *split, bool *is_clean);

// topology_join.c

/// Unite faces of a cell to the same neighbour that lie side by side in one plane.
LitheStatus lth_topology_join_faces(LitheCtx *ctx, LthTopology *t, LitheIndex cell);

/// Take out those of some points that are corners of a cell and lie inside a straight edge of all faces at them.
LitheStatus lth_topology_drop_corners(LitheCtx *ctx, LthTopology *t, LitheIndex cell,
                                      LitheIndex n_points, const LitheIndex *points);

/// The slicer's parts: chains of directed edges that are cut by one family of planes after another.
///
/// A piece is a planar region known only by its boundary, a 1-cycle of directed edges between points.
/// Cutting a cycle is done edge by edge, and each closing edge that a cut adds to one side is subtracted
/// from the other and from the cap between them. So every cell's pieces bound nothing (the boundary of
/// a boundary is zero) whatever rounding does to coordinates: elements are closed by construction.
/// The steps, one file each:
///   slice_clip.c     three passes: pieces are cut by all planes of an axis; cut edges go to caps
///   slice_cap.c      caps: pieces in grid planes, from the edges that the cuts left behind
///   slice_weld.c     coincident points become one
///   slice_trace.c    cycles to loops of points
///   slice_loops.c    loops to connected parts with their holes
///   slice_cells.c    parts to elements: those that share edges in a cell; cavities to what holds them
///   slice_merge.c    slivers into neighbours
///   slice_faces.c    parts to faces of the mesh
#pragma once

#include "base/hash.h"
#include "mesh/mesh.h"

#define SLICE_BOUNDARY 3 ///< `axis` of a piece cut from the surface

/// A planar region. Boundary pieces are oriented outward. A cap lies between the cell `slab`, out of
/// which it points along +axis, and its next cell along that axis.
typedef struct SlicePiece {
  LitheIndex tag;     ///< surface triangle, -1 for caps
  LitheIndex axis;    ///< of a cap's plane, or SLICE_BOUNDARY
  LitheIndex slab[3]; ///< cell, known for the axes passed so far
  LitheIndex count;   ///< number of edges
  LitheCount first;   ///< first edge
} SlicePiece;

/// Pieces and their edges; the edges of a piece lie together.
typedef struct SlicePieces {
  SlicePiece *piece;
  LitheIndex *edge; ///< from, to (n_edges x 2)
  LitheCount n, cap, n_edges, edge_cap;
} SlicePieces;

/// A closing edge on its way to a cap.
typedef struct SliceCapEdge {
  LitheIndex cap, from, to;
} SliceCapEdge;

/// The caps of one pass while their edges are collected.
typedef struct SliceCaps {
  LthHash index;      ///< (slab 0, slab 1, plane) -> cap
  LitheIndex *slab;   ///< (n x 3)
  SliceCapEdge *edge; ///< (n_edges)
  LitheCount n, slab_cap, n_edges, edge_cap;
} SliceCaps;

/// Connected parts of pieces, as loops: the first is the outer one where there are holes.
typedef struct SliceParts {
  LitheIndex *piece;    ///< (n)
  LitheIndex *loop_off; ///< first loop of a part        (n + 1)
  LitheIndex *off;      ///< first point of a loop       (n_loops + 1)
  LitheIndex *point;    ///< (off[n_loops])
  double *area;         ///< [m^2]                       (n)
  LitheCount n, cap, area_cap, loop_off_cap, n_loops, off_cap, n_points, point_cap;
} SliceParts;

/// Elements; a cap's part belongs to two of them: entry 2p the low side, 2p + 1 the high side.
typedef struct SliceElements {
  LitheIndex *of;    ///< element of a part's side, -1 none   (2 x number of parts)
  LitheIndex *group; ///< final element, -1 dropped           (n)
  LitheIndex n, n_groups, n_merged;
  double *volume, *area; ///< of elements, later of groups  (n)
} SliceElements;

typedef struct Slicer {
  LitheCtx *ctx;
  const LthSurface *surface;
  LitheIndex cells[3];
  double *plane[3];   ///< positions of all planes   (cells + 1)
  double cell_volume; ///< of a full cell [m^3]
  double rounding;    ///< of the largest coordinate [m]
  double reach;       ///< a point this close to a plane is on it [m]
  double *point;      ///< (n_points x 3)
  LitheCount n_points, point_cap;
  SlicePieces pieces;
  SliceParts parts;
  SliceElements elements;
} Slicer;

/// Append a piece with no edges yet; its edges are those appended next.
LitheStatus lth_slice_add_piece(LitheCtx *ctx, SlicePieces *pieces, const SlicePiece *piece);
LitheStatus lth_slice_add_edge(LitheCtx *ctx, SlicePieces *pieces, LitheIndex from, LitheIndex to);
void lth_slice_free_pieces(LitheCtx *ctx, SlicePieces *pieces);

/// Cut all pieces by the inner planes of an axis and add the caps.
LitheStatus lth_slice_pass(Slicer *s, int axis);

/// Enter the closing edge from -> to of the low side of plane `plane` (so the cap gets its opposite).
LitheStatus lth_slice_cap_edge(LitheCtx *ctx, SliceCaps *caps, const SlicePiece *piece, int axis,
                               LitheIndex plane, LitheIndex from, LitheIndex to);
/// Append the collected caps as pieces.
LitheStatus lth_slice_close_caps(LitheCtx *ctx, SliceCaps *caps, int axis, SlicePieces *pieces);
void lth_slice_free_caps(LitheCtx *ctx, SliceCaps *caps);

/// Make points of equal coordinates one, and cancel opposite edges within pieces.
LitheStatus lth_slice_weld(Slicer *s);

/// Cancel opposite edges of a list in place, a multiplicity left over stays; returns their new number.
LitheIndex lth_slice_cancel(LitheIndex *edge, LitheIndex n);

/// Split a cycle into loops and append them to `parts` (not the part itself). In a cap (axis < 3) that
/// touches itself in points, loops take the sharpest left turn, so they never cross.
LitheStatus lth_slice_trace(Slicer *s, int axis, const LitheIndex *edge, LitheIndex n);

LitheStatus lth_slice_add_loop_point(Slicer *s, LitheIndex point);
LitheStatus lth_slice_end_loop(Slicer *s);

/// Build all parts.
LitheStatus lth_slice_make_parts(Slicer *s);

/// Signed area of a loop of points across an axis, and its area vector.
double lth_slice_loop_area(const double *points, const LitheIndex *loop, LitheIndex n, int axis);
void lth_slice_area_vector(const double *points, const LitheIndex *loop, LitheIndex n,
                           double vector[3]);
void lth_slice_free_parts(LitheCtx *ctx, SliceParts *parts);

/// Group parts into elements, give cavities to the elements around them.
LitheStatus lth_slice_make_elements(Slicer *s);

/// Merge elements below `sliver` times a full cell, and all without volume.
LitheStatus lth_slice_merge(Slicer *s, double sliver);

/// Final faces and the mesh.
LitheStatus lth_slice_make_mesh(Slicer *s, LthMesh **mesh);

/// An update of a skin in progress.
#pragma once

#include "geometry/face_polygon.h"
#include "geometry/polygon.h"
#include "mesh/skin.h"

#include "base/tensor.h"

/// A *node* is a point of the topology on one side of the cuts through it: its number for points on no cut, else
/// n_points + the first entry of its part.
typedef struct SkinWork {
  LthSkin *skin;
  const LthTopology *t;

  // points of cuts, and the cells around them (skin_sides.c)
  LitheIndex *cut_point; ///< number + 1 among them, 0: none               (t->n_points)
  LitheIndex n_cut_points;
  LitheCount *off;    ///< entries of each                                (n_cut_points + 1)
  LitheIndex *cell;   ///< ascending
  LitheIndex *part;   ///< first entry that hangs together with this one
  LitheIndex *owner;  ///< point of the topology of each entry
  LitheIndex *number; ///< skin's point of a node, -1               (t->n_points + entries)
  LitheIndex *node;   ///< of each of the skin's points, -1         (n_points when the update began)
  LitheIndex *lowest; ///< cell + 1 at each point of the boundary            (t->n_points)
  LitheIndex n_nodes, n_before;
  bool *is_kept; ///< points of the topology that the surface has (t->n_points)

  // pieces: boundary faces by facet, facets by polygon (skin_facets.c)
  LitheIndex *piece_off, *piece, *facet_off, *facet;
  bool *in_parts; ///< facets whose pieces cannot be joined                     (n_facets)

  // the facet in hand: its outline as loops of nodes
  LitheIndex *edge, *loop_off, *loop_node; ///< edge: pairs
  bool *is_used;
  LitheIndex n_edges, n_loops, n_corners;
  LitheCount edge_cap, loop_off_cap, loop_node_cap, used_cap;

  // the polygon in hand (skin_corners.c)
  LthPolygonWork clip;
  LthPolygonList list;
  LitheIndex *corner, *clipped; ///< nodes; triangles of rows
  double *corner_place;
  LitheCount corner_cap, clipped_cap, place_cap;
  LitheIndex poly, *poly_row, *poly_tri,
      n_poly_tris; ///< triangles of the soup's polygon, for its texture
  LitheCount poly_tri_cap, poly_row_cap;

  // polygons as they come
  LthSoup out;
  LitheIndex *poly_cell; ///< an element at each, -1: not looked for
  LitheCount poly_cell_cap;
  LitheCount n_corners_out, off_cap, out_point_cap, out_uv_cap, uv_cap, group_cap;
} SkinWork;

/// Point of the topology of a node.
static inline LitheIndex lth_skin_point(const SkinWork *w, LitheIndex node) {
  return node < w->t->n_points ? node : w->owner[node - w->t->n_points];
}

static inline const double *lth_skin_place(const SkinWork *w, LitheIndex node) {
  return w->t->points + 3 * (LitheCount)lth_skin_point(w, node);
}

/// A live face of the boundary.
static inline bool lth_skin_is_boundary(const LthTopologyFace *f) {
  return f->is_live && f->cell[1] < 0;
}

static inline LitheIndex lth_skin_facet(const SkinWork *w, const LthTopologyFace *f) {
  return f->source >= 0 && f->source < w->skin->n_faces ? w->skin->face_facet[f->source] : -1;
}

// skin_sides.c

/// Find the points of all cuts, the sides that they have, and the skin's points there.
LitheStatus lth_skin_find_sides(LitheCtx *ctx, SkinWork *w);

/// Node of a corner of a cell; -1: the cell does not have the point.
LitheIndex lth_skin_node(const SkinWork *w, LitheIndex point, LitheIndex cell);

/// The skin's point of a node, a new one where there is none.
LitheStatus lth_skin_number(LitheCtx *ctx, SkinWork *w, LitheIndex node, LitheIndex *number);

/// Append a point to the skin: `point` of the topology, -1: none.
LitheStatus lth_skin_add_point(LitheCtx *ctx, LthSkin *skin, const double x[3], LitheIndex point,
                               LitheIndex cell, LitheIndex *number);

// skin_facets.c

/// List pieces by facet and decide which of them can be joined; marks points that the surface has.
LitheStatus lth_skin_find_facets(LitheCtx *ctx, SkinWork *w);

/// Outline of all pieces of a facet. `*is_simple`: loops without holes that pass no place twice.
LitheStatus lth_skin_outline(LitheCtx *ctx, SkinWork *w, LitheIndex facet, bool *is_simple);

// skin_corners.c

/// Write the polygons of the surface: those that nothing touched, parts of others, caps.
LitheStatus lth_skin_write(LitheCtx *ctx, SkinWork *w);

/// Append texture coordinates.
LitheStatus lth_skin_add_uv(LitheCtx *ctx, SkinWork *w, double u, double v, LitheIndex *uv);

// skin_edges.c

/// Give polygons in twos edges of their own where more than two have one.
LitheStatus lth_skin_part_edges(LitheCtx *ctx, SkinWork *w);

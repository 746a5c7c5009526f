/// Parts of a split cell to connected cells: those that meet in an edge with the solid between them; cavities go to the
/// cell around them.
#include "mesh/topology_priv.h"

#include "base/disjoint_sets.h"
#include "geometry/bvh.h"
#include "mesh/mesh_measure.h"

#include <stdlib.h>

/// A cell whose volume is below this share of its area to the power 3/2, or thinner than so many units of rounding,
/// has none.
#define NO_VOLUME 1e-12
#define NO_THICKNESS 64
#define OFF_PLANE 4

static int compare_edges(const void *a, const void *b) {
  const TopologyEdge *x = a, *y = b;
  if (x->key != y->key) return x->key < y->key ? -1 : 1;
  return (x->node > y->node) - (x->node < y->node);
}

/// Does the part's normal point out of the cell on this side (0 below, 1 above)?
static bool points_out(const LthTopology *t, const TopologyPart *part, LitheIndex cell, int side) {
  return part->face < 0 ? side == 0 : t->faces[part->face].cell[0] == cell;
}

static LitheStatus list_part(LitheCtx *ctx, LthTopology *t, LitheIndex cell, int side,
                             LitheIndex part, LitheIndex *n) {
  LthTopologyWork *w = t->work;
  LthFaceView view = lth_topology_part(t, w->parts + part);
  bool is_out = points_out(t, w->parts + part, cell, side);
  for (LitheIndex l = 0; l < view.n_loops; l++) {
    LitheIndex first = view.loop_off[l], last = view.loop_off[l + 1];
    LTH_RESERVE(ctx, w->edges, w->edges_cap, *n + last - first);
    for (LitheIndex j = first; j < last; j++) {
      LitheIndex a = view.loop_point[j], b = view.loop_point[j + 1 < last ? j + 1 : first];
      w->edges[(*n)++] =
          (TopologyEdge){lth_topology_edge_key(a, b), 2 * part + side, (a < b) == is_out ? 1 : -1};
    }
  }
  return LITHE_OK;
}

/// Angle about an edge (from its lower end to its higher) at which a part lies.
static double angle_of(const LthTopology *t, LitheIndex cell, const TopologyEdge *e,
                       const double u[3], const double v[3], const double d[3]) {
  const TopologyPart *part = t->work->parts + e->node / 2;
  double n[3], inside[3];
  lth_v3_copy(part->face < 0 ? t->work->plane : t->faces[part->face].plane, n);
  if (!points_out(t, part, cell, e->node % 2)) lth_v3_scale(-1, n);
  lth_v3_cross(n, d, inside);
  lth_v3_scale(e->direction, inside);
  return atan2(lth_v3_dot(inside, v), lth_v3_dot(inside, u));
}

/// More than two parts at an edge: about it the solid goes on, counter-clockwise, from each part with direction -1
/// to the next with +1. False where they do not alternate.
static bool unite_around(LthTopology *t, LitheIndex cell, TopologyEdge *e, LitheIndex n,
                         double *angle) {
  const double *p = t->points;
  double d[3], u[3], v[3];
  lth_v3_sub(p + 3 * (LitheCount)(uint32_t)e->key, p + 3 * (LitheCount)(e->key >> 32), d);
  lth_v3_normalize(d);
  lth_face_frame(d, u, v);
  for (LitheIndex i = 0; i < n; i++) {
    TopologyEdge moved = e[i];
    double at = angle_of(t, cell, e + i, u, v, d);
    LitheIndex j = i;
    for (; j > 0 && angle[j - 1] > at; j--) angle[j] = angle[j - 1], e[j] = e[j - 1];
    angle[j] = at;
    e[j] = moved;
  }
  for (LitheIndex i = 0; i < n; i++)
    if (e[i].direction == e[(i + 1) % n].direction) return false;
  for (LitheIndex i = 0; i < n; i++)
    if (e[i].direction < 0) lth_sets_unite(t->work->set, e[i].node, e[(i + 1) % n].node);
  return true;
}

static LitheStatus unite_side(LitheCtx *ctx, LthTopology *t, LitheIndex cell, int side) {
  LthTopologyWork *w = t->work;
  LitheIndex n = 0;
  for (LitheIndex p = 0; p < w->n_parts; p++)
    if (w->parts[p].side == side || w->parts[p].side == 2)
      LITHE_TRY(list_part(ctx, t, cell, side, p, &n));
  qsort(w->edges, (size_t)n, sizeof *w->edges, compare_edges);
  for (LitheIndex i = 0, j; i < n; i = j) {
    for (j = i + 1; j < n && w->edges[j].key == w->edges[i].key;) j++;
    LTH_RESERVE(ctx, w->angle, w->angle_cap, j - i);
    if (j - i > 2 && unite_around(t, cell, w->edges + i, j - i, w->angle)) continue;
    for (LitheIndex k = i + 1; k < j; k++)
      lth_sets_unite(w->set, w->edges[i].node, w->edges[k].node);
  }
  return LITHE_OK;
}

/// Number the sets of one side as pieces.
static LitheStatus number_side(LitheCtx *ctx, LthTopology *t, int side) {
  LthTopologyWork *w = t->work;
  for (LitheIndex p = 0; p < w->n_parts; p++) {
    TopologyPart *part = w->parts + p;
    if (part->side != side && part->side != 2) continue;
    LitheIndex root = lth_sets_root(w->set, 2 * p + side), *of = &w->parts[root / 2].cell[side];
    if (*of < 0) {
      LTH_RESERVE(ctx, w->pieces, w->pieces_cap, w->n_pieces + 1);
      *of = w->n_pieces;
      w->pieces[w->n_pieces++] = (TopologyPiece){.side = side, .record = -1};
    }
    part->cell[side] = *of;
  }
  return LITHE_OK;
}

static void measure_piece(LthTopology *t, LitheIndex cell, LitheIndex piece) {
  LthTopologyWork *w = t->work;
  TopologyPiece *k = w->pieces + piece;
  int side = k->side;
  for (int a = 0; a < 3; a++) k->box[a] = INFINITY, k->box[3 + a] = -INFINITY;
  for (LitheIndex p = 0; p < w->n_parts; p++) {
    if (w->parts[p].cell[side] != piece) continue;
    LthFaceView view = lth_topology_part(t, w->parts + p);
    k->area += w->parts[p].area;
    for (LitheIndex j = view.loop_off[0]; j < view.loop_off[view.n_loops]; j++)
      for (int a = 0; a < 3; a++) {
        double x = t->points[3 * (LitheCount)view.loop_point[j] + a];
        if (x < k->box[a]) k->box[a] = x;
        if (x > k->box[3 + a]) k->box[3 + a] = x;
      }
  }
  double volume = 0, moment[3] = {0, 0, 0};
  for (int a = 0; a < 3; a++) k->centroid[a] = k->box[a] + 0.5 * (k->box[3 + a] - k->box[a]);
  for (LitheIndex p = 0; p < w->n_parts; p++) {
    const TopologyPart *part = w->parts + p;
    if (part->cell[side] != piece) continue;
    LthFaceView view = lth_topology_part(t, part);
    lth_mesh_add_cone(&view, points_out(t, part, cell, side) ? 1 : -1, k->centroid, &volume,
                      moment);
  }
  k->volume = volume / 6;
  if (volume != 0) lth_v3_axpy(1 / (4 * volume), moment, k->centroid);
}

/// Winding number of a piece's surface around x.
static double winding(const LthTopology *t, LitheIndex cell, LitheIndex piece, const double x[3]) {
  const LthTopologyWork *w = t->work;
  int side = w->pieces[piece].side;
  double sum = 0;
  for (LitheIndex p = 0; p < w->n_parts; p++) {
    if (w->parts[p].cell[side] != piece) continue;
    LthFaceView view = lth_topology_part(t, w->parts + p);
    double sign = points_out(t, w->parts + p, cell, side) ? 1 : -1;
    LitheIndex c[3];
    for (LthFan fan = lth_fan(&view); lth_fan_next(&fan, c);)
      sum +=
          sign * lth_solid_angle(t->points + 3 * (LitheCount)c[0], t->points + 3 * (LitheCount)c[1],
                                 t->points + 3 * (LitheCount)c[2], x);
  }
  return sum / (4 * M_PI);
}

/// The smallest piece around a cavity, -1 if there is none. A point of the cavity's largest part tells; pieces that
/// touch do so in edges and corners.
static LitheIndex find_container(const LthTopology *t, LitheIndex cell, LitheIndex cavity) {
  const LthTopologyWork *w = t->work;
  int side = w->pieces[cavity].side;
  LitheIndex probe = -1, best = -1;
  double x[3];
  for (LitheIndex p = 0; p < w->n_parts; p++)
    if (w->parts[p].cell[side] == cavity && (probe < 0 || w->parts[p].area > w->parts[probe].area))
      probe = p;
  LthFaceView view = lth_topology_part(t, w->parts + probe);
  lth_face_area_centroid(&view, x);
  for (LitheIndex i = 0; i < w->n_pieces; i++) {
    if (w->pieces[i].side != side || !(w->pieces[i].volume > -w->pieces[cavity].volume)) continue;
    if (best >= 0 && w->pieces[i].volume >= w->pieces[best].volume) continue;
    if (winding(t, cell, i, x) > 0.5) best = i;
  }
  return best;
}

/// Whole shells of negative volume are cavities: they join the piece around them.
static bool attach_cavities(LthTopology *t, LitheIndex cell) {
  LthTopologyWork *w = t->work;
  LitheIndex n = 0;
  bool any = false;
  for (LitheIndex i = 0; i < w->n_pieces; i++) {
    w->pieces[i].record = i; // the piece that takes it over
    if (!(w->pieces[i].volume < 0)) continue;
    LitheIndex container = find_container(t, cell, i);
    if (container < 0) return false;
    w->pieces[i].record = container;
    any = true;
  }
  if (!any) return true;
  for (LitheIndex p = 0; p < w->n_parts; p++)
    for (int side = 0; side < 2; side++)
      if (w->parts[p].cell[side] >= 0)
        w->parts[p].cell[side] = w->pieces[w->parts[p].cell[side]].record;
  for (LitheIndex i = 0; i < w->n_pieces; i++)
    w->pieces[i].record = w->pieces[i].record == i ? n++ : -1;
  for (LitheIndex p = 0; p < w->n_parts; p++)
    for (int side = 0; side < 2; side++)
      if (w->parts[p].cell[side] >= 0)
        w->parts[p].cell[side] = w->pieces[w->parts[p].cell[side]].record;
  for (LitheIndex i = 0; i < w->n_pieces; i++)
    if (w->pieces[i].record >= 0)
      w->pieces[w->pieces[i].record] = (TopologyPiece){.side = w->pieces[i].side};
  w->n_pieces = n;
  for (LitheIndex i = 0; i < n; i++) measure_piece(t, cell, i);
  return true;
}

LitheStatus lth_topology_connect(LitheCtx *ctx, LthTopology *t, LitheIndex cell, bool *is_clean) {
  LthTopologyWork *w = t->work;
  LTH_RESERVE(ctx, w->set, w->set_cap, 2 * w->n_parts);
  lth_sets_reset(w->set, 2 * w->n_parts);
  w->n_pieces = 0;
  for (LitheIndex p = 0; p < w->n_parts; p++) {
    TopologyPart *part = w->parts + p;
    double centroid[3];
    LthFaceView view = lth_topology_part(t, part);
    part->area =
        part->n_loops ? lth_face_area_centroid(&view, centroid) : t->faces[part->face].area;
  }
  for (int side = 0; side < 2; side++) {
    LITHE_TRY(unite_side(ctx, t, cell, side));
    LITHE_TRY(number_side(ctx, t, side));
  }
  for (LitheIndex i = 0; i < w->n_pieces; i++) measure_piece(t, cell, i);
  *is_clean = attach_cavities(t, cell);
  for (LitheIndex i = 0; i < w->n_pieces; i++) {
    const TopologyPiece *k = w->pieces + i;
    double thickness = fmax(NO_VOLUME * sqrt(k->area), NO_THICKNESS * t->rounding);
    // faces that are not quite plane change volumes by so much when they are divided
    thickness = fmax(thickness, OFF_PLANE * fmax(t->off_plane, w->reach));
    *is_clean &= k->volume > thickness * k->area;
  }
  return LITHE_OK;
}

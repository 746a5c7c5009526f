/// Points of the boundary that touch others: nodes and middles of faces, weighted so that a pressure on them is carried
/// as the elements carry it (docs/theory/contact.md). Radon 1948 for triangles (degree 3), Simpson for squares.
#include "disc/cg/cg_priv.h"

/// Points by corners, middles of sides and the middle: all weights are positive.
static const LthCgPlaneRule quadratic[2] = {
    {7,
     {{0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}, {1. / 3, 1. / 3}},
     {1. / 40, 1. / 40, 1. / 40, 1. / 15, 1. / 15, 1. / 15, 9. / 40}},
    {9,
     {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0}, {1, 0.5}, {0.5, 1}, {0, 0.5}, {0.5, 0.5}},
     {1. / 36, 1. / 36, 1. / 36, 1. / 36, 1. / 9, 1. / 9, 1. / 9, 1. / 9, 4. / 9}},
};

/// Corners alone.
static const LthCgPlaneRule linear[2] = {
    {3, {{0, 0}, {1, 0}, {0, 1}}, {1. / 6, 1. / 6, 1. / 6}},
    {4, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {0.25, 0.25, 0.25, 0.25}},
};

bool lth_cg_touches_by_faces(const LthDisc *disc) {
  const LthCgDisc *d = lth_cg_of(disc);
  if (d->cell_element) return false;
  for (LitheIndex e = 0; e < d->elements->n_elements; e++)
    if (lth_cg_kind(d, e)->shape->degree == 2) return true;
  return false;
}

void lth_touch_points_free(LitheCtx *ctx, LthTouchPoints *t) {
  lth_free(ctx, t->points);
  lth_free(ctx, t->cells);
  lth_free(ctx, t->area);
  *t = (LthTouchPoints){0};
}

typedef struct Collector {
  LitheCtx *ctx;
  const LthCgDisc *d;
  LitheIndex *of_node; ///< point of a node, from 1; 0: none yet      (n_nodes)
  LthTouchPoints *out;
  LitheCount cap_points, cap_cells, cap_area;
} Collector;

static LitheStatus new_point(Collector *c, LitheIndex cell, const double x[3], LitheIndex *point) {
  LthTouchPoints *t = c->out;
  LTH_RESERVE(c->ctx, t->points, c->cap_points, 3 * ((LitheCount)t->n + 1));
  LTH_RESERVE(c->ctx, t->cells, c->cap_cells, (LitheCount)t->n + 1);
  LTH_RESERVE(c->ctx, t->area, c->cap_area, (LitheCount)t->n + 1);
  lth_v3_copy(x, t->points + 3 * (LitheCount)t->n);
  t->cells[t->n] = cell;
  t->area[t->n] = 0;
  *point = t->n++;
  return LITHE_OK;
}

/// Node of the element at a place of the reference element, -1.
static LitheIndex node_at(const LthCgDisc *d, LitheIndex e, const double xi[3]) {
  const LthCgKind *kind = lth_cg_kind(d, e);
  for (int i = 0; i < kind->n; i++)
    if (lth_v3_distance(kind->node[i], xi) < 1e-9) return lth_cg_nodes(d, e)[i];
  return -1;
}

/// A face of an element, or half of one: neighbours share the points that are nodes.
static LitheStatus add_face(Collector *c, LitheIndex cell, const LthCgFace *face) {
  const LthCgDisc *d = c->d;
  const LitheIndex e = lth_cg_element(d, cell);
  const LthCgKind *kind = lth_cg_kind(d, e);
  const LthCgPlaneRule *rules = kind->shape->degree == 2 ? quadratic : linear;
  LthCgFaceRule rule;
  lth_cg_face_rule(kind, face->n_corners, face->corner, &rules[face->n_corners - 3], &rule);
  for (int q = 0; q < rule.n; q++) {
    double X[3], J[9], phi[LTH_CG_MAX], dphi[3 * LTH_CG_MAX], a[3], b[3], normal[3];
    lth_cg_map(d, e, rule.xi[q], X, J, phi, dphi);
    lth_m3_apply(J, rule.a[q], a);
    lth_m3_apply(J, rule.b[q], b);
    lth_v3_cross(a, b, normal);
    LitheIndex node = node_at(d, e, rule.xi[q]), point = node < 0 ? -1 : c->of_node[node] - 1;
    if (point < 0) LITHE_TRY(new_point(c, cell, X, &point));
    if (node >= 0) c->of_node[node] = point + 1;
    c->out->area[point] += rule.weight[q] * lth_v3_norm(normal);
  }
  return LITHE_OK;
}

LitheStatus lth_cg_touch_points(LitheCtx *ctx, const LthDisc *disc, LthTouchPoints *t) {
  LitheStatus status = LITHE_OK;
  const LthMesh *mesh = disc->mesh;
  Collector c = {.ctx = ctx, .d = lth_cg_of(disc), .out = t};
  *t = (LthTouchPoints){0};
  LTH_NEW_OR(done, ctx, c.of_node, c.d->elements->n_nodes);
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex cell = mesh->face_cell[2 * f], point;
    if (mesh->face_cell[2 * f + 1] >= 0) continue;
    if (c.d->face[f].n_corners > 0) {
      LITHE_TRY_OR(done, add_face(&c, cell, &c.d->face[f]));
      continue;
    }
    LITHE_TRY_OR(done, new_point(&c, cell, mesh->face_centroid + 3 * (LitheCount)f, &point));
    t->area[point] = mesh->face_area[f];
  }
done:
  lth_free(ctx, c.of_node);
  if (status != LITHE_OK) lth_touch_points_free(ctx, t);
  return status;
}

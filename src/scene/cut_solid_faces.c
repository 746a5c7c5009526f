/// The cut faces of a body as another solid sees them: what it is divided along, and which of its faces lie on them.
#include "scene/cut_solid_priv.h"

#include "base/tensor.h"
#include "geometry/bvh.h"
#include "geometry/face_polygon.h"
#include "geometry/polygon.h"

#include <stdlib.h>

#define ON_FACE 1e-9  ///< of an element's size: faces as near as that lie in one plane
#define BESIDE 1e-3   ///< of a face's size: how far beside it elements are looked for
#define COMMON 1e-6   ///< of the smaller face: less in common is rounding
#define OPPOSITE 1e-9 ///< of the normals of two faces of a pair

// ------------------------------------------------------------------ faces and edges of the new cut

static bool is_new(const LthCutSolid *s, const LthTopologyFace *f) {
  return f->is_live && !f->is_line && f->tag <= LTH_TAG_CUT - s->c->n_cuts;
}

static int compare_sides(const void *a, const void *b) {
  const LthCutSide *p = a, *q = b;
  for (int k = 0; k < 4; k++)
    if (p->plane[k] != q->plane[k]) return p->plane[k] < q->plane[k] ? -1 : 1;
  return (p->order > q->order) - (p->order < q->order);
}

static void grow(double box[6], const double x[3]) {
  for (int a = 0; a < 3; a++) {
    box[a] = fmin(box[a], x[a]);
    box[3 + a] = fmax(box[3 + a], x[a]);
  }
}

static LitheStatus add_side(LitheCtx *ctx, LthCutSolid *s, const LthTopologyFace *f,
                            LthCutSide *side) {
  double sign = 1;
  LTH_RESERVE(ctx, s->sides, s->sides_cap, (LitheCount)s->n_sides + 1);
  for (int k = 2; k >= 0; k--)
    if (f->plane[k] != 0) sign = f->plane[k] < 0 ? -1 : 1;
  for (int k = 0; k < 4; k++) side->plane[k] = sign * f->plane[k];
  lth_v3_copy(f->centroid, side->point);
  side->order = s->n_sides;
  s->sides[s->n_sides++] = *side;
  return LITHE_OK;
}

/// Digest of a face's corners in any order.
static void hash_corners(const LthFaceView *f, uint64_t key[2]) {
  key[0] = key[1] = 0;
  for (LitheIndex k = 0; k < f->loop_off[f->n_loops]; k++) {
    uint64_t x = ((uint64_t)(uint32_t)f->loop_point[k] + 1) * 0x9E3779B97F4A7C15u;
    x ^= x >> 29;
    key[0] += x * 0xBF58476D1CE4E5B9u;
    key[1] ^= x * 0x94D049BB133111EBu;
  }
}

static LitheStatus add_pair(LitheCtx *ctx, LthCutSolid *s, LitheIndex a, LitheIndex b,
                            LitheIndex tag) {
  LitheIndex kept;
  return lth_hash_insert(ctx, &s->pairs, lth_hash_pair(a < b ? a : b, a < b ? b : a), 0,
                         LTH_TAG_CUT - tag, &kept);
}

/// Faces that look at each other have the same corners: their elements are a pair.
static LitheStatus add_faces(LitheCtx *ctx, LthCutSolid *s) {
  const LthTopology *t = s->body_t;
  LitheStatus status = LITHE_OK;
  LthHash first = {0};
  for (LitheIndex i = 0; i < t->n_faces; i++) {
    const LthTopologyFace *f = t->faces + i;
    if (!is_new(s, f)) continue;
    LthFaceView view = lth_topology_face(t, i);
    LthCutSide side = {.box = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY},
                       .face = i};
    uint64_t key[2];
    LitheIndex other = -1;
    for (LitheIndex k = 0; k < view.loop_off[view.n_loops]; k++)
      grow(side.box, view.points + 3 * (LitheCount)view.loop_point[k]);
    LITHE_TRY_OR(done, add_side(ctx, s, f, &side));
    hash_corners(&view, key);
    LITHE_TRY_OR(done, lth_hash_insert(ctx, &first, key[0], key[1], i, &other));
    if (other != i)
      LITHE_TRY_OR(done, add_pair(ctx, s, f->cell[0], t->faces[other].cell[0], f->tag));
  }
done:
  lth_hash_free(ctx, &first);
  return status;
}

/// Faces by cell and directed edge, as the cell sees it from outside.
typedef struct Edges {
  LthHash face;
  bool *is_at_cut; ///< (n_points)
} Edges;

typedef LitheStatus (*VisitEdge)(LitheCtx *ctx, LthCutSolid *s, Edges *e, LitheIndex face,
                                 LitheIndex p, LitheIndex q);

static LitheStatus visit_edges(LitheCtx *ctx, LthCutSolid *s, Edges *e, LitheIndex face,
                               VisitEdge visit) {
  LthFaceView v = lth_topology_face(s->body_t, face);
  for (LitheIndex l = 0; l < v.n_loops; l++)
    for (LitheIndex k = v.loop_off[l]; k < v.loop_off[l + 1]; k++) {
      LitheIndex next = k + 1 < v.loop_off[l + 1] ? k + 1 : v.loop_off[l];
      LITHE_TRY(visit(ctx, s, e, face, v.loop_point[k], v.loop_point[next]));
    }
  return LITHE_OK;
}

static LitheStatus mark_edge(LitheCtx *ctx, LthCutSolid *s, Edges *e, LitheIndex face, LitheIndex p,
                             LitheIndex q) {
  (void)ctx, (void)s, (void)face;
  e->is_at_cut[p] = e->is_at_cut[q] = true;
  return LITHE_OK;
}

static LitheStatus enter_edge(LitheCtx *ctx, LthCutSolid *s, Edges *e, LitheIndex face,
                              LitheIndex p, LitheIndex q) {
  const LitheIndex *cell = s->body_t->faces[face].cell;
  LitheIndex kept;
  if (!e->is_at_cut[p] || !e->is_at_cut[q]) return LITHE_OK;
  LITHE_TRY(lth_hash_insert(ctx, &e->face, lth_hash_pair(p, q), (uint64_t)cell[0], face, &kept));
  if (cell[1] < 0) return LITHE_OK;
  return lth_hash_insert(ctx, &e->face, lth_hash_pair(q, p), (uint64_t)cell[1], face, &kept);
}

/// Walk around an edge of a cut face, from its cell through inner faces to the face where that ends: is that the other side
/// of the cut, then the cut ends in the edge. The steepest of the inner faces shows where.
static LitheStatus follow_edge(LitheCtx *ctx, LthCutSolid *s, Edges *e, LitheIndex face,
                               LitheIndex p, LitheIndex q) {
  const LthTopology *t = s->body_t;
  const LthTopologyFace *f = t->faces + face;
  LitheIndex cell = f->cell[0], steepest = -1, other;
  double least = INFINITY;
  for (LitheIndex n = 0; n <= t->n_live_cells; n++) {
    other = lth_hash_find(&e->face, lth_hash_pair(q, p), (uint64_t)cell);
    if (other < 0) return LITHE_OK;
    const LthTopologyFace *g = t->faces + other;
    if (g->cell[1] < 0) break;
    double along = fabs(lth_v3_dot(g->plane, f->plane));
    if (along < least) least = along, steepest = other;
    cell = g->cell[g->cell[0] == cell];
  }
  if (steepest < 0 || !is_new(s, t->faces + other)) return LITHE_OK;
  if (lth_v3_dot(t->faces[other].plane, f->plane) > OPPOSITE - 1) return LITHE_OK;
  LthCutSide side = {.box = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY},
                     .face = -1};
  grow(side.box, t->points + 3 * (LitheCount)p);
  grow(side.box, t->points + 3 * (LitheCount)q);
  return add_side(ctx, s, t->faces + steepest, &side);
}

/// The edges in which the new cut ends inside the body.
static LitheStatus add_front(LitheCtx *ctx, LthCutSolid *s) {
  const LthTopology *t = s->body_t;
  LitheStatus status = LITHE_OK;
  Edges e = {0};
  LTH_NEW_OR(done, ctx, e.is_at_cut, t->n_points);
  for (LitheIndex i = 0; i < t->n_faces; i++)
    if (is_new(s, t->faces + i)) LITHE_TRY_OR(done, visit_edges(ctx, s, &e, i, mark_edge));
  for (LitheIndex i = 0; i < t->n_faces; i++)
    if (t->faces[i].is_live) LITHE_TRY_OR(done, visit_edges(ctx, s, &e, i, enter_edge));
  for (LitheIndex i = 0; i < t->n_faces; i++)
    if (is_new(s, t->faces + i)) LITHE_TRY_OR(done, visit_edges(ctx, s, &e, i, follow_edge));
done:
  lth_hash_free(ctx, &e.face);
  lth_free(ctx, e.is_at_cut);
  return status;
}

LitheStatus lth_cut_solid_find_sides(LitheCtx *ctx, LthCutSolid *s) {
  LITHE_TRY(add_faces(ctx, s));
  LITHE_TRY(add_front(ctx, s));
  if (s->n_sides > 0) qsort(s->sides, (size_t)s->n_sides, sizeof *s->sides, compare_sides);
  return LITHE_OK;
}

// ------------------------------------------------------------------ parting

/// A triangle of a face.
typedef struct Triangle {
  double x[3][3];
  LitheIndex face;
} Triangle;

/// Triangles of faces, one after the other.
typedef struct Triangles {
  Triangle *at;
  LitheIndex n;
  LitheCount cap;
  LthPolygonList polygons;
  LthPolygonWork work;
  LitheIndex *corner;
  LitheCount corner_cap;
} Triangles;

static void free_triangles(LitheCtx *ctx, Triangles *t) {
  lth_free(ctx, t->at);
  lth_free(ctx, t->corner);
  lth_polygon_list_free(ctx, &t->polygons);
  lth_polygon_work_free(ctx, &t->work);
}

static LitheStatus add_triangles(LitheCtx *ctx, const LthTopology *t, LitheIndex face,
                                 Triangles *to) {
  LthFaceView view = lth_topology_face(t, face);
  LthPolygonList *list = &to->polygons;
  list->n = list->n_polygons = 0;
  LITHE_TRY(lth_face_polygons(ctx, &view, list));
  for (LitheCount at = 0; at < list->n; at += list->items[at] + 1) {
    LitheIndex n = list->items[at];
    if (n < 3) continue;
    LTH_RESERVE(ctx, to->corner, to->corner_cap, 3 * (LitheCount)n);
    LTH_RESERVE(ctx, to->at, to->cap, (LitheCount)to->n + n);
    LITHE_TRY(
        lth_polygon_triangulate(ctx, &to->work, view.points, n, list->items + at + 1, to->corner));
    for (LitheIndex k = 0; k < n - 2; k++, to->n++) {
      to->at[to->n].face = face;
      for (int i = 0; i < 3; i++)
        lth_v3_copy(view.points + 3 * (LitheCount)to->corner[3 * k + i], to->at[to->n].x[i]);
    }
  }
  return LITHE_OK;
}

static double triangle_area(const Triangle *t, double cross[3]) {
  double e[3], f[3];
  lth_v3_sub(t->x[1], t->x[0], e);
  lth_v3_sub(t->x[2], t->x[0], f);
  lth_v3_cross(e, f, cross);
  return 0.5 * lth_v3_norm(cross);
}

/// Area that two triangles of one plane with this unit normal have in common: one clipped by the sides of the other.
static double common_area(const Triangle *a, const Triangle *b, const double normal[3]) {
  double p[9][3], q[9][3], cross[3], sum[3] = {0, 0, 0};
  int n = 3;
  memcpy(p, a->x, sizeof a->x);
  triangle_area(b, cross);
  double turn = lth_v3_dot(cross, normal) < 0 ? -1 : 1;
  for (int side = 0; side < 3 && n > 0; side++) {
    double along[3], inward[3], height[9], d[3];
    int m = 0;
    lth_v3_sub(b->x[(side + 1) % 3], b->x[side], along);
    lth_v3_cross(normal, along, inward);
    for (int i = 0; i < n; i++) {
      lth_v3_sub(p[i], b->x[side], d);
      height[i] = turn * lth_v3_dot(inward, d);
    }
    for (int i = 0; i < n; i++) {
      int next = (i + 1) % n;
      if (height[i] >= 0) lth_v3_copy(p[i], q[m++]);
      if ((height[i] >= 0) == (height[next] >= 0)) continue;
      double s = height[i] / (height[i] - height[next]);
      for (int k = 0; k < 3; k++) q[m][k] = p[i][k] + s * (p[next][k] - p[i][k]);
      m++;
    }
    n = m;
    memcpy(p, q, sizeof p);
  }
  for (int i = 1; i + 1 < n; i++) {
    Triangle fan;
    lth_v3_copy(p[0], fan.x[0]);
    lth_v3_copy(p[i], fan.x[1]);
    lth_v3_copy(p[i + 1], fan.x[2]);
    triangle_area(&fan, cross);
    lth_v3_axpy(0.5, cross, sum);
  }
  return lth_v3_norm(sum);
}

/// Looking for cut faces that a face of the solid lies on.
typedef struct Parting {
  LthCutSolid *s;
  LthBvh *bvh; ///< over the triangles of the new cut faces
  Triangles cut, own;
  // the face of the solid in hand
  const LthTopologyFace *f;
  const Triangle *triangle;
  LitheIndex tag;
} Parting;

static LitheStatus make_tree(LitheCtx *ctx, Parting *w) {
  const LthCutSolid *s = w->s;
  LitheStatus status = LITHE_OK;
  double *box = NULL;
  for (LitheIndex i = 0; i < s->n_sides; i++)
    if (s->sides[i].face >= 0)
      LITHE_TRY_OR(done, add_triangles(ctx, s->body_t, s->sides[i].face, &w->cut));
  LTH_NEW_OR(done, ctx, box, 6 * (LitheCount)w->cut.n);
  for (LitheIndex i = 0; i < w->cut.n; i++) {
    double *b = box + 6 * (LitheCount)i;
    for (int a = 0; a < 3; a++) b[a] = INFINITY, b[3 + a] = -INFINITY;
    for (int k = 0; k < 3; k++) grow(b, w->cut.at[i].x[k]);
  }
  status = lth_bvh_create_boxes(ctx, w->cut.n, box, &w->bvh);
done:
  lth_free(ctx, box);
  return status;
}

static bool visit_cut(void *self, LitheIndex item) {
  Parting *w = self;
  const Triangle *cut = w->cut.at + item;
  double limit = ON_FACE * w->s->body_t->cell_size, d[3], cross[3];
  for (int i = 0; i < 3; i++) {
    lth_v3_sub(cut->x[i], w->f->centroid, d);
    if (fabs(lth_v3_dot(d, w->f->plane)) > limit) return true;
  }
  double least = COMMON * fmin(w->f->area, triangle_area(cut, cross));
  if (!(common_area(w->triangle, cut, w->f->plane) > least)) return true;
  w->tag = w->s->body_t->faces[cut->face].tag;
  return false;
}

/// Does a triangle of the solid's face have area in common with a new cut face?
static void look_for_cut(Parting *w, const Triangle *triangle) {
  double x[3], reach = 0;
  for (int a = 0; a < 3; a++)
    x[a] = (triangle->x[0][a] + triangle->x[1][a] + triangle->x[2][a]) / 3;
  for (int i = 0; i < 3; i++) reach = fmax(reach, lth_v3_distance(x, triangle->x[i]));
  w->triangle = triangle;
  lth_bvh_visit(w->bvh, x, reach, visit_cut, w);
}

/// Have two elements of the body an inner face in common?
static bool hang_together(const LthCutSolid *s, LitheIndex a, LitheIndex b) {
  for (LitheIndex i = 0; i < s->body_t->cells[a].n_faces; i++) {
    const LthTopologyFace *f = s->body_t->faces + lth_topology_cell_faces(s->body_t, a)[i];
    if (f->cell[1] >= 0 && (f->cell[0] == b || f->cell[1] == b)) return true;
  }
  return false;
}

/// Do two elements without a common face have points in common, and stand on two sides of a cut at all of them?
static bool stand_apart(const LthCutSolid *s, LitheIndex a, LitheIndex b) {
  const LthMesh *m = s->mesh;
  bool any = false;
  for (LitheIndex i = m->cell_face_off[a]; i < m->cell_face_off[a + 1]; i++) {
    LitheIndex f = m->cell_face[i];
    for (LitheIndex k = m->loop_off[m->face_loop_off[f]]; k < m->loop_off[m->face_loop_off[f + 1]];
         k++) {
      LitheIndex p = m->loop_point[k], of_a = lth_around_part(&s->around, p, a),
                 of_b = lth_around_part(&s->around, p, b);
      if (of_b < 0) continue;
      if (of_a == of_b) return false;
      any = true;
    }
  }
  return any;
}

/// Where the solid is beside the body, or the body's wedge was too thin for it: what the elements on both sides of the
/// middle of a triangle say.
static LitheIndex ask_elements(const Parting *w, const Triangle *triangle) {
  const LthCutSolid *s = w->s;
  LitheIndex record[2];
  double cross[3], size = sqrt(triangle_area(triangle, cross));
  for (int i = 0; i < 2; i++) {
    double x[3];
    for (int a = 0; a < 3; a++)
      x[a] = (triangle->x[0][a] + triangle->x[1][a] + triangle->x[2][a]) / 3;
    lth_v3_axpy((i ? BESIDE : -BESIDE) * size, w->f->plane, x);
    LitheIndex cell = lth_cell_search_find(s->search, x, NULL);
    if (cell < 0) return 0;
    record[i] = s->cell_record[cell];
  }
  LitheIndex a = record[0], b = record[1];
  if (a == b || hang_together(s, a, b)) return 0;
  LitheIndex k = lth_hash_find(&s->pairs, lth_hash_pair(a < b ? a : b, a < b ? b : a), 0);
  if (k >= 0) return LTH_TAG_CUT - k;
  bool is_apart = s->place[a] >= 0 && s->place[b] >= 0 && stand_apart(s, s->place[a], s->place[b]);
  return is_apart ? LTH_TAG_CUT - (s->body->change->n_cuts - 1) : 0;
}

static LitheStatus part_face(LitheCtx *ctx, Parting *w, LitheIndex face) {
  const Triangle *largest = NULL;
  double most = -1, cross[3];
  w->f = w->s->t->faces + face;
  w->tag = 0;
  w->own.n = 0;
  LITHE_TRY(add_triangles(ctx, w->s->t, face, &w->own));
  for (LitheIndex i = 0; i < w->own.n && w->tag == 0; i++) {
    const Triangle *triangle = w->own.at + i;
    look_for_cut(w, triangle);
    double area = triangle_area(triangle, cross);
    if (area > most) most = area, largest = triangle;
  }
  if (w->tag == 0 && largest) w->tag = ask_elements(w, largest);
  return w->tag != 0 ? lth_topology_separate(ctx, w->s->t, face, w->tag, NULL) : LITHE_OK;
}

LitheStatus lth_cut_solid_part(LitheCtx *ctx, LthCutSolid *s) {
  LitheStatus status = LITHE_OK;
  Parting w = {.s = s};
  LitheIndex n = s->t->n_faces;
  if (s->n_sides == 0) return LITHE_OK;
  LITHE_TRY_OR(done, make_tree(ctx, &w));
  for (LitheIndex i = 0; i < n; i++) {
    const LthTopologyFace *f = s->t->faces + i;
    if (f->is_live && !f->is_line && f->cell[1] >= 0) LITHE_TRY_OR(done, part_face(ctx, &w, i));
  }
done:
  lth_bvh_destroy(ctx, &w.bvh);
  free_triangles(ctx, &w.cut);
  free_triangles(ctx, &w.own);
  return status;
}

/// A solid that is not the body, cut as the body is: its cells are divided by the planes of the body's cut faces near them,
/// each part finds the element that it lies in, and parts are separated as their elements are.
#include "scene/cut_surface.h"

#include "embed/around.h"
#include "embed/cell_search.h"
#include "scene/change.h"

#include "base/hash.h"
#include "base/tensor.h"

#include <stdlib.h>
#include <string.h>

#define NUDGE                                                                                      \
  1e-3 ///< of the way to the middle of its cell: puts a point off the cuts that it lies on
#define TOUCHES 1e-6 ///< of a cell's size: a face that reaches into a cell by less only touches it

/// A face with its plane, the same from both sides.
typedef struct CutFace {
  double plane[4];
  LitheIndex face;
} CutFace;

/// A cut of the solid in progress.
typedef struct Solid {
  const LthBody *body;
  LthCutSurface *c;
  const LthTopology *body_t;
  LthTopology *t;
  const LthMesh *mesh; ///< of the body, that to come
  const LitheIndex *cell_record;
  LitheIndex *place; ///< cell of the mesh of each record, -1                (body_t->n_cells)
  LthCellSearch *search;
  LthAround around;
  CutFace *faces; ///< new cut faces of the body, those in one plane together
  LitheIndex n_faces;
  LitheCount faces_cap;
  LthHash
      pairs; ///< two elements of the body that a new cut has parted -> tag, as LTH_TAG_CUT - tag
} Solid;

// ------------------------------------------------------------------ hosts

/// Elements of the body around the middles of the solid's cells that have none, or a dead one.
static LitheStatus find_hosts(LitheCtx *ctx, Solid *s) {
  LthCutSurface *c = s->c;
  LitheCount had = c->cap_host;
  LTH_RESERVE(ctx, c->host, c->cap_host, s->t->n_cells);
  for (LitheCount i = had; i < c->cap_host; i++) c->host[i] = -1;
  for (LitheIndex i = 0; i < s->t->log.n_births; i++) c->host[s->t->log.births[i].cell] = -1;
  for (LitheIndex i = 0; i < s->t->n_cells; i++) {
    LitheIndex host = c->host[i];
    if (!s->t->cells[i].is_live || (host >= 0 && s->body_t->cells[host].is_live)) continue;
    LitheIndex cell = lth_cell_search_find(s->search, s->t->cells[i].centroid, NULL);
    c->host[i] = cell >= 0 ? s->cell_record[cell] : -1;
  }
  return LITHE_OK;
}

LitheStatus lth_cut_solid_begin(LitheCtx *ctx, LthBody *body) {
  const LthBodyChange *change = body->change;
  Solid s = {.body = body,
             .c = change->surface,
             .body_t = change->topology,
             .t = change->surface->solid,
             .mesh = body->mesh,
             .cell_record = change->cell_record};
  LITHE_TRY(lth_cell_search_create(ctx, body->mesh, &s.search));
  LitheStatus status = find_hosts(ctx, &s);
  lth_cell_search_destroy(ctx, &s.search);
  return status;
}

// ------------------------------------------------------------------ faces of the new cuts

static int compare_planes(const void *a, const void *b) {
  const CutFace *p = a, *q = b;
  for (int k = 0; k < 4; k++)
    if (p->plane[k] != q->plane[k]) return p->plane[k] < q->plane[k] ? -1 : 1;
  return (p->face > q->face) - (p->face < q->face);
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

static LitheStatus add_pair(LitheCtx *ctx, Solid *s, LitheIndex a, LitheIndex b, LitheIndex tag) {
  LitheIndex kept;
  return lth_hash_insert(ctx, &s->pairs, lth_hash_pair(a < b ? a : b, a < b ? b : a), 0,
                         LTH_TAG_CUT - tag, &kept);
}

/// Faces that look at each other have the same corners: their elements are a pair.
static LitheStatus find_faces(LitheCtx *ctx, Solid *s) {
  const LthTopology *t = s->body_t;
  LitheStatus status = LITHE_OK;
  LthHash first = {0};
  for (LitheIndex i = 0; i < t->n_faces; i++) {
    const LthTopologyFace *f = t->faces + i;
    if (!f->is_live || f->is_line || f->tag > LTH_TAG_CUT - s->c->n_cuts) continue;
    LthFaceView view = lth_topology_face(t, i);
    uint64_t key[2];
    LitheIndex other = -1;
    double sign = 1;
    LTH_RESERVE_OR(done, ctx, s->faces, s->faces_cap, (LitheCount)s->n_faces + 1);
    for (int k = 2; k >= 0; k--)
      if (f->plane[k] != 0) sign = f->plane[k] < 0 ? -1 : 1;
    for (int k = 0; k < 4; k++) s->faces[s->n_faces].plane[k] = sign * f->plane[k];
    s->faces[s->n_faces++].face = i;
    hash_corners(&view, key);
    LITHE_TRY_OR(done, lth_hash_insert(ctx, &first, key[0], key[1], i, &other));
    if (other != i)
      LITHE_TRY_OR(done, add_pair(ctx, s, f->cell[0], t->faces[other].cell[0], f->tag));
  }
  if (s->n_faces > 0) qsort(s->faces, (size_t)s->n_faces, sizeof *s->faces, compare_planes);
done:
  lth_hash_free(ctx, &first);
  return status;
}

// ------------------------------------------------------------------ dividing

/// Does a face reach into a box? By its own box, which both must have two sides in common with.
static bool reaches_into(const LthTopology *t, LitheIndex face, const double box[6], double least) {
  LthFaceView f = lth_topology_face(t, face);
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  int n_common = 0;
  for (LitheIndex k = 0; k < f.loop_off[f.n_loops]; k++)
    for (int a = 0; a < 3; a++) {
      low[a] = fmin(low[a], f.points[3 * (LitheCount)f.loop_point[k] + a]);
      high[a] = fmax(high[a], f.points[3 * (LitheCount)f.loop_point[k] + a]);
    }
  for (int a = 0; a < 3; a++) {
    double common = fmin(high[a], box[3 + a]) - fmax(low[a], box[a]);
    if (common < -least) return false;
    n_common += common > least;
  }
  return n_common >= 2;
}

/// Should a cell be divided by the plane of one of some faces? Those that reach into it, or, where it lies beside the body, those of
/// its host.
static bool is_divided(const Solid *s, LitheIndex cell, LitheIndex first, LitheIndex end) {
  const LthTopologyCell *at = s->t->cells + cell;
  double least = TOUCHES * s->t->cell_size;
  for (LitheIndex i = first; i < end; i++) {
    LitheIndex face = s->faces[i].face, of = s->body_t->faces[face].cell[0];
    if (reaches_into(s->body_t, face, at->box, least)) return true;
    bool is_inside = false;
    LitheIndex near = lth_cell_search_find(s->search, at->centroid, &is_inside);
    if (!is_inside && near >= 0 && s->cell_record[near] == of) return true;
  }
  return false;
}

/// Divide the solid's cells by the plane that the faces first ... end - 1 have in common; nothing is parted yet.
static LitheStatus divide(LitheCtx *ctx, Solid *s, LitheIndex first, LitheIndex end) {
  const LthTopologyFace *f = s->body_t->faces + s->faces[first].face;
  LitheStatus status = LITHE_OK;
  LitheIndex n = 0, *cells = NULL;
  LthPlane plane;
  LthCut cut;
  lth_v3_copy(f->plane, plane.normal);
  lth_v3_copy(f->centroid, plane.point);
  LTH_NEW_OR(done, ctx, cells, s->t->n_live_cells);
  for (LitheIndex i = 0; i < s->t->n_cells; i++)
    if (s->t->cells[i].is_live && is_divided(s, i, first, end)) cells[n++] = i;
  if (n > 0) LITHE_TRY_OR(done, lth_topology_cut(ctx, s->t, n, cells, 1, &plane, -1, &cut));
done:
  lth_free(ctx, cells);
  return status;
}

static LitheStatus divide_all(LitheCtx *ctx, Solid *s) {
  for (LitheIndex i = 0, end; i < s->n_faces; i = end) {
    for (end = i; end < s->n_faces &&
                  memcmp(s->faces[i].plane, s->faces[end].plane, sizeof s->faces[i].plane) == 0;)
      end++;
    LITHE_TRY(divide(ctx, s, i, end));
  }
  return LITHE_OK;
}

// ------------------------------------------------------------------ parting

/// Do two elements without a common face have points in common, and stand on two sides of a cut at all of them?
static bool stand_apart(const Solid *s, LitheIndex a, LitheIndex b) {
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

/// The tag with which two cells of the solid are to be parted, 0: they stay together.
static LitheIndex parting_tag(const Solid *s, LitheIndex cell, LitheIndex across) {
  LitheIndex a = s->c->host[cell], b = s->c->host[across];
  if (a < 0 || b < 0 || a == b) return 0;
  LitheIndex k = lth_hash_find(&s->pairs, lth_hash_pair(a < b ? a : b, a < b ? b : a), 0);
  if (k >= 0) return LTH_TAG_CUT - k;
  bool is_apart = s->place[a] >= 0 && s->place[b] >= 0 && stand_apart(s, s->place[a], s->place[b]);
  return is_apart ? LTH_TAG_CUT - (s->body->change->n_cuts - 1) : 0;
}

static LitheStatus part(LitheCtx *ctx, Solid *s) {
  LitheIndex n = s->t->n_faces;
  for (LitheIndex i = 0; i < n; i++) {
    const LthTopologyFace *f = s->t->faces + i;
    LitheIndex tag = f->is_live && f->cell[1] >= 0 ? parting_tag(s, f->cell[0], f->cell[1]) : 0;
    if (tag != 0) LITHE_TRY(lth_topology_separate(ctx, s->t, i, tag, NULL));
  }
  return LITHE_OK;
}

// ------------------------------------------------------------------ taking away

/// Cells of the solid that lay in the body as it was (body->mesh) and do not in what is left of it.
static LitheStatus find_gone(LitheCtx *ctx, const Solid *s, LitheIndex *n, LitheIndex *gone) {
  LthCellSearch *before = NULL;
  LITHE_TRY(lth_cell_search_create(ctx, s->body->mesh, &before));
  for (LitheIndex i = 0; i < s->t->n_cells; i++) {
    bool was_inside = false, is_inside = false;
    if (!s->t->cells[i].is_live) continue;
    lth_cell_search_find(s->search, s->t->cells[i].centroid, &is_inside);
    if (!is_inside) lth_cell_search_find(before, s->t->cells[i].centroid, &was_inside);
    if (was_inside) gone[(*n)++] = i;
  }
  lth_cell_search_destroy(ctx, &before);
  return LITHE_OK;
}

/// Part some cells from all others, and take them away. A surface that would be gone altogether stays.
static LitheStatus take_away(LitheCtx *ctx, Solid *s) {
  LitheStatus status = LITHE_OK;
  LitheIndex n = 0, *gone = NULL, n_faces = s->t->n_faces,
             tag = LTH_TAG_CUT - (s->body->change->n_cuts - 1);
  bool *is_gone = NULL;
  LTH_NEW_OR(done, ctx, gone, s->t->n_live_cells);
  LTH_NEW_OR(done, ctx, is_gone, s->t->n_cells);
  LITHE_TRY_OR(done, find_gone(ctx, s, &n, gone));
  if (n == 0 || n == s->t->n_live_cells) goto done;
  for (LitheIndex i = 0; i < n; i++) is_gone[gone[i]] = true;
  for (LitheIndex i = 0; i < n_faces; i++) {
    const LthTopologyFace *f = s->t->faces + i;
    if (f->is_live && f->cell[1] >= 0 && is_gone[f->cell[0]] != is_gone[f->cell[1]])
      LITHE_TRY_OR(done, lth_topology_separate(ctx, s->t, i, tag, NULL));
  }
  status = lth_topology_remove(ctx, s->t, n, gone);
done:
  lth_free(ctx, gone);
  lth_free(ctx, is_gone);
  return status;
}

// ------------------------------------------------------------------ points

/// The element that a point follows: the one around it, on its side of the cuts.
static LitheIndex find_home(const Solid *s, LitheIndex i) {
  const LthSkin *skin = s->c->skin;
  double x[3];
  lth_v3_copy(skin->soup->points + 3 * (LitheCount)i, x);
  if (skin->cell[i] >= 0) {
    lth_v3_scale(1 - NUDGE, x);
    lth_v3_axpy(NUDGE, s->t->cells[skin->cell[i]].centroid, x);
  }
  LitheIndex cell = lth_cell_search_find(s->search, x, NULL);
  return cell >= 0 ? s->cell_record[cell] : -1;
}

/// Homes of points that have none, that a cut has given another side, or whose element died.
static LitheStatus find_homes(LitheCtx *ctx, Solid *s, const LitheIndex *old_cell) {
  LthCutSurface *c = s->c;
  LitheIndex n = c->skin->soup->n_points;
  LTH_RESERVE(ctx, c->home, c->cap_home, n);
#pragma omp parallel for schedule(dynamic, 64) num_threads(lth_threads(ctx))
  for (LitheIndex i = 0; i < n; i++) {
    bool is_there = i < c->n_home && c->home[i] >= 0 && s->body_t->cells[c->home[i]].is_live &&
                    old_cell[i] == c->skin->cell[i];
    if (!is_there) c->home[i] = find_home(s, i);
  }
  c->n_home = n;
  return LITHE_OK;
}

static LitheStatus cut_as_body(LitheCtx *ctx, Solid *s) {
  LITHE_TRY(find_faces(ctx, s));
  LITHE_TRY(lth_around_create(ctx, s->mesh, &s->around));
  LITHE_TRY(divide_all(ctx, s));
  LITHE_TRY(take_away(ctx, s));
  LITHE_TRY(find_hosts(ctx, s));
  return part(ctx, s);
}

static LitheStatus follow(LitheCtx *ctx, Solid *s, bool is_cut) {
  LthCutSurface *c = s->c;
  LitheStatus status = LITHE_OK;
  LitheIndex n = c->skin->soup->n_points, *old_cell = NULL;
  LITHE_TRY_OR(done, lth_cell_search_create(ctx, s->mesh, &s->search));
  LTH_NEW_OR(done, ctx, s->place, s->body_t->n_cells);
  for (LitheIndex i = 0; i < s->body_t->n_cells; i++) s->place[i] = -1;
  for (LitheIndex i = 0; i < s->mesh->n_cells; i++) s->place[s->cell_record[i]] = i;
  LTH_NEW_OR(done, ctx, old_cell, n);
  memcpy(old_cell, c->skin->cell, sizeof *old_cell * (size_t)n);
  if (is_cut)
    LITHE_TRY_OR(done, cut_as_body(ctx, s));
  else
    LITHE_TRY_OR(done, find_hosts(ctx, s));
  LITHE_TRY_OR(done, lth_skin_follow(ctx, c->skin, s->t));
  if (is_cut) LITHE_TRY_OR(done, lth_skin_update(ctx, c->skin, s->t));
  LITHE_TRY_OR(done, find_homes(ctx, s, old_cell));
  status = lth_topology_forget(ctx, s->t);
done:
  lth_free(ctx, old_cell);
  return status;
}

LitheStatus lth_cut_solid_follow(LitheCtx *ctx, LthBody *body, const LthMesh *mesh,
                                 const LitheIndex *cell_record) {
  const LthBodyChange *change = body->change;
  Solid s = {.body = body,
             .c = change->surface,
             .body_t = change->topology,
             .t = change->surface->solid,
             .mesh = mesh,
             .cell_record = cell_record};
  LitheStatus status = follow(ctx, &s, change->n_cuts > s.c->n_cuts);
  lth_cell_search_destroy(ctx, &s.search);
  lth_around_free(ctx, &s.around);
  lth_hash_free(ctx, &s.pairs);
  lth_free(ctx, s.faces);
  lth_free(ctx, s.place);
  return status;
}

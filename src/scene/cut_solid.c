/// A solid that is not the body, cut as the body is: its cells are divided by the planes of the body's cut faces near them, and
/// by those in which a cut ends; then what lies on a cut face of the body is parted (cut_solid_faces.c).
#include "scene/cut_solid_priv.h"

#include "base/tensor.h"

#include <string.h>

#define NUDGE                                                                                      \
  1e-3 ///< of the way to the middle of its cell: puts a point off the cuts that it lies on
#define TOUCHES 1e-6 ///< of a cell's size: what reaches into a cell by less only touches it

// ------------------------------------------------------------------ dividing

/// Has a side of a cut more in common with a cell's box than that it touches it? Faces in two directions, edges in one.
static bool reaches_into(const LthCutSide *side, const double box[6], double least) {
  int n_common = 0;
  for (int a = 0; a < 3; a++) {
    double common = fmin(side->box[3 + a], box[3 + a]) - fmax(side->box[a], box[a]);
    if (common < -least) return false;
    n_common += common > least;
  }
  return n_common >= (side->face >= 0 ? 2 : 1);
}

/// The element nearest to a cell of the solid that lies beside the body; -1: its middle is inside.
static LitheIndex find_beside(LthCutSolid *s, LitheIndex cell) {
  LitheIndex *beside = s->beside + cell;
  if (*beside == LTH_NOT_LOOKED_FOR) {
    bool is_inside = false;
    LitheIndex near = lth_cell_search_find(s->search, s->t->cells[cell].centroid, &is_inside);
    *beside = is_inside || near < 0 ? -1 : s->cell_record[near];
  }
  return *beside;
}

/// Should a cell be divided by the plane of one of some sides? Those that reach into it, or, where it lies beside the body,
/// those of the nearest element.
static bool is_divided(LthCutSolid *s, LitheIndex cell, LitheIndex first, LitheIndex end) {
  double least = TOUCHES * s->t->cell_size;
  for (LitheIndex i = first; i < end; i++) {
    const LthCutSide *side = s->sides + i;
    if (reaches_into(side, s->t->cells[cell].box, least)) return true;
    if (side->face >= 0 && find_beside(s, cell) == s->body_t->faces[side->face].cell[0])
      return true;
  }
  return false;
}

static LitheStatus look_at_new_cells(LitheCtx *ctx, LthCutSolid *s) {
  LTH_RESERVE(ctx, s->beside, s->beside_cap, s->t->n_cells);
  for (; s->n_beside < s->t->n_cells; s->n_beside++) s->beside[s->n_beside] = LTH_NOT_LOOKED_FOR;
  return LITHE_OK;
}

/// Divide the solid's cells by the plane that the sides first ... end - 1 have in common; nothing is parted yet.
static LitheStatus divide(LitheCtx *ctx, LthCutSolid *s, LitheIndex first, LitheIndex end) {
  LitheStatus status = LITHE_OK;
  LitheIndex n = 0, *cells = NULL;
  LthPlane plane;
  LthCut cut;
  lth_v3_copy(s->sides[first].plane, plane.normal);
  lth_v3_copy(s->sides[first].point, plane.point);
  LITHE_TRY(look_at_new_cells(ctx, s));
  LTH_NEW_OR(done, ctx, cells, s->t->n_live_cells);
  for (LitheIndex i = 0; i < s->t->n_cells; i++)
    if (s->t->cells[i].is_live && is_divided(s, i, first, end)) cells[n++] = i;
  if (n > 0) LITHE_TRY_OR(done, lth_topology_cut(ctx, s->t, n, cells, 1, &plane, -1, &cut));
done:
  lth_free(ctx, cells);
  return status;
}

static LitheStatus divide_all(LitheCtx *ctx, LthCutSolid *s) {
  for (LitheIndex i = 0, end; i < s->n_sides; i = end) {
    for (end = i; end < s->n_sides &&
                  memcmp(s->sides[i].plane, s->sides[end].plane, sizeof s->sides[i].plane) == 0;)
      end++;
    LITHE_TRY(divide(ctx, s, i, end));
  }
  return LITHE_OK;
}

// ------------------------------------------------------------------ taking away

/// Cells of the solid that lay in the body as it was (body->mesh) and do not in what is left of it.
static LitheStatus find_gone(LitheCtx *ctx, const LthCutSolid *s, LitheIndex *n, LitheIndex *gone) {
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
static LitheStatus take_away(LitheCtx *ctx, LthCutSolid *s) {
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
static LitheIndex find_home(const LthCutSolid *s, LitheIndex i) {
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
static LitheStatus find_homes(LitheCtx *ctx, LthCutSolid *s, const LitheIndex *old_cell) {
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

static LitheStatus cut_as_body(LitheCtx *ctx, LthCutSolid *s) {
  LITHE_TRY(lth_cut_solid_find_sides(ctx, s));
  LITHE_TRY(lth_around_create(ctx, s->mesh, &s->around));
  LITHE_TRY(divide_all(ctx, s));
  LITHE_TRY(take_away(ctx, s));
  return lth_cut_solid_part(ctx, s);
}

static LitheStatus follow(LitheCtx *ctx, LthCutSolid *s, bool is_cut) {
  LthCutSurface *c = s->c;
  LitheStatus status = LITHE_OK;
  LitheIndex n = c->skin->soup->n_points, *old_cell = NULL;
  LITHE_TRY_OR(done, lth_cell_search_create(ctx, s->mesh, &s->search));
  LTH_NEW_OR(done, ctx, s->place, s->body_t->n_cells);
  for (LitheIndex i = 0; i < s->body_t->n_cells; i++) s->place[i] = -1;
  for (LitheIndex i = 0; i < s->mesh->n_cells; i++) s->place[s->cell_record[i]] = i;
  LTH_NEW_OR(done, ctx, old_cell, n);
  memcpy(old_cell, c->skin->cell, sizeof *old_cell * (size_t)n);
  if (is_cut) LITHE_TRY_OR(done, cut_as_body(ctx, s));
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
  LthCutSolid s = {.body = body,
                   .c = change->surface,
                   .body_t = change->topology,
                   .t = change->surface->solid,
                   .mesh = mesh,
                   .cell_record = cell_record};
  LitheStatus status = follow(ctx, &s, change->n_cuts > s.c->n_cuts);
  lth_cell_search_destroy(ctx, &s.search);
  lth_around_free(ctx, &s.around);
  lth_hash_free(ctx, &s.pairs);
  lth_free(ctx, s.sides);
  lth_free(ctx, s.beside);
  lth_free(ctx, s.place);
  return status;
}

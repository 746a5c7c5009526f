/// Evaluation of `where` trees at points, and the planes that divide faces.
#include "mesh/where.h"

#include "base/tensor.h"
#include "mesh/face_patch.h"

void lth_where_free(LitheCtx *ctx, LthWhere *where) {
  for (LitheIndex i = 0; i < where->n_children; i++) lth_where_free(ctx, &where->children[i]);
  lth_free(ctx, where->children);
  lth_shape_free(ctx, &where->shape);
  lth_free(ctx, where->label);
  where->label = NULL;
  where->children = NULL;
  where->n_children = 0;
}

static double body_size(const LthMesh *mesh) {
  double min[3], max[3], size = 0;
  lth_mesh_bounds(mesh, min, max);
  for (int i = 0; i < 3; i++) size = fmax(size, max[i] - min[i]);
  return size;
}

static LitheStatus add_plane(LitheCtx *ctx, LthWhereReady *r, const double point[3],
                             const double normal[3]) {
  LTH_RESERVE(ctx, r->planes, r->cap_planes, r->n_planes + 1);
  LthPlane *plane = &r->planes[r->n_planes++];
  lth_v3_copy(point, plane->point);
  lth_v3_copy(normal, plane->normal);
  return LITHE_OK;
}

/// The sides of all boxes of a shape.
static LitheStatus add_shape_planes(LitheCtx *ctx, LthWhereReady *r, const LthShape *shape) {
  for (int i = 0; shape->kind == LTH_SHAPE_BOX && i < 3; i++) {
    double normal[3] = {i == 0, i == 1, i == 2};
    if (isfinite(shape->a[i])) LITHE_TRY(add_plane(ctx, r, shape->a, normal));
    if (isfinite(shape->b[i])) LITHE_TRY(add_plane(ctx, r, shape->b, normal));
  }
  for (LitheIndex i = 0; i < shape->n_children; i++)
    LITHE_TRY(add_shape_planes(ctx, r, &shape->children[i]));
  return LITHE_OK;
}

static LitheStatus prepare_node(LitheCtx *ctx, LthWhereReady *r, const LthWhere *w) {
  if (w->kind == LTH_WHERE_SHAPE) LITHE_TRY(add_shape_planes(ctx, r, &w->shape));
  if (w->kind == LTH_WHERE_PLANE) LITHE_TRY(add_plane(ctx, r, w->point, w->normal));
  if (w->kind == LTH_WHERE_FACE || w->kind == LTH_WHERE_LABEL) {
    LTH_RESERVE(ctx, r->patches, r->cap_patches, r->n_patches + 1);
    LthFacePatch *patch = &r->patches[r->n_patches++];
    *patch = (LthFacePatch){.node = w};
    if (w->kind == LTH_WHERE_LABEL) return lth_mesh_label(ctx, r->mesh, w->label, patch);
    LTH_NEW(ctx, patch->member, r->mesh->n_faces);
    LITHE_TRY(lth_face_patch_grow(ctx, r->mesh, w->point, w->angle, patch->member));
  }
  for (LitheIndex i = 0; i < w->n_children; i++) LITHE_TRY(prepare_node(ctx, r, &w->children[i]));
  return LITHE_OK;
}

LitheStatus lth_where_prepare(LitheCtx *ctx, const LthMesh *mesh, const LthWhere *where,
                              LthWhereReady *ready) {
  *ready = (LthWhereReady){.mesh = mesh, .where = where, .tolerance = 1e-9 * body_size(mesh)};
  return prepare_node(ctx, ready, where);
}

void lth_where_ready_free(LitheCtx *ctx, LthWhereReady *ready) {
  for (LitheIndex i = 0; i < ready->n_patches; i++) {
    lth_free(ctx, ready->patches[i].member);
    lth_free(ctx, ready->patches[i].cell);
  }
  lth_free(ctx, ready->patches);
  lth_free(ctx, ready->planes);
  *ready = (LthWhereReady){0};
}

/// Kleene's three values; `not` is YES - answer, `and` the smaller, `or` the larger.
typedef enum Answer { NO, UNKNOWN, YES } Answer;

static Answer answer_if(bool yes) { return yes ? YES : NO; }

static Answer within_normal(const LthWhere *w, const double normal[3]) {
  double cross[3];
  lth_v3_cross(w->normal, normal, cross);
  return answer_if(atan2(lth_v3_norm(cross), lth_v3_dot(w->normal, normal)) <= w->angle + 1e-9);
}

static const LthFacePatch *patch_of(const LthWhereReady *r, const LthWhere *w) {
  LitheIndex i = 0;
  while (r->patches[i].node != w) i++;
  return &r->patches[i];
}

/// A boundary face is in a group of faces, or where there is none of that name in the group of its cell.
static Answer within_label(const LthWhereReady *r, const LthWhere *w, LitheIndex face,
                           LitheIndex cell) {
  const LthFacePatch *patch = patch_of(r, w);
  if (face >= 0)
    return answer_if(patch->member ? patch->member[face]
                                   : patch->cell[r->mesh->face_cell[2 * face]]);
  return cell < 0 || !patch->cell ? UNKNOWN : answer_if(patch->cell[cell]);
}

/// `face` and `cell` are -1 where x does not stand for one.
static Answer ask(const LthWhereReady *r, const LthWhere *w, const double x[3], LitheIndex face,
                  LitheIndex cell) {
  double d[3];
  Answer answer, child;
  switch (w->kind) {
  case LTH_WHERE_ALL:
    return YES;
  case LTH_WHERE_SHAPE:
    return answer_if(lth_shape_value(&w->shape, x) <= r->tolerance);
  case LTH_WHERE_PLANE:
    lth_v3_sub(x, w->point, d);
    return answer_if(lth_v3_dot(d, w->normal) >= -r->tolerance);
  case LTH_WHERE_NORMAL:
    return face < 0 ? UNKNOWN : within_normal(w, r->mesh->face_normal + 3 * (LitheCount)face);
  case LTH_WHERE_FACE:
    return face < 0 ? UNKNOWN : answer_if(patch_of(r, w)->member[face]);
  case LTH_WHERE_LABEL:
    return within_label(r, w, face, cell);
  case LTH_WHERE_NOT:
    return (Answer)(YES - ask(r, &w->children[0], x, face, cell));
  case LTH_WHERE_AND:
  case LTH_WHERE_OR:
    answer = w->kind == LTH_WHERE_AND ? YES : NO;
    for (LitheIndex i = 0; i < w->n_children; i++) {
      child = ask(r, &w->children[i], x, face, cell);
      if (w->kind == LTH_WHERE_AND ? child < answer : child > answer) answer = child;
    }
    return answer;
  }
  return NO;
}

bool lth_where_contains(const LthWhereReady *ready, const double x[3], LitheIndex face) {
  return ask(ready, ready->where, x, face, -1) == YES;
}

bool lth_where_contains_cell(const LthWhereReady *ready, LitheIndex cell) {
  const double *x = ready->mesh->cell_centroid + 3 * (LitheCount)cell;
  return ask(ready, ready->where, x, -1, cell) == YES;
}

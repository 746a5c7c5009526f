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
  if (w->kind == LTH_WHERE_LABEL)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED,
               "where: label %s: this mesh has no labels; select by a shape, plane, normal or face "
               "instead",
               w->label ? w->label : "");
  if (w->kind == LTH_WHERE_SHAPE) LITHE_TRY(add_shape_planes(ctx, r, &w->shape));
  if (w->kind == LTH_WHERE_PLANE) LITHE_TRY(add_plane(ctx, r, w->point, w->normal));
  if (w->kind == LTH_WHERE_FACE) {
    LTH_RESERVE(ctx, r->patches, r->cap_patches, r->n_patches + 1);
    LthFacePatch *patch = &r->patches[r->n_patches];
    *patch = (LthFacePatch){.node = w};
    LTH_NEW(ctx, patch->member, r->mesh->n_faces);
    r->n_patches++;
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
  for (LitheIndex i = 0; i < ready->n_patches; i++) lth_free(ctx, ready->patches[i].member);
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

static Answer within_patch(const LthWhereReady *r, const LthWhere *w, LitheIndex face) {
  for (LitheIndex i = 0; i < r->n_patches; i++)
    if (r->patches[i].node == w) return answer_if(r->patches[i].member[face]);
  return NO;
}

static Answer ask(const LthWhereReady *r, const LthWhere *w, const double x[3], LitheIndex face) {
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
    return face < 0 ? UNKNOWN : within_patch(r, w, face);
  case LTH_WHERE_LABEL:
    return NO;
  case LTH_WHERE_NOT:
    return (Answer)(YES - ask(r, &w->children[0], x, face));
  case LTH_WHERE_AND:
  case LTH_WHERE_OR:
    answer = w->kind == LTH_WHERE_AND ? YES : NO;
    for (LitheIndex i = 0; i < w->n_children; i++) {
      child = ask(r, &w->children[i], x, face);
      if (w->kind == LTH_WHERE_AND ? child < answer : child > answer) answer = child;
    }
    return answer;
  }
  return NO;
}

bool lth_where_contains(const LthWhereReady *ready, const double x[3], LitheIndex face) {
  return ask(ready, ready->where, x, face) == YES;
}

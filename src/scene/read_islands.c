/// Islands of images: pieces that no voxel face joins, told, or left out but for the largest or for those that constraints
/// hold.
#include "scene/reader.h"

#include "base/tensor.h"
#include "mesh/where_place.h"

#include <math.h>
#include <string.h>

#define ISLANDS_TOLD 5

enum { ISLANDS_REPORT, ISLANDS_KEEP_LARGEST, ISLANDS_REMOVE_FREE };

static int read_choice(const LthNode *image) {
  static const char *const words[] = {"report", "keep-largest", "remove-free", NULL};
  return lth_read_word(image, "islands", words);
}

/// Sizes of the islands that `of` (NULL: all) does not name, in a few words: "120, 40, ...".
static const char *list_sizes(LthReader *r, const LthImage *m, const bool *of, LitheCount *all) {
  const char *list = "";
  LitheIndex n = 0;
  *all = 0;
  for (LitheIndex i = 0; i < m->n_islands; i++) {
    if (of && of[i]) continue;
    *all += m->island_size[i];
    if (n < ISLANDS_TOLD)
      list = lth_arena_print(r->arena, "%s%s%lld", list ? list : "", n ? ", " : "",
                             (long long)m->island_size[i]);
    n++;
  }
  if (n > ISLANDS_TOLD) list = lth_arena_print(r->arena, "%s, ...", list ? list : "");
  return list ? list : "";
}

static LitheStatus keep_largest(LthReader *r, LthImage *m) {
  bool *keep = NULL;
  LTH_NEW(r->ctx, keep, m->n_islands);
  LitheIndex largest = 0;
  for (LitheIndex i = 1; i < m->n_islands; i++)
    if (m->island_size[i] > m->island_size[largest]) largest = i;
  keep[largest] = true;
  lth_image_drop(m, keep);
  lth_free(r->ctx, keep);
  return LITHE_OK;
}

LitheStatus lth_settle_islands(LthReader *r, const LthNode *image, LthImage *m) {
  LitheCount all;
  if (m->n_islands < 2) return LITHE_OK;
  const char *file = lth_read_text(image, "file"), *list = list_sizes(r, m, NULL, &all);
  switch (read_choice(image)) {
  case ISLANDS_REMOVE_FREE:
    return LITHE_OK; // once constraints are known
  case ISLANDS_KEEP_LARGEST:
    lth_warn(r->ctx, "%s: it shows %d islands of %s voxels; only the largest is kept", file,
             m->n_islands, list);
    return keep_largest(r, m);
  default:
    lth_warn(r->ctx,
             "%s: it shows %d islands of %s voxels (%lld in all), which nothing joins; `islands: "
             "keep-largest` leaves all but one out, `remove-free` those that no constraint holds",
             file, m->n_islands, list, (long long)all);
    return LITHE_OK;
  }
}

// --- islands that no constraint holds ---

/// Does `ready` contain the middle of a face between a voxel and what is outside?
static bool holds_face(const LthImage *m, const LthWhereSolid *ready, const LitheIndex at[3],
                       int axis, int side) {
  const LthVolume *v = m->volume;
  LthPlace place = {.is_boundary = true};
  LitheIndex next[3] = {at[0], at[1], at[2]};
  next[axis] += side;
  bool in = next[axis] >= 0 && next[axis] < v->n[axis];
  if (in && m->island[lth_volume_index(v, next[0], next[1], next[2])] >= 0) return false;
  for (int i = 0; i < 3; i++) {
    const double *row = v->to_world + 4 * i;
    double step = 0.5 * side * row[axis];
    place.x[i] = row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + row[3] + step;
    place.normal[i] = step;
  }
  lth_v3_normalize(place.normal);
  lth_v3_copy(place.x, place.point);
  return lth_where_solid_contains(ready, &place);
}

static bool holds_voxel(const LthImage *m, const LthWhereSolid *ready, const LitheIndex at[3]) {
  int dim = m->volume->n[2] > 1 ? 3 : 2;
  for (int axis = 0; axis < dim; axis++)
    for (int side = -1; side <= 1; side += 2)
      if (holds_face(m, ready, at, axis, side)) return true;
  return false;
}

/// Mark the islands with boundary in one constraint's selection.
static LitheStatus mark_held(LthReader *r, const LthSceneBody *body, const LthWhere *where,
                             bool *held) {
  const LthImage *m = body->shape.image;
  const LthVolume *v = m->volume;
  LthWhereSolid ready = {0};
  const double edge = sqrt(v->to_world[0] * v->to_world[0] + v->to_world[4] * v->to_world[4] +
                           v->to_world[8] * v->to_world[8]);
  LitheStatus status = lth_where_solid_prepare(r->ctx, where, v->n[2] > 1 ? 3 : 2, &body->shape,
                                               NULL, edge, false, &ready);
  LitheCount p = 0;
  for (LitheIndex k = 0; status == LITHE_OK && k < v->n[2]; k++)
    for (LitheIndex j = 0; j < v->n[1]; j++)
      for (LitheIndex i = 0; i < v->n[0]; i++, p++) {
        LitheIndex island = m->island[p];
        if (island >= 0 && !held[island])
          held[island] = holds_voxel(m, &ready, (LitheIndex[]){i, j, k});
      }
  lth_where_solid_free(r->ctx, &ready);
  return status;
}

static LitheStatus remove_free(LthReader *r, const LthNode *image, const LthSceneBody *body,
                               bool *held) {
  LthImage *m = (LthImage *)(uintptr_t)body->shape.image; // owned by the scene that is being read
  LitheIndex n_held = 0;
  LitheCount n_voxels;
  for (LitheIndex i = 0; i < body->n_constraints; i++)
    LITHE_TRY(mark_held(r, body, &body->constraints[i].where, held));
  for (LitheIndex i = 0; i < m->n_islands; i++) n_held += held[i];
  if (n_held == 0) {
    lth_report(r->report, lth_node_find(image, "islands"),
               "no constraint holds any of the %d islands, got remove-free; expected constraints "
               "that reach one, or keep-largest",
               m->n_islands);
    return LITHE_OK;
  }
  if (n_held == m->n_islands) return LITHE_OK;
  const char *list = list_sizes(r, m, held, &n_voxels);
  lth_warn(r->ctx,
           "%s: %d of %d islands (%s voxels, %lld in all) are held by no constraint and left out",
           lth_read_text(image, "file"), m->n_islands - n_held, m->n_islands, list,
           (long long)n_voxels);
  lth_image_drop(m, held);
  return LITHE_OK;
}

/// The first image below a shape's node that asks for it, or NULL.
static const LthNode *find_request(const LthNode *node) {
  const LthNode *islands = node->kind == LTH_NODE_MAP ? lth_node_find(node, "islands") : NULL;
  if (islands && lth_node_is_text(islands, "remove-free")) return islands;
  for (const LthNode *child = node->first; child; child = child->next) {
    const LthNode *found = find_request(child);
    if (found) return found;
  }
  return NULL;
}

LitheStatus lth_read_islands(LthReader *r, const LthNode *shape, const LthSceneBody *body) {
  const LthNode *request = shape ? find_request(shape) : NULL;
  const LthNode *image = shape ? lth_node_find(shape, "image") : NULL;
  bool *held = NULL;
  if (!request) return LITHE_OK;
  if (!image || request->parent != image) {
    lth_report(
        r->report, request,
        "constraints hold the whole shape, not one image of it, got remove-free; expected an "
        "image that is the shape alone, or keep-largest");
    return LITHE_OK;
  }
  if (body->shape.kind != LTH_SHAPE_IMAGE || body->shape.image->n_islands < 2) return LITHE_OK;
  LTH_NEW(r->ctx, held, body->shape.image->n_islands);
  LitheStatus status = remove_free(r, image, body, held);
  lth_free(r->ctx, held);
  return status;
}

/// Shapes from images: files read, placed and selected from; what `value` and `label` mean.
#include "scene/reader.h"

#include "base/tensor.h"
#include "io/volume_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

LitheStatus lth_own_volume(LthReader *r, LthVolume *volume) {
  LthSceneOwned *owned = r->owned;
  LitheStatus status = lth_reserve_(r->ctx, (void **)&owned->volumes, &owned->cap_volumes,
                                    owned->n_volumes + 1, sizeof *owned->volumes);
  if (status == LITHE_OK)
    owned->volumes[owned->n_volumes++] = volume;
  else
    lth_volume_destroy(r->ctx, &volume);
  return status;
}

LitheStatus lth_own_image(LthReader *r, LthImage *image) {
  LthSceneOwned *owned = r->owned;
  LitheStatus status = lth_reserve_(r->ctx, (void **)&owned->images, &owned->cap_images,
                                    owned->n_images + 1, sizeof *owned->images);
  if (status == LITHE_OK)
    owned->images[owned->n_images++] = image;
  else
    lth_image_destroy(r->ctx, &image);
  return status;
}

/// Report the message of a failure that is the scene's or the file's fault.
static LitheStatus blame(LthReader *r, const LthNode *node, LitheStatus status) {
  if (status != LITHE_BAD_INPUT) return status;
  lth_report(r->report, node, "%s", lithe_ctx_message(r->ctx));
  return LITHE_OK;
}

/// Voxel axes of the length `spacing`, then `place`.
static LitheStatus place_volume(LthReader *r, const LthNode *node, const LthPlacement *place,
                                LthVolume *v) {
  double A[12], placed[12], spacing[3];
  memcpy(A, v->to_world, sizeof A);
  bool has_spacing = lth_read_vector(node, "spacing", spacing);
  for (int j = 0; j < 3 && has_spacing; j++) {
    double length = sqrt(A[j] * A[j] + A[4 + j] * A[4 + j] + A[8 + j] * A[8 + j]);
    if (!(spacing[j] > 0)) {
      lth_report(r->report, lth_node_find(node, "spacing"),
                 "no size of a voxel, got %g m along axis %d; expected three positive lengths",
                 spacing[j], j + 1);
      return LITHE_OK;
    }
    for (int i = 0; i < 3; i++) A[4 * i + j] *= spacing[j] / length;
  }
  if (r->scene->dimension == 2) A[3] = A[0] / 2, A[7] = A[5] / 2; // the corner stays at the origin
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++)
      placed[4 * i + j] = place->rotation[3 * i] * A[j] + place->rotation[3 * i + 1] * A[4 + j] +
                          place->rotation[3 * i + 2] * A[8 + j] +
                          (j == 3 ? place->translation[i] : 0);
  return lth_volume_place(r->ctx, v, placed);
}

/// A plane scene takes flat images, all others take volumes.
static bool check_kind(LthReader *r, const LthNode *file) {
  size_t n = strlen(file->text);
  bool is_flat = n > 4 && strcasecmp(file->text + n - 4, ".png") == 0;
  if (is_flat == (r->scene->dimension == 2)) return true;
  lth_report(r->report, file,
             is_flat ? "a flat image, got %s in three dimensions; expected .nii, .nii.gz, .nrrd or "
                       ".mhd, or `dimension: 2`"
                     : "an image in three dimensions, got %s in `dimension: 2`; expected .png",
             lth_show(r->arena, file));
  return false;
}

static LitheStatus read_volume(LthReader *r, const LthNode *node, const LthPlacement *place,
                               LthVolume **volume) {
  const LthNode *file = lth_node_get(node, "file");
  const char *path = NULL;
  *volume = NULL;
  if (!file || !r->opens_files) return LITHE_OK;
  LITHE_TRY(lth_find_file(r, file, &path));
  if (!path || !check_kind(r, file)) return LITHE_OK;
  LitheStatus status = lth_volume_read(r->ctx, path, volume);
  if (status != LITHE_OK) return blame(r, file, status);
  LITHE_TRY(lth_own_volume(r, *volume));
  status = place_volume(r, node, place, *volume);
  if (status != LITHE_OK) *volume = NULL;
  return blame(r, file, status);
}

/// Labels of the list; NULL where there is none.
static const double *read_labels(LthReader *r, const LthNode *list, LitheIndex *n) {
  *n = 0;
  if (!list) return NULL;
  double *labels = lth_read_array(r, list, sizeof *labels);
  for (const LthNode *item = list->first; labels && item; item = item->next)
    if (item->has_value && !item->bad) labels[(*n)++] = item->value.constant;
  return labels;
}

static LitheStatus select_voxels(LthReader *r, const LthNode *node, const LthVolume *volume,
                                 LthImage **image) {
  const LthNode *list = lth_node_get(node, "labels"), *threshold = lth_node_get(node, "threshold");
  LitheIndex n_labels = 0;
  const double *labels = read_labels(r, list, &n_labels);
  LitheStatus status =
      lth_image_create(r->ctx, volume, lth_read_number(node, "threshold", 0), labels, n_labels,
                       lth_read_number(node, "smooth", 0), image);
  if (status != LITHE_OK) return blame(r, list ? list : threshold ? threshold : node, status);
  LITHE_TRY(lth_own_image(r, *image));
  return lth_settle_islands(r, node, *image);
}

LitheStatus lth_read_image(LthReader *r, const LthNode *node, const LthPlacement *place,
                           LthShape *shape) {
  LthVolume *volume = NULL;
  LthImage *image = NULL;
  *shape = (LthShape){.kind = LTH_SHAPE_SPHERE, .radius = 1}; // until there is an image
  bool has_threshold = lth_node_find(node, "threshold"), has_labels = lth_node_find(node, "labels");
  if (has_threshold == has_labels)
    lth_report(r->report, node, "%s, got %s of threshold and labels; expected exactly one",
               has_labels ? "contradictory" : "incomplete", has_labels ? "both" : "none");
  LITHE_TRY(read_volume(r, node, place, &volume));
  if (!volume || has_threshold == has_labels) return LITHE_OK;
  LITHE_TRY(select_voxels(r, node, volume, &image));
  if (image) *shape = (LthShape){.kind = LTH_SHAPE_IMAGE, .image = image};
  return LITHE_OK;
}

/// --- value and label ---

typedef struct ImageLabel {
  const LthImage *image;
  double label;
} ImageLabel;

static double outside_label(const void *self, const double x[3], double t) {
  const ImageLabel *l = self;
  (void)t;
  return lth_image_label(l->image, x) == l->label ? -1 : 1;
}

/// A label that no voxel has selects nothing.
static bool has_label(const LthVolume *v, double label) {
  for (LitheCount p = 0; p < lth_volume_size(v); p++)
    if ((double)v->values[p] == label) return true;
  return false;
}

LitheStatus lth_read_image_label(LthReader *r, const LthNode *node, LthWhere *where) {
  char *end = NULL;
  double label = strtod(node->text, &end);
  if (*end || end == node->text || !has_label(r->image->volume, label)) {
    lth_report(r->report, node,
               "no voxel of the image has this label, got %s; expected the number of one that is "
               "there",
               lth_show(r->arena, node));
    return LITHE_OK;
  }
  ImageLabel *l = lth_arena_take(r->arena, sizeof *l);
  if (!l) LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  *l = (ImageLabel){r->image, label};
  where->kind = LTH_WHERE_SHAPE;
  where->shape =
      (LthShape){.kind = LTH_SHAPE_IMPLICIT, .value = {.eval = outside_label, .self = l}};
  for (int i = 0; i < 3; i++) where->shape.box[i] = -INFINITY, where->shape.box[3 + i] = INFINITY;
  return LITHE_OK;
}

void lth_bind_image(LthReader *r, const LthNode *map, const char *key) {
  LthNode *node = lth_node_find(map, key);
  if (!node || node->bad || !node->has_value || node->value.eval != lth_expression_eval) return;
  LthExpression *e = (LthExpression *)(uintptr_t)node->value.self;
  if (!(lth_expression_uses(e) & LTH_USES_IMAGE)) return;
  if (r->image)
    lth_expression_bind(e, r->image);
  else if (!r->image_is_missing)
    lth_report(r->report, node,
               "value and label are known only in bodies made from images, got %s; expected an "
               "expression of x, y%s, or an image as the shape",
               lth_show(r->arena, node), r->scene->dimension == 3 ? ", z" : "");
}

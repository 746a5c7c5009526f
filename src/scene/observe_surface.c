/// The embedded surface: surface.obj (at rest) with surface.pc2, numbered .obj .ply .stl. A cut while the run goes on ends
/// the cache, which has one number of points for all frames: numbered .obj follow.
#include "io/file.h"
#include "io/pc2.h"
#include "io/surface_file.h"
#include "scene/change.h"
#include "scene/cut_surface.h"
#include "scene/observe.h"

#include "base/tensor.h"

#include <stdio.h>
#include <string.h>

struct LthSurfaceOutput {
  char *folder, *stem;
  LthPc2 *pc2;
  double *points; ///< deformed, in the space of the output   (n x 3)
  LitheIndex n_frames;
  LitheIndex n_cached; ///< frames in the cache when a cut ended it, -1: it goes on
  bool kinds[3];       ///< numbered .obj, .ply, .stl
  bool in_file_space;
  double inverse[9], shift[3]; ///< file = inverse (scene - shift)
};

/// Without an embedded surface there is nothing to write.
static bool is_wanted(const LthBody *body) {
  const LthScene *scene = body->scene;
  if (!body->embedding) return false;
  return scene->surface_pc2 || scene->surface_obj || scene->surface_ply || scene->surface_stl;
}

/// Has a cut changed the surface since the run began?
static bool has_other_points(const LthBody *body) {
  return body->change && body->change->surface && body->change->surface->has_changed;
}

/// Invert scene = A file + b.
static LitheStatus invert(LitheCtx *ctx, const LthSceneBody *def, LthSurfaceOutput *out) {
  double A[9], C[9];
  for (int r = 0; r < 3; r++) {
    memcpy(A + 3 * r, def->file_to_scene + 4 * r, 3 * sizeof *A);
    out->shift[r] = def->file_to_scene[4 * r + 3];
  }
  double det = lth_m3_det(A);
  if (det == 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "output.space: `file` needs a body whose shape is a mesh file; use `scene`");
  lth_m3_cofactor(A, C);
  for (int i = 0; i < 9; i++) out->inverse[i] = C[3 * (i % 3) + i / 3] / det;
  return LITHE_OK;
}

static void to_output_space(const LthSurfaceOutput *out, LitheIndex n, double *points) {
  if (!out->in_file_space) return;
  for (LitheIndex i = 0; i < n; i++) {
    double d[3];
    lth_v3_sub(points + 3 * (LitheCount)i, out->shift, d);
    lth_m3_apply(out->inverse, d, points + 3 * (LitheCount)i);
  }
}

/// surface.obj at rest and the cache that moves it.
static LitheStatus open_cache(LitheCtx *ctx, const LthBody *body, double period, bool resumes,
                              LthSurfaceOutput *out) {
  LitheStatus status = LITHE_OK;
  char *obj = NULL, *pc2 = NULL;
  LitheIndex n = body->soup->n_points;
  memcpy(out->points, body->soup->points, sizeof *out->points * 3 * (size_t)n);
  to_output_space(out, n, out->points);
  LITHE_TRY_OR(done, lth_path_ending(ctx, out->folder, out->stem, "obj", &obj));
  LITHE_TRY_OR(done, lth_path_ending(ctx, out->folder, out->stem, "pc2", &pc2));
  LITHE_TRY_OR(done, lth_soup_write_obj(ctx, obj, body->soup, out->points));
  LITHE_TRY_OR(done, resumes ? lth_pc2_reopen(ctx, pc2, n, &out->pc2)
                             : lth_pc2_open(ctx, pc2, n, period, &out->pc2));

done:
  lth_free(ctx, obj);
  lth_free(ctx, pc2);
  return status;
}

LitheStatus lth_surface_output_open(LitheCtx *ctx, const char *folder, const LthBody *body,
                                    double period, bool resumes, LthSurfaceOutput **out) {
  LTH_NEW(ctx, *out, 1);
  (*out)->n_cached = -1;
  LITHE_TRY(lth_copy_text(ctx, folder, &(*out)->folder));
  LITHE_TRY(lth_output_stem(ctx, body, "surface", &(*out)->stem));
  if (!is_wanted(body)) return LITHE_OK;
  (*out)->kinds[0] = body->scene->surface_obj;
  (*out)->kinds[1] = body->scene->surface_ply;
  (*out)->kinds[2] = body->scene->surface_stl;
  (*out)->in_file_space = body->scene->output_in_file_space;
  if ((*out)->in_file_space) LITHE_TRY(invert(ctx, body->def, *out));
  LTH_NEW(ctx, (*out)->points, 3 * (LitheCount)body->soup->n_points);
  if (!body->scene->surface_pc2) return LITHE_OK;
  // of a run that goes on behind a cut the cache is complete
  if (resumes && has_other_points(body)) return LITHE_OK;
  return open_cache(ctx, body, period, resumes, *out);
}

LitheStatus lth_surface_output_renew(LitheCtx *ctx, LthSurfaceOutput *out, const LthBody *body) {
  if (!is_wanted(body) || !has_other_points(body)) return LITHE_OK;
  lth_free(ctx, out->points);
  LTH_NEW(ctx, out->points, 3 * (LitheCount)body->soup->n_points);
  if (!out->pc2) return LITHE_OK;
  out->n_cached = out->n_frames;
  out->kinds[0] = true;
  return lth_pc2_close(ctx, &out->pc2);
}

void lth_surface_output_put(LthJson *json, const LthSurfaceOutput *out) {
  char name[300];
  if (!out || out->n_cached < 0) return;
  lth_json_begin_object(json, "surface");
  lth_json_integer(json, "pc2_frames", out->n_cached);
  snprintf(name, sizeof name, "%s_%04d.obj", out->stem, out->n_cached);
  lth_json_string(json, "numbered_from", name);
  lth_json_string(json, "why",
                  "a cut gave the surface other points, of which a pc2 cache has the same number "
                  "in all frames");
  lth_json_end_object(json);
}

typedef LitheStatus WriteFn(LitheCtx *ctx, const char *path, const LthSoup *soup,
                            const double *points);

static LitheStatus write_numbered(LitheCtx *ctx, const LthSurfaceOutput *out, const LthBody *body,
                                  const char *ending, WriteFn *write) {
  char *path;
  LITHE_TRY(lth_path_numbered(ctx, out->folder, out->stem, out->n_frames, ending, &path));
  LitheStatus status = write(ctx, path, body->soup, out->points);
  lth_free(ctx, path);
  return status;
}

LitheStatus lth_surface_output_frame(LitheCtx *ctx, LthSurfaceOutput *out, const LthBody *body) {
  const LthScene *scene = body->scene;
  if (!is_wanted(body)) return LITHE_OK;
  lth_embedding_apply(body->embedding, lth_threads(ctx), lth_body_displacement(body), out->points);
  to_output_space(out, body->soup->n_points, out->points);
  if (out->pc2) LITHE_TRY(lth_pc2_append(ctx, out->pc2, out->points));
  if (out->kinds[0]) LITHE_TRY(write_numbered(ctx, out, body, "obj", lth_soup_write_obj));
  if (scene->surface_ply) LITHE_TRY(write_numbered(ctx, out, body, "ply", lth_soup_write_ply));
  if (scene->surface_stl) LITHE_TRY(write_numbered(ctx, out, body, "stl", lth_soup_write_stl));
  out->n_frames++;
  return LITHE_OK;
}

/// Remove what a longer run left behind, of the kinds that this run wrote.
static LitheStatus remove_rest(LitheCtx *ctx, const LthSurfaceOutput *out) {
  const char *folder = out->folder, *stem = out->stem;
  LitheIndex n = out->n_frames;
  if (n == 0) return LITHE_OK;
  if (out->kinds[0]) LITHE_TRY(lth_file_remove_numbered(ctx, folder, stem, n, "obj"));
  if (out->kinds[1]) LITHE_TRY(lth_file_remove_numbered(ctx, folder, stem, n, "ply"));
  if (out->kinds[2]) LITHE_TRY(lth_file_remove_numbered(ctx, folder, stem, n, "stl"));
  return LITHE_OK;
}

void lth_surface_output_archive(LthSurfaceOutput *out, LthArchive *archive) {
  LTH_ARCHIVE(archive, out->n_frames);
  LTH_ARCHIVE(archive, out->n_cached);
  out->kinds[0] = out->kinds[0] || out->n_cached >= 0;
  if (out->pc2) lth_pc2_archive(out->pc2, archive);
}

LitheStatus lth_surface_output_close(LitheCtx *ctx, LthSurfaceOutput **out) {
  LthSurfaceOutput *o = *out;
  if (!o) return LITHE_OK;
  LitheStatus status = lth_pc2_close(ctx, &o->pc2);
  LitheStatus removed = remove_rest(ctx, o);
  lth_free(ctx, o->folder);
  lth_free(ctx, o->stem);
  lth_free(ctx, o->points);
  lth_free(ctx, o);
  *out = NULL;
  return status != LITHE_OK ? status : removed;
}

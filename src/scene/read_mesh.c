/// Surface files of a scene: found, read, scaled, fitted, placed and cleaned.
#include "scene/reader.h"

#include "base/tensor.h"
#include "io/file.h"
#include "io/surface_file.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>

LitheStatus lth_own_surface(LthReader *r, LthSurface *surface) {
  LthSceneOwned *owned = r->owned;
  LitheStatus status = lth_reserve_(r->ctx, (void **)&owned->surfaces, &owned->cap_surfaces,
                                    owned->n_surfaces + 1, sizeof *owned->surfaces);
  if (status == LITHE_OK)
    owned->surfaces[owned->n_surfaces++] = surface;
  else
    lth_surface_destroy(r->ctx, &surface);
  return status;
}

LitheStatus lth_own_soup(LthReader *r, LthSoup *soup) {
  LthSceneOwned *owned = r->owned;
  LitheStatus status = lth_reserve_(r->ctx, (void **)&owned->soups, &owned->cap_soups,
                                    owned->n_soups + 1, sizeof *owned->soups);
  if (status == LITHE_OK)
    owned->soups[owned->n_soups++] = soup;
  else
    lth_soup_destroy(r->ctx, &soup);
  return status;
}

LitheStatus lth_own_wrap(LthReader *r, LthWrap *wrap) {
  LthSceneOwned *owned = r->owned;
  LitheStatus status = lth_reserve_(r->ctx, (void **)&owned->wraps, &owned->cap_wraps,
                                    owned->n_wraps + 1, sizeof *owned->wraps);
  if (status == LITHE_OK)
    owned->wraps[owned->n_wraps++] = wrap;
  else
    lth_wrap_destroy(r->ctx, &wrap);
  return status;
}

LitheStatus lth_find_file(LthReader *r, const LthNode *node, const char **path) {
  char *joined = NULL;
  *path = NULL;
  LITHE_TRY(lth_path_join(r->ctx, r->scene->directory, node->text, &joined));
  const char *kept = lth_arena_text(r->arena, joined, strlen(joined));
  lth_free(r->ctx, joined);
  if (!kept) LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  struct stat info;
  const char *shown = lth_show(r->arena, node), *why = NULL;
  if (stat(kept, &info) != 0)
    why = strerror(errno);
  else if (!S_ISREG(info.st_mode))
    why = S_ISDIR(info.st_mode) ? "it is a folder" : "it is no regular file";
  if (why)
    lth_report(r->report, node, "cannot be read: %s, got %s; expected a file (looked for %s)", why,
               shown, kept);
  else
    *path = kept;
  return LITHE_OK;
}

double lth_read_unit(LthReader *r, const LthNode *node) {
  LthUnit unit;
  const char *name = lth_read_text(node, "unit");
  if (!name) return 1;
  static const LthUnit metre = {1, {1, 0, 0, 0}};
  if (lth_unit_parse(name, &unit, NULL, NULL) && lth_unit_same(&unit, &metre)) return unit.factor;
  lth_report(r->report, lth_node_find(node, "unit"),
             "no unit of length, got %s; expected m, mm, cm, um, in "
             "or ft",
             lth_show_text(r->arena, name));
  return 1;
}

/// Box of the points that polygons use; false where there are none.
static bool used_bounds(const LthSoup *soup, double min[3], double max[3]) {
  for (int i = 0; i < 3; i++) min[i] = INFINITY, max[i] = -INFINITY;
  LitheIndex n = soup->n_polys ? soup->poly_off[soup->n_polys] : 0;
  for (LitheIndex k = 0; k < n; k++) {
    const double *x = soup->points + 3 * (size_t)soup->poly_point[k];
    for (int i = 0; i < 3; i++) min[i] = fmin(min[i], x[i]), max[i] = fmax(max[i], x[i]);
  }
  return n > 0;
}

/// Fit: the longest side becomes `fit`, the box is centred on the origin and rests on 0 along `up`.
static void fit_map(const LthNode *node, const LthSoup *soup, double *scale, double shift[3]) {
  static const char *const axes[] = {"x", "y", "z", NULL};
  double fit = lth_read_number(node, "fit", 0), min[3], max[3];
  for (int i = 0; i < 3; i++) shift[i] = 0;
  if (!(fit > 0) || !used_bounds(soup, min, max)) return;
  double longest = fmax(max[0] - min[0], fmax(max[1] - min[1], max[2] - min[2]));
  if (!(longest > 0) || !isfinite(longest)) return;
  *scale = fit / longest;
  int up = lth_read_word(node, "up", axes);
  for (int i = 0; i < 3; i++)
    shift[i] = -*scale * (i == up ? min[i] : min[i] + (max[i] - min[i]) / 2);
}

/// x_scene = R (scale x + shift) + t as a 3x4 matrix.
static void file_map(LthReader *r, const LthNode *node, const LthSoup *soup,
                     const LthPlacement *place, double A[12]) {
  const LthNode *up = lth_node_find(node, "up");
  if (up && !up->is_default && !lth_node_find(node, "fit"))
    lth_report_key(r->report, up,
                   "it goes with fit, got no fit; expected fit beside it, or place.rotate");
  double shift[3], b[3], scale = lth_read_unit(r, node) * lth_read_number(node, "scale", 1);
  fit_map(node, soup, &scale, shift);
  lth_place_point(place, shift, b);
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) A[4 * i + j] = scale * place->rotation[3 * i + j];
    A[4 * i + 3] = b[i];
  }
}

static void map_points(LitheIndex n, double *points, const double A[12]) {
  for (LitheIndex p = 0; p < n; p++) {
    double *x = points + 3 * (size_t)p, old[3] = {x[0], x[1], x[2]};
    for (int i = 0; i < 3; i++)
      x[i] = A[4 * i] * old[0] + A[4 * i + 1] * old[1] + A[4 * i + 2] * old[2] + A[4 * i + 3];
  }
}

/// Report the message of a failure that is the file's fault.
static LitheStatus blame_file(LthReader *r, const LthNode *file, LitheStatus status,
                              const char *more) {
  if (status != LITHE_BAD_INPUT) return status;
  lth_report(r->report, file, "%s%s", lithe_ctx_message(r->ctx), more);
  return LITHE_OK;
}

/// Write the places of defects where the caller wants them; the text for the message.
static const char *write_defects(LthReader *r, const LthDefects *defects) {
  if (!r->defects_path || defects->n == 0) return "";
  const char *done = NULL;
  char *message =
      lth_arena_text(r->arena, lithe_ctx_message(r->ctx), strlen(lithe_ctx_message(r->ctx)));
  if (lth_defects_write_ply(r->ctx, r->defects_path, defects) == LITHE_OK)
    done = lth_arena_print(r->arena, "; they are drawn in %s", r->defects_path);
  else
    done = lth_arena_print(r->arena, "; they could not be drawn: %s", lithe_ctx_message(r->ctx));
  lth_fail(r->ctx, LITHE_BAD_INPUT, "%s", message ? message : "");
  return done ? done : "";
}

/// What a user can do about a defective surface besides mending the file.
static const char *remedy(LthReader *r, const LthNode *node, const LthDefects *defects) {
  bool may_wrap = lth_node_find(node, "repair") && defects->n > 0;
  const char *drawn = write_defects(r, defects);
  if (!may_wrap) return drawn;
  const char *text =
      lth_arena_print(r->arena, "; or write `repair: wrap` beside file, which closes it%s", drawn);
  return text ? text : drawn;
}

/// The clean surface in the file's own coordinates. With `wrap` a surface with defects is no error:
/// *n_crossings then says how many of its triangles cross, and mesh->surface stays NULL.
static LitheStatus clean_surface(LthReader *r, const LthNode *node, bool wrap, LthMeshFile *mesh,
                                 LitheIndex *n_crossings) {
  const LthNode *file = lth_node_get(node, "file");
  LthDefects defects = {0};
  LthSurface *surface = NULL;
  LitheStatus status = lth_surface_from_soup(r->ctx, mesh->soup, file->text, &defects, &surface);
  if (status == LITHE_OK) {
    status = lth_own_surface(r, surface);
    mesh->surface = status == LITHE_OK ? surface : NULL;
  } else if (status == LITHE_BAD_INPUT && wrap) {
    status = LITHE_OK;
  } else {
    const char *more = status == LITHE_BAD_INPUT ? remedy(r, node, &defects) : "";
    status = blame_file(r, file, status, more);
  }
  *n_crossings = defects.count[LTH_DEFECT_CROSSING];
  lth_defects_free(r->ctx, &defects);
  return status;
}

/// Part of an enumeration.
static const char *join(LthReader *r, const char *list, const char *item) {
  if (!list || !item) return item ? item : list;
  const char *joined = lth_arena_print(r->arena, "%s, %s", list, item);
  return joined ? joined : list;
}

/// What is wrong with a file, in one line of the result.
static void warn_of_wrapping(LthReader *r, const LthNode *file, LitheIndex n_crossings,
                             const LthWrap *w) {
  const struct {
    LitheIndex n;
    const char *what;
  } found[] = {{n_crossings, "pairs of triangles that cross or overlap"},
               {w->n_crowded_edges, "edges with more than two triangles"},
               {w->n_repeated, "repeated triangles"},
               {w->n_one_sided, "shells without an outside"},
               {w->n_turned_shells, "shells inside out"}};
  const char *list = NULL;
  if (w->n_open_edges > 0)
    list = lth_arena_print(r->arena, "%d open edges around %d holes (the largest is %.3g m across)",
                           w->n_open_edges, w->n_holes, w->largest_hole);
  for (size_t i = 0; i < sizeof found / sizeof *found; i++)
    if (found[i].n > 0)
      list = join(r, list, lth_arena_print(r->arena, "%d %s", found[i].n, found[i].what));
  lth_warn(r->ctx, "%s: wrapped where its winding number is one half; found %s", file->text,
           list ? list : "nothing to mend");
}

static LitheStatus wrap_surface(LthReader *r, const LthNode *file, LitheIndex n_crossings,
                                LthMeshFile *mesh) {
  LthWrap *wrap = NULL;
  LitheStatus status = lth_wrap_create(r->ctx, mesh->soup, file->text, &wrap);
  if (status != LITHE_OK) return blame_file(r, file, status, "");
  warn_of_wrapping(r, file, n_crossings, wrap);
  LITHE_TRY(lth_own_wrap(r, wrap));
  mesh->wrap = wrap;
  return LITHE_OK;
}

/// Does `repair: wrap` apply? What it does not go with is reported.
static bool is_wrapped(LthReader *r, const LthNode *node, bool needs_surface, LthMeshFile *mesh) {
  LthNode *repair = lth_node_find(node, "repair");
  LthNode *resolution = lth_node_find(node, "resolution");
  bool wrap = repair && lth_node_is_text(repair, "wrap");
  mesh->resolution = lth_read_number(node, "resolution", 0);
  if (wrap && !needs_surface)
    lth_report(r->report, repair,
               "an embedded surface may have defects as it is, got wrap; expected it with the "
               "shape's file");
  if (resolution && !wrap)
    lth_report_key(r->report, resolution,
                   "it goes with repair: wrap, got no wrap; expected repair: wrap beside it");
  return wrap && needs_surface;
}

static LitheStatus read_soup(LthReader *r, const LthNode *file, LthSoup **soup) {
  const char *path = NULL;
  *soup = NULL;
  if (!file || !r->opens_files) return LITHE_OK;
  LITHE_TRY(lth_find_file(r, file, &path));
  if (!path) return LITHE_OK;
  LitheStatus status = lth_soup_read(r->ctx, path, soup);
  if (status != LITHE_OK) return blame_file(r, file, status, "");
  status = lth_own_soup(r, *soup);
  if (status != LITHE_OK) *soup = NULL;
  return status;
}

LitheStatus lth_read_mesh(LthReader *r, const LthNode *node, const LthPlacement *place,
                          bool needs_surface, LthMeshFile *mesh) {
  *mesh = (LthMeshFile){0};
  const LthNode *file = lth_node_get(node, "file");
  LITHE_TRY(read_soup(r, file, &mesh->soup));
  if (!mesh->soup) return LITHE_OK;
  LthSoup *soup = mesh->soup;
  file_map(r, node, soup, place, mesh->to_scene);

  // cleaned in the file's own coordinates: there the places of defects mean something to its owner
  LitheIndex n_crossings = 0;
  bool wrap = is_wrapped(r, node, needs_surface, mesh);
  if (needs_surface) LITHE_TRY(clean_surface(r, node, wrap, mesh, &n_crossings));
  map_points(soup->n_points, soup->points, mesh->to_scene);
  if (mesh->surface) map_points(mesh->surface->n_points, mesh->surface->points, mesh->to_scene);
  if (!wrap || (mesh->surface && mesh->resolution == 0)) return LITHE_OK;
  mesh->surface = NULL;
  return wrap_surface(r, file, n_crossings, mesh);
}

LitheStatus lth_read_mesh_as(LthReader *r, const LthNode *file, const double to_scene[12],
                             LthMeshFile *mesh) {
  *mesh = (LthMeshFile){0};
  LITHE_TRY(read_soup(r, file, &mesh->soup));
  if (!mesh->soup) return LITHE_OK;
  memcpy(mesh->to_scene, to_scene, sizeof mesh->to_scene);
  map_points(mesh->soup->n_points, mesh->soup->points, to_scene);
  return LITHE_OK;
}

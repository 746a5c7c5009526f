/// fields_0000.vtu ... and fields.pvd: the deformed polyhedra with displacement, velocity and stress; or what
/// staggered bodies have in their place.
#include "io/file.h"
#include "io/vtu.h"
#include "scene/change.h"
#include "scene/measure.h"
#include "scene/observe.h"
#include "scene/observe_grid.h"

#include "base/tensor.h"

#include <stdio.h>
#include <string.h>

struct LthFields {
  char *folder, *stem;
  LitheCount *cell_point_off;
  LitheIndex *cell_mesh_point;
  LitheIndex n_points;
  double *points, *displacement, *velocity;            ///< (n_points x 3)
  double *stress, *von_mises, *degree, *level, *label; ///< per cell
  LthVtuTopology *topology;
  LthGridFields *grid; ///< of a staggered body, with files of its own
  LitheIndex n_frames;
  LitheCount cap_frames;
  double *times;   ///< (n_frames)
  const double *u; ///< the present displacement, lent by the simulation
};

static LitheStatus allocate(LitheCtx *ctx, const LthBody *body, LthFields *f) {
  LitheIndex n_cells = body->mesh->n_cells;
  LITHE_TRY(lth_vtu_cell_points(ctx, body->mesh, &f->cell_point_off, &f->cell_mesh_point));
  f->n_points = (LitheIndex)f->cell_point_off[n_cells];
  LTH_NEW(ctx, f->points, 3 * (LitheCount)f->n_points);
  LTH_NEW(ctx, f->displacement, 3 * (LitheCount)f->n_points);
  LTH_NEW(ctx, f->velocity, 3 * (LitheCount)f->n_points);
  LTH_NEW(ctx, f->stress, 6 * (LitheCount)n_cells);
  LTH_NEW(ctx, f->von_mises, n_cells);
  LTH_NEW(ctx, f->degree, n_cells);
  LTH_NEW(ctx, f->level, n_cells);
  LTH_NEW(ctx, f->label, n_cells);
  for (LitheIndex c = 0; c < n_cells; c++) {
    f->degree[c] = body->disc->cell_degree[c];
    f->label[c] = body->label[c];
    if (body->change) f->level[c] = body->change->level[body->change->cell_record[c]];
  }
  return LITHE_OK;
}

static void free_arrays(LitheCtx *ctx, LthFields *f) {
  lth_vtu_topology_destroy(ctx, &f->topology);
  void *blocks[] = {f->cell_point_off, f->cell_mesh_point, f->points, f->displacement, f->velocity,
                    f->stress,         f->von_mises,       f->degree, f->level,        f->label};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  f->cell_point_off = NULL;
  f->cell_mesh_point = NULL;
  f->points = f->displacement = f->velocity = f->stress = f->von_mises = NULL;
  f->degree = f->level = f->label = NULL;
}

LitheStatus lth_fields_renew(LitheCtx *ctx, LthFields *f, const LthBody *body) {
  if (body->staggered || !body->scene->fields_vtu) return LITHE_OK;
  free_arrays(ctx, f);
  return allocate(ctx, body, f);
}

LitheStatus lth_fields_open(LitheCtx *ctx, const char *folder, const LthBody *body,
                            LthFields **fields) {
  LTH_NEW(ctx, *fields, 1);
  LITHE_TRY(lth_copy_text(ctx, folder, &(*fields)->folder));
  LITHE_TRY(lth_output_stem(ctx, body, "fields", &(*fields)->stem));
  if (body->staggered) return lth_grid_fields_open(ctx, &(*fields)->grid);
  return body->scene->fields_vtu ? allocate(ctx, body, *fields) : LITHE_OK;
}

/// Fields of one cell at its points and its centroid.
static void sample_cell(const LthBody *body, LthFields *f, LitheIndex cell) {
  const double *u = f->u, *v = lth_body_velocity(body), *x = lth_body_position(body);
  for (LitheCount i = f->cell_point_off[cell]; i < f->cell_point_off[cell + 1]; i++) {
    const double *rest = body->mesh->points + 3 * (LitheCount)f->cell_mesh_point[i];
    lth_disc_sample(body->disc, cell, u, rest, f->displacement + 3 * i);
    lth_disc_sample(body->disc, cell, v, rest, f->velocity + 3 * i);
    lth_v3_add(rest, f->displacement + 3 * i, f->points + 3 * i);
  }
  double *stress = f->stress + 6 * (LitheCount)cell;
  body->disc->table->stress(body->disc, cell, x, body->mesh->cell_centroid + 3 * (LitheCount)cell,
                            stress);
  f->von_mises[cell] = lth_von_mises(stress);
}

static LitheStatus write_vtu(LitheCtx *ctx, LthFields *f, const LthBody *body, const char *path) {
  const LthVtuArray point_arrays[] = {lth_vtk_array("displacement", 3, f->displacement),
                                      lth_vtk_array("velocity", 3, f->velocity)};
  const LthVtuArray cell_arrays[] = {
      lth_vtk_array("stress", 6, f->stress), lth_vtk_array("von_mises", 1, f->von_mises),
      lth_vtk_array("degree", 1, f->degree), lth_vtk_array("level", 1, f->level),
      lth_vtk_array("label", 1, f->label)};
  LthVtu vtu = {.mesh = body->mesh,
                .n_points = f->n_points,
                .points = f->points,
                .cell_point_off = f->cell_point_off,
                .cell_mesh_point = f->cell_mesh_point,
                .point_arrays = point_arrays,
                .n_point_arrays = body->scene->time_kind == LTH_TIME_DYNAMIC ? 2 : 1,
                .cell_arrays = cell_arrays,
                .n_cell_arrays = sizeof cell_arrays / sizeof cell_arrays[0],
                .time = lth_simulation_time(body->sim)};
  if (!f->topology) LITHE_TRY(lth_vtu_topology_create(ctx, &vtu, &f->topology));
  vtu.topology = f->topology;
  return lth_vtu_write(ctx, path, &vtu);
}

/// The list of all files so far, names relative to it.
static LitheStatus write_pvd(LitheCtx *ctx, const LthFields *f, const char *ending) {
  LitheStatus status = LITHE_OK;
  size_t room = strlen(f->stem) + 24;
  char *names = NULL, *path = NULL;
  const char **files = NULL;
  LTH_NEW_OR(done, ctx, names, ((LitheCount)f->n_frames + 1) * (LitheCount)room);
  LTH_NEW_OR(done, ctx, files, f->n_frames);
  for (LitheIndex i = 0; i < f->n_frames; i++) {
    files[i] = names + room * (size_t)i;
    snprintf(names + room * (size_t)i, room, "%s_%04d.%s", f->stem, i, ending);
  }
  char *name = names + room * (size_t)f->n_frames;
  snprintf(name, room, "%s.pvd", f->stem);
  LITHE_TRY_OR(done, lth_path_join(ctx, f->folder, name, &path));
  LITHE_TRY_OR(done, lth_pvd_write(ctx, path, f->n_frames, f->times, files));

done:
  lth_free(ctx, names);
  lth_free(ctx, files);
  lth_free(ctx, path);
  return status;
}

/// Is a format written for a staggered body? Where the scene names none, images.
static bool wants(const LthBody *body, const char *ending) {
  const LthScene *scene = body->scene;
  if (strcmp(ending, "vti") == 0) return scene->fields_vti || scene->fields_unsaid;
  if (strcmp(ending, "vtu") == 0) return scene->fields_vtu && !scene->fields_unsaid;
  return scene->fields_nifti && body->def->shape.kind == LTH_SHAPE_IMAGE;
}

/// One file of a frame.
static LitheStatus write_grid(LitheCtx *ctx, const LthFields *f, const LthBody *body,
                              const char *ending) {
  char *path = NULL;
  if (!wants(body, ending)) return LITHE_OK;
  LITHE_TRY(lth_path_numbered(ctx, f->folder, f->stem, f->n_frames, ending, &path));
  LitheStatus status = strcmp(ending, "vti") == 0 ? lth_grid_fields_image(ctx, f->grid, path)
                                                  : lth_grid_fields_voxels(ctx, f->grid, path);
  lth_free(ctx, path);
  return status;
}

/// displacement_0007.nii.gz and so on.
static LitheStatus write_volumes(LitheCtx *ctx, const LthFields *f, const LthBody *body) {
  for (int what = 0; wants(body, "nii.gz") && what < LTH_GRID_VOLUMES; what++) {
    char *stem = NULL, *path = NULL;
    LITHE_TRY(lth_output_stem(ctx, body, lth_grid_fields_volume_name(what), &stem));
    LitheStatus status = lth_path_numbered(ctx, f->folder, stem, f->n_frames, "nii.gz", &path);
    if (status == LITHE_OK) status = lth_grid_fields_volume(ctx, f->grid, what, path);
    lth_free(ctx, stem);
    lth_free(ctx, path);
    LITHE_TRY(status);
  }
  return LITHE_OK;
}

static LitheStatus frame_of_grid(LitheCtx *ctx, LthFields *f, const LthBody *body) {
  bool any_vtk = wants(body, "vti") || wants(body, "vtu");
  if (!any_vtk && !wants(body, "nii.gz")) return LITHE_OK;
  LITHE_TRY(lth_grid_fields_begin(ctx, f->grid, body));
  LITHE_TRY(write_grid(ctx, f, body, "vti"));
  LITHE_TRY(write_grid(ctx, f, body, "vtu"));
  LITHE_TRY(write_volumes(ctx, f, body));
  LTH_RESERVE(ctx, f->times, f->cap_frames, f->n_frames + 1);
  f->times[f->n_frames++] = lth_simulation_time(body->sim);
  return any_vtk ? write_pvd(ctx, f, wants(body, "vti") ? "vti" : "vtu") : LITHE_OK;
}

LitheStatus lth_fields_frame(LitheCtx *ctx, LthFields *f, const LthBody *body) {
  if (body->staggered) return frame_of_grid(ctx, f, body);
  if (!body->scene->fields_vtu) return LITHE_OK;
  char *path;
  f->u = lth_body_displacement(body);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) sample_cell(body, f, c);
  LTH_RESERVE(ctx, f->times, f->cap_frames, f->n_frames + 1);
  LITHE_TRY(lth_path_numbered(ctx, f->folder, f->stem, f->n_frames, "vtu", &path));
  LitheStatus status = write_vtu(ctx, f, body, path);
  lth_free(ctx, path);
  LITHE_TRY(status);
  f->times[f->n_frames++] = lth_simulation_time(body->sim);
  return write_pvd(ctx, f, "vtu");
}

static LitheStatus make_room(LitheCtx *ctx, LthFields *f, LitheCount n) {
  LTH_RESERVE(ctx, f->times, f->cap_frames, n);
  return LITHE_OK;
}

void lth_fields_archive(LthFields *f, LthArchive *archive) {
  LitheCount n = f->n_frames;
  lth_archive_count(archive, &n);
  if (archive->status == LITHE_OK && archive->is_reading)
    archive->status = make_room(archive->ctx, f, n);
  if (archive->status != LITHE_OK) return;
  f->n_frames = (LitheIndex)n;
  LTH_ARCHIVE_ARRAY(archive, f->times, n);
}

/// What a longer run left behind, of all kinds.
static LitheStatus remove_later(LitheCtx *ctx, const LthFields *f) {
  LITHE_TRY(lth_file_remove_numbered(ctx, f->folder, f->stem, f->n_frames, "vtu"));
  return lth_file_remove_numbered(ctx, f->folder, f->stem, f->n_frames, "vti");
}

LitheStatus lth_fields_close(LitheCtx *ctx, LthFields **fields) {
  LthFields *f = *fields;
  if (!f) return LITHE_OK;
  LitheStatus status = LITHE_OK;
  if (f->n_frames > 0) status = remove_later(ctx, f);
  lth_grid_fields_close(ctx, &f->grid);
  free_arrays(ctx, f);
  lth_free(ctx, f->folder);
  lth_free(ctx, f->stem);
  lth_free(ctx, f->times);
  lth_free(ctx, f);
  *fields = NULL;
  return status;
}

/// Named points of the bodies: probes.csv, and their last values for the result.
#include "io/csv.h"
#include "io/file.h"
#include "scene/measure.h"
#include "scene/observe.h"
#include "scene/staggered_body.h"

#include "base/tensor.h"

#include <stdio.h>
#include <string.h>

#define COLUMNS 10 // a probe: ux uy uz, xx yy zz yz zx xy, von Mises

struct LthProbes {
  LthCsv *csv;
  LitheIndex n;
  LitheIndex *body, *cell; ///< that a probe lies in               (n)
  double *at;              ///< where it is read [m]           (n x 3)
  double *row;             ///< (1 + COLUMNS n)
};

/// Diagonal of an element's box.
static double width_of(const LthBody *body, LitheIndex cell) {
  if (body->staggered) return body->staggered->diagonal;
  const double *box = body->mesh->cell_box + 6 * (LitheCount)cell;
  return lth_v3_distance(box, box + 3);
}

/// The first body that holds a place, else the one whose nearest element's centroid is nearest. `place`: the
/// probe itself, or that centroid where it is farther away than an element is wide.
static LitheStatus find_cell(LitheCtx *ctx, const LthWorld *world, const LthSceneProbe *p,
                             LitheIndex *body, LitheIndex *cell, double place[3]) {
  double nearest = INFINITY, best[3] = {0};
  lth_v3_copy(p->point, place);
  for (LitheIndex b = 0; b < world->n_bodies; b++) {
    const LthBody *at = world->bodies[b];
    LitheIndex found;
    bool inside;
    double center[3];
    LITHE_TRY(lth_disc_find_cell(ctx, at->disc, p->point, &found, &inside));
    lth_body_cell_center(at, found, center);
    double distance = lth_v3_distance(p->point, center);
    if (!inside && distance >= nearest) continue;
    nearest = distance;
    *body = b;
    *cell = found;
    lth_v3_copy(center, best);
    if (inside) return LITHE_OK;
  }
  if (!(nearest < INFINITY)) return LITHE_OK;
  bool far = nearest > width_of(world->bodies[*body], *cell);
  if (far) lth_v3_copy(best, place);
  lth_warn(ctx,
           "probe %s: (%g, %g, %g) lies outside the body at rest, %.3g m from the centre of the "
           "nearest element, (%g, %g, %g); %s; choose a point inside",
           p->name, p->point[0], p->point[1], p->point[2], nearest, best[0], best[1], best[2],
           far ? "its values are those there" : "its values are those of that element carried on");
  return LITHE_OK;
}

/// "ear_ux", "ear_uy", ... in one block of `room` bytes a name.
static void write_names(const LthScene *scene, char *text, size_t room, const char **names) {
  static const char *const endings[COLUMNS] = {"ux",   "uy",   "uz",   "s_xx", "s_yy",
                                               "s_zz", "s_yz", "s_zx", "s_xy", "von_mises"};
  snprintf(text, room, "t");
  names[0] = text;
  for (LitheIndex i = 0; i < scene->n_probes; i++)
    for (int k = 0; k < COLUMNS; k++) {
      char *name = text + room * (size_t)(1 + COLUMNS * i + k);
      snprintf(name, room, "%s_%s", scene->probes[i].name, endings[k]);
      names[1 + COLUMNS * i + k] = name;
    }
}

static LitheStatus open_csv(LitheCtx *ctx, const char *folder, const LthScene *scene, bool resumes,
                            LthProbes *probes) {
  LitheStatus status = LITHE_OK;
  size_t room = 16;
  char *path = NULL, *text = NULL;
  const char **names = NULL;
  LitheIndex n = 1 + COLUMNS * probes->n;
  for (LitheIndex i = 0; i < scene->n_probes; i++) {
    size_t length = strlen(scene->probes[i].name) + 16;
    if (length > room) room = length;
  }
  LTH_NEW_OR(done, ctx, text, n * (LitheCount)room);
  LTH_NEW_OR(done, ctx, names, n);
  write_names(scene, text, room, names);
  LITHE_TRY_OR(done, lth_path_join(ctx, folder, "probes.csv", &path));
  LITHE_TRY_OR(done, resumes ? lth_csv_reopen(ctx, path, n, &probes->csv)
                             : lth_csv_open(ctx, path, n, names, &probes->csv));

done:
  lth_free(ctx, path);
  lth_free(ctx, text);
  lth_free(ctx, names);
  return status;
}

LitheStatus lth_probes_open(LitheCtx *ctx, const char *folder, const LthWorld *world, bool resumes,
                            LthProbes **probes) {
  LTH_NEW(ctx, *probes, 1);
  LthProbes *p = *probes;
  p->n = world->scene->n_probes;
  if (p->n == 0) return LITHE_OK;
  LTH_NEW(ctx, p->body, p->n);
  LTH_NEW(ctx, p->cell, p->n);
  LTH_NEW(ctx, p->at, 3 * (LitheCount)p->n);
  LTH_NEW(ctx, p->row, 1 + COLUMNS * (LitheCount)p->n);
  for (LitheIndex i = 0; i < p->n; i++)
    LITHE_TRY(find_cell(ctx, world, world->scene->probes + i, p->body + i, p->cell + i,
                        p->at + 3 * (LitheCount)i));
  return open_csv(ctx, folder, world->scene, resumes, p);
}

LitheStatus lth_probes_renew(LitheCtx *ctx, LthProbes *p, const LthWorld *world) {
  for (LitheIndex i = 0; i < p->n; i++) {
    const LthBody *body = world->bodies[p->body[i]];
    bool inside;
    if (body->change)
      LITHE_TRY(
          lth_disc_find_cell(ctx, body->disc, p->at + 3 * (LitheCount)i, p->cell + i, &inside));
  }
  return LITHE_OK;
}

LthProbeValue lth_probe_value(const LthProbes *probes, const LthWorld *world, const double *u,
                              LitheIndex i) {
  LthProbeValue value;
  const LthBody *body = world->bodies[probes->body[i]];
  const double *at = probes->at + 3 * (LitheCount)i;
  lth_disc_sample(body->disc, probes->cell[i], u + body->first, at, value.displacement);
  body->disc->table->stress(body->disc, probes->cell[i], lth_body_position(body), at, value.stress);
  value.von_mises = lth_von_mises(value.stress);
  return value;
}

LitheStatus lth_probes_row(LitheCtx *ctx, LthProbes *probes, const LthWorld *world) {
  if (probes->n == 0) return LITHE_OK;
  const double *u = lth_simulation_displacement(world->sim);
  probes->row[0] = lth_simulation_time(world->sim);
  for (LitheIndex i = 0; i < probes->n; i++) {
    LthProbeValue value = lth_probe_value(probes, world, u, i);
    double *row = probes->row + 1 + COLUMNS * (LitheCount)i;
    memcpy(row, value.displacement, sizeof value.displacement);
    memcpy(row + 3, value.stress, sizeof value.stress);
    row[9] = value.von_mises;
  }
  return lth_csv_row(ctx, probes->csv, probes->row);
}

void lth_probes_archive(LthProbes *probes, LthArchive *archive) {
  if (probes->csv) lth_csv_archive(probes->csv, archive);
}

LitheStatus lth_probes_close(LitheCtx *ctx, LthProbes **probes) {
  if (!*probes) return LITHE_OK;
  LitheStatus status = lth_csv_close(ctx, &(*probes)->csv);
  lth_free(ctx, (*probes)->body);
  lth_free(ctx, (*probes)->cell);
  lth_free(ctx, (*probes)->at);
  lth_free(ctx, (*probes)->row);
  lth_free(ctx, *probes);
  *probes = NULL;
  return status;
}

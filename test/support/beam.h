/// Small bodies for the tests of step: boxes of hexahedra, clamped or free, as built or rotated.
#pragma once

#include "check.h"

#include "base/tensor.h"
#include "disc/dg/dg_disc.h"
#include "disc/dg/dg_load.h"
#include "step/simulation.h"
#include "system/free_motion.h"

#include <string.h>

/// What a test asks for; zero means the default in brackets.
typedef struct BeamDef {
  double size[3];                 // [4 x 1 x 1]
  LitheIndex cells[3];            // [4 x 1 x 1]
  int degree;                     // [1]
  double young, poisson, density; // [1000, 0 is 0, 1]
  double gravity[3];
  double angle, axis[3];         // the whole body is turned by this before anything else
  double offset[3];              // and then moved
  bool linear;                   // no warping
  bool clamp_weak, clamp_strong; // the face (or layer of cells) x = 0
  bool pull_weak;                // the face x = max, by `pull` (displacement along the turned axes)
  LthValue pull[3];
  double damping_mass, damping_stiffness;
  int threads;            // [2]
  LthStepOptions options; // [lth_step_options_default()]
} BeamDef;

typedef struct Beam {
  LitheCtx *ctx;
  LthMesh *mesh;
  LthDgSpace *space;
  LthDgOperator *op;
  LthPatches *clamp, *pulled;
  double *young, *poisson, *density, *rest;
  uint8_t *strong; // per cell
  uint8_t *held;   // per unknown, of strong cells
  LthDisc *disc;
  LthSystem *system;
  LthSimulation *sim;
  double Q[9], offset[3]; // rest place of the box point p: Q p + offset
  double speed;           // of the strong layer along x
} Beam;

static inline void rotation_about(const double axis[3], double angle, double Q[9]) {
  double n[3] = {axis[0], axis[1], axis[2]};
  lth_m3_identity(Q);
  if (lth_v3_normalize(n) == 0) return;
  double c = cos(angle), s = sin(angle);
  double cross[9] = {0, -n[2], n[1], n[2], 0, -n[0], -n[1], n[0], 0};
  for (int i = 0; i < 9; i++)
    Q[i] = (i % 4 == 0 ? c : 0) + s * cross[i] + (1 - c) * n[i / 3] * n[i % 3];
}

static inline void place(const Beam *b, const double p[3], double x[3]) {
  lth_m3_apply(b->Q, p, x);
  lth_v3_add(x, b->offset, x);
}

static inline LthMesh *turned_box(Beam *b, const BeamDef *def) {
  LthGrid grid = {.max = {def->size[0], def->size[1], def->size[2]},
                  .cells = {def->cells[0], def->cells[1], def->cells[2]}};
  LthMesh *box = NULL, *turned = NULL;
  CHECK_OK(b->ctx, lth_mesh_hexahedra(b->ctx, &grid, &box));
  double *points = malloc(sizeof *points * 3 * (size_t)box->n_points);
  for (LitheIndex i = 0; i < box->n_points; i++) place(b, box->points + 3 * i, points + 3 * i);
  LthMeshDef d = {.n_points = box->n_points,
                  .n_faces = box->n_faces,
                  .n_cells = box->n_cells,
                  .points = points,
                  .face_loop_off = box->face_loop_off,
                  .loop_off = box->loop_off,
                  .loop_point = box->loop_point,
                  .face_cell = box->face_cell,
                  .cell_size = box->cell_size};
  CHECK_OK(b->ctx, lth_mesh_create(b->ctx, &d, &turned));
  lth_mesh_destroy(b->ctx, &box);
  free(points);
  return turned;
}

/// Whole boundary faces whose centroid, turned back, has x = `plane`.
static inline LthPatches *end_faces(Beam *b, double plane) {
  const LthMesh *m = b->mesh;
  LthPatches *p = lth_alloc(b->ctx, 1, sizeof *p);
  LitheIndex n = 0, n_points = 0, max = 4 * m->n_faces;
  p->face = lth_alloc(b->ctx, m->n_faces, sizeof *p->face);
  p->loop_off_of = lth_alloc(b->ctx, m->n_faces + 1, sizeof *p->loop_off_of);
  p->loop_off = lth_alloc(b->ctx, m->n_faces + 1, sizeof *p->loop_off);
  p->loop_point = lth_alloc(b->ctx, max, sizeof *p->loop_point);
  p->points = lth_alloc(b->ctx, 3 * max, sizeof *p->points);
  p->area = lth_alloc(b->ctx, m->n_faces, sizeof *p->area);
  p->centroid = lth_alloc(b->ctx, 3 * m->n_faces, sizeof *p->centroid);
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    double away[3], back[3];
    lth_v3_sub(m->face_centroid + 3 * f, b->offset, away);
    lth_m3_apply_t(b->Q, away, back);
    if (m->face_cell[2 * f + 1] >= 0 || fabs(back[0] - plane) > 1e-9) continue;
    LthFaceView view = lth_mesh_face(m, f);
    for (LitheIndex k = view.loop_off[0]; k < view.loop_off[1]; k++) {
      memcpy(p->points + 3 * n_points, view.points + 3 * view.loop_point[k], 3 * sizeof(double));
      p->loop_point[n_points] = n_points;
      n_points++;
    }
    p->face[n] = f;
    p->area[n] = m->face_area[f];
    memcpy(p->centroid + 3 * n, m->face_centroid + 3 * f, 3 * sizeof(double));
    n++;
    p->loop_off_of[n] = n;
    p->loop_off[n] = n_points;
  }
  p->n = n;
  p->n_points = n_points;
  return p;
}

/// The strong layer stays in shape and moves along the turned x axis.
static LitheStatus move_layer(const void *self, double t, double *x) {
  const Beam *b = self;
  for (LitheIndex c = 0; c < b->space->n_cells; c++) {
    LitheCount first = 3 * (LitheCount)b->space->func_off[c],
               last = 3 * (LitheCount)b->space->func_off[c + 1];
    if (!b->strong[c]) continue;
    memcpy(x + first, b->rest + first, sizeof *x * (size_t)(last - first));
    for (int a = 0; a < 3; a++) x[first + a] += b->speed * t * b->Q[3 * a];
  }
  return LITHE_OK;
}

static inline void fill_defaults(BeamDef *def) {
  if (def->size[0] == 0) memcpy(def->size, (double[]){4, 1, 1}, sizeof def->size);
  if (def->cells[0] == 0) memcpy(def->cells, (LitheIndex[]){4, 1, 1}, sizeof def->cells);
  if (def->degree == 0) def->degree = 1;
  if (def->young == 0) def->young = 1000;
  if (def->density == 0) def->density = 1;
  if (def->threads == 0) def->threads = 2;
  if (def->options.tolerance == 0) def->options = lth_step_options_default();
}

/// The beam as the only body of a system, perhaps in contact.
static inline LthSystem *beam_system(const Beam *b, const BeamDef *def, LthContact *contact) {
  LthSystem *system = NULL;
  LthSystemBody body = {.disc = b->disc,
                        .damping_mass = def->damping_mass,
                        .damping_stiffness = def->damping_stiffness,
                        .held = b->held,
                        .prescribe = b->held ? move_layer : NULL,
                        .prescribe_self = b,
                        .warped = !def->linear};
  LthSystemContact touch = {.contact = contact};
  LthSystemDef d = {
      .bodies = &body, .n_bodies = 1, .contacts = &touch, .n_contacts = contact ? 1 : 0};
  lth_m3_apply(b->Q, def->gravity, d.gravity);
  CHECK_OK(b->ctx, lth_system_create(b->ctx, &d, &system));
  return system;
}

static inline LthDisc *beam_disc(const Beam *b, LthDgOperator *op) {
  LthDisc *disc = NULL;
  LthDgDiscDef d = {.space = b->space, .op = op, .density = b->density};
  CHECK_OK(b->ctx, lth_dg_disc_create(b->ctx, &d, &disc));
  return disc;
}

static inline void beam_build_operator(Beam *b, const BeamDef *def) {
  LthWeakConstraint weak[2] = {0};
  LitheIndex n_weak = 0;
  if (def->clamp_weak)
    weak[n_weak++] = (LthWeakConstraint){.patches = b->clamp, .fixed = {true, true, true}};
  if (def->pull_weak) {
    weak[n_weak] = (LthWeakConstraint){.patches = b->pulled, .fixed = {true, true, true}};
    memcpy(weak[n_weak++].value, def->pull, sizeof def->pull);
  }
  LthDgOperatorDef d = {.space = b->space,
                        .young = b->young,
                        .poisson = b->poisson,
                        .warped = !def->linear,
                        .weak = weak,
                        .n_weak = n_weak};
  CHECK_OK(b->ctx, lth_dg_operator_create(b->ctx, &d, &b->op));
}

/// The beam is large enough to be kept by its owner: callbacks point into it.
static inline void beam_create(Beam *b, BeamDef def) {
  memset(b, 0, sizeof *b);
  fill_defaults(&def);
  b->ctx = test_ctx();
  lth_set_threads(b->ctx, def.threads);
  rotation_about(def.axis, def.angle, b->Q);
  memcpy(b->offset, def.offset, sizeof b->offset);
  b->mesh = turned_box(b, &def);
  CHECK_OK(b->ctx, lth_dg_space_create(b->ctx, b->mesh, def.degree, NULL, &b->space));
  LitheIndex n = b->mesh->n_cells;
  b->young = calloc((size_t)n, sizeof(double));
  b->poisson = calloc((size_t)n, sizeof(double));
  b->density = calloc((size_t)n, sizeof(double));
  b->rest = calloc((size_t)b->space->n_dofs, sizeof(double));
  lth_dg_rest(b->space, b->rest);
  for (LitheIndex c = 0; c < n; c++) {
    b->young[c] = def.young;
    b->poisson[c] = def.poisson;
    b->density[c] = def.density;
  }
  b->clamp = end_faces(b, 0);
  b->pulled = end_faces(b, def.size[0]);
  if (def.clamp_strong) {
    b->strong = calloc((size_t)n, 1);
    for (LitheIndex i = 0; i < b->clamp->n; i++)
      b->strong[b->mesh->face_cell[2 * b->clamp->face[i]]] = 1;
    b->held = calloc((size_t)b->space->n_dofs, 1);
    for (LitheIndex c = 0; c < n; c++)
      memset(b->held + 3 * b->space->func_off[c], b->strong[c],
             3 * (size_t)lth_dg_funcs(b->space, c));
  }
  beam_build_operator(b, &def);
  b->disc = beam_disc(b, b->op);
  b->system = beam_system(b, &def, NULL);
  CHECK_OK(b->ctx, lth_simulation_create(b->ctx, b->system, &def.options, &b->sim));
}

static inline void beam_destroy(Beam *b) {
  lth_simulation_destroy(b->ctx, &b->sim);
  lth_system_destroy(b->ctx, &b->system);
  lth_disc_destroy(b->ctx, &b->disc);
  lth_dg_operator_destroy(b->ctx, &b->op);
  lth_patches_destroy(b->ctx, &b->clamp);
  lth_patches_destroy(b->ctx, &b->pulled);
  lth_dg_space_destroy(b->ctx, &b->space);
  lth_mesh_destroy(b->ctx, &b->mesh);
  free(b->young), free(b->poisson), free(b->density), free(b->rest), free(b->strong), free(b->held);
  assert_int_equal(lth_alloc_bytes(b->ctx), 0);
  lithe_ctx_destroy(&b->ctx);
}

/// Displacement of the box point p, in the box's own axes: mean over the cells that hold it.
static inline void beam_displacement(Beam *b, const double p[3], double u[3]) {
  double x[3], sum[3] = {0}, value[3];
  const double *coef = lth_simulation_displacement(b->sim);
  int n = 0;
  place(b, p, x);
  for (LitheIndex c = 0; c < b->mesh->n_cells; c++) {
    const double *box = b->mesh->cell_box + 6 * c, eps = 1e-9;
    bool inside = true;
    for (int a = 0; a < 3; a++) inside &= x[a] >= box[a] - eps && x[a] <= box[3 + a] + eps;
    if (!inside) continue;
    lth_dg_sample(b->space, c, coef, x, value);
    lth_v3_add(sum, value, sum);
    n++;
  }
  assert_true(n > 0);
  lth_v3_scale(1.0 / n, sum);
  lth_m3_apply_t(b->Q, sum, u);
}

/// Velocity v(x) = linear + spin x (x - center) for every cell.
static inline void beam_set_velocity(Beam *b, const double linear[3], const double spin[3]) {
  double *v = lth_simulation_velocity(b->sim);
  double center[3] = {0};
  for (LitheIndex c = 0; c < b->mesh->n_cells; c++)
    for (int a = 0; a < 3; a++) center[a] += b->mesh->cell_centroid[3 * c + a] / b->mesh->n_cells;
  for (LitheIndex c = 0; c < b->space->n_cells; c++)
    for (LitheIndex i = b->space->func_off[c]; i < b->space->func_off[c + 1]; i++) {
      bool constant = i == b->space->func_off[c];
      double x[3];
      for (int a = 0; a < 3; a++) x[a] = b->rest[3 * i + a] - (constant ? center[a] : 0);
      lth_v3_cross(spin, x, v + 3 * i);
      for (int a = 0; a < 3; a++) v[3 * i + a] += constant ? linear[a] : 0;
    }
}

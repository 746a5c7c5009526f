/// Contact of bodies with each other: momentum, rest, impact, friction, thin plates, what does not touch.
#include "check.h"

#include "base/tensor.h"
#include "disc/dg/dg_space.h"
#include "embed/contact.h"

#define GRAVITY 9.81
#define BODIES 3
#define GROUND 1e6 ///< [kg] such a block does not fall

/// A box that moves without turning or bending.
typedef struct Block {
  LthMesh *mesh;
  LthDgSpace *space;
  LthSurface *surface;
  LthEmbedding *e;
  LitheIndex *point;
  double size[3], x[3], v[3], mass;
} Block;

typedef struct Fixture {
  LitheCtx *ctx;
  int n;
  Block block[BODIES];
  LitheCount first[BODIES + 1];
  LthContact *contact[BODIES * BODIES];
  int of[BODIES * BODIES][2];
  int n_contacts;
} Fixture;

static void add_block(Fixture *f, const double min[3], const double max[3], LitheIndex cells,
                      double density) {
  Block *b = &f->block[f->n];
  LthGrid grid = {.cells = {cells, cells, cells}};
  LthShape shape = {.kind = LTH_SHAPE_BOX};
  LthSurface *coarse = NULL;
  b->mass = density;
  for (int a = 0; a < 3; a++) {
    grid.min[a] = shape.a[a] = min[a], grid.max[a] = shape.b[a] = max[a];
    b->size[a] = max[a] - min[a];
    b->mass *= b->size[a];
  }
  CHECK_OK(f->ctx, lth_mesh_hexahedra(f->ctx, &grid, &b->mesh));
  CHECK_OK(f->ctx, lth_dg_space_create(f->ctx, b->mesh, 1, NULL, &b->space));
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &shape, 1, &coarse));
  double edge = fmax(b->size[0], fmax(b->size[1], b->size[2])) / 3;
  CHECK_OK(f->ctx, lth_surface_refine(f->ctx, coarse, edge, &b->surface));
  lth_surface_destroy(f->ctx, &coarse);
  const LthSurface *s = b->surface;
  CHECK_OK(f->ctx, lth_embedding_create(f->ctx, b->space, s->n_points, s->points, NULL,
                                        LTH_EMBED_MLS, LTH_SAMPLE_NODES, &b->e));
  b->point = calloc((size_t)s->n_points, sizeof *b->point);
  LitheIndex *off = calloc((size_t)s->n_tris + 1, sizeof *off);
  for (LitheIndex i = 0; i < s->n_points; i++) b->point[i] = i;
  for (LitheIndex i = 0; i <= s->n_tris; i++) off[i] = 3 * i;
  CHECK_OK(f->ctx, lth_embedding_set_area(f->ctx, b->e, s->n_tris, off, s->tris));
  free(off);
  f->first[f->n + 1] = f->first[f->n] + b->space->n_dofs;
  f->n++;
}

static LthPairSide side_of(const Fixture *f, int b) {
  const Block *k = &f->block[b];
  return (LthPairSide){.name = "block",
                       .points = k->e,
                       .surface = k->surface,
                       .surface_point = k->point,
                       .modulus = 190e3,
                       .cell_size = k->mesh->cell_size,
                       .body_size = fmax(k->size[0], fmax(k->size[1], k->size[2])),
                       .body_weight = k->mass * GRAVITY};
}

static LthContact *touch(Fixture *f, int a, int b, double friction) {
  LthPairDef def = {.side = {side_of(f, a), side_of(f, b)}, .friction = friction};
  LthContact **c = &f->contact[f->n_contacts];
  CHECK_OK(f->ctx, lth_contact_create_pair(f->ctx, &def, c));
  lth_contact_place(*c, 0, 0, f->first[a], 0);
  lth_contact_place(*c, 1, 0, f->first[b], 0);
  f->of[f->n_contacts][0] = a, f->of[f->n_contacts][1] = b;
  f->n_contacts++;
  return *c;
}

static int setup(void **state) {
  Fixture *f = calloc(1, sizeof *f);
  f->ctx = test_ctx();
  *state = f;
  return 0;
}

static int teardown(void **state) {
  Fixture *f = *state;
  for (int c = 0; c < f->n_contacts; c++) lth_contact_destroy(f->ctx, &f->contact[c]);
  for (int k = 0; k < f->n; k++) {
    Block *b = &f->block[k];
    lth_embedding_destroy(f->ctx, &b->e);
    lth_surface_destroy(f->ctx, &b->surface);
    lth_dg_space_destroy(f->ctx, &b->space);
    lth_mesh_destroy(f->ctx, &b->mesh);
    free(b->point);
  }
  bool leaked = lth_alloc_bytes(f->ctx) != 0;
  lithe_ctx_destroy(&f->ctx);
  free(f);
  return leaked;
}

static double *zeros(const Fixture *f) { return calloc((size_t)f->first[f->n], sizeof(double)); }

/// Coefficients of translations (n x 3) of the blocks.
static void translate(const Fixture *f, const double *d, double *coef) {
  memset(coef, 0, sizeof *coef * (size_t)f->first[f->n]);
  for (int b = 0; b < f->n; b++)
    for (LitheIndex c = 0; c < f->block[b].space->n_cells; c++)
      lth_v3_copy(d + 3 * b, coef + f->first[b] + 3 * f->block[b].space->func_off[c]);
}

/// Net force on each block (n x 3) of a force vector.
static void net(const Fixture *f, const double *coef, double *sum) {
  memset(sum, 0, sizeof *sum * 3 * (size_t)f->n);
  for (int b = 0; b < f->n; b++)
    for (LitheIndex c = 0; c < f->block[b].space->n_cells; c++)
      lth_v3_axpy(1, coef + f->first[b] + 3 * f->block[b].space->func_off[c], sum + 3 * b);
}

/// Gaussian elimination of a definite system.
static void solve(int n, double *A, double *b) {
  for (int k = 0; k < n; k++)
    for (int i = k + 1; i < n; i++) {
      double factor = A[i * n + k] / A[k * n + k];
      for (int j = k; j < n; j++) A[i * n + j] -= factor * A[k * n + j];
      b[i] -= factor * b[k];
    }
  for (int k = n - 1; k >= 0; k--) {
    for (int j = k + 1; j < n; j++) b[k] -= A[k * n + j] * b[j];
    b[k] /= A[k * n + k];
  }
}

/// Matrix and right-hand side of one implicit step for the blocks' translations.
static void reduced_system(const Fixture *f, double dt, const double gravity[3], double *A,
                           double *b, double *y, double *w) {
  const int n = 3 * f->n;
  for (int j = 0; j < n; j++) {
    double unit[3 * BODIES] = {0}, column[3 * BODIES];
    unit[j] = 1;
    translate(f, unit, w);
    memset(y, 0, sizeof *y * (size_t)f->first[f->n]);
    for (int c = 0; c < f->n_contacts; c++) lth_contact_apply(f->contact[c], w, y);
    net(f, y, column);
    for (int i = 0; i < n; i++) A[i * n + j] = column[i] + (i == j ? f->block[i / 3].mass : 0);
  }
  memset(y, 0, sizeof *y * (size_t)f->first[f->n]);
  for (int c = 0; c < f->n_contacts; c++) lth_contact_add_rhs(f->contact[c], y);
  net(f, y, b);
  for (int i = 0; i < n; i++) {
    const Block *block = &f->block[i / 3];
    b[i] += block->mass * (block->v[i % 3] + (block->mass < GROUND ? dt * gravity[i % 3] : 0));
  }
}

/// One step of all blocks.
static void step(Fixture *f, double t, double dt, const double gravity[3]) {
  const int n = 3 * f->n;
  double *u = zeros(f), *v = zeros(f), *y = zeros(f);
  double x[3 * BODIES], A[9 * BODIES * BODIES], b[3 * BODIES];
  LitheIndex n_active;
  for (int i = 0; i < n; i++) x[i] = f->block[i / 3].x[i % 3], b[i] = f->block[i / 3].v[i % 3];
  translate(f, x, u);
  translate(f, b, v);
  for (int c = 0; c < f->n_contacts; c++)
    CHECK_OK(f->ctx, lth_contact_detect(f->ctx, f->contact[c], t, dt, u, v, &n_active));
  bool again = true;
  while (again) {
    reduced_system(f, dt, gravity, A, b, y, v);
    solve(n, A, b);
    translate(f, b, v);
    again = false;
    for (int c = 0; c < f->n_contacts; c++) again |= lth_contact_revise(f->contact[c], v);
  }
  for (int i = 0; i < n; i++) {
    f->block[i / 3].v[i % 3] = b[i];
    f->block[i / 3].x[i % 3] += dt * b[i];
  }
  free(u), free(v), free(y);
}

static double force_of(const LthContact *c, double *penetration) {
  LitheIndex n;
  double force;
  lth_contact_report(c, &n, penetration, &force);
  return force;
}

static const double down[3] = {0, -GRAVITY, 0};

/// Forces at random places and velocities: no net force, no net torque, a symmetric operator without negative
/// energy, and a block diagonal above it.
static void forces_keep_both_momenta(void **state) {
  Fixture *f = *state;
  add_block(f, (double[]){-0.1, 0, -0.1}, (double[]){0.1, 0.1, 0.1}, 2, 1000);
  add_block(f, (double[]){-0.07, 0.098, -0.05}, (double[]){0.16, 0.2, 0.15}, 3, 1000);
  LthContact *c = touch(f, 0, 1, 0.4);
  LitheCount n = f->first[2], n_extra = 0;
  double *u = zeros(f), *v = zeros(f), *y = zeros(f), *w = zeros(f), *z = zeros(f);
  uint64_t seed = 3;
  LitheIndex active;
  for (LitheCount i = 0; i < n; i++) {
    u[i] = 4e-4 * (test_random(&seed) - 0.5);
    v[i] = 1e-2 * (test_random(&seed) - 0.5), w[i] = test_random(&seed) - 0.5;
  }
  lth_contact_set_look(c, LTH_LOOK_FIRST); // however deep
  CHECK_OK(f->ctx, lth_contact_detect(f->ctx, c, 0, 0.01, u, v, &active));
  CHECK_AT_LEAST(active, 10);

  // symmetry and sign
  lth_contact_apply(c, v, y);
  lth_contact_apply(c, w, z);
  double vw = 0, wv = 0, ww = 0, bound = 0;
  for (LitheCount i = 0; i < n; i++) vw += y[i] * w[i], wv += z[i] * v[i], ww += z[i] * w[i];
  CHECK_NEAR(vw, wv, 1e-12 * fabs(ww));
  CHECK_AT_LEAST(ww, 0);

  // equation (5)
  LitheCount first_block[2] = {0, 0};
  for (int b = 0; b < 2; b++) {
    first_block[b] = n_extra;
    for (LitheIndex k = 0; k < f->block[b].space->n_cells; k++) n_extra += 144;
  }
  for (int b = 0; b < 2; b++) lth_contact_place(c, b, 0, f->first[b], first_block[b]);
  double *extra = calloc((size_t)n_extra, sizeof *extra);
  lth_contact_add_diagonal(c, extra);
  for (LitheCount i = 0; i < n; i++)
    for (LitheCount j = 0; j < 12; j++)
      bound += w[i] * extra[i / 12 * 144 + i % 12 * 12 + j] * w[i / 12 * 12 + j];
  CHECK_AT_LEAST(bound, ww);
  free(extra);

  // r is a set of forces that are opposite in pairs; those without friction meet in one line
  memset(y, 0, sizeof *y * (size_t)n);
  lth_contact_add_rhs(c, y);
  double force[3 * BODIES], size = 0;
  net(f, y, force);
  for (int a = 0; a < 3; a++) size += fabs(force[a]);
  assert_true(size > 0);
  for (int a = 0; a < 3; a++) CHECK_NEAR(force[a] + force[3 + a], 0, 1e-12 * size);

  lth_contact_destroy(f->ctx, &f->contact[0]);
  f->n_contacts = 0;
  c = touch(f, 0, 1, 0);
  lth_contact_set_look(c, LTH_LOOK_FIRST);
  CHECK_OK(f->ctx, lth_contact_detect(f->ctx, c, 0, 0.01, u, v, &active));
  memset(y, 0, sizeof *y * (size_t)n);
  lth_contact_add_rhs(c, y);
  double torque[3] = {0, 0, 0}, lever = 0;
  for (int b = 0; b < 2; b++) {
    double *x = zeros(f);
    lth_dg_rest(f->block[b].space, x);
    for (LitheCount i = 0; i < f->block[b].space->n_dofs; i += 3) {
      double arm[3], part[3];
      for (int a = 0; a < 3; a++) arm[a] = x[i + a] + u[f->first[b] + i + a];
      lth_v3_cross(arm, y + f->first[b] + i, part);
      lth_v3_axpy(1, part, torque);
      lever += lth_v3_norm(part);
    }
    free(x);
  }
  for (int a = 0; a < 3; a++) CHECK_NEAR(torque[a], 0, 1e-11 * lever);
  free(u), free(v), free(y), free(w), free(z);
}

static void a_tower_of_three_carries_its_weight(void **state) {
  Fixture *f = *state;
  add_block(f, (double[]){-1, -0.5, -1}, (double[]){1, 0, 1}, 2, 1e9);
  add_block(f, (double[]){-0.1, 0.001, -0.1}, (double[]){0.1, 0.1, 0.1}, 2, 1000);
  add_block(f, (double[]){-0.05, 0.102, -0.06}, (double[]){0.06, 0.2, 0.05}, 2, 1000);
  LthContact *lower = touch(f, 0, 1, 0.3), *upper = touch(f, 1, 2, 0.3);
  for (int k = 0; k < 240; k++) step(f, k / 120.0, 1 / 120.0, down);
  double depth[2], weight[2] = {f->block[1].mass * GRAVITY, f->block[2].mass * GRAVITY};
  CHECK_NEAR(force_of(upper, &depth[1]), weight[1], 0.01 * weight[1]);
  CHECK_NEAR(force_of(lower, &depth[0]), weight[0] + weight[1], 0.01 * weight[0]);
  CHECK_AT_MOST(depth[0], 0.005 * 0.2);
  CHECK_AT_MOST(depth[1], 0.005 * 0.11);
  for (int b = 1; b < 3; b++) CHECK_AT_MOST(fabs(f->block[b].v[1]), 1e-3);
}

static void an_impact_keeps_momentum_and_makes_no_energy(void **state) {
  Fixture *f = *state;
  add_block(f, (double[]){-0.1, 0, -0.1}, (double[]){0.1, 0.2, 0.1}, 2, 1000);
  add_block(f, (double[]){0.11, 0.05, -0.05}, (double[]){0.21, 0.15, 0.05}, 2, 2000);
  touch(f, 0, 1, 0.2);
  const double none[3] = {0, 0, 0};
  f->block[0].v[0] = 1;
  double p0 = f->block[0].mass, energy = 0.5 * f->block[0].mass;
  for (int k = 0; k < 60; k++) step(f, k * 1e-3, 1e-3, none);
  double p[3] = {0}, after = 0;
  for (int b = 0; b < 2; b++) {
    lth_v3_axpy(f->block[b].mass, f->block[b].v, p);
    after += 0.5 * f->block[b].mass * lth_v3_dot(f->block[b].v, f->block[b].v);
  }
  CHECK_NEAR(p[0], p0, 1e-12 * p0);
  CHECK_NEAR(p[1], 0, 1e-12 * p0);
  CHECK_AT_MOST(after, energy);
  CHECK_AT_LEAST(f->block[1].v[0], f->block[0].v[0]); // they part
  CHECK_AT_LEAST(f->block[1].v[0], 0.5);
}

/// The weight pulls aslant: friction holds below its angle, and leaves g (sin - mu cos) above it.
static void friction_between_bodies_holds_and_slides(void **state) {
  for (int slides = 0; slides < 2; slides++) {
    Fixture *f = *state;
    f->n = 0;
    add_block(f, (double[]){-1, -0.5, -1}, (double[]){1, 0, 1}, 3, 1e9);
    add_block(f, (double[]){-0.1, 0, -0.1}, (double[]){0.1, 0.1, 0.1}, 2, 1000);
    touch(f, 0, 1, 0.3);
    double angle = (slides ? 30 : 10) * acos(-1) / 180;
    double aslant[3] = {GRAVITY * sin(angle), -GRAVITY * cos(angle), 0}, before = 0;
    for (int k = 0; k < 60; k++) {
      step(f, k / 120.0, 1 / 120.0, aslant);
      if (k == 29) before = f->block[1].v[0];
    }
    double a = (f->block[1].v[0] - before) / 0.25;
    if (slides) {
      double want = GRAVITY * (sin(angle) - 0.3 * cos(angle));
      CHECK_NEAR(a, want, 0.02 * want);
    } else {
      CHECK_NEAR(f->block[1].v[0], 0, 1e-5);
      CHECK_NEAR(f->block[1].x[0], 0, 1e-4);
    }
    if (!slides) { // the teardown frees the second round's
      teardown(state);
      setup(state);
    }
  }
}

/// A plate of a tenth of a cell, pressed in beyond its middle: the way out is the way in.
static void a_thin_plate_pushes_back_on_the_side_that_is_touched(void **state) {
  Fixture *f = *state;
  add_block(f, (double[]){-0.1, -0.004, -0.1}, (double[]){0.1, 0, 0.1}, 2, 1000);
  add_block(f, (double[]){-0.1, 0, -0.1}, (double[]){0.1, 0.2, 0.1}, 2, 1000);
  LthContact *c = touch(f, 0, 1, 0);
  double *u = zeros(f), *v = zeros(f), *y = zeros(f), force[3 * BODIES];
  for (int k = 0; k < 3; k++) {
    double d[6] = {0, 0, 0, 0.01, -0.0012 * (k + 1), 0};
    LitheIndex active;
    translate(f, d, u);
    lth_contact_set_look(c, LTH_LOOK_FIRST);
    CHECK_OK(f->ctx, lth_contact_detect(f->ctx, c, 0, 1, u, v, &active));
    assert_true(active > 0);
    memset(y, 0, sizeof *y * (size_t)f->first[2]);
    lth_contact_add_rhs(c, y);
    net(f, y, force);
    CHECK_AT_LEAST(force[4], 0.9 * lth_contact_stiffness(c) * 0.0012 * (k + 1) * 0.19 * 0.2);
    CHECK_AT_MOST(fabs(force[3]), 0.2 * force[4]);
  }
  free(u), free(v), free(y);
}

static void excluded_points_do_not_touch(void **state) {
  Fixture *f = *state;
  add_block(f, (double[]){-0.1, 0, -0.1}, (double[]){0.1, 0.1, 0.1}, 2, 1000);
  add_block(f, (double[]){-0.1, 0.099, -0.1}, (double[]){0.1, 0.2, 0.1}, 2, 1000);
  LthPairDef def = {.side = {side_of(f, 0), side_of(f, 1)}};
  uint8_t *excluded[2];
  for (int b = 0; b < 2; b++) {
    excluded[b] = calloc((size_t)f->block[b].e->n_points, 1);
    for (LitheIndex p = 0; p < f->block[b].e->n_points; p++)
      excluded[b][p] = fabs(f->block[b].e->rest[3 * p + 1] - 0.1) < 0.002;
    def.side[b].excluded = excluded[b];
  }
  CHECK_OK(f->ctx, lth_contact_create_pair(f->ctx, &def, &f->contact[0]));
  lth_contact_place(f->contact[0], 1, 0, f->first[1], 0);
  f->n_contacts = 1;
  double *u = zeros(f), *v = zeros(f);
  LitheIndex active;
  CHECK_OK(f->ctx, lth_contact_detect(f->ctx, f->contact[0], 0, 1, u, v, &active));
  assert_int_equal(active, 0);
  free(u), free(v), free(excluded[0]), free(excluded[1]);
}

/// Contact's forces (zeros(f)) with blocks 0 and 1 moved by d, in a look for an equilibrium.
static double *forces_at(Fixture *f, LthContact *c, LthContactLook look, const double d[6]) {
  double *u = zeros(f), *v = zeros(f), *y = zeros(f);
  LitheIndex active;
  translate(f, d, u);
  lth_contact_set_look(c, look);
  CHECK_OK(f->ctx, lth_contact_detect(f->ctx, c, 0, 1, u, v, &active));
  lth_contact_add_rhs(c, y);
  free(u), free(v);
  return y;
}

/// In a search friction pulls by how far a point is from where it was first met, whatever was tried in between: far
/// to one side, apart, far to the other side; and no more than its limit.
static void a_search_for_an_equilibrium_leaves_no_trace_in_the_forces(void **state) {
  Fixture *f = *state;
  add_block(f, (double[]){-0.1, 0, -0.1}, (double[]){0.1, 0.1, 0.1}, 2, 1000);
  add_block(f, (double[]){-0.043, 0.1, -0.047}, (double[]){0.052, 0.2, 0.041}, 2, 1000);
  LthContact *c = touch(f, 0, 1, 0.3);
  const double tried[][6] = {{0, 0, 0, 0.005, -0.002, 0},
                             {0, 0, 0, -0.005, 0.001, 0.002},
                             {0, 0, 0, -0.004, -0.001, -0.003}};
  const double at[6] = {0, 0, 0, 2e-5, -0.001, 1e-5};
  free(forces_at(f, c, LTH_LOOK_FIRST, (double[]){0, 0, 0, 0, -0.001, 0}));
  double *before = forces_at(f, c, LTH_LOOK_AGAIN, at), force[3 * BODIES];
  net(f, before, force);
  CHECK_NEAR(force[3] / force[4], -0.02, 1e-9); // a spring as stiff as the normal's
  CHECK_NEAR(force[5] / force[4], -0.01, 1e-9);
  for (int k = 0; k < 3; k++) {
    double *y = forces_at(f, c, k == 1 ? LTH_LOOK_AGAIN : LTH_LOOK_NEAR, tried[k]);
    net(f, y, force);
    double pull = hypot(force[3], force[5]);
    CHECK_NEAR(pull, 0.3 * force[4], 1e-9 * (pull + fabs(force[4])));
    free(y);
  }
  double *after = forces_at(f, c, LTH_LOOK_AGAIN, at);
  for (LitheCount i = 0; i < f->first[2]; i++)
    CHECK_NEAR(after[i], before[i], 1e-9 * fabs(force[4]));
  free(before), free(after);
}

/// Where a point sinks between those of a coarse one, the other's surface holds it.
static void refining_keeps_the_surface(void **state) {
  Fixture *f = *state;
  LthShape shape = {.kind = LTH_SHAPE_BOX, .a = {0, 0, 0}, .b = {1, 0.3, 0.05}};
  LthSurface *coarse = NULL, *fine = NULL;
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &shape, 1, &coarse));
  CHECK_OK(f->ctx, lth_surface_refine(f->ctx, coarse, 0.1, &fine));
  CHECK_NEAR(lth_surface_volume(fine), 0.015, 1e-15);
  CHECK_NEAR(lth_surface_area(fine), 0.73, 1e-14);
  double longest = 0;
  for (LitheIndex h = 0; h < 3 * fine->n_tris; h++)
    longest =
        fmax(longest, lth_v3_distance(fine->points + 3 * fine->tris[h],
                                      fine->points + 3 * fine->tris[h / 3 * 3 + (h % 3 + 1) % 3]));
  CHECK_AT_MOST(longest, 0.1);
  assert_int_equal(fine->n_tris, 2 * fine->n_points - 4); // closed, no T-junction
  lth_surface_destroy(f->ctx, &coarse);
  lth_surface_destroy(f->ctx, &fine);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(forces_keep_both_momenta, setup, teardown),
      cmocka_unit_test_setup_teardown(a_tower_of_three_carries_its_weight, setup, teardown),
      cmocka_unit_test_setup_teardown(an_impact_keeps_momentum_and_makes_no_energy, setup,
                                      teardown),
      cmocka_unit_test_setup_teardown(friction_between_bodies_holds_and_slides, setup, teardown),
      cmocka_unit_test_setup_teardown(a_thin_plate_pushes_back_on_the_side_that_is_touched, setup,
                                      teardown),
      cmocka_unit_test_setup_teardown(a_search_for_an_equilibrium_leaves_no_trace_in_the_forces,
                                      setup, teardown),
      cmocka_unit_test_setup_teardown(excluded_points_do_not_touch, setup, teardown),
      cmocka_unit_test_setup_teardown(refining_keeps_the_surface, setup, teardown)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

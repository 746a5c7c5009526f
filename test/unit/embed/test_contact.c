/// Contact: gaps and normals, the operator, rest, friction, moving colliders, the active set.
#include "check.h"

#include "base/tensor.h"
#include "embed/collider.h"

#define GRAVITY 9.81

/// A block of 0.2 x 0.1 x 0.2 m that starts on the plane y = 0; its points are a lattice on its bottom and top.
typedef struct Fixture {
  LitheCtx *ctx;
  LthMesh *mesh;
  LthDgSpace *space;
  LthEmbedding *e;
  LthContact *contact;
  double x[3], v[3]; ///< of the block, which moves without turning or bending
  double mass;
} Fixture;

#define SIDE 6

static void make_block(Fixture *f) {
  LthGrid grid = {.min = {-0.1, 0, -0.1}, .max = {0.1, 0.1, 0.1}, .cells = {2, 1, 2}};
  CHECK_OK(f->ctx, lth_mesh_hexahedra(f->ctx, &grid, &f->mesh));
  CHECK_OK(f->ctx, lth_dg_space_create(f->ctx, f->mesh, 1, NULL, &f->space));
  double points[2 * SIDE * SIDE * 3];
  LitheIndex tris[4 * (SIDE - 1) * (SIDE - 1) * 3], off[4 * (SIDE - 1) * (SIDE - 1) + 1], n = 0;
  for (int p = 0; p < 2 * SIDE * SIDE; p++) {
    points[3 * p] = -0.1 + 0.2 * (p % SIDE) / (SIDE - 1);
    points[3 * p + 1] = p < SIDE * SIDE ? 0 : 0.1;
    points[3 * p + 2] = -0.1 + 0.2 * (p / SIDE % SIDE) / (SIDE - 1);
  }
  for (int q = 0; q < 2 * SIDE * SIDE; q++) {
    if (q % SIDE == SIDE - 1 || q / SIDE % SIDE == SIDE - 1) continue;
    LitheIndex quad[6] = {q, q + 1, q + SIDE + 1, q, q + SIDE + 1, q + SIDE};
    for (int k = 0; k < 6; k++) tris[n++] = quad[k];
  }
  CHECK_OK(f->ctx, lth_embedding_create(f->ctx, f->space, 2 * SIDE * SIDE, points, NULL,
                                        LTH_EMBED_MLS, LTH_SAMPLE_NODES, &f->e));
  for (LitheIndex i = 0; i <= n / 3; i++) off[i] = 3 * i;
  CHECK_OK(f->ctx, lth_embedding_set_area(f->ctx, f->e, n / 3, off, tris));
  f->mass = 1000 * 0.2 * 0.1 * 0.2;
}

static int setup(void **state) {
  Fixture *f = calloc(1, sizeof *f);
  f->ctx = test_ctx();
  make_block(f);
  *state = f;
  return 0;
}

static int teardown(void **state) {
  Fixture *f = *state;
  lth_contact_destroy(f->ctx, &f->contact);
  lth_embedding_destroy(f->ctx, &f->e);
  lth_dg_space_destroy(f->ctx, &f->space);
  lth_mesh_destroy(f->ctx, &f->mesh);
  bool leaked = lth_alloc_bytes(f->ctx) != 0;
  lithe_ctx_destroy(&f->ctx);
  free(f);
  return leaked;
}

static void make_contact(Fixture *f, const LthCollider *colliders, LitheIndex n, double friction) {
  LthContactDef def = {.points = f->e,
                       .colliders = colliders,
                       .n_colliders = n,
                       .friction = friction,
                       .modulus = 190e3,
                       .cell_size = 0.1,
                       .body_size = 0.2,
                       .body_weight = f->mass * GRAVITY};
  CHECK_OK(f->ctx, lth_contact_create(f->ctx, &def, &f->contact));
}

/// Coefficients of a translation.
static void translate(const Fixture *f, const double d[3], double *coef) {
  memset(coef, 0, sizeof *coef * (size_t)f->space->n_dofs);
  for (LitheIndex c = 0; c < f->space->n_cells; c++)
    lth_v3_copy(d, coef + 3 * f->space->func_off[c]);
}

/// Sum over cells of a force vector's constants: the net force.
static void net(const Fixture *f, const double *coef, double sum[3]) {
  sum[0] = sum[1] = sum[2] = 0;
  for (LitheIndex c = 0; c < f->space->n_cells; c++)
    lth_v3_axpy(1, coef + 3 * f->space->func_off[c], sum);
}

static void solve3(const double A[9], const double b[3], double x[3]) {
  double det = lth_m3_det(A);
  for (int i = 0; i < 3; i++) {
    double B[9];
    memcpy(B, A, sizeof B);
    for (int r = 0; r < 3; r++) B[3 * r + i] = b[r];
    x[i] = lth_m3_det(B) / det;
  }
}

/// One implicit step of the block's translation under gravity; returns the number of solves.
static int step(Fixture *f, double t, double dt, const double gravity[3]) {
  LitheCount n = f->space->n_dofs;
  double *u = calloc((size_t)n, sizeof *u), *v = calloc((size_t)n, sizeof *v),
         *y = calloc((size_t)n, sizeof *y);
  double v1[3];
  LitheIndex n_active;
  int solves = 0;
  translate(f, f->x, u);
  translate(f, f->v, v);
  CHECK_OK(f->ctx, lth_contact_detect(f->ctx, f->contact, t, dt, u, v, &n_active));
  do {
    double A[9] = {0}, b[3];
    for (int a = 0; a < 3; a++) {
      double unit[3] = {a == 0, a == 1, a == 2}, column[3];
      translate(f, unit, v);
      memset(y, 0, sizeof *y * (size_t)n);
      lth_contact_apply(f->contact, v, y);
      net(f, y, column);
      for (int r = 0; r < 3; r++) A[3 * r + a] = column[r] + (r == a ? f->mass : 0);
    }
    memset(y, 0, sizeof *y * (size_t)n);
    lth_contact_add_rhs(f->contact, y);
    net(f, y, b);
    for (int a = 0; a < 3; a++) b[a] += f->mass * (f->v[a] + dt * gravity[a]);
    solve3(A, b, v1);
    translate(f, v1, v);
    solves++;
  } while (lth_contact_revise(f->contact, v));
  lth_v3_copy(v1, f->v);
  lth_v3_axpy(dt, v1, f->x);
  free(u), free(v), free(y);
  return solves;
}

static const double down[3] = {0, -GRAVITY, 0};
static const LthCollider floor_plane = {.kind = LTH_COLLIDER_PLANE, .normal = {0, 1, 0}};

static double swing(const void *self, const double x[3], double t) {
  (void)self, (void)x;
  return 0.3 * sin(2 * t);
}

/// Gradients by differences must be the normals, and lengths must be distances.
/// Gap and normal of a collider at time t, in the world.
static double world_gap(const LthCollider *c, const double x[3], double t, double normal[3]) {
  LthPose pose = lth_collider_pose(c, t);
  double rest[3], n[3];
  lth_pose_to_rest(&pose, x, rest);
  double gap = lth_collider_rest_gap(c, rest, n);
  lth_m3_apply(pose.R, n, normal);
  return gap;
}

static void gaps_have_unit_gradients_along_their_normals(void **state) {
  Fixture *f = *state;
  LthShape tilted = {
      .kind = LTH_SHAPE_CYLINDER, .a = {0, 0, 0}, .b = {0.3, 0.2, 0.1}, .radius = 0.2};
  LthSurface *surface = NULL;
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &tilted, 0.1, &surface));
  LthShape mesh = {.kind = LTH_SHAPE_MESH, .surface = surface};
  CHECK_OK(f->ctx, lth_shape_prepare(f->ctx, &mesh));
  LthCollider colliders[] = {
      {.kind = LTH_COLLIDER_PLANE, .point = {0, 0.1, 0}, .normal = {1, 2, -0.5}},
      {.kind = LTH_COLLIDER_SPHERE, .shape = {.a = {0.1, 0, 0}, .radius = 0.3}},
      {.kind = LTH_COLLIDER_BOX,
       .shape = {.kind = LTH_SHAPE_BOX, .a = {-0.3, -0.2, -0.1}, .b = {0.3, 0.25, 0.4}}},
      {.kind = LTH_COLLIDER_CAPSULE,
       .shape = {.a = {-0.2, 0, 0}, .b = {0.2, 0.1, 0.3}, .radius = 0.15}},
      {.kind = LTH_COLLIDER_MESH, .shape = mesh}};
  uint64_t seed = 9;
  for (int k = 0; k < 5; k++) {
    LthCollider *c = &colliders[k];
    c->translation[1].eval = swing;
    c->angle.eval = swing;
    c->axis[0] = 1, c->axis[2] = 0.7;
    c->pivot[0] = 0.4;
    for (int i = 0; i < 60; i++) {
      double x[3], n[3], h = 1e-6, other[3];
      int kinks = 0;
      for (int a = 0; a < 3; a++) x[a] = 1.2 * test_random(&seed) - 0.6;
      double gap = world_gap(c, x, 0.7, n);
      CHECK_NEAR(lth_v3_norm(n), 1, 1e-14);
      for (int a = 0; a < 3; a++) {
        double low[3], high[3];
        lth_v3_copy(x, low), lth_v3_copy(x, high);
        low[a] -= h, high[a] += h;
        double slope = (world_gap(c, high, 0.7, other) - world_gap(c, low, 0.7, other)) / (2 * h);
        kinks += fabs(slope - n[a]) > 1e-4;
      }
      assert_true(kinks == 0);
      lth_v3_copy(x, other);
      lth_v3_axpy(-gap, n, other);
      CHECK_NEAR(world_gap(c, other, 0.7, n), 0, 1e-9); // the foot lies on the surface
    }
  }
  lth_shape_free(f->ctx, &mesh);
  lth_free(f->ctx, surface->points), lth_free(f->ctx, surface->tris),
      lth_free(f->ctx, surface->tri_shell);
  lth_free(f->ctx, surface->tri_poly), lth_free(f->ctx, surface->soup_point),
      lth_free(f->ctx, surface);
}

/// Velocity of the collider's material at x, by central differences in time.
static void material_velocity(const LthCollider *c, const double x[3], double t, double v[3]) {
  double h = 1e-6, rest[3], before[3], after[3];
  LthPose now = lth_collider_pose(c, t), p = lth_collider_pose(c, t - h),
          q = lth_collider_pose(c, t + h);
  lth_pose_to_rest(&now, x, rest);
  lth_pose_to_world(&p, rest, before);
  lth_pose_to_world(&q, rest, after);
  for (int i = 0; i < 3; i++) v[i] = (after[i] - before[i]) / (2 * h);
}

static void collider_velocity_is_that_of_its_material(void **state) {
  (void)state;
  LthCollider c = {
      .kind = LTH_COLLIDER_PLANE, .normal = {0, 1, 0}, .axis = {0, 0, 2}, .pivot = {1, 0, 0}};
  c.angle.eval = swing;
  c.translation[0].eval = swing;
  double x[3] = {1.5, 0.25, 3}, v[3], w = 0.6 * cos(1), shift = 0.3 * sin(1);
  material_velocity(&c, x, 0.5, v);
  CHECK_NEAR(v[0], w - w * x[1], 1e-9);
  CHECK_NEAR(v[1], w * (x[0] - 1 - shift), 1e-9);
  CHECK_NEAR(v[2], 0, 1e-9);
}

static void operator_is_symmetric_and_its_bound_dominates_it(void **state) {
  Fixture *f = *state;
  make_contact(f, &floor_plane, 1, 0.4);
  LitheCount n = f->space->n_dofs;
  double *u = calloc((size_t)n, sizeof *u), *v = calloc((size_t)n, sizeof *v);
  double *C = calloc((size_t)(n * n), sizeof *C), *extra = calloc((size_t)(n * n), sizeof *extra);
  double sink[3] = {0, -1e-4, 0}, slide[3] = {0.3, 0, 0.1};
  LitheIndex n_active;
  translate(f, sink, u);
  translate(f, slide, v);
  CHECK_OK(f->ctx, lth_contact_detect(f->ctx, f->contact, 0, 0.01, u, v, &n_active));
  assert_int_equal(n_active, SIDE * SIDE);
  lth_contact_revise(f->contact, v); // so that some slide
  for (LitheCount i = 0; i < n; i++) {
    memset(v, 0, sizeof *v * (size_t)n);
    v[i] = 1;
    lth_contact_apply(f->contact, v, C + i * n);
  }
  double largest = 0;
  for (LitheCount i = 0; i < n * n; i++) largest = fmax(largest, fabs(C[i]));
  for (LitheCount i = 0; i < n; i++)
    for (LitheCount j = 0; j < n; j++) CHECK_NEAR(C[i * n + j], C[j * n + i], 1e-14 * largest);
  lth_contact_add_diagonal(f->contact, extra);
  uint64_t seed = 2;
  for (int trial = 0; trial < 200; trial++) {
    double energy = 0, bound = 0;
    for (LitheCount i = 0; i < n; i++) v[i] = 2 * test_random(&seed) - 1;
    for (LitheCount i = 0; i < n; i++)
      for (LitheCount j = 0; j < n; j++) energy += v[i] * C[i * n + j] * v[j];
    for (LitheCount k = 0, at = 0; k < n / 12; k++)
      for (int i = 0; i < 12; i++)
        for (int j = 0; j < 12; j++, at++) bound += v[12 * k + i] * extra[at] * v[12 * k + j];
    CHECK_AT_LEAST(energy, -1e-13 * largest);
    CHECK_AT_LEAST(bound, energy);
  }
  free(u), free(v), free(C), free(extra);
}

static void net_force_is_the_sum_over_points(void **state) {
  Fixture *f = *state;
  make_contact(f, &floor_plane, 1, 0);
  LitheCount n = f->space->n_dofs;
  double *u = calloc((size_t)n, sizeof *u), *v = calloc((size_t)n, sizeof *v),
         *y = calloc((size_t)n, sizeof *y);
  double sink[3] = {0, -2e-4, 0}, dt = 0.01, total[3], force, penetration;
  LitheIndex n_active;
  translate(f, sink, u);
  CHECK_OK(f->ctx, lth_contact_detect(f->ctx, f->contact, 0, dt, u, v, &n_active));
  lth_contact_add_rhs(f->contact, y);
  net(f, y, total);
  double want = dt * lth_contact_stiffness(f->contact) * 0.2 * 0.2 * 2e-4;
  CHECK_NEAR(total[1], want, 1e-12 * want);
  CHECK_NEAR(total[0], 0, 1e-12 * want);
  assert_false(lth_contact_revise(f->contact, v));
  lth_contact_report(f->contact, &n_active, &penetration, &force);
  CHECK_NEAR(force, want / dt, 1e-12 * want / dt);
  CHECK_NEAR(penetration, 2e-4, 1e-15);
  free(u), free(v), free(y);
}

static void block_comes_to_rest_with_small_penetration(void **state) {
  Fixture *f = *state;
  make_contact(f, &floor_plane, 1, 0.3);
  f->x[1] = 0.02;
  for (int i = 0; i < 240; i++) step(f, i / 120.0, 1 / 120.0, down);
  LitheIndex n;
  double penetration, force;
  lth_contact_report(f->contact, &n, &penetration, &force);
  assert_int_equal(n, SIDE * SIDE);
  CHECK_NEAR(force, f->mass * GRAVITY, 1e-3 * f->mass * GRAVITY);
  CHECK_AT_MOST(penetration, 0.005 * 0.2);
  CHECK_NEAR(f->v[1], 0, 1e-4);
}

/// Put the block on a slope of `angle`: gravity is tilted instead of the floor.
static void slide_for(Fixture *f, double angle, int steps, double dt) {
  double g[3] = {GRAVITY * sin(angle), -GRAVITY * cos(angle), 0};
  for (int i = 0; i < steps; i++) step(f, i * dt, dt, g);
}

static void block_stays_on_a_slope_below_the_friction_angle(void **state) {
  Fixture *f = *state;
  make_contact(f, &floor_plane, 1, 0.3);
  slide_for(f, 10 * M_PI / 180, 60, 1 / 120.0);
  double start = f->x[0];
  slide_for(f, 10 * M_PI / 180, 240, 1 / 120.0);
  CHECK_NEAR(f->x[0], start, 1e-6 * 0.2); // no creep in two seconds
  CHECK_AT_MOST(f->x[0], 0.01 * 0.2);
}

static void block_slides_on_a_slope_above_the_friction_angle(void **state) {
  Fixture *f = *state;
  make_contact(f, &floor_plane, 1, 0.3);
  double angle = 30 * M_PI / 180, a = GRAVITY * (sin(angle) - 0.3 * cos(angle));
  slide_for(f, angle, 60, 1 / 120.0);
  double before = f->v[0];
  slide_for(f, angle, 60, 1 / 120.0);
  CHECK_NEAR((f->v[0] - before) / 0.5, a, 0.01 * a);
}

static void friction_stops_a_sliding_block_and_holds_it(void **state) {
  Fixture *f = *state;
  make_contact(f, &floor_plane, 1, 0.3);
  slide_for(f, 0, 30, 1 / 120.0);
  f->v[0] = 1, f->v[2] = 0.5;
  double start = f->x[0], speed = hypot(1, 0.5), way = speed * speed / (2 * 0.3 * GRAVITY);
  slide_for(f, 0, 120, 1 / 120.0);
  CHECK_NEAR(f->x[0] - start, way / speed, 0.03 * way); // v^2 / (2 mu g), along its direction
  CHECK_NEAR(lth_v3_norm(f->v), 0, 1e-3);
}

static double rising(const void *self, const double x[3], double t) {
  (void)self, (void)x;
  return 0.5 * t;
}

static void moving_plane_pushes_and_drags(void **state) {
  Fixture *f = *state;
  LthCollider belt = floor_plane;
  belt.translation[0].eval = rising;
  belt.translation[1].eval = rising;
  make_contact(f, &belt, 1, 0.5);
  for (int i = 0; i < 120; i++) step(f, i / 120.0, 1 / 120.0, down);
  CHECK_NEAR(f->v[1], 0.5, 1e-3);
  CHECK_NEAR(f->v[0], 0.5, 1e-3);
  CHECK_NEAR(f->x[1], 0.5, 0.005 * 0.2 + 1e-3);
}

static void points_that_pull_are_dropped(void **state) {
  Fixture *f = *state;
  make_contact(f, &floor_plane, 1, 0);
  f->x[1] = -1e-4;
  f->v[1] = 5; // leaves at once: contact must not hold it
  step(f, 0, 0.01, down);
  CHECK_AT_LEAST(f->v[1], 5 - 0.01 * GRAVITY - 1e-12);
  LitheIndex n;
  double penetration, force;
  lth_contact_report(f->contact, &n, &penetration, &force);
  assert_int_equal(n, 0);
  CHECK_NEAR(force, 0, 0);
}

static void fast_points_are_caught_within_the_step(void **state) {
  Fixture *f = *state;
  make_contact(f, &floor_plane, 1, 0);
  f->x[1] = 0.03;
  f->v[1] = -5; // would end 20 mm inside
  step(f, 0, 0.01, down);
  CHECK_AT_LEAST(f->x[1], -0.005);
}

static void steps_allocate_nothing_once_the_set_stands(void **state) {
  Fixture *f = *state;
  make_contact(f, &floor_plane, 1, 0.3);
  for (int i = 0; i < 4; i++) step(f, i / 120.0, 1 / 120.0, down);
  LitheCount before = lth_alloc_count(f->ctx);
  for (int i = 4; i < 20; i++) step(f, i / 120.0, 1 / 120.0, down);
  assert_int_equal(lth_alloc_count(f->ctx), before);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(gaps_have_unit_gradients_along_their_normals),
      TEST(collider_velocity_is_that_of_its_material),
      TEST(operator_is_symmetric_and_its_bound_dominates_it),
      TEST(net_force_is_the_sum_over_points),
      TEST(block_comes_to_rest_with_small_penetration),
      TEST(block_stays_on_a_slope_below_the_friction_angle),
      TEST(block_slides_on_a_slope_above_the_friction_angle),
      TEST(friction_stops_a_sliding_block_and_holds_it),
      TEST(moving_plane_pushes_and_drags),
      TEST(points_that_pull_are_dropped),
      TEST(fast_points_are_caught_within_the_step),
      TEST(steps_allocate_nothing_once_the_set_stands),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

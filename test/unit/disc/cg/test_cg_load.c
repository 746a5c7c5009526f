/// Loads on conforming bodies: on whole faces, curved ones too, on cut pieces, in the volume, followers.
#include "cg_body.h"

#define FOR_KINDS(k) for (int k = LTH_TET4; k < LTH_POLYHEDRON; k++)

static void add(CgBody *b, LthLoad load, const double *x) {
  memset(b->f, 0, sizeof *b->f * (size_t)b->disc->n_dofs);
  CHECK_OK(b->ctx, b->disc->table->add_load(b->ctx, b->disc, &load, 0, x, b->f));
}

/// Sum of forces, and of forces times places: sum_i f_i (x) X_i.
static void sums(const CgBody *b, const double *f, const double *x, double force[3],
                 double moment[9]) {
  memset(force, 0, 3 * sizeof *force);
  memset(moment, 0, 9 * sizeof *moment);
  for (LitheIndex i = 0; i < b->disc->n_funcs; i++) {
    lth_v3_add(force, f + 3 * i, force);
    for (int k = 0; k < 9; k++) moment[k] += f[3 * i + k / 3] * x[3 * i + k % 3];
  }
}

/// Bend the cube: all nodes move, so that sides of quadratic elements curve, outer ones too.
static void bend(CgBody *b) {
  for (LitheIndex i = 0; i < b->elements->n_nodes; i++) {
    double *x = b->elements->nodes + 3 * i, y = x[1];
    x[0] += 0.2 * y * y - 0.1 * x[2] * x[2];
    x[2] += 0.15 * x[0] * y;
  }
}

static double volume(CgBody *b) {
  LitheCount n = b->disc->n_dofs;
  for (LitheCount i = 0; i < n; i++) b->x[i] = 1;
  b->disc->table->apply_mass(b->disc, b->x, b->r);
  double sum = 0;
  for (LitheCount i = 0; i < n; i += 3) sum += b->r[i];
  return sum;
}

/// Divergence theorem: int n dA = 0 and int n (x) x dA = V I, by face rules on one side and volume rules on the
/// other. Holds only where both see the same curved surface.
static void pressure_on_curved_faces_sees_the_volume_of_the_curved_body(void **state) {
  (void)state;
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 2, 0);
    bend(&b);
    cg_build(&b);
    double force[3], moment[9], V = volume(&b);
    add(&b,
        (LthLoad){.kind = LTH_LOAD_PRESSURE,
                  .patches = cg_select(&b, 0, NULL, NULL),
                  .value = {lth_value_constant(3)}},
        NULL);
    sums(&b, b.f, b.elements->nodes, force, moment);
    for (int a = 0; a < 3; a++) CHECK_NEAR(force[a], 0, 1e-13);
    // rational functions of pyramids are not integrated exactly on curved elements
    bool is_pyramid = k == LTH_PYRAMID13 || k == LTH_PYRAMID14 || k == LTH_PYRAMID5;
    for (int i = 0; i < 9; i++)
      CHECK_NEAR(moment[i], i % 4 == 0 ? -3 * V : 0, is_pyramid ? 1e-5 : 1e-12);
    cg_free(&b);
  }
}

static void a_cut_piece_takes_its_share_exactly(void **state) {
  (void)state;
  static const double point[3] = {0, 0.3, 0}, normal[3] = {0, 1, 0};
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 2, 0);
    cg_build(&b);
    double force[3], moment[9];
    LthWhere part[2] = {{.kind = LTH_WHERE_PLANE}, {.kind = LTH_WHERE_NORMAL, .angle = 0.1}};
    LthWhere both = {.kind = LTH_WHERE_AND, .children = part, .n_children = 2};
    for (int a = 0; a < 3; a++)
      part[0].point[a] = point[a], part[0].normal[a] = normal[a], part[1].normal[a] = a == 0;
    CHECK_OK(b.ctx, lth_select_boundary(b.ctx, b.mesh, &both, &b.patches[0]));
    LthLoad load = {.kind = LTH_LOAD_TRACTION, .patches = b.patches[0]};
    load.value[1] = lth_value_constant(10);
    add(&b, load, NULL);
    // 10 Pa on x = 1, 0.3 < y < 1: 7 N at y = 0.65, z = 0.5
    sums(&b, b.f, b.x0, force, moment);
    CHECK_NEAR(force[1], 7, 1e-13);
    CHECK_NEAR(moment[3], 7, 1e-13);
    CHECK_NEAR(moment[4], 7 * 0.65, 1e-13);
    CHECK_NEAR(moment[5], 7 * 0.5, 1e-13);
    load.kind = LTH_LOAD_TOTAL_FORCE;
    add(&b, load, NULL);
    sums(&b, b.f, b.x0, force, moment);
    CHECK_NEAR(force[1], 10, 1e-13);
    CHECK_NEAR(moment[4], 10 * 0.65, 1e-13);
    cg_free(&b);
  }
}

static double height(const void *self, const double x[3], double t) {
  (void)self, (void)t;
  return x[2] * x[2];
}

static void a_varying_body_force_is_integrated(void **state) {
  (void)state;
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 2, 0);
    cg_build(&b);
    double force[3], moment[9];
    LthLoad load = {.kind = LTH_LOAD_BODY_FORCE};
    load.value[0].eval = height;
    add(&b, load, NULL);
    sums(&b, b.f, b.x0, force, moment);
    CHECK_NEAR(force[0], 1.0 / 3, 1e-13); // int z^2
    cg_free(&b);
  }
}

static void a_follower_turns_and_stretches_with_the_surface(void **state) {
  (void)state;
  double axis[3] = {0.6, 0, 0.8}, R[9];
  lth_m3_rotation(axis, 1.3, R);
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 2, 0.1);
    cg_build(&b);
    double point[3] = {1, 0, 0}, normal[3] = {1, 0, 0}, turned[3], none[3] = {0};
    LthLoad load = {.kind = LTH_LOAD_PRESSURE,
                    .patches = cg_select(&b, 0, point, normal),
                    .value = {lth_value_constant(2)}};
    add(&b, load, NULL);
    memcpy(b.r, b.f, sizeof *b.r * (size_t)b.disc->n_dofs);
    load.follower = true;
    for (int i = 0; i < 9; i++) R[i] *= 1.5; // a grown body has 2.25 times the area
    cg_affine(&b, R, none, b.x);
    add(&b, load, b.x);
    for (LitheIndex i = 0; i < b.disc->n_funcs; i++) {
      lth_m3_apply(R, b.r + 3 * i, turned);
      for (int a = 0; a < 3; a++) CHECK_NEAR(b.f[3 * i + a], 1.5 * turned[a], 1e-12);
    }
    for (int i = 0; i < 9; i++) R[i] /= 1.5;
    cg_free(&b);
  }
}

static void patches_know_their_nodes(void **state) {
  (void)state;
  FOR_KINDS(k) {
    CgBody b = cg_body((LthElementKind)k, 2, 0.1);
    cg_build(&b);
    uint8_t *node = lth_alloc(b.ctx, b.disc->n_funcs, 1);
    double point[3] = {0, 0, 0.5}, up[3] = {0, 0, 1};
    // the upper half: sides of z > 1/2 and the top; nodes of the plane between the halves belong to it
    LthPatches *patches = cg_select(&b, 0, point, up);
    for (LitheIndex i = 0; i < patches->n; i++) lth_cg_patch_nodes(b.disc, patches, i, node);
    for (LitheIndex i = 0; i < b.disc->n_funcs; i++) {
      const double *x = b.x0 + 3 * i;
      bool is_rim = false;
      for (int a = 0; a < 3; a++) is_rim |= fabs(x[a] - 0.5) > 0.5 - 1e-9;
      // nodes of inner lattice planes are moved, those of the boundary not
      assert_int_equal(node[i], is_rim && x[2] > 0.5 - 1e-9);
    }
    lth_free(b.ctx, node);
    cg_free(&b);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pressure_on_curved_faces_sees_the_volume_of_the_curved_body),
      cmocka_unit_test(a_cut_piece_takes_its_share_exactly),
      cmocka_unit_test(a_varying_body_force_is_integrated),
      cmocka_unit_test(a_follower_turns_and_stretches_with_the_surface),
      cmocka_unit_test(patches_know_their_nodes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

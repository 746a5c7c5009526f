/// Splits move nothing, merges keep momentum, and planes come back to rest.
#include "dg_body.h"
#include "topology_ops.h"

#include "disc/dg/dg_transfer.h"

static uint64_t seed = 7;

static double *random_field(LitheCtx *ctx, const LthDgSpace *space) {
  double *v = lth_alloc(ctx, space->n_dofs, sizeof *v);
  for (LitheCount i = 0; i < space->n_dofs; i++) v[i] = 2 * test_random(&seed) - 1;
  return v;
}

typedef struct Totals {
  double momentum[3], angular[3], energy;
} Totals;

/// int v, int x x v and int v^2 / 2, by the orthogonality of the basis.
static Totals totals(const LthDgSpace *s, const double *x, const double *v) {
  Totals t = {0};
  for (LitheIndex c = 0; c < s->n_cells; c++) {
    double volume = s->mesh->cell_volume[c], cross[3];
    for (LitheIndex i = s->func_off[c]; i < s->func_off[c + 1]; i++) {
      if (i == s->func_off[c]) lth_v3_axpy(volume, v + 3 * i, t.momentum);
      lth_v3_cross(x + 3 * i, v + 3 * i, cross);
      lth_v3_axpy(volume, cross, t.angular);
      t.energy += volume * lth_v3_dot(v + 3 * i, v + 3 * i) / 2;
    }
  }
  return t;
}

static void check_vector(const double *got, const double *want, double tolerance) {
  for (int a = 0; a < 3; a++) CHECK_NEAR(got[a], want[a], tolerance);
}

/// A body before and after changes of its topology.
typedef struct Change {
  LitheCtx *ctx;
  LthTopology *t;
  LthMesh *mesh, *atoms, *after;
  LthDgSpace *from, *to;
  LitheIndex *from_cell, *to_cell; ///< of atoms
} Change;

static Change start_change(LitheCtx *ctx, LthMesh *mesh, int degree) {
  Change c = {.ctx = ctx, .mesh = mesh};
  CHECK_OK(ctx, lth_topology_create(ctx, mesh, &c.t));
  c.from = test_space(ctx, mesh, degree);
  return c;
}

/// Call after all splits and before merges.
static void take_atoms(Change *c, LitheIndex **record) {
  CHECK_OK(c->ctx, lth_topology_mesh(c->ctx, c->t, 0, NULL, &c->atoms, record, NULL));
  c->from_cell = lth_alloc(c->ctx, c->atoms->n_cells, sizeof *c->from_cell);
  c->to_cell = lth_alloc(c->ctx, c->atoms->n_cells, sizeof *c->to_cell);
  for (LitheIndex i = 0; i < c->atoms->n_cells; i++) {
    c->from_cell[i] = lth_topology_before(c->t, (*record)[i]);
    c->to_cell[i] = i;
  }
}

/// Find the new cells of the atoms, after merges.
static void take_after(Change *c, const LitheIndex *atom_record, int degree) {
  LitheIndex *record = NULL;
  CHECK_OK(c->ctx, lth_topology_mesh(c->ctx, c->t, 0, NULL, &c->after, &record, NULL));
  for (LitheIndex i = 0; i < c->atoms->n_cells; i++) {
    LitheIndex now = lth_topology_now(c->t, atom_record[i]);
    for (LitheIndex k = 0; k < c->after->n_cells; k++)
      if (record[k] == now) c->to_cell[i] = k;
  }
  lth_free(c->ctx, record);
  c->to = test_space(c->ctx, c->after, degree);
}

static void end_change(Change *c) {
  lth_dg_space_destroy(c->ctx, &c->from);
  lth_dg_space_destroy(c->ctx, &c->to);
  lth_mesh_destroy(c->ctx, &c->mesh);
  lth_mesh_destroy(c->ctx, &c->atoms);
  lth_mesh_destroy(c->ctx, &c->after);
  lth_topology_destroy(c->ctx, &c->t);
  lth_free(c->ctx, c->from_cell);
  lth_free(c->ctx, c->to_cell);
}

static double *transferred(const Change *c, const double *v) {
  double *out = lth_alloc(c->ctx, c->to->n_dofs, sizeof *out);
  LthDgTransfer t = {.from = c->from,
                     .to = c->to,
                     .atoms = c->atoms,
                     .n_atoms = c->atoms->n_cells,
                     .from_cell = c->from_cell,
                     .to_cell = c->to_cell};
  CHECK_OK(c->ctx, lth_dg_transfer(c->ctx, &t, v, out));
  return out;
}

/// Planes through random cells, none of which makes slivers.
static void split_some(Change *c, int n) {
  for (int i = 0; i < n; i++) {
    LthSplit s;
    LthPlane p;
    LitheIndex cell = topology_random_cell(c->t, &seed);
    lth_v3_copy(c->t->cells[cell].centroid, p.point);
    topology_direction(&seed, p.normal);
    CHECK_OK(c->ctx, lth_topology_split(c->ctx, c->t, cell, &p, i % 2 ? -1 : LTH_TAG_CUT, &s));
  }
}

static void nothing_moves_when_elements_are_split(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  static const int solids[4] = {0, 3, 4, 7};
  for (int k = 0; k < 4; k++)
    for (int degree = 1; degree <= 4; degree++) {
      Change c = start_change(ctx, topology_solid(ctx, solids[k]), degree);
      LitheIndex *record = NULL;
      split_some(&c, 5);
      take_atoms(&c, &record);
      take_after(&c, record, degree);
      assert_true(c.to->n_cells >= c.from->n_cells + 5);
      double *x = random_field(ctx, c.from), *v = random_field(ctx, c.from);
      double *y = transferred(&c, x), *w = transferred(&c, v);

      for (int i = 0; i < 200; i++) {
        LitheIndex cell = topology_int(&seed, c.to->n_cells);
        double at[3], before[3], after[3];
        for (int a = 0; a < 3; a++) {
          const double *box = c.after->cell_box + 6 * cell;
          at[a] = box[a] + test_random(&seed) * (box[3 + a] - box[a]);
        }
        lth_dg_sample(c.from, c.from_cell[cell], v, at, before);
        lth_dg_sample(c.to, cell, w, at, after);
        check_vector(after, before, 1e-11);
      }
      Totals before = totals(c.from, x, v), after = totals(c.to, y, w);
      check_vector(after.momentum, before.momentum, 1e-12);
      check_vector(after.angular, before.angular, 1e-11 * before.energy);
      CHECK_NEAR(after.energy, before.energy, 1e-12 * before.energy);
      double *fields[] = {x, v, y, w};
      for (int i = 0; i < 4; i++) lth_free(ctx, fields[i]);
      lth_free(ctx, record);
      end_change(&c);
    }
  lithe_ctx_destroy(&ctx);
}

static void raising_the_degree_keeps_values_and_lowering_it_the_mean(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  for (int low = 1; low < 4; low++) {
    Change c = start_change(ctx, topology_solid(ctx, 3), low);
    LitheIndex *record = NULL;
    take_atoms(&c, &record);
    take_after(&c, record, low + 1);
    double *v = random_field(ctx, c.from), *w = transferred(&c, v), at[3] = {0.3, 0.2, 0.1}, p[3],
           q[3];
    lth_dg_sample(c.from, 0, v, at, p);
    lth_dg_sample(c.to, 0, w, at, q);
    check_vector(q, p, 1e-13);

    // and down again: functions of the lower degree come back, those above are gone
    for (LitheCount i = 3 * c.from->n_funcs; i < c.to->n_dofs; i++) w[i] = test_random(&seed);
    LthDgTransfer down = {.from = c.to,
                          .to = c.from,
                          .atoms = c.atoms,
                          .n_atoms = c.atoms->n_cells,
                          .from_cell = c.to_cell,
                          .to_cell = c.from_cell};
    double *back = lth_alloc(ctx, c.from->n_dofs, sizeof *back);
    CHECK_OK(ctx, lth_dg_transfer(ctx, &down, w, back));
    for (LitheCount i = 0; i < c.from->n_dofs; i++) CHECK_NEAR(back[i], v[i], 1e-12);
    double *fields[] = {v, w, back};
    for (int i = 0; i < 3; i++) lth_free(ctx, fields[i]);
    lth_free(ctx, record);
    end_change(&c);
  }
  lithe_ctx_destroy(&ctx);
}

/// Splits and merges in one turn: cells between the two are the atoms.
static void merging_keeps_momentum_and_raises_no_energy(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  for (int degree = 1; degree <= 4; degree++) {
    Change c = start_change(ctx, topology_solid(ctx, 0), degree);
    LitheIndex *record = NULL;
    split_some(&c, 6);
    take_atoms(&c, &record);
    LitheIndex first_merge = c.t->log.n_births;
    for (int i = 0, done = 0; done < 6 && i < 1000; i++)
      done += topology_random_merge(ctx, c.t, &seed);
    assert_true(c.t->log.n_births - first_merge >= 6);
    take_after(&c, record, degree);
    double *rest = lth_alloc(ctx, c.from->n_dofs, sizeof *rest),
           *rest_after = lth_alloc(ctx, c.to->n_dofs, sizeof *rest);
    lth_dg_rest(c.from, rest);
    lth_dg_rest(c.to, rest_after);
    double *v = random_field(ctx, c.from), *w = transferred(&c, v), *y = transferred(&c, rest);
    Totals before = totals(c.from, rest, v), after = totals(c.to, rest_after, w);
    check_vector(after.momentum, before.momentum, 1e-13);
    check_vector(after.angular, before.angular, 1e-12);
    assert_true(after.energy < before.energy);
    for (LitheCount i = 0; i < c.to->n_dofs; i++) CHECK_NEAR(y[i], rest_after[i], 1e-12);
    double *fields[] = {rest, rest_after, v, w, y};
    for (int i = 0; i < 5; i++) lth_free(ctx, fields[i]);
    lth_free(ctx, record);
    end_change(&c);
  }
  lithe_ctx_destroy(&ctx);
}

/// A deformed cell is cut where the plane meets it: the cut at rest, deformed, lies in the plane.
static void check_plane(LitheCtx *ctx, const LthDgSpace *space, const double *x, double tolerance) {
  LthTopology *t = NULL;
  CHECK_OK(ctx, lth_topology_create(ctx, space->mesh, &t));
  LitheIndex cut = 0;
  for (LitheIndex cell = 0; cell < space->n_cells; cell++) {
    LthPlane deformed, rest;
    LthSplit s;
    lth_dg_sample(space, cell, x, space->mesh->cell_centroid + 3 * cell, deformed.point);
    for (int a = 0; a < 3; a++) deformed.point[a] += 0.1 * (test_random(&seed) - 0.5);
    topology_direction(&seed, deformed.normal);
    assert_true(lth_dg_plane_to_rest(space, cell, x, &deformed, &rest));
    CHECK_OK(ctx, lth_topology_split(ctx, t, cell, &rest, LTH_TAG_CUT, &s));
    for (LitheIndex i = 0; i < s.n; i++) {
      LitheIndex child = t->log.births[s.first + i].cell;
      for (LitheIndex k = 0; k < t->cells[child].n_faces; k++) {
        LitheIndex f = lth_topology_cell_faces(t, child)[k];
        if (t->faces[f].tag != LTH_TAG_CUT) continue;
        LthFaceView view = lth_topology_face(t, f);
        for (LitheIndex j = 0; j < t->faces[f].n_corners; j++) {
          double at[3];
          lth_dg_sample(space, cell, x, t->points + 3 * view.loop_point[j], at);
          lth_v3_sub(at, deformed.point, at);
          CHECK_NEAR(lth_v3_dot(at, deformed.normal), 0, tolerance);
        }
        cut++;
      }
    }
  }
  assert_true(cut >= space->n_cells);
  lth_topology_destroy(ctx, &t);
}

static void planes_come_back_through_affine_maps_exactly(void **state) {
  (void)state;
  for (int degree = 1; degree <= 4; degree++) {
    TestBody b = test_body(TEST_HEXAHEDRA, (LthGrid){{0, 0, 0}, {2, 2, 2}, {2, 2, 2}}, degree);
    double R[9], A[9] = {1.3, 0.2, -0.1, 0.05, 0.7, 0.3, -0.2, 0.1, 1.1}, shift[3] = {5, -3, 2};
    test_rotation(1.2, R);
    test_affine(&b, R, shift, b.x0, b.x);
    check_plane(b.ctx, b.space, b.x, 1e-13);
    test_affine(&b, A, shift, b.x0, b.x);
    check_plane(b.ctx, b.space, b.x, 1e-13);
    test_body_free(&b);
  }
}

/// x -> bent: quadratic in the rest position.
static void bend(const void *self, const double x[3], double value[3]) {
  const double *by = self;
  value[0] = x[0] + *by * x[1] * x[1];
  value[1] = x[1] - *by * x[0] * x[2];
  value[2] = x[2] + *by * x[0] * x[0];
}

static void planes_come_back_through_curved_maps_to_second_order(void **state) {
  (void)state;
  for (int n = 2; n <= 8; n *= 2) {
    TestBody b = test_body(TEST_HEXAHEDRA, (LthGrid){{0, 0, 0}, {1, 1, 1}, {n, n, n}}, 2);
    double by = 0.2, size = 1.0 / n;
    CHECK_OK(b.ctx, lth_dg_project(b.ctx, b.space, bend, &by, 4, b.x));
    LthPlane deformed = {{0, 0, 0}, {0.6, 0, 0.8}}, rest;
    for (LitheIndex cell = 0; cell < b.space->n_cells; cell++) {
      const double *center = b.mesh->cell_centroid + 3 * cell;
      lth_dg_sample(b.space, cell, b.x, center, deformed.point);
      lth_v3_axpy(0.2 * size, deformed.normal, deformed.point);
      assert_true(lth_dg_plane_to_rest(b.space, cell, b.x, &deformed, &rest));
      for (int i = 0; i < 20; i++) {
        double d[3], at[3];
        topology_direction(&seed, d);
        lth_v3_scale(i > 0 ? size / 2 : 0, d);
        lth_v3_axpy(-lth_v3_dot(d, rest.normal), rest.normal, d);
        lth_v3_add(d, rest.point, d);
        lth_dg_sample(b.space, cell, b.x, d, at);
        lth_v3_sub(at, deformed.point, at);

        // the point itself is in the plane; beside it the map's second derivatives (at most 0.4) are left
        CHECK_NEAR(lth_v3_dot(at, deformed.normal), 0, i > 0 ? 0.2 * size * size / 4 : 1e-14);
      }
    }
    test_body_free(&b);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nothing_moves_when_elements_are_split),
      cmocka_unit_test(raising_the_degree_keeps_values_and_lowering_it_the_mean),
      cmocka_unit_test(merging_keeps_momentum_and_raises_no_energy),
      cmocka_unit_test(planes_come_back_through_affine_maps_exactly),
      cmocka_unit_test(planes_come_back_through_curved_maps_to_second_order),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

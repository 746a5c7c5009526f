/// Parts of one body that are pressed together, against forces known beforehand: share, balance, what faces what, depth, memory.
#include "check.h"

#include "base/tensor.h"
#include "disc/dg/dg_disc.h"
#include "embed/contact.h"

#define PARTS_MAX 4
#define CELLS 3
#define STIFFNESS 2000.0 ///< [Pa/m]
#define CELL 1.0         ///< size that contact is told [m]
#define COARSE 0.6       ///< edges [m]: above 0.4 cells triangles touch by three places ...
#define FINE 0.1         ///< ... below by their middle
#define HEIGHT 1.0       ///< top of the base [m]
#define AREA 0.16        ///< of a face of the block on it [m^2]

/// Surfaces of parts; each follows the linear functions of one element, wherever it lies.
typedef struct Parts {
  LthSurface *made[PARTS_MAX], surface[PARTS_MAX];
  LitheIndex n, first_point[PARTS_MAX + 1];
  LthEmbedding *points;
  uint8_t *excluded; ///< the base meets what touches it, and touches nothing by itself
  LthContact *contact;
} Parts;

typedef struct Fixture {
  LitheCtx *ctx;
  LthMesh *mesh;
  LthDgSpace *space;
  LthDgOperator *op;
  LthDisc *disc;
  double young[CELLS], poisson[CELLS], density[CELLS];
  double *rest, *u, *v, *force; ///< (n_dofs)
  Parts parts[2];
} Fixture;

/// A part: a box and the element that it follows.
typedef struct PartDef {
  double min[3], max[3], edge;
  LitheIndex cell;
} PartDef;

enum { BASE, BLOCK, ASIDE };

static PartDef base(double edge) { return (PartDef){{0, 0, 0}, {1, 1, HEIGHT}, edge, BASE}; }

static PartDef block(double edge) {
  return (PartDef){{0.3, 0.35, HEIGHT}, {0.7, 0.75, HEIGHT + 0.4}, edge, BLOCK};
}

static int setup(void **state) {
  Fixture *f = calloc(1, sizeof *f);
  LthGrid grid = {.max = {CELLS, 1, 1}, .cells = {CELLS, 1, 1}};
  f->ctx = test_ctx();
  for (int c = 0; c < CELLS; c++) f->young[c] = 1e5, f->poisson[c] = 0.3, f->density[c] = 1000;
  CHECK_OK(f->ctx, lth_mesh_hexahedra(f->ctx, &grid, &f->mesh));
  CHECK_OK(f->ctx, lth_dg_space_create(f->ctx, f->mesh, 1, NULL, &f->space));
  LthDgOperatorDef op = {.space = f->space,
                         .young = f->young,
                         .poisson = f->poisson,
                         .penalty = LTH_PENALTY_AUTO,
                         .eta = 1};
  CHECK_OK(f->ctx, lth_dg_operator_create(f->ctx, &op, &f->op));
  LthDgDiscDef disc = {.space = f->space, .op = f->op, .density = f->density};
  CHECK_OK(f->ctx, lth_dg_disc_create(f->ctx, &disc, &f->disc));
  const size_t n = (size_t)f->space->n_dofs;
  f->rest = calloc(n, sizeof *f->rest), f->force = calloc(n, sizeof *f->force);
  f->u = calloc(n, sizeof *f->u), f->v = calloc(n, sizeof *f->v);
  lth_dg_rest(f->space, f->rest);
  *state = f;
  return 0;
}

static void free_parts(Fixture *f, Parts *p) {
  lth_contact_destroy(f->ctx, &p->contact);
  lth_embedding_destroy(f->ctx, &p->points);
  for (LitheIndex k = 0; k < p->n; k++) lth_surface_destroy(f->ctx, &p->made[k]);
  free(p->excluded);
  *p = (Parts){0};
}

static int teardown(void **state) {
  Fixture *f = *state;
  for (int i = 0; i < 2; i++) free_parts(f, &f->parts[i]);
  lth_disc_destroy(f->ctx, &f->disc);
  lth_dg_operator_destroy(f->ctx, &f->op);
  lth_dg_space_destroy(f->ctx, &f->space);
  lth_mesh_destroy(f->ctx, &f->mesh);
  free(f->rest), free(f->u), free(f->v), free(f->force);
  bool leaked = lth_alloc_bytes(f->ctx) != 0;
  lithe_ctx_destroy(&f->ctx);
  free(f);
  return leaked;
}

static void add_part(Fixture *f, Parts *p, const PartDef *def) {
  LthShape shape = {.kind = LTH_SHAPE_BOX};
  LthSurface *box = NULL;
  lth_v3_copy(def->min, shape.a), lth_v3_copy(def->max, shape.b);
  CHECK_OK(f->ctx, lth_shape_tessellate(f->ctx, &shape, 1, &box));
  CHECK_OK(f->ctx, lth_surface_refine(f->ctx, box, def->edge, &p->made[p->n]));
  lth_surface_destroy(f->ctx, &box);
  p->surface[p->n] = *p->made[p->n];
  p->first_point[p->n + 1] = p->first_point[p->n] + p->surface[p->n].n_points;
  p->n++;
}

static void embed(Fixture *f, Parts *p, const PartDef *def) {
  const LitheIndex n = p->first_point[p->n];
  double *x = calloc(3 * (size_t)n, sizeof *x);
  LitheIndex *off = calloc((size_t)n + 1, sizeof *off), *cell = calloc((size_t)n, sizeof *cell);
  p->excluded = calloc((size_t)n, 1);
  for (LitheIndex k = 0; k < p->n; k++)
    for (LitheIndex i = p->first_point[k]; i < p->first_point[k + 1]; i++) {
      lth_v3_copy(p->surface[k].points + 3 * (i - p->first_point[k]), x + 3 * i);
      cell[i] = def[k].cell, off[i + 1] = i + 1;
      p->excluded[i] = def[k].cell == BASE;
    }
  CHECK_OK(f->ctx,
           lth_embedding_create_average(f->ctx, f->disc, f->space, n, x, off, cell, &p->points));
  free(x), free(off), free(cell);
}

/// Parts in the given order. `both`: the base touches as well.
static Parts *make_parts(Fixture *f, int at, int n, const PartDef *def, double friction,
                         bool both) {
  Parts *p = &f->parts[at];
  free_parts(f, p);
  for (int k = 0; k < n; k++) add_part(f, p, &def[k]);
  embed(f, p, def);
  LthPartsDef contact = {.n_sides = 1, .stiffness = STIFFNESS, .friction = friction};
  contact.side[0] = (LthPartsSide){.name = "body",
                                   .points = p->points,
                                   .surface = p->surface,
                                   .first_point = p->first_point,
                                   .n_parts = p->n,
                                   .excluded = both ? NULL : p->excluded,
                                   .modulus = 1e5,
                                   .cell_size = CELL,
                                   .body_size = 1,
                                   .body_weight = 1};
  CHECK_OK(f->ctx, lth_contact_create_parts(f->ctx, &contact, &p->contact));
  return p;
}

/// The block of edges no longer than `edge` on the base.
static Parts *make_pair(Fixture *f, double edge, double friction, bool both) {
  return make_parts(f, 0, 2, (PartDef[]){base(edge), block(edge)}, friction, both);
}

/// Coefficients of x -> R x + d of what follows an element (NULL: R = 1).
static void move(Fixture *f, LitheIndex cell, const double *R, const double d[3]) {
  const LitheIndex first = f->space->func_off[cell];
  for (LitheIndex i = first; i < f->space->func_off[cell + 1]; i++) {
    double *u = f->u + 3 * i, x[3];
    lth_v3_copy(f->rest + 3 * i, x);
    if (R) lth_m3_apply(R, f->rest + 3 * i, x);
    lth_v3_sub(x, f->rest + 3 * i, u);
    if (i == first) lth_v3_add(u, d, u);
  }
}

/// Contact's forces as they are found at f->u and f->v in a step of one second; returns touches that are active.
static LitheIndex find_forces(Fixture *f, Parts *p) {
  LitheIndex active;
  memset(f->force, 0, sizeof *f->force * (size_t)f->space->n_dofs);
  CHECK_OK(f->ctx, lth_contact_detect(f->ctx, p->contact, 0, 1, f->u, f->v, &active));
  lth_contact_add_rhs(p->contact, f->force);
  return active;
}

/// Sum of the forces on what follows an element, and of their moments about a place.
static void sum_up(const Fixture *f, LitheIndex cell, const double about[3], double force[3],
                   double moment[3]) {
  const LitheIndex first = f->space->func_off[cell];
  lth_v3_copy(f->force + 3 * first, force);
  moment[0] = moment[1] = moment[2] = 0;
  for (LitheIndex i = first; i < f->space->func_off[cell + 1]; i++) {
    double arm[3], part[3];
    lth_v3_add(f->rest + 3 * i, f->u + 3 * i, arm);
    if (i == first) lth_v3_sub(arm, about, arm);
    lth_v3_cross(arm, f->force + 3 * i, part);
    lth_v3_add(moment, part, moment);
  }
}

/// Upward force on the block.
static double lift(const Fixture *f) { return f->force[3 * f->space->func_off[BLOCK] + 2]; }

/// However fine its triangles are: stiffness times area times depth, in the middle of the face.
static void a_face_is_pushed_back_by_its_area_in_its_middle(void **state) {
  Fixture *f = *state;
  const double edge[] = {COARSE, 0.3, FINE}, depth = 0.005, want = STIFFNESS * AREA * depth;
  LitheIndex active[3];
  for (int i = 0; i < 3; i++) {
    Parts *p = make_pair(f, edge[i], 0, false);
    double middle[3] = {0.5, 0.55, HEIGHT - depth}, force[3], moment[3], deepest, total;
    move(f, BLOCK, NULL, (double[]){0, 0, -depth});
    lth_contact_set_look(p->contact, LTH_LOOK_FIRST);
    active[i] = find_forces(f, p);
    sum_up(f, BLOCK, middle, force, moment);
    // a gap is a difference of numbers of size one
    CHECK_NEAR(force[2], want, 1e-12 * want / depth);
    for (int a = 0; a < 2; a++) CHECK_NEAR(force[a], 0, 1e-12 * want / depth);
    for (int a = 0; a < 3; a++) CHECK_NEAR(moment[a], 0, 1e-12 * want / depth);
    lth_contact_revise(p->contact, f->v);
    lth_contact_report(p->contact, &active[i], &deepest, &total);
    CHECK_NEAR(deepest, depth, 1e-14);
    CHECK_NEAR(total, want, 1e-12 * want / depth);
  }
  assert_int_equal(active[0], 2 * 3); // two triangles by three places each
  assert_true(active[2] > active[1]);
}

/// Parts that are strained and turned at random: forces and moments sum up to nothing, whatever the triangles touch by.
static void forces_of_parts_keep_both_momenta(void **state) {
  Fixture *f = *state;
  const double edge[] = {COARSE, FINE}, about[3] = {-3, 5, 2};
  uint64_t seed = 7;
  for (int i = 0; i < 2; i++) {
    Parts *p = make_pair(f, edge[i], 0, true);
    for (LitheIndex cell = BASE; cell <= BLOCK; cell++) {
      double R[9], d[3] = {0, 0, cell == BLOCK ? -0.04 : 0};
      for (int k = 0; k < 9; k++) R[k] = (k % 4 == 0) + 0.02 * (test_random(&seed) - 0.5);
      move(f, cell, R, d);
    }
    lth_contact_set_look(p->contact, LTH_LOOK_FIRST); // however deep
    CHECK_AT_LEAST(find_forces(f, p), 4);
    double force[2][3], moment[2][3];
    for (LitheIndex cell = BASE; cell <= BLOCK; cell++)
      sum_up(f, cell, about, force[cell], moment[cell]);
    const double scale = lth_v3_norm(force[BLOCK]);
    CHECK_AT_LEAST(scale, 0.01 * STIFFNESS * AREA);
    for (int a = 0; a < 3; a++) {
      CHECK_NEAR(force[BASE][a] + force[BLOCK][a], 0, 1e-12 * scale);
      CHECK_NEAR(moment[BASE][a] + moment[BLOCK][a], 0, 1e-11 * scale);
    }
  }
}

/// Stiffness times area times depth of the block's triangles whose middle is below the top of the base and whose
/// normal looks at it: the cosine between the two is below -0.05.
static double facing_lift(const Parts *p, const double R[9], const double d[3]) {
  const LthSurface *s = &p->surface[BLOCK];
  double sum = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    double x[3][3], e1[3], e2[3], n[3];
    for (int k = 0; k < 3; k++) {
      lth_m3_apply(R, s->points + 3 * s->tris[3 * t + k], x[k]);
      lth_v3_add(x[k], d, x[k]);
    }
    lth_v3_sub(x[1], x[0], e1), lth_v3_sub(x[2], x[0], e2);
    lth_v3_cross(e1, e2, n);
    double area = 0.5 * lth_v3_norm(n), depth = HEIGHT - (x[0][2] + x[1][2] + x[2][2]) / 3;
    if (depth > 0 && n[2] < -0.05 * 2 * area) sum += STIFFNESS * area * depth;
  }
  return sum;
}

/// A block that leans: of its walls only those that look down by more than a cosine of 0.05 touch, however deep they are in.
static void walls_beside_a_right_angle_do_not_touch(void **state) {
  Fixture *f = *state;
  const double degrees[] = {0, 2, 4, 45};
  for (int i = 0; i < 4; i++) {
    Parts *p = make_pair(f, FINE, 0, false);
    const double a = degrees[i] * acos(-1) / 180, none[3] = {0, 0, 0};
    const double R[9] = {cos(a), 0, -sin(a), 0, 1, 0, sin(a), 0, cos(a)};
    double d[3] = {0}, corner[3], middle[3];
    lth_m3_apply(R, (double[]){0.3, 0.35, HEIGHT}, corner); // the lowest edge
    lth_m3_apply(R, (double[]){0.5, 0.55, HEIGHT}, middle);
    d[0] = 0.5 - middle[0], d[2] = HEIGHT - 0.08 - corner[2];
    // apart at first: what is inside in the first step of all may have come from anywhere
    move(f, BLOCK, NULL, (double[]){0, 0, 0.05});
    lth_contact_set_look(p->contact, LTH_LOOK_FIRST);
    assert_int_equal(find_forces(f, p), 0);
    move(f, BLOCK, R, d);
    lth_contact_set_look(p->contact, LTH_LOOK_AGAIN);
    find_forces(f, p);
    const double want = facing_lift(p, R, d);
    double force[3], moment[3];
    sum_up(f, BLOCK, none, force, moment);
    CHECK_AT_LEAST(want, 0.1 * STIFFNESS * AREA * 0.08);
    CHECK_NEAR(force[2], want, 1e-11 * want);
    for (int k = 0; k < 2; k++) CHECK_NEAR(force[k], 0, 1e-11 * want);
  }
}

/// How deep the block is found (0: nothing is) and the force on it over that of the same depth, where it is `depth` below, and `way` a step
/// downwards.
static double push(Fixture *f, Parts *p, double depth, double way, double *found) {
  double force;
  LitheIndex active;
  move(f, BLOCK, NULL, (double[]){0, 0, -depth});
  f->v[3 * f->space->func_off[BLOCK] + 2] = -way;
  find_forces(f, p);
  lth_contact_report(p->contact, &active, found, &force);
  return lift(f) / (STIFFNESS * AREA * depth);
}

/// The block stands `depth` deep in balance: its springs hold that.
static void stand(Fixture *f, Parts *p, double depth) {
  double found;
  lth_contact_set_look(p->contact, LTH_LOOK_FIRST);
  CHECK_NEAR(push(f, p, depth, 0, &found), 1, 1e-10);
  lth_contact_revise(p->contact, f->v);
  lth_contact_set_look(p->contact, LTH_LOOK_STEP);
}

/// Inside for the first time: by 0.01 cells and one and a half ways of a step. Later by as much more than before. Springs are pressed
/// by what they were, for more would be energy from nowhere.
static void what_is_deeper_than_it_can_have_come_does_not_touch(void **state) {
  Fixture *f = *state;
  const struct {
    double before, way, limit;
  } cases[] = {{0, 0, 0.01}, {0, 0.01, 0.025}, {0.009, 0, 0.019}, {0.009, 0.002, 0.022}};
  for (int i = 0; i < 4; i++)
    for (int deeper = 0; deeper < 2; deeper++) {
      Parts *p = make_pair(f, COARSE, 0, false);
      if (cases[i].before > 0) stand(f, p, cases[i].before);
      const double depth = cases[i].limit * CELL * (deeper ? 1.01 : 0.99);
      double found;
      CHECK_NEAR(push(f, p, depth, cases[i].way, &found), deeper ? 0 : cases[i].before / depth,
                 1e-10);
      CHECK_NEAR(found, deeper ? 0 : depth, 1e-10 * depth);
    }
}

/// Ways along the surface lead nowhere deeper, and what was out of reach in the step before has not come by its way at all.
static void what_was_not_seen_coming_does_not_touch_where_it_is_deep(void **state) {
  Fixture *f = *state;
  for (int deeper = 0; deeper < 2; deeper++) {
    const double depth = 0.01 * CELL * (deeper ? 1.01 : 0.99), want = deeper ? 0 : depth;
    double found;
    Parts *p = make_pair(f, COARSE, 0, false);
    f->v[3 * f->space->func_off[BLOCK]] = 0.05;
    CHECK_NEAR(push(f, p, depth, 0, &found), 0, 1e-10);
    CHECK_NEAR(found, want, 1e-10 * depth);
    f->v[3 * f->space->func_off[BLOCK]] = 0;
    p = make_pair(f, COARSE, 0, false);
    CHECK_NEAR(push(f, p, -0.6, 0, &found), 0, 1e-10);
    CHECK_NEAR(push(f, p, depth, 0.05, &found), 0, 1e-10);
    CHECK_NEAR(found, want, 1e-10 * depth);
  }
}

/// A spring begins a step with the energy that it ended the last one with, also where it finds itself deeper or stiffer. What it has lost
/// lets others take up slack, and no more than that.
static void springs_give_no_more_than_they_took(void **state) {
  Fixture *f = *state;
  const double before = 0.005, deep = 0.007, after = 0.004, unit = 0.5 * STIFFNESS * AREA;
  double found, stored, spare;
  Parts *p = make_pair(f, COARSE, 0, false);
  stand(f, p, before);
  lth_contact_energy(p->contact, &stored, &spare);
  const double held = unit * before * before;
  CHECK_NEAR(stored, held, 1e-10 * held);
  CHECK_NEAR(spare, 0, 1e-10 * held);
  CHECK_NEAR(push(f, p, deep, 0, &found), before / deep, 1e-10);
  // it moves out: an implicit step loses what a spring of this way would hold
  f->v[3 * f->space->func_off[BLOCK] + 2] = deep - after;
  lth_contact_revise(p->contact, f->v);
  double left = before - (deep - after), lost = unit * (deep - after) * (deep - after);
  lth_contact_energy(p->contact, &stored, &spare);
  CHECK_NEAR(stored, unit * left * left, 1e-10 * held);
  CHECK_NEAR(spare, lost, 1e-10 * held);
  // 0.001 cells of slack, and then as much as what is left is enough for
  const double relaxed[] = {left + 0.001 * CELL, sqrt(left * left + lost / unit)};
  for (int k = 0; k < 2; k++) {
    CHECK_NEAR(push(f, p, after, 0, &found) * after, relaxed[k], 1e-10 * before);
    lth_contact_revise(p->contact, f->v);
    lth_contact_energy(p->contact, &stored, &spare);
    CHECK_NEAR(stored + spare, unit * left * left + lost, 1e-10 * held);
  }
}

/// A solve that had a point active which ends short of the surface has pulled it there: that is energy which no spring had, and the point is
/// left out. It stays so for the step, also where it would come in again.
static void points_that_pull_and_make_energy_are_left_out(void **state) {
  Fixture *f = *state;
  const double gap = 0.001, unit = STIFFNESS * AREA;
  double found, stored, spare, *v = &f->v[3 * f->space->func_off[BLOCK] + 2];
  Parts *p = make_pair(f, COARSE, 0, false);
  push(f, p, -gap, 0.01, &found);
  *v = -0.5 * gap;
  lth_contact_revise(p->contact, f->v);
  lth_contact_energy(p->contact, &stored, &spare);
  CHECK_NEAR(stored, 0, 0);
  CHECK_NEAR(spare, -unit * 0.5 * gap * 0.5 * gap, 1e-9 * unit * gap * gap);
  assert_true(lth_contact_acted(p->contact));
  assert_true(lth_contact_drop_pulls(p->contact));
  *v = -0.01;
  lth_contact_revise(p->contact, f->v);
  assert_false(lth_contact_acted(p->contact));
  assert_false(lth_contact_drop_pulls(p->contact));
  lth_contact_energy(p->contact, &stored, &spare);
  CHECK_NEAR(stored, 0, 0);
  CHECK_NEAR(spare, 0, 0);
  LitheIndex n;
  double depth, force;
  lth_contact_report(p->contact, &n, &depth, &force);
  assert_int_equal(n, 0);
}

/// A part elsewhere falls in two, and all parts, points and triangles get other numbers; the base's triangles may become
/// others, too. What is held by friction is held where it was, with the same pull.
static void friction_holds_where_it_did_after_a_cut_elsewhere(void **state) {
  Fixture *f = *state;
  const double depth = 0.005, way = 0.001; // below 0.5 x depth: it does not slide
  const PartDef aside = {{3, 0, 0}, {4, 1, 1}, COARSE, ASIDE};
  const PartDef half[2] = {{{3, 0, 0}, {3.4, 1, 1}, 0.3, ASIDE},
                           {{3.4, 0, 0}, {4, 1, 1}, 0.3, ASIDE}};
  const double edge[][2] = {{COARSE, COARSE}, {FINE, FINE}, {COARSE, FINE}, {FINE, COARSE}};
  for (int i = 0; i < 4; i++) {
    const double before = edge[i][0], after = edge[i][1];
    const bool both = before == after; // new triangles of the base have met nothing yet
    double force[2][3], moment[3];
    Parts *old = make_parts(f, 0, 3, (PartDef[]){base(before), block(before), aside}, 0.5, both);
    move(f, BLOCK, NULL, (double[]){0, 0, -depth});
    lth_contact_set_look(old->contact, LTH_LOOK_FIRST);
    find_forces(f, old);
    f->v[3 * f->space->func_off[BLOCK]] = way;
    lth_contact_revise(old->contact, f->v);
    f->v[3 * f->space->func_off[BLOCK]] = 0;
    lth_contact_set_look(old->contact, LTH_LOOK_STEP);
    Parts *now =
        make_parts(f, 1, 4, (PartDef[]){half[0], half[1], base(after), block(before)}, 0.5, both);
    CHECK_OK(f->ctx, lth_contact_inherit_parts(f->ctx, now->contact, old->contact));
    move(f, BLOCK, NULL, (double[]){way, 0, -depth});
    for (int k = 0; k < 2; k++) {
      find_forces(f, k == 0 ? old : now);
      sum_up(f, BLOCK, (double[]){0, 0, 0}, force[k], moment);
    }
    CHECK_AT_LEAST(force[0][2], STIFFNESS * AREA * depth * (1 - 1e-9));
    CHECK_NEAR(force[0][0], -force[0][2] * way / depth, 1e-12 * STIFFNESS * AREA);
    for (int a = 0; a < 3; a++) CHECK_NEAR(force[1][a], force[0][a], 1e-12 * STIFFNESS * AREA);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_face_is_pushed_back_by_its_area_in_its_middle, setup,
                                      teardown),
      cmocka_unit_test_setup_teardown(forces_of_parts_keep_both_momenta, setup, teardown),
      cmocka_unit_test_setup_teardown(walls_beside_a_right_angle_do_not_touch, setup, teardown),
      cmocka_unit_test_setup_teardown(what_is_deeper_than_it_can_have_come_does_not_touch, setup,
                                      teardown),
      cmocka_unit_test_setup_teardown(what_was_not_seen_coming_does_not_touch_where_it_is_deep,
                                      setup, teardown),
      cmocka_unit_test_setup_teardown(springs_give_no_more_than_they_took, setup, teardown),
      cmocka_unit_test_setup_teardown(points_that_pull_and_make_energy_are_left_out, setup,
                                      teardown),
      cmocka_unit_test_setup_teardown(friction_holds_where_it_did_after_a_cut_elsewhere, setup,
                                      teardown)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/// Parts of one body that a cut has made: they lie face to face, rest, slide, collide and fall apart.
#include "check.h"

#include "base/tensor.h"
#include "mesh/topology.h"
#include "scene/body.h"
#include "system/system.h"

#define GRAVITY 9.81
#define SIDE 0.1 ///< of the cube [m]

/// A cube that was cut, as a world of one body.
typedef struct Cube {
  LitheCtx *ctx;
  LthMesh *whole;
  LthTopology *topology;
  LthBody body;
  LthDgOperator *op;
  double *young, *poisson, *density, *held_x;
  uint8_t *held;
  LthCollider floor;
  LthContact *contact, *on_floor;
  LthSystem *system;
  LthSimulation *sim;
  int cuts;
  double tolerance; ///< of solves, 0: as usual
  LthLinearChoice linear;
} Cube;

static int setup(void **state) {
  Cube *k = calloc(1, sizeof *k);
  k->ctx = test_ctx();
  *state = k;
  return 0;
}

static void take_down(Cube *k) {
  lth_simulation_destroy(k->ctx, &k->sim);
  lth_system_destroy(k->ctx, &k->system);
  lth_contact_destroy(k->ctx, &k->contact);
  lth_contact_destroy(k->ctx, &k->on_floor);
  lth_body_parts_destroy(k->ctx, &k->body.parts);
  lth_disc_destroy(k->ctx, &k->body.disc);
  lth_dg_operator_destroy(k->ctx, &k->op);
  lth_dg_space_destroy(k->ctx, &k->body.space);
  lth_mesh_destroy(k->ctx, &k->body.mesh);
  lth_topology_destroy(k->ctx, &k->topology);
  lth_mesh_destroy(k->ctx, &k->whole);
  free(k->young), free(k->poisson), free(k->density), free(k->held), free(k->held_x);
}

static int teardown(void **state) {
  Cube *k = *state;
  take_down(k);
  bool leaked = lth_alloc_bytes(k->ctx) != 0;
  lithe_ctx_destroy(&k->ctx);
  free(k);
  return leaked;
}

static void begin(Cube *k, LitheIndex cells) {
  LthGrid grid = {.max = {SIDE, SIDE, SIDE}, .cells = {cells, cells, cells}};
  CHECK_OK(k->ctx, lth_mesh_hexahedra(k->ctx, &grid, &k->whole));
  CHECK_OK(k->ctx, lth_topology_create(k->ctx, k->whole, &k->topology));
  k->cuts = 0;
}

/// Cut what has its middle above the plane `above` (NULL: all of it) by the plane n . x = height.
static void cut_above(Cube *k, double x, double y, double z, double height, const double *above) {
  LthPlane plane = {.point = {height * x, height * y, height * z}, .normal = {x, y, z}};
  LthCut done;
  LitheIndex n = 0, *cells = calloc((size_t)k->topology->n_cells, sizeof *cells);
  for (LitheIndex c = 0; c < k->topology->n_cells; c++)
    if (k->topology->cells[c].is_live &&
        (!above || lth_v3_dot(above, k->topology->cells[c].centroid) > above[3]))
      cells[n++] = c;
  CHECK_OK(k->ctx, lth_topology_cut(k->ctx, k->topology, n, cells, 1, &plane,
                                    LTH_TAG_CUT - k->cuts++, &done));
  CHECK_OK(k->ctx, lth_topology_forget(k->ctx, k->topology));
  free(cells);
}

static void cut(Cube *k, double x, double y, double z, double height) {
  cut_above(k, x, y, z, height, NULL);
}

static void build_body(Cube *k) {
  CHECK_OK(k->ctx, lth_topology_mesh(k->ctx, k->topology, 0, NULL, &k->body.mesh, NULL, NULL));
  const LitheIndex n = k->body.mesh->n_cells;
  k->young = calloc((size_t)n, sizeof *k->young);
  k->poisson = calloc((size_t)n, sizeof *k->poisson);
  k->density = calloc((size_t)n, sizeof *k->density);
  for (LitheIndex c = 0; c < n; c++) k->young[c] = 1e5, k->poisson[c] = 0.3, k->density[c] = 1000;
  CHECK_OK(k->ctx, lth_dg_space_create(k->ctx, k->body.mesh, 1, NULL, &k->body.space));
  LthDgOperatorDef op = {.space = k->body.space,
                         .young = k->young,
                         .poisson = k->poisson,
                         .penalty = LTH_PENALTY_AUTO,
                         .eta = 1,
                         .warped = true};
  CHECK_OK(k->ctx, lth_dg_operator_create(k->ctx, &op, &k->op));
  LthDgDiscDef disc = {.space = k->body.space, .op = k->op, .density = k->density};
  CHECK_OK(k->ctx, lth_dg_disc_create(k->ctx, &disc, &k->body.disc));
  k->body.cell_size = k->whole->cell_size;
  k->body.size = SIDE;
  CHECK_OK(k->ctx, lth_body_count_parts(k->ctx, &k->body));
  CHECK_OK(k->ctx, lth_build_parts(k->ctx, &k->body));
}

static void build_contact(Cube *k, double friction, bool has_floor) {
  LthBodyParts *parts = k->body.parts;
  LthPartsDef def = {.n_sides = 1, .friction = friction};
  def.side[0] = (LthPartsSide){.name = "cube",
                               .points = parts->points,
                               .surface = parts->surface,
                               .first_point = parts->first_point,
                               .n_parts = parts->n,
                               .cracks = parts->cracks,
                               .modulus = 1.35e5,
                               .cell_size = k->body.cell_size,
                               .body_size = SIDE,
                               .body_weight = GRAVITY};
  CHECK_OK(k->ctx, lth_contact_create_parts(k->ctx, &def, &k->contact));
  if (!has_floor) return;
  k->floor = (LthCollider){.kind = LTH_COLLIDER_PLANE, .normal = {0, 0, 1}};
  LthContactDef floor = {.points = parts->points,
                         .colliders = &k->floor,
                         .n_colliders = 1,
                         .friction = friction,
                         .modulus = 1.35e5,
                         .cell_size = k->body.cell_size,
                         .body_size = SIDE,
                         .body_weight = GRAVITY};
  CHECK_OK(k->ctx, lth_contact_create(k->ctx, &floor, &k->on_floor));
}

static LitheStatus stay(const void *self, double t, double *x) {
  const Cube *k = self;
  (void)t;
  for (LitheCount i = 0; i < k->body.disc->n_dofs; i++)
    if (k->held[i]) x[i] = k->held_x[i];
  return LITHE_OK;
}

/// `holds`: elements whose middle is below the plane n . x = height do not move.
static void start(Cube *k, const double gravity[3], double friction, bool has_floor,
                  const double *holds, double damping) {
  build_body(k);
  build_contact(k, friction, has_floor);
  LthSystemBody body = {.disc = k->body.disc, .warped = true, .damping_stiffness = damping};
  if (holds) {
    const LthDgSpace *space = k->body.space;
    k->held = calloc((size_t)space->n_dofs, 1);
    k->held_x = calloc((size_t)space->n_dofs, sizeof(double));
    lth_dg_rest(space, k->held_x);
    for (LitheIndex c = 0; c < space->n_cells; c++)
      if (lth_v3_dot(holds, k->body.mesh->cell_centroid + 3 * c) < holds[3])
        memset(k->held + 3 * space->func_off[c], 1,
               3 * (size_t)(space->func_off[c + 1] - space->func_off[c]));
    body.held = k->held, body.prescribe = stay, body.prescribe_self = k;
  }
  LthSystemContact contacts[2] = {{k->contact, {0, 0}}, {k->on_floor, {0, -1}}};
  LthSystemDef def = {.bodies = &body,
                      .n_bodies = 1,
                      .contacts = contacts,
                      .n_contacts = has_floor ? 2 : 1,
                      .gravity = {gravity[0], gravity[1], gravity[2]}};
  CHECK_OK(k->ctx, lth_system_create(k->ctx, &def, &k->system));
  LthStepOptions options = lth_step_options_default();
  if (k->tolerance > 0) options.tolerance = k->tolerance;
  if (k->linear) options.linear = k->linear;
  CHECK_OK(k->ctx, lth_simulation_create(k->ctx, k->system, &options, &k->sim));
}

static void step(Cube *k, int n, double dt) {
  for (int i = 0; i < n; i++) CHECK_OK(k->ctx, lth_simulation_step(k->ctx, k->sim, dt));
}

/// Mass, momentum and middle of what is above (or below) the plane n . x = height.
typedef struct Half {
  double mass, momentum[3], middle[3];
} Half;

static Half measure(Cube *k, const double plane[4], bool above) {
  const LthMesh *m = k->body.mesh;
  const double *x = lth_simulation_position(k->sim), *v = lth_simulation_velocity(k->sim);
  Half half = {0};
  for (LitheIndex c = 0; c < m->n_cells; c++) {
    if ((lth_v3_dot(plane, m->cell_centroid + 3 * c) > plane[3]) != above) continue;
    double mass = 1000 * m->cell_volume[c];
    size_t first = 3 * (size_t)k->body.space->func_off[c];
    half.mass += mass; // the functions behind the first have no mean
    lth_v3_axpy(mass, v + first, half.momentum);
    lth_v3_axpy(mass, x + first, half.middle);
  }
  lth_v3_scale(1 / half.mass, half.middle);
  return half;
}

static void throw_half(Cube *k, const double plane[4], bool above, const double v[3]) {
  double *velocity = lth_simulation_velocity(k->sim);
  for (LitheIndex c = 0; c < k->body.mesh->n_cells; c++)
    if ((lth_v3_dot(plane, k->body.mesh->cell_centroid + 3 * c) > plane[3]) == above)
      lth_v3_copy(v, velocity + 3 * (size_t)k->body.space->func_off[c]);
}

static const double none[3] = {0, 0, 0}, down[3] = {0, 0, -GRAVITY};

static double surface_area(const LthSurface *s, const LitheIndex *sheet, LitheIndex wanted,
                           double normal[3]) {
  normal[0] = normal[1] = normal[2] = 0;
  for (LitheIndex t = 0; t < s->n_tris; t++) {
    double e[2][3], n[3];
    if (sheet[t] != wanted) continue;
    for (int i = 0; i < 2; i++)
      lth_v3_sub(s->points + 3 * s->tris[3 * t + 1 + i], s->points + 3 * s->tris[3 * t], e[i]);
    lth_v3_cross(e[0], e[1], n);
    lth_v3_axpy(0.5, n, normal);
  }
  return lth_v3_norm(normal);
}

/// A tongue between two cuts that do not end at one edge: four sheets, of which each looks at one. The tongue's two sides, which
/// look at each other's backs, are not among them. The surface is closed, and has points of its own on each side.
static void each_side_of_a_crack_looks_at_the_other(void **state) {
  Cube *k = *state;
  const double above[4] = {0, 0, 1, 0.4 * SIDE};
  begin(k, 5);
  cut_above(k, 1, 0.1, 0, 0.045, above);
  cut_above(k, 1, 0.1, 0, 0.061, above);
  build_body(k);
  assert_int_equal(k->body.n_parts, 1);
  CHECK_AT_LEAST(k->body.n_fronts, 2 * 5);
  const LthCrackSides *sides = k->body.parts->cracks;
  const LthSurface *s = &k->body.parts->surface[0];
  CHECK_NEAR(lth_surface_volume(s), SIDE * SIDE * SIDE, 1e-13 * SIDE * SIDE * SIDE);
  assert_int_equal(sides->n_mates, 4);
  for (int m = 0; m < 4; m++) {
    double n[2][3], area[2];
    const LitheIndex *pair = sides->mates + 2 * m;
    for (int i = 0; i < 2; i++) area[i] = surface_area(s, sides->sheet, pair[i], n[i]);
    // without the triangles at the front
    CHECK_AT_LEAST(area[0], 0.3 * SIDE * SIDE);
    CHECK_AT_MOST(lth_v3_dot(n[0], n[1]), -0.999 * area[0] * area[1]); // short edges are contracted
    for (int other = 0; other < 4; other++)
      if (other != m) assert_true(sides->mates[2 * other] != pair[0]);
  }
}

/// Steps leave no energy and no depth.
static void check_nothing_moves(Cube *k) {
  step(k, 20, 0.005);
  lth_simulation_measure(k->ctx, k->sim);
  const LthStepReport *report = lth_simulation_report(k->sim);
  const double scale = 1e5 * SIDE * SIDE * SIDE; // [J] of a strain of one
  CHECK_AT_MOST(report->strain_energy, 1e-20 * scale);
  CHECK_AT_MOST(report->kinetic_energy, 1e-20 * scale);
  CHECK_AT_MOST(report->penetration, 1e-14);
}

/// Sides of a crack touch with a gap of zero: nothing moves.
static void a_crack_has_no_force_and_no_energy(void **state) {
  Cube *k = *state;
  const double above[4] = {0, 0, 1, 0.4 * SIDE}, right[4] = {1, 0, 0, 0.5 * SIDE};
  begin(k, 5);
  cut_above(k, 0.8, 0.6, 0.1, 0.07, above);
  cut_above(k, 0, 0.1, 1, 0.071, right);
  start(k, none, 0.3, false, NULL, 0);
  assert_int_equal(k->body.n_parts, 1);
  check_nothing_moves(k);
  assert_true(k->contact && lth_simulation_report(k->sim)->contacts > 0);
}

/// Two halves that hang together at the bottom alone fly at each other: momentum to rounding, and energy never more than there was.
static void halves_with_a_hinge_do_not_pass_through_each_other(void **state) {
  Cube *k = *state;
  const double plane[4] = {1, 0, 0, 0.5 * SIDE}, above[4] = {0, 0, 1, 0.2 * SIDE};
  double deepest = 0;
  k->tolerance = 1e-13;
  begin(k, 5);
  cut_above(k, plane[0], plane[1], plane[2], plane[3], above);
  start(k, none, 0.2, false, NULL, 0);
  throw_half(k, plane, true, (double[]){-0.4, 0.1, 0});
  Half right = measure(k, plane, true), left = measure(k, plane, false);
  lth_simulation_measure(k->ctx, k->sim);
  double energy = lth_simulation_report(k->sim)->kinetic_energy, before[3];
  lth_v3_add(right.momentum, left.momentum, before);
  for (int i = 0; i < 60; i++) {
    step(k, 1, 1e-3);
    right = measure(k, plane, true), left = measure(k, plane, false);
    for (int a = 0; a < 3; a++)
      CHECK_NEAR(right.momentum[a] + left.momentum[a], before[a], 1e-12 * lth_v3_norm(before));
    lth_simulation_measure(k->ctx, k->sim);
    const LthStepReport *report = lth_simulation_report(k->sim);
    CHECK_AT_MOST(report->kinetic_energy + report->strain_energy, energy * (1 + 1e-9));
    deepest = fmax(deepest, report->penetration);
  }
  CHECK_AT_LEAST(deepest, 1e-5 * SIDE); // they did meet
  CHECK_AT_MOST(deepest, 0.02 * SIDE);
}

/// Faces of a cut coincide: the gap is zero, and nothing pushes.
static void a_fresh_cut_has_no_force_and_no_energy(void **state) {
  Cube *k = *state;
  begin(k, 3);
  cut(k, 0.36, 0.48, 0.8, 0.07);
  cut(k, 0.8, -0.6, 0, 0.011);
  start(k, none, 0.3, false, NULL, 0);
  assert_int_equal(k->body.n_parts, 4);
  check_nothing_moves(k);
}

/// A cube cut in four rests as it did whole: cuts carry what lies above them.
static void halves_on_the_floor_stay_in_place(void **state) {
  Cube *k = *state;
  const double upper[4] = {0, 0, 1, 0.043}, left[4] = {1, 0, 0, 0.052};
  begin(k, 2);
  cut(k, upper[0], upper[1], upper[2], upper[3]);
  cut(k, left[0], left[1], left[2], left[3]);
  start(k, down, 0.3, true, NULL, 5e-3);
  assert_int_equal(k->body.n_parts, 4);
  step(k, 120, 1 / 120.0);
  Half above = measure(k, upper, true), below = measure(k, upper, false);
  Half right = measure(k, left, true);
  double penetration, force;
  LitheIndex active;
  lth_contact_report(k->contact, &active, &penetration, &force);
  // weights of what is above; the vertical cut carries nothing but what bulging presses
  CHECK_AT_LEAST(force, above.mass * GRAVITY * 0.98);
  CHECK_AT_MOST(penetration, 0.005 * SIDE);
  CHECK_NEAR(above.middle[0], SIDE / 2, 1e-3 * SIDE);
  CHECK_NEAR(above.middle[1], SIDE / 2, 1e-3 * SIDE);
  CHECK_NEAR(below.middle[0], SIDE / 2, 1e-3 * SIDE);
  CHECK_NEAR(right.middle[0], (SIDE + left[3]) / 2, 1e-3 * SIDE);
  CHECK_NEAR(above.middle[2], (SIDE + upper[3]) / 2, 0.01 * SIDE); // sags by its weight alone
  for (int a = 0; a < 3; a++) CHECK_AT_MOST(fabs(above.momentum[a]), 1e-4 * above.mass);
}

/// On a cut that is inclined the upper half stays below the angle of friction, and slides with g (sin - mu cos) above it.
static void friction_holds_a_tilted_cut_below_its_angle(void **state) {
  Cube *k = *state;
  for (int slides = 0; slides < 2; slides++) {
    const double angle = (slides ? 30 : 10) * acos(-1) / 180, dt = 1 / 240.0;
    double plane[4] = {sin(angle), 0, cos(angle), 0};
    plane[3] = 0.5 * SIDE * (plane[0] + plane[2]);
    begin(k, 3);
    cut(k, plane[0], plane[1], plane[2], plane[3]);
    start(k, down, 0.3, false, plane, 2e-3);
    assert_int_equal(k->body.n_parts, 2);
    step(k, 24, dt);
    Half first = measure(k, plane, true);
    step(k, 12, dt);
    Half last = measure(k, plane, true);
    double way[3] = {cos(angle), 0, -sin(angle)}, gain[3];
    lth_v3_sub(last.momentum, first.momentum, gain);
    double a = lth_v3_dot(gain, way) / last.mass / (12 * dt);
    if (slides) {
      double want = GRAVITY * (sin(angle) - 0.3 * cos(angle));
      CHECK_NEAR(a, want, 0.03 * want);
    } else {
      double rest[3] = {0};
      double mass = 0;
      for (LitheIndex c = 0; c < k->body.mesh->n_cells; c++)
        if (!k->held[3 * k->body.space->func_off[c]]) {
          mass += k->body.mesh->cell_volume[c];
          lth_v3_axpy(k->body.mesh->cell_volume[c], k->body.mesh->cell_centroid + 3 * c, rest);
        }
      lth_v3_scale(1 / mass, rest);
      lth_v3_sub(last.middle, rest, rest);
      CHECK_NEAR(lth_v3_dot(rest, way), 0, 2e-3 * SIDE);
      CHECK_NEAR(lth_v3_dot(last.momentum, way) / last.mass, 0, 1e-3);
    }
    if (slides) break;
    take_down(k);
    LitheCtx *ctx = k->ctx;
    *k = (Cube){.ctx = ctx};
  }
}

/// Halves that fly at each other: momentum to rounding, energy never more than there was, and they part.
static void an_impact_of_two_halves_keeps_momentum(void **state) {
  Cube *k = *state;
  const double plane[4] = {0.6, 0, 0.8, 0.068};
  k->tolerance = 1e-13;
  begin(k, 2);
  cut(k, plane[0], plane[1], plane[2], plane[3]);
  start(k, none, 0.2, false, NULL, 0);
  throw_half(k, plane, true, (double[]){-0.3, 0.1, -0.4});
  Half before = measure(k, plane, true);
  lth_simulation_measure(k->ctx, k->sim);
  double energy = lth_simulation_report(k->sim)->kinetic_energy;
  const double scale = lth_v3_norm(before.momentum);
  for (int i = 0; i < 30; i++) {
    step(k, 1, 1e-3);
    Half above = measure(k, plane, true), below = measure(k, plane, false);
    for (int a = 0; a < 3; a++)
      CHECK_NEAR(above.momentum[a] + below.momentum[a], before.momentum[a], 1e-12 * scale);
  }
  lth_simulation_measure(k->ctx, k->sim);
  const LthStepReport *report = lth_simulation_report(k->sim);
  CHECK_AT_MOST(report->kinetic_energy + report->strain_energy, energy);
  Half above = measure(k, plane, true), below = measure(k, plane, false);
  CHECK_AT_LEAST(lth_v3_dot(above.momentum, plane) / above.mass,
                 lth_v3_dot(below.momentum, plane) / below.mass);
  CHECK_AT_LEAST(fabs(lth_v3_dot(below.momentum, plane)), 0.1 * scale);
}

/// A cube parted along all of its elements' faces.
static void sixty_four_fragments_rest_side_by_side(void **state) {
  Cube *k = *state;
  begin(k, 4);
  for (int a = 0; a < 3; a++)
    for (int i = 1; i < 4; i++) cut(k, a == 0, a == 1, a == 2, 0.25 * i * SIDE);
  start(k, down, 0.4, true, NULL, 5e-3);
  assert_int_equal(k->body.n_parts, 64);
  step(k, 8, 1 / 120.0);
  const double upper[4] = {0, 0, 1, 0.01};
  Half all = measure(k, upper, true);
  const LthStepReport *report = lth_simulation_report(k->sim);
  CHECK_NEAR(all.middle[0], SIDE / 2, 1e-4 * SIDE);
  CHECK_NEAR(all.middle[1], SIDE / 2, 1e-4 * SIDE);
  CHECK_AT_MOST(report->penetration, 0.001 * SIDE);
  assert_true(report->converged);
}

/// Sum of v phi D phi v over lumped touches.
typedef struct Lumps {
  const double *v;
  const LitheIndex *row_func;
  double energy;
  int n, most_ends;
} Lumps;

static void add_lump(void *self, int n_ends, const LthContactEnd *end, const double *D) {
  Lumps *l = self;
  double w[3] = {0}, f[3];
  for (int e = 0; e < n_ends; e++)
    for (int j = 0; j < end[e].nb; j++)
      lth_v3_axpy(end[e].phi[j], l->v + 3 * (l->row_func[end[e].row] + j), w);
  lth_m3_apply(D, w, f);
  l->energy += lth_v3_dot(w, f);
  l->n++;
  l->most_ends = n_ends > l->most_ends ? n_ends : l->most_ends;
}

/// Means over the elements at a corner have the values of a linear motion, and so does the element that a touch lies on.
static void lumped_contact_is_contact_for_linear_motions(void **state) {
  Cube *k = *state;
  const double plane[4] = {0.6, 0, 0.8, 0.068};
  begin(k, 3);
  cut(k, plane[0], plane[1], plane[2], plane[3]);
  start(k, none, 0.2, false, NULL, 0);
  throw_half(k, plane, true, (double[]){-0.3, 0.1, -0.4});
  step(k, 1, 1e-3);
  const LitheCount n = k->system->n;
  double *v = calloc((size_t)n, sizeof *v), *y = calloc((size_t)n, sizeof *y), energy = 0;
  lth_dg_rest(k->body.space, y);
  for (LitheCount i = 0; i < n; i += 3) {
    LitheIndex c = 0;
    while (3 * (LitheCount)k->body.space->func_off[c + 1] <= i) c++;
    bool above = lth_v3_dot(plane, k->body.mesh->cell_centroid + 3 * c) > plane[3];
    const double M[2][9] = {{1, 2, 0, 0, 3, 1, 4, 0, 1}, {0, 1, 1, 2, 0, 5, 1, 1, 2}};
    lth_m3_apply(M[above], y + i, v + i);
  }
  memset(y, 0, sizeof *y * (size_t)n);
  lth_contact_apply(k->contact, v, y);
  for (LitheCount i = 0; i < n; i++) energy += v[i] * y[i];
  Lumps l = {.v = v, .row_func = k->body.space->func_off};
  assert_true(lth_contact_visit_lumps(k->contact, false, add_lump, &l));
  assert_true(l.n > 20 && l.most_ends == 2 && energy > 0);
  CHECK_NEAR(l.energy, energy, 1e-11 * energy);
  free(v), free(y);
}

/// Conjugate gradients that know contact by block diagonals take several times the iterations.
static void coarse_levels_know_how_fragments_touch(void **state) {
  Cube *k = *state;
  LitheIndex iterations[2];
  for (int i = 0; i < 2; i++) {
    k->linear = i == 0 ? LTH_LINEAR_PCG : LTH_LINEAR_MULTIGRID;
    begin(k, 6);
    for (int a = 0; a < 3; a++)
      for (int j = 1; j < 3; j++) cut(k, a == 0, a == 1, a == 2, j * SIDE / 3);
    start(k, down, 0.4, true, NULL, 5e-3);
    assert_int_equal(k->body.n_parts, 27);
    step(k, 3, 1 / 120.0);
    iterations[i] = lth_simulation_report(k->sim)->linear_total;
    assert_true(lth_simulation_report(k->sim)->converged);
    if (i == 1) break;
    take_down(k);
    LitheCtx *ctx = k->ctx;
    *k = (Cube){.ctx = ctx};
  }
  CHECK_AT_MOST(2.5 * iterations[1], iterations[0]);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_fresh_cut_has_no_force_and_no_energy, setup, teardown),
      cmocka_unit_test_setup_teardown(each_side_of_a_crack_looks_at_the_other, setup, teardown),
      cmocka_unit_test_setup_teardown(a_crack_has_no_force_and_no_energy, setup, teardown),
      cmocka_unit_test_setup_teardown(halves_with_a_hinge_do_not_pass_through_each_other, setup,
                                      teardown),
      cmocka_unit_test_setup_teardown(halves_on_the_floor_stay_in_place, setup, teardown),
      cmocka_unit_test_setup_teardown(friction_holds_a_tilted_cut_below_its_angle, setup, teardown),
      cmocka_unit_test_setup_teardown(an_impact_of_two_halves_keeps_momentum, setup, teardown),
      cmocka_unit_test_setup_teardown(lumped_contact_is_contact_for_linear_motions, setup,
                                      teardown),
      cmocka_unit_test_setup_teardown(coarse_levels_know_how_fragments_touch, setup, teardown),
      cmocka_unit_test_setup_teardown(sixty_four_fragments_rest_side_by_side, setup, teardown),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

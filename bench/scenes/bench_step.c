/// Corotated dynamic steps per second: a clamped cube of 10 x 10 x 10 elements, and a scene's body at several
/// resolutions. Options: --csv, --threads N, --scene FILE (default scenes/bunny-drop.yaml), --no-scene.
#include "disc/dg/dg_disc.h"
#include "scene/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CUBE_CELLS 10
#define REPEATS 12 // of a block of steps; the best counts

/// Nothing here can go on after a failure.
static void check(LitheCtx *ctx, LitheStatus status, const char *what) {
  if (status == LITHE_OK) return;
  fprintf(stderr, "bench_step: %s: %s: %s\n", what, lithe_status_text(status),
          lithe_ctx_message(ctx));
  exit(1);
}

#define CHECK(call) check(ctx, (call), #call)

/// A unit cube, E = 1e5, nu = 0.3, rho = 1000, clamped weakly at x = 0.
typedef struct Cube {
  LthMesh *mesh;
  LthDgSpace *space;
  LthPatches *clamp;
  LthDgOperator *op;
  double *young, *poisson, *density;
} Cube;

static void fill(LitheCtx *ctx, LitheIndex n, double value, double **array) {
  CHECK(lth_new_(ctx, (void **)array, n, sizeof **array));
  for (LitheIndex i = 0; i < n; i++) (*array)[i] = value;
}

static Cube cube_create(LitheCtx *ctx, int degree) {
  Cube c = {0};
  LthGrid grid = {.max = {1, 1, 1}, .cells = {CUBE_CELLS, CUBE_CELLS, CUBE_CELLS}};
  LthWhere side = {.kind = LTH_WHERE_PLANE, .normal = {-1, 0, 0}}; // x <= 0
  CHECK(lth_mesh_hexahedra(ctx, &grid, &c.mesh));
  CHECK(lth_select_boundary(ctx, c.mesh, &side, &c.clamp));
  fill(ctx, c.mesh->n_cells, 1e5, &c.young);
  fill(ctx, c.mesh->n_cells, 0.3, &c.poisson);
  fill(ctx, c.mesh->n_cells, 1000, &c.density);
  CHECK(lth_dg_space_create(ctx, c.mesh, degree, NULL, &c.space));
  LthWeakConstraint weak = {.patches = c.clamp, .fixed = {true, true, true}};
  LthDgOperatorDef def = {.space = c.space,
                          .young = c.young,
                          .poisson = c.poisson,
                          .warped = true,
                          .weak = &weak,
                          .n_weak = 1};
  CHECK(lth_dg_operator_create(ctx, &def, &c.op));
  return c;
}

static void cube_destroy(LitheCtx *ctx, Cube *c) {
  lth_dg_operator_destroy(ctx, &c->op);
  lth_dg_space_destroy(ctx, &c->space);
  lth_patches_destroy(ctx, &c->clamp);
  lth_mesh_destroy(ctx, &c->mesh);
  lth_free(ctx, c->young);
  lth_free(ctx, c->poisson);
  lth_free(ctx, c->density);
}

/// Best block of `block` steps after `warm` steps; the row gives its time and the mean of its parts.
static void time_steps(LitheCtx *ctx, LthSimulation *sim, const char *name, LitheCount unknowns,
                       double tolerance, double dt, int warm, int block, bool csv) {
  LthStepReport best = {0};
  double best_time = INFINITY;
  for (int i = 0; i < warm; i++) CHECK(lth_simulation_step(ctx, sim, dt));
  for (int repeat = 0; repeat < REPEATS; repeat++) {
    LthStepReport before = *lth_simulation_report(sim);
    double start = lth_now();
    for (int i = 0; i < block; i++) CHECK(lth_simulation_step(ctx, sim, dt));
    double time = lth_now() - start;
    if (time >= best_time) continue;
    best_time = time;
    best = *lth_simulation_report(sim);
    best.time_assemble -= before.time_assemble;
    best.time_factor -= before.time_factor;
    best.time_solve -= before.time_solve;
    best.linear_total -= before.linear_total;
  }
  printf(csv ? "%s,%lld,%.0e,%.1f,%.2f,%.2f,%.2f,%.1f,%d,%d\n"
             : "%-10s %8lld %8.0e %8.1f %9.2f %8.2f %8.2f %7.1f %9d %5d\n",
         name, (long long)unknowns, tolerance, block / best_time, 1e3 * best.time_assemble / block,
         1e3 * best.time_factor / block, 1e3 * best.time_solve / block,
         (double)best.linear_total / block, (int)best.contacts, best.converged);
  fflush(stdout);
}

static void cube_row(LitheCtx *ctx, const char *name, int degree, double tolerance, int block,
                     bool csv) {
  Cube c = cube_create(ctx, degree);
  LthStepOptions options = lth_step_options_default();
  LthSimulation *sim = NULL;
  LthDisc *disc = NULL;
  LthSystem *system = NULL;
  LthDgDiscDef seen = {.space = c.space, .op = c.op, .density = c.density};
  CHECK(lth_dg_disc_create(ctx, &seen, &disc));
  LthSystemBody body = {.disc = disc, .warped = true};
  LthSystemDef def = {.bodies = &body, .n_bodies = 1, .gravity = {0, 0, -9.81}};
  CHECK(lth_system_create(ctx, &def, &system));
  options.tolerance = tolerance;
  CHECK(lth_simulation_create(ctx, system, &options, &sim));
  time_steps(ctx, sim, name, c.space->n_dofs, tolerance, 0.01, 5, block, csv);
  lth_simulation_destroy(ctx, &sim);
  lth_system_destroy(ctx, &system);
  lth_disc_destroy(ctx, &disc);
  cube_destroy(ctx, &c);
}

static void scene_row(LitheCtx *ctx, const char *file, int cells, int block, bool csv) {
  LthSceneErrors errors = {0};
  LthScene *scene = NULL;
  LthWorld *world = NULL;
  char override[64], name[32];
  double times[2];
  snprintf(override, sizeof override, "bodies.0.method.cells=%d", cells);
  snprintf(name, sizeof name, "scene %d", cells);
  const char *overrides[] = {override};
  CHECK(lth_scene_read(ctx, file, overrides, 1, NULL, &errors, &scene));
  lth_scene_errors_free(&errors);
  CHECK(lth_world_create(ctx, scene, times, &world));
  // a quarter of a second in: the bunny lies on the floor and shakes
  int warm = cells > 16 ? 2 : (int)(0.25 / scene->step);
  time_steps(ctx, world->sim, name, world->system->n, scene->tolerance, scene->step, warm, block,
             csv);
  lth_world_destroy(ctx, &world);
  lth_scene_destroy(ctx, &scene);
}

static bool is_there(const char *file) {
  FILE *f = fopen(file, "r");
  if (f) fclose(f);
  return f != NULL;
}

int main(int argc, char **argv) {
  bool csv = false;
  const char *scene = "scenes/bunny-drop.yaml";
  LitheCtxDef def = lithe_ctx_def_default();
  for (int i = 1; i < argc; i++) {
    csv |= strcmp(argv[i], "--csv") == 0;
    if (strcmp(argv[i], "--no-scene") == 0) scene = NULL;
    if (strcmp(argv[i], "--threads") == 0 && i + 1 < argc)
      def.threads = atoi(argv[++i]);
    else if (strcmp(argv[i], "--scene") == 0 && i + 1 < argc)
      scene = argv[++i];
  }
  LitheCtx *ctx = lithe_ctx_create(&def);
  if (!ctx) return 4;
  if (csv)
    printf(
        "case,unknowns,tolerance,steps a second,assemble ms,factor ms,solve ms,iterations,contacts,"
        "converged\n");
  else
    printf("Corotated dynamic steps, best of %d blocks, %d threads [ms a step]\n%-10s %8s %8s %8s "
           "%9s %8s "
           "%8s %7s %9s %5s\n",
           REPEATS, lth_threads(ctx), "", "unknowns", "toler.", "steps/s", "assemble", "factor",
           "solve", "its", "contacts", "conv.");
  cube_row(ctx, "cube P1", 1, 1e-6, 5, csv);
  cube_row(ctx, "cube P1", 1, 1e-8, 5, csv);
  cube_row(ctx, "cube P2", 2, 1e-8, 2, csv);
  if (scene && is_there(scene)) {
    scene_row(ctx, scene, 8, 4, csv);
    scene_row(ctx, scene, 16, 2, csv);
    scene_row(ctx, scene, 32, 1, csv);
  } else if (scene) {
    fprintf(stderr, "bench_step: %s: not found; run from the top folder or give --scene FILE\n",
            scene);
  }
  lithe_ctx_destroy(&ctx);
  return 0;
}

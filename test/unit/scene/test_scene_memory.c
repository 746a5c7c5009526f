/// Reading a scene with the 1st, 2nd, 3rd ... allocation failing: a status, and nothing left behind.
#include "scene_text.h"

typedef struct Failing {
  long long countdown;
  long long n_live;
} Failing;

static void *allocate(void *user, size_t alignment, size_t bytes) {
  Failing *f = user;
  if (f->countdown-- == 0) return NULL;
  f->n_live++;
  return aligned_alloc(alignment, bytes);
}

static void release(void *user, void *block) {
  ((Failing *)user)->n_live--;
  free(block);
}

static const char text[] =
    "lithe: 1\n"
    "bodies:\n"
    "  - shape: {difference: [{box: {min: [0, 0, 0], max: [1, 1, 1]}}, {implicit: x}]}\n"
    "    material: [{young_modulus: 1+x, poisson_ratio: 0, density: 1, where: {not: all}}, "
    "{young_modulus: 1, "
    "poisson_ratio: 0, density: 1}]\n"
    "    method: {cells: 2}\n"
    "    place: {rotate: {axis: [0, 0, 1], angle: 10 deg}}\n"
    "    constraints: [{where: {or: [all, {box: {min: [0, 0, 0], max: [1, 1, 1]}}]}, displacement: "
    "[0, t, x]}]\n"
    "    loads: [{body_force: [0, 0, x]}]\n"
    "    embed: {}\n"
    "colliders: [{sphere: {center: [0, 0, 0], radius: 1, motion: [t, 0, 0]}}]\n"
    "probes: [{name: a, point: [0, 0, 0]}]\n";

/// Read with allocation `k` failing; true if it came to that.
static bool fails_cleanly(const char *scene_text, long long k, LitheStatus otherwise) {
  Failing failing = {.countdown = k};
  LitheCtxDef def = lithe_ctx_def_default();
  def.allocate = allocate;
  def.release = release;
  def.memory_user = &failing;
  LitheCtx *ctx = lithe_ctx_create(&def);
  LthSceneErrors errors = {0};
  LthScene *scene = NULL;
  LitheStatus status =
      lth_scene_read_text(ctx, "s.yaml", scene_text, strlen(scene_text), NULL, 0, &errors, &scene);
  bool has_failed = failing.countdown < 0;
  if (status != (has_failed ? LITHE_NO_MEMORY : otherwise))
    fail_msg("allocation %lld: %s: %s", k, lithe_status_text(status), lithe_ctx_message(ctx));
  lth_scene_errors_free(&errors);
  lth_scene_destroy(ctx, &scene);
  assert_int_equal(failing.n_live, 0);
  lithe_ctx_destroy(&ctx);
  return has_failed;
}

static void a_good_scene_survives_any_failing_allocation(void **state) {
  (void)state;
  long long k = 0;
  while (fails_cleanly(text, k, LITHE_OK)) k++;
  assert_true(k > 20);
}

static void a_bad_scene_survives_any_failing_allocation(void **state) {
  (void)state;
  long long k = 0;
  while (fails_cleanly("lithe: 1\nbodys: []\ntime: statik\ngravity: [0, x, \"1 kg\"]\n", k,
                       LITHE_BAD_INPUT))
    k++;
  assert_true(k > 5);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_good_scene_survives_any_failing_allocation),
      cmocka_unit_test(a_bad_scene_survives_any_failing_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

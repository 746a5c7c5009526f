/// Scenes as text for the tests: a whole one, and checks of what the reader says about another.
#pragma once

#include "check.h"
#include "scene/scene.h"

#include <string.h>

/// Lines 1 to 7; tests add further keys behind.
#define SMALL_SCENE                                                                                \
  "lithe: 1\n"                                                                                     \
  "bodies:\n"                                                                                      \
  "  - name: bar\n"                                                                                \
  "    shape: {box: {min: [0, 0, 0], max: [4, 1, 1]}}\n"                                           \
  "    material: {young_modulus: 1 MPa, poisson_ratio: 0.3, density: 1000}\n"                      \
  "    method: {cells: [4, 1, 1]}\n"

typedef struct Reading {
  LitheCtx *ctx;
  LthScene *scene;
  LthSceneErrors errors;
  LitheStatus status;
} Reading;

static inline Reading read_with(const char *text, int n_overrides, const char *const *overrides) {
  Reading reading = {.ctx = test_ctx()};
  reading.status = lth_scene_read_text(reading.ctx, "s.yaml", text, strlen(text), overrides,
                                       n_overrides, &reading.errors, &reading.scene);
  return reading;
}

static inline void end_reading(Reading *reading) {
  lth_scene_errors_free(&reading->errors);
  lth_scene_destroy(reading->ctx, &reading->scene);
  assert_int_equal(lth_alloc_bytes(reading->ctx), 0);
  lithe_ctx_destroy(&reading->ctx);
}

static inline Reading read_good(const char *text) {
  Reading reading = read_with(text, 0, NULL);
  if (reading.status != LITHE_OK) fail_msg("%s", lithe_ctx_message(reading.ctx));
  return reading;
}

/// The reader says exactly these lines (NULL-ended).
static inline void expect_lines(const char *text, int n_overrides, const char *const *overrides,
                                const char *const *lines) {
  Reading reading = read_with(text, n_overrides, overrides);
  int n = 0;
  while (lines[n]) n++;
  assert_null(reading.scene);
  for (int i = 0; i < n && i < reading.errors.n; i++)
    assert_string_equal(reading.errors.lines[i], lines[i]);
  if (n != reading.errors.n)
    fail_msg("%d errors instead of %d; the last: %s", reading.errors.n, n,
             reading.errors.n ? reading.errors.lines[reading.errors.n - 1] : "(none)");
  assert_int_equal(reading.status, LITHE_BAD_INPUT);
  end_reading(&reading);
}

#define EXPECT_ERRORS(text, ...)                                                                   \
  expect_lines((text), 0, NULL, (const char *const[]){__VA_ARGS__, NULL})

/// One override of the small scene, and what is said about it.
#define EXPECT_OVERRIDE_ERROR(override, line)                                                      \
  expect_lines(SMALL_SCENE, 1, (const char *const[]){override}, (const char *const[]){line, NULL})

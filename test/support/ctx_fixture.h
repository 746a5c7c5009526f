/// Set-up and tear-down of tests that need a context and nothing else; what is left allocated fails the test.
#pragma once

#include "check.h"

typedef struct Fixture {
  LitheCtx *ctx;
} Fixture;

static inline int setup(void **state) {
  Fixture *f = calloc(1, sizeof *f);
  f->ctx = test_ctx();
  *state = f;
  return 0;
}

static inline int teardown(void **state) {
  Fixture *f = *state;
  bool leaked = lth_alloc_bytes(f->ctx) != 0;
  lithe_ctx_destroy(&f->ctx);
  free(f);
  return leaked;
}

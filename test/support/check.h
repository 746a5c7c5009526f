/// What every unit test includes: cmocka, checks that print both numbers, a context.
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/ctx.h"

/// Fail unless |got - want| <= tolerance; NaN fails.
#define CHECK_NEAR(got, want, tolerance)                                                           \
  do {                                                                                             \
    double got_ = (got), want_ = (want), tol_ = (tolerance);                                       \
    if (!(fabs(got_ - want_) <= tol_))                                                             \
      fail_msg("%s = %.17g, expected %.17g within %.3g (off by %.3g)", #got, got_, want_, tol_,    \
               got_ - want_);                                                                      \
  } while (0)

/// Fail unless got <= bound; NaN fails.
#define CHECK_AT_MOST(got, bound)                                                                  \
  do {                                                                                             \
    double got_ = (got), bound_ = (bound);                                                         \
    if (!(got_ <= bound_)) fail_msg("%s = %.6g, expected at most %.6g", #got, got_, bound_);       \
  } while (0)

/// Fail unless got >= bound; NaN fails.
#define CHECK_AT_LEAST(got, bound)                                                                 \
  do {                                                                                             \
    double got_ = (got), bound_ = (bound);                                                         \
    if (!(got_ >= bound_)) fail_msg("%s = %.6g, expected at least %.6g", #got, got_, bound_);      \
  } while (0)

/// Fail with the context's message unless `call` gives LITHE_OK.
#define CHECK_OK(ctx, call)                                                                        \
  do {                                                                                             \
    LitheStatus status_ = (call);                                                                  \
    if (status_ != LITHE_OK)                                                                       \
      fail_msg("%s: %s: %s", #call, lithe_status_text(status_), lithe_ctx_message(ctx));           \
  } while (0)

/// A context for a test; destroy it with lithe_ctx_destroy().
static inline LitheCtx *test_ctx(void) {
  LitheCtxDef def = lithe_ctx_def_default();
  return lithe_ctx_create(&def);
}

/// A small repeatable generator (xorshift64*), uniform in [0, 1); print the seed when a case fails.
static inline double test_random(uint64_t *state) {
  uint64_t x = *state ? *state : 0x9E3779B97F4A7C15u;
  x ^= x >> 12, x ^= x << 25, x ^= x >> 27;
  *state = x;
  return (double)((x * 0x2545F4914F6CDD1Du) >> 11) * 0x1p-53;
}

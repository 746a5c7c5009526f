/// The context behind LitheCtx: failures, warnings, memory, threads, cancellation, progress.
#pragma once

#include "lithe/base.h"

#include <stdarg.h>

/// Record a failure's message and return its status. Keeps the first LTH_MESSAGE_MAX - 1 bytes. This and
/// lth_warn() may be called from a parallel loop; the last message stays.
LitheStatus lth_fail(LitheCtx *ctx, LitheStatus status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/// Add a warning that ends up in `warnings` of the result. Equal texts are kept once.
void lth_warn(LitheCtx *ctx, const char *format, ...) __attribute__((format(printf, 2, 3)));

/// Memory of `count * size` bytes, aligned to 64, all zero; NULL on overflow or where memory is out.
/// A count of 0 gives a valid block. Free with lth_free().
void *lth_alloc(LitheCtx *ctx, LitheCount count, size_t size);

/// Resize a block of lth_alloc(): contents up to the smaller size are kept, the rest is zero.
/// NULL where memory is out (the old block stays valid).
void *lth_realloc(LitheCtx *ctx, void *block, LitheCount old_count, LitheCount count, size_t size);

/// Free a block of lth_alloc(). Accepts NULL.
void lth_free(LitheCtx *ctx, void *block);

/// Keep large blocks that are freed, and give them out again: pages that are in memory already cost nothing, new ones as much as the
/// work on them. Blocks get a quarter more room, so that what is made again a little larger finds its own place.
/// False: release what is kept.
void lth_keep_spares(LitheCtx *ctx, bool keeps);

/// Release spare blocks that nobody has asked for since the last call.
void lth_age_spares(LitheCtx *ctx);

/// As lth_alloc() for a table that its owner writes in full before it is read: spare blocks come as they are.
LitheStatus lth_new_rough_(LitheCtx *ctx, void **ptr, LitheCount count, size_t size);

/// Number of allocations so far; tests compare it before and after a step.
LitheCount lth_alloc_count(const LitheCtx *ctx);

/// Bytes held now, and the most that were held at any time: the same in every run on one thread.
LitheCount lth_alloc_bytes(const LitheCtx *ctx);
LitheCount lth_alloc_peak(const LitheCtx *ctx);

/// Number of threads that parallel loops use: `num_threads(lth_threads(ctx))`.
int lth_threads(const LitheCtx *ctx);

/// Change the number of threads, 0 for all cores.
void lth_set_threads(LitheCtx *ctx, int threads);

/// True once lithe_ctx_cancel() was called: return LITHE_INTERRUPTED at the next safe place.
bool lth_cancelled(const LitheCtx *ctx);

/// Tell the user how far a phase is; `fraction` in [0, 1] or -1. Cheap, may be called often.
void lth_progress(LitheCtx *ctx, const char *phase, double fraction);

/// What stands before every phase from now on, such as which of many runs this is: copied, cut where too long, "" for
/// nothing.
#define LTH_PROGRESS_HEAD_MAX 120
void lth_progress_head(LitheCtx *ctx, const char *head);

/// Digest of the contents of all files read so far: a sum, so that the difference of two readings tells
/// what was read between them.
void lth_note_input(LitheCtx *ctx, uint64_t digest);
uint64_t lth_inputs(const LitheCtx *ctx);

/// Wall clock [s] from an arbitrary start.
double lth_now(void);

/// Seconds that processors have worked for this process, all threads together: other programs do not stretch them.
double lth_processor_time(void);

/// Fail from the current function: LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: expected ..., got %g", ...).
#define LITHE_FAIL(ctx, status, ...) return lth_fail((ctx), (status), __VA_ARGS__)

/// Return a failure of `call` to the caller.
#define LITHE_TRY(call)                                                                            \
  do {                                                                                             \
    LitheStatus try_status_ = (call);                                                              \
    if (try_status_ != LITHE_OK) return try_status_;                                               \
  } while (0)

/// Set `status` from `call` and jump to `label` if it failed.
#define LITHE_TRY_OR(label, call)                                                                  \
  do {                                                                                             \
    status = (call);                                                                               \
    if (status != LITHE_OK) goto label;                                                            \
  } while (0)

/// `ptr = lth_alloc(...)` of `count` elements of ptr's type; returns LITHE_NO_MEMORY if that fails.
#define LTH_NEW(ctx, ptr, count) LITHE_TRY(lth_new_((ctx), (void **)&(ptr), (count), sizeof *(ptr)))

/// As LTH_NEW, but sets `status` and jumps to `label`.
#define LTH_NEW_OR(label, ctx, ptr, count)                                                         \
  LITHE_TRY_OR(label, lth_new_((ctx), (void **)&(ptr), (count), sizeof *(ptr)))

/// As LTH_NEW_OR, of lth_new_rough_().
#define LTH_NEW_ROUGH_OR(label, ctx, ptr, count)                                                   \
  LITHE_TRY_OR(label, lth_new_rough_((ctx), (void **)&(ptr), (count), sizeof *(ptr)))

/// Make room for at least `need` elements in a growable array (doubling).
#define LTH_RESERVE(ctx, ptr, cap, need)                                                           \
  LITHE_TRY(lth_reserve_((ctx), (void **)&(ptr), &(cap), (need), sizeof *(ptr)))
#define LTH_RESERVE_OR(label, ctx, ptr, cap, need)                                                 \
  LITHE_TRY_OR(label, lth_reserve_((ctx), (void **)&(ptr), &(cap), (need), sizeof *(ptr)))

/// A copy of a text, freed by lth_free().
LitheStatus lth_copy_text(LitheCtx *ctx, const char *text, char **copy);

LitheStatus lth_new_(LitheCtx *ctx, void **ptr, LitheCount count, size_t size);
LitheStatus lth_reserve_(LitheCtx *ctx, void **ptr, LitheCount *cap, LitheCount need, size_t size);

/// Our own mistakes; on in Debug and `check` builds. Input is never checked with it.
#ifdef LITHE_ASSERTS
#include <assert.h>
#define LITHE_ASSERT(condition) assert(condition)
#else
#define LITHE_ASSERT(condition) ((void)0)
#endif

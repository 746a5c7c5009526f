/// Failures, warnings, counted memory, threads, cancellation and progress of one library user.
#include "base/ctx.h"

#include <omp.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#define LTH_MESSAGE_MAX 4096
#define LTH_WARNINGS_MAX 1000
#define LTH_ALIGNMENT 64
#define SPARES_MAX 64
#define SPARE_LEAST ((size_t)1 << 18) ///< bytes: smaller blocks are the allocator's own business

typedef struct BlockHead BlockHead;

struct LitheCtx {
  LitheCtxDef def;
  int threads;
  atomic_bool cancelled;
  atomic_flag is_writing; ///< messages and warnings
  atomic_llong n_allocs, bytes, peak;
  char message[LTH_MESSAGE_MAX];
  char **warnings;
  LitheIndex n_warnings;
  uint64_t inputs; ///< sum of digests
  char progress_head[LTH_PROGRESS_HEAD_MAX];
  bool keeps_spares;
  atomic_flag is_sparing; ///< spares
  BlockHead *spare[SPARES_MAX];
  uint32_t spare_age[SPARES_MAX]; ///< when it came
  int n_spares;
  uint32_t age;
};

/// Stands in front of every block so that its size is known when it is freed.
struct BlockHead {
  size_t bytes, room; ///< in use, there
  char pad[LTH_ALIGNMENT - 2 * sizeof(size_t)];
};

static const struct {
  int exit_status;
  const char *text;
} status_table[] = {
#define STATUS_ROW(name, exit_status, text) {exit_status, text},
    LITHE_STATUS_LIST(STATUS_ROW)
#undef STATUS_ROW
};

static bool is_status(LitheStatus status) {
  return (size_t)status < sizeof status_table / sizeof status_table[0];
}

const char *lithe_status_text(LitheStatus status) {
  return is_status(status) ? status_table[status].text : "unknown status";
}

int lithe_status_exit(LitheStatus status) {
  return is_status(status) ? status_table[status].exit_status : 1;
}

#define STRING_(x) #x
#define STRING(x) STRING_(x)

const char *lithe_version(void) {
  return STRING(LITHE_VERSION_MAJOR) "." STRING(LITHE_VERSION_MINOR) "." STRING(
      LITHE_VERSION_PATCH);
}

#define HUGE_PAGE ((size_t)1 << 21)

// Large blocks ask for large pages: loops over grids touch many places at once, and each would miss a translation.
static void *default_allocate(void *user, size_t alignment, size_t bytes) {
  (void)user;
#ifdef MADV_HUGEPAGE
  if (bytes >= 2 * HUGE_PAGE) {
    void *block = aligned_alloc(HUGE_PAGE, (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE);
    if (block) (void)madvise(block, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
    return block;
  }
#endif
  return aligned_alloc(alignment, bytes);
}

static void default_release(void *user, void *block) {
  (void)user;
  free(block);
}

#if defined(MAP_ANONYMOUS) && defined(MADV_HUGEPAGE) && !defined(__SANITIZE_ADDRESS__)
#define MAPPED (16 * HUGE_PAGE) // bytes from which malloc would map blocks too
#endif

/// Zeros straight from the system: what nobody ever writes takes no memory. The first page begins at a large page.
static void *map_zeros(size_t bytes) {
#ifdef MAPPED
  const size_t whole = (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
  char *at =
      mmap(NULL, whole + HUGE_PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (at == MAP_FAILED) return NULL;
  const size_t before = (HUGE_PAGE - (uintptr_t)at % HUGE_PAGE) % HUGE_PAGE;
  if (before > 0) (void)munmap(at, before);
  if (before < HUGE_PAGE) (void)munmap(at + before + whole, HUGE_PAGE - before);
  (void)madvise(at + before, whole, MADV_HUGEPAGE);
  return at + before;
#else
  (void)bytes;
  return NULL;
#endif
}

static void unmap(void *block, size_t bytes) {
#ifdef MAPPED
  (void)munmap(block, (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE);
#else
  (void)block;
  (void)bytes;
#endif
}

LitheCtxDef lithe_ctx_def_default(void) {
  return (LitheCtxDef){.allocate = default_allocate, .release = default_release};
}

LitheCtx *lithe_ctx_create(const LitheCtxDef *def) {
  LitheCtx *ctx = calloc(1, sizeof *ctx);
  if (!ctx) return NULL;
  ctx->def = *def;
  if (!ctx->def.allocate) ctx->def.allocate = default_allocate;
  if (!ctx->def.release) ctx->def.release = default_release;
  atomic_flag_clear(&ctx->is_writing);
  atomic_flag_clear(&ctx->is_sparing);
  lth_set_threads(ctx, def->threads);
  return ctx;
}

void lithe_ctx_destroy(LitheCtx **ctx) {
  if (!ctx || !*ctx) return;
  lth_keep_spares(*ctx, false);
  for (LitheIndex i = 0; i < (*ctx)->n_warnings; i++) free((*ctx)->warnings[i]);
  free((*ctx)->warnings);
  free(*ctx);
  *ctx = NULL;
}

const char *lithe_ctx_message(const LitheCtx *ctx) { return ctx->message; }
LitheIndex lithe_ctx_warning_count(const LitheCtx *ctx) { return ctx->n_warnings; }

const char *lithe_ctx_warning(const LitheCtx *ctx, LitheIndex i) {
  return i >= 0 && i < ctx->n_warnings ? ctx->warnings[i] : "";
}

void lithe_ctx_cancel(LitheCtx *ctx) { atomic_store(&ctx->cancelled, true); }
bool lth_cancelled(const LitheCtx *ctx) { return atomic_load(&ctx->cancelled); }

/// One thread at a time writes messages. Not an OpenMP critical section: its name would be exported.
static void begin_message(LitheCtx *ctx) {
  while (atomic_flag_test_and_set(&ctx->is_writing)) {
  }
}

static void end_message(LitheCtx *ctx) { atomic_flag_clear(&ctx->is_writing); }

LitheStatus lth_fail(LitheCtx *ctx, LitheStatus status, const char *format, ...) {
  va_list args;
  va_start(args, format);
  begin_message(ctx);
  vsnprintf(ctx->message, sizeof ctx->message, format, args);
  end_message(ctx);
  va_end(args);
  return status;
}

static bool has_warning(const LitheCtx *ctx, const char *text) {
  for (LitheIndex i = 0; i < ctx->n_warnings; i++)
    if (strcmp(ctx->warnings[i], text) == 0) return true;
  return false;
}

static void keep_warning(LitheCtx *ctx, const char *text) {
  if (ctx->n_warnings >= LTH_WARNINGS_MAX || has_warning(ctx, text)) return;

  // a warning that finds no memory is dropped: the work itself goes on
  char **grown = realloc(ctx->warnings, sizeof *grown * (size_t)(ctx->n_warnings + 1));
  if (!grown) return;
  ctx->warnings = grown;
  char *copy = strdup(text);
  if (copy) ctx->warnings[ctx->n_warnings++] = copy;
}

void lth_warn(LitheCtx *ctx, const char *format, ...) {
  char text[LTH_MESSAGE_MAX];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  begin_message(ctx);
  keep_warning(ctx, text);
  end_message(ctx);
}

/// A block of so many bytes comes straight from the system.
static bool is_mapped(const LitheCtx *ctx, size_t bytes) {
#ifdef MAPPED
  return bytes >= MAPPED && ctx->def.allocate == default_allocate &&
         ctx->def.release == default_release;
#else
  (void)ctx;
  (void)bytes;
  return false;
#endif
}

static void release_block(LitheCtx *ctx, BlockHead *head) {
  if (is_mapped(ctx, head->room))
    unmap(head, head->room);
  else
    ctx->def.release(ctx->def.memory_user, head);
}

static void begin_sparing(LitheCtx *ctx) {
  while (atomic_flag_test_and_set(&ctx->is_sparing)) {
  }
}

/// The smallest spare block that fits and is not much too large, or NULL.
static BlockHead *take_spare(LitheCtx *ctx, size_t whole) {
  BlockHead *found = NULL;
  int best = -1;
  begin_sparing(ctx);
  for (int i = 0; i < ctx->n_spares; i++) {
    size_t room = ctx->spare[i]->room;
    if (room >= whole && room / 2 <= whole && (best < 0 || room < ctx->spare[best]->room)) best = i;
  }
  if (best >= 0) {
    found = ctx->spare[best];
    ctx->spare_age[best] = ctx->spare_age[--ctx->n_spares];
    ctx->spare[best] = ctx->spare[ctx->n_spares];
  }
  atomic_flag_clear(&ctx->is_sparing);
  return found;
}

/// False where there are enough.
static bool put_spare(LitheCtx *ctx, BlockHead *head) {
  begin_sparing(ctx);
  bool fits = ctx->n_spares < SPARES_MAX;
  if (fits) {
    ctx->spare_age[ctx->n_spares] = ctx->age;
    ctx->spare[ctx->n_spares++] = head;
  }
  atomic_flag_clear(&ctx->is_sparing);
  return fits;
}

void lth_keep_spares(LitheCtx *ctx, bool keeps) {
  ctx->keeps_spares = keeps;
  while (!keeps && ctx->n_spares > 0) release_block(ctx, ctx->spare[--ctx->n_spares]);
}

void lth_age_spares(LitheCtx *ctx) {
  int n = 0;
  for (int i = 0; i < ctx->n_spares; i++)
    if (ctx->spare_age[i] < ctx->age) {
      release_block(ctx, ctx->spare[i]);
    } else {
      ctx->spare_age[n] = ctx->spare_age[i];
      ctx->spare[n++] = ctx->spare[i];
    }
  ctx->n_spares = n;
  ctx->age++;
}

/// A block from the spare ones, or a new one with room to grow into; zeros but for spare ones that are written anyway.
static BlockHead *find_block(LitheCtx *ctx, size_t whole, bool is_rough) {
  const bool spares = ctx->keeps_spares && whole >= SPARE_LEAST;
  // nothing is in memory before it is written
  size_t room = spares ? whole + whole / 4 / LTH_ALIGNMENT * LTH_ALIGNMENT : whole;
  BlockHead *head = spares ? take_spare(ctx, whole) : NULL;
  const bool is_new = !head, mapped = is_new && is_mapped(ctx, room);
  if (is_new)
    head = mapped ? map_zeros(room) : ctx->def.allocate(ctx->def.memory_user, LTH_ALIGNMENT, room);
  if (!head) return NULL;
  if (!is_new) room = head->room;
  if (is_new ? !mapped : !is_rough) memset(head, 0, whole);
  head->bytes = whole;
  head->room = room;
  return head;
}

static void *allocate(LitheCtx *ctx, LitheCount count, size_t size, bool is_rough) {
  size_t bytes = 0;
  if (count < 0 || __builtin_mul_overflow((size_t)count, size, &bytes) ||
      bytes > PTRDIFF_MAX - 2 * sizeof(BlockHead))
    return NULL;
  size_t whole = (bytes + 2 * sizeof(BlockHead) - 1) / sizeof(BlockHead) * sizeof(BlockHead);
  BlockHead *head = find_block(ctx, whole, is_rough);
  if (!head) return NULL;
  atomic_fetch_add(&ctx->n_allocs, 1);
  const long long now = atomic_fetch_add(&ctx->bytes, (long long)whole) + (long long)whole;
  long long peak = atomic_load(&ctx->peak);
  while (now > peak && !atomic_compare_exchange_weak(&ctx->peak, &peak, now)) continue;
  return head + 1;
}

void *lth_alloc(LitheCtx *ctx, LitheCount count, size_t size) {
  return allocate(ctx, count, size, false);
}

void *lth_realloc(LitheCtx *ctx, void *block, LitheCount old_count, LitheCount count, size_t size) {
  void *grown = lth_alloc(ctx, count, size);
  if (!grown) return NULL;
  LitheCount kept = old_count < count ? old_count : count;
  if (block && kept > 0) memcpy(grown, block, (size_t)kept * size);
  lth_free(ctx, block);
  return grown;
}

void lth_free(LitheCtx *ctx, void *block) {
  if (!block) return;
  BlockHead *head = (BlockHead *)block - 1;
  atomic_fetch_sub(&ctx->bytes, (long long)head->bytes);
  if (ctx->keeps_spares && head->room >= SPARE_LEAST && put_spare(ctx, head)) return;
  release_block(ctx, head);
}

LitheCount lth_alloc_count(const LitheCtx *ctx) { return atomic_load(&ctx->n_allocs); }
LitheCount lth_alloc_bytes(const LitheCtx *ctx) { return atomic_load(&ctx->bytes); }
LitheCount lth_alloc_peak(const LitheCtx *ctx) { return atomic_load(&ctx->peak); }

static LitheStatus fail_memory(LitheCtx *ctx, LitheCount count, size_t size) {
  return lth_fail(ctx, LITHE_NO_MEMORY, "out of memory: %lld x %zu bytes were asked for",
                  (long long)count, size);
}

LitheStatus lth_new_(LitheCtx *ctx, void **ptr, LitheCount count, size_t size) {
  *ptr = lth_alloc(ctx, count, size);
  return *ptr ? LITHE_OK : fail_memory(ctx, count, size);
}

LitheStatus lth_new_rough_(LitheCtx *ctx, void **ptr, LitheCount count, size_t size) {
  *ptr = allocate(ctx, count, size, true);
  return *ptr ? LITHE_OK : fail_memory(ctx, count, size);
}

LitheStatus lth_reserve_(LitheCtx *ctx, void **ptr, LitheCount *cap, LitheCount need, size_t size) {
  if (need <= *cap) return LITHE_OK;
  LitheCount grown_cap = *cap < 16 ? 16 : 2 * *cap;
  if (grown_cap < need) grown_cap = need;
  void *grown = lth_realloc(ctx, *ptr, *cap, grown_cap, size);
  if (!grown)
    return lth_fail(ctx, LITHE_NO_MEMORY, "out of memory: %lld x %zu bytes were asked for",
                    (long long)grown_cap, size);
  *ptr = grown;
  *cap = grown_cap;
  return LITHE_OK;
}

LitheStatus lth_copy_text(LitheCtx *ctx, const char *text, char **copy) {
  size_t bytes = strlen(text) + 1;
  LTH_NEW(ctx, *copy, (LitheCount)bytes);
  memcpy(*copy, text, bytes);
  return LITHE_OK;
}

int lth_threads(const LitheCtx *ctx) { return ctx->threads; }

void lth_set_threads(LitheCtx *ctx, int threads) {
  ctx->threads = threads > 0 ? threads : omp_get_num_procs();
}

void lth_progress(LitheCtx *ctx, const char *phase, double fraction) {
  char text[2 * LTH_PROGRESS_HEAD_MAX];
  if (!ctx->def.progress) return;
  if (ctx->progress_head[0]) {
    snprintf(text, sizeof text, "%s%s", ctx->progress_head, phase);
    phase = text;
  }
  ctx->def.progress(ctx->def.progress_user, phase, fraction);
}

void lth_progress_head(LitheCtx *ctx, const char *head) {
  snprintf(ctx->progress_head, sizeof ctx->progress_head, "%s", head);
}

void lth_note_input(LitheCtx *ctx, uint64_t digest) { ctx->inputs += digest; }
uint64_t lth_inputs(const LitheCtx *ctx) { return ctx->inputs; }

double lth_processor_time(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double lth_now(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

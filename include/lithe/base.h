/// Status codes, the context and the index types that every other public header uses.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#define LITHE_API
#else
#define LITHE_API __attribute__((visibility("default")))
#endif

#define LITHE_VERSION_MAJOR 0
#define LITHE_VERSION_MINOR 1
#define LITHE_VERSION_PATCH 0

typedef int32_t LitheIndex; ///< local things: points, faces, cells, unknown blocks
typedef int64_t LitheCount; ///< non-zeros, unknowns and other sizes that may exceed 2^31

/// The one list of status codes: name, exit status of the program, text.
#define LITHE_STATUS_LIST(X)                                                                       \
  X(LITHE_OK, 0, "success")                                                                        \
  X(LITHE_FAILED, 1, "a check does not hold")                                                      \
  X(LITHE_BAD_INPUT, 2, "bad input")                                                               \
  X(LITHE_UNSUPPORTED, 2, "not supported")                                                         \
  X(LITHE_NOT_CONVERGED, 3, "did not converge")                                                    \
  X(LITHE_NO_MEMORY, 4, "out of memory")                                                           \
  X(LITHE_NO_SPACE, 4, "cannot write")                                                             \
  X(LITHE_INTERRUPTED, 130, "interrupted")

typedef enum LitheStatus {
#define LITHE_STATUS_ENUM(name, exit_status, text) name,
  LITHE_STATUS_LIST(LITHE_STATUS_ENUM)
#undef LITHE_STATUS_ENUM
} LitheStatus;

/// Short text of a status, never NULL.
LITHE_API const char *lithe_status_text(LitheStatus status);

/// Exit status of the program for a status (0, 1, 2, 3, 4 or 130).
LITHE_API int lithe_status_exit(LitheStatus status);

/// Memory, messages, threads and cancellation of one user of the library. Not shared between threads.
typedef struct LitheCtx LitheCtx;

/// Called now and then during long work. `fraction` in [0, 1], or -1 where it is not known.
typedef void (*LitheProgressFn)(void *user, const char *phase, double fraction);

/// What a context is made from. Start from lithe_ctx_def_default().
typedef struct LitheCtxDef {
  int threads;                                                   ///< 0: all cores
  LitheProgressFn progress;                                      ///< may be NULL
  void *progress_user;                                           ///< passed to `progress`
  void *(*allocate)(void *user, size_t alignment, size_t bytes); ///< NULL: aligned_alloc
  void (*release)(void *user, void *block);                      ///< NULL: free
  void *memory_user; ///< passed to `allocate` and `release`
} LitheCtxDef;

LITHE_API LitheCtxDef lithe_ctx_def_default(void);

/// Make a context; free it with lithe_ctx_destroy(). NULL where memory is out.
LITHE_API LitheCtx *lithe_ctx_create(const LitheCtxDef *def);

/// Free a context and clear the pointer. Accepts NULL. Everything made with it must be freed before.
LITHE_API void lithe_ctx_destroy(LitheCtx **ctx);

/// The message of the last failure, "" if none. Borrowed until the next call with this context.
LITHE_API const char *lithe_ctx_message(const LitheCtx *ctx);

/// Number of warnings so far, and one of them. Borrowed until the context is destroyed.
LITHE_API LitheIndex lithe_ctx_warning_count(const LitheCtx *ctx);
LITHE_API const char *lithe_ctx_warning(const LitheCtx *ctx, LitheIndex i);

/// Ask running work to stop soon with LITHE_INTERRUPTED. May be called from a signal handler.
LITHE_API void lithe_ctx_cancel(LitheCtx *ctx);

/// Version of the linked library, "MAJOR.MINOR.PATCH".
LITHE_API const char *lithe_version(void);

#ifdef __cplusplus
}
#endif

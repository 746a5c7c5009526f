/// A scene: what is simulated, read from a file and checked.
#pragma once

#include "lithe/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A checked scene with the surfaces it names. Immutable once read.
typedef struct LitheScene LitheScene;

/// What to read. Start from lithe_scene_def_default() and set `file`. Nothing is kept.
typedef struct LitheSceneDef {
  const char *file;             ///< a scene file (YAML or JSON)
  const char *const *overrides; ///< "bodies.0.method.degree=2" and so on     (n_overrides)
  int n_overrides;
  const char *defects_path; ///< where defects of a surface are written as .ply; NULL: nowhere
} LitheSceneDef;

LITHE_API LitheSceneDef lithe_scene_def_default(void);

/// Read and check a scene; free it with lithe_scene_destroy(), after a failure too: `*scene` then holds
/// the list of errors and nothing else (NULL where memory is out).
/// @return LITHE_BAD_INPUT, LITHE_UNSUPPORTED: see lithe_scene_error(). LITHE_NO_MEMORY.
LITHE_API LitheStatus lithe_scene_read(LitheCtx *ctx, const LitheSceneDef *def, LitheScene **scene);

/// Everything that is wrong with the file, each as "file:line:column: path: what; what is expected".
/// Borrowed until the scene is destroyed.
LITHE_API LitheIndex lithe_scene_error_count(const LitheScene *scene);
LITHE_API const char *lithe_scene_error(const LitheScene *scene, LitheIndex i);

/// Title and name (the stem of the file). Borrowed until the scene is destroyed.
LITHE_API const char *lithe_scene_title(const LitheScene *scene);
LITHE_API const char *lithe_scene_name(const LitheScene *scene);

/// Free a scene and clear the pointer. Accepts a pointer to NULL.
LITHE_API void lithe_scene_destroy(LitheCtx *ctx, LitheScene **scene);

#ifdef __cplusplus
}
#endif

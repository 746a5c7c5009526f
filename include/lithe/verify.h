/// One scene by all methods at refining resolutions: do they agree?
#pragma once

#include "lithe/study.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What to compare. Start from lithe_verify_def_default() and set `scene`. Nothing is kept.
typedef struct LitheVerifyDef {
  const char *scene;   ///< a scene file
  const char *folder;  ///< where everything is written; NULL: out/<scene>-verify
  const char *methods; ///< "dg,staggered,cg"; NULL: all that the scene allows
  const char *
      cells; ///< "8,16,32" along the longest side, or "dg:8,16;cg:16,32"; NULL: half the scene's own, its own, and twice that
  const char
      *meshes;      ///< "a.msh,b.msh" beside the scene: what cg takes, coarse to fine; NULL: cells
  double tolerance; ///< how far methods may be apart, as a share; stresses three times as far
  const char *const *overrides; ///< put into every run                       (n_overrides)
  int n_overrides;
  void (*tell)(void *user, const char *text); ///< gets the report when it is done; may be NULL
  void *tell_user;
} LitheVerifyDef;

LITHE_API LitheVerifyDef lithe_verify_def_default(void);

/// Run a scene with every method at every resolution, and compare displacements and stresses at probes and energies,
/// extrapolated where three resolutions allow it. Writes what lithe_study() writes.
/// @return LITHE_OK: they agree. LITHE_FAILED: they do not, or a run did not converge. LITHE_BAD_INPUT: the scene is
/// bad, or leaves fewer than two methods to compare.
LITHE_API LitheStatus lithe_verify(LitheCtx *ctx, const LitheVerifyDef *def,
                                   LitheStudyResult **result);

#ifdef __cplusplus
}
#endif

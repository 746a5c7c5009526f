/// A solid's surface with its sharp edges: lattices are tried until all that is checked holds.
#include "geometry/sharp_priv.h"

#define ATTEMPTS 4 ///< lattices

static void release_pieces(LthSharp *s) {
  LitheCtx *ctx = s->ctx;
  lth_hash_free(ctx, &s->hash);
  for (int side = 0; side < 2; side++) lth_free(ctx, s->negative[side]);
  lth_free(ctx, s->source);
  lth_free(ctx, s->points);
  lth_free(ctx, s->tris);
  lth_free(ctx, s->group);
  *s = (LthSharp){.ctx = ctx, .solid = s->solid};
}

static LitheStatus try_lattice(LthSharp *s, const double min[3], const double max[3],
                               double resolution, int attempt, bool *is_good) {
  LITHE_TRY(lth_sharp_lay_out(s, min, max, resolution, attempt));
  LITHE_TRY(lth_sharp_march(s));
  *is_good = !s->is_bad;
  if (!*is_good || s->n_tris == 0) return LITHE_OK;
  LITHE_TRY(lth_sharp_move(s, is_good));
  return *is_good ? lth_sharp_separate(s, is_good) : LITHE_OK;
}

LitheStatus lth_sharp_surface(LitheCtx *ctx, const LthSolid *solid, const double min[3],
                              const double max[3], double resolution, bool *is_sharp,
                              LitheIndex *n_points, double **points, LitheIndex *n_tris,
                              LitheIndex **tris) {
  LitheStatus status = LITHE_OK;
  LthSharp s = {.ctx = ctx, .solid = solid};
  *is_sharp = false, *points = NULL, *tris = NULL, *n_points = 0, *n_tris = 0;
  for (int attempt = 0; attempt < ATTEMPTS && !*is_sharp; attempt++) {
    release_pieces(&s);
    LITHE_TRY_OR(done, try_lattice(&s, min, max, resolution, attempt, is_sharp));
  }
  if (!*is_sharp) goto done;
  *points = s.points, *tris = s.tris, *n_points = s.n_points, *n_tris = s.n_tris;
  s.points = NULL, s.tris = NULL;
done:
  release_pieces(&s);
  return status;
}

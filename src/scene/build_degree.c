/// The degree of every element: a number, or an expression at its centroid.
#include "scene/body.h"

#include <math.h>

static LitheStatus degree_at(LitheCtx *ctx, const LthBody *body, const double x[3], int *degree) {
  double value = lth_value_at(&body->def->degree_at, x, 0), nearest = round(value);
  if (nearest >= 1 && nearest <= LTH_DG_MAX_DEGREE) {
    *degree = (int)nearest;
    return LITHE_OK;
  }
  LITHE_TRY(lth_scene_check_values(ctx, body->scene));
  LITHE_FAIL(
      ctx, LITHE_BAD_INPUT,
      "%s.method.degree: it is %g at the centroid (%g, %g, %g) of an element; expected an "
      "expression that rounds to 1 to %d everywhere in the body, as with min(max(.., 1), %d)",
      body->def->place, value, x[0], x[1], x[2], LTH_DG_MAX_DEGREE, LTH_DG_MAX_DEGREE);
}

LitheStatus lth_build_degrees_of(LitheCtx *ctx, const LthBody *body, const LthMesh *mesh,
                                 uint8_t *degree) {
  for (LitheIndex c = 0; c < mesh->n_cells; c++) {
    int k = body->def->degree;
    if (k == 0) LITHE_TRY(degree_at(ctx, body, mesh->cell_centroid + 3 * (LitheCount)c, &k));
    degree[c] = (uint8_t)k;
  }
  return LITHE_OK;
}

LitheStatus lth_build_degrees(LitheCtx *ctx, const LthBody *body, uint8_t *degree) {
  return lth_build_degrees_of(ctx, body, body->mesh, degree);
}

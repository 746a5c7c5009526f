/// Freeing polygon soups.
#include "geometry/surface.h"

void lth_soup_destroy(LitheCtx *ctx, LthSoup **soup) {
  if (!soup || !*soup) return;
  LthSoup *s = *soup;
  if (s->group_names)
    for (LitheIndex i = 0; i < s->n_groups; i++) lth_free(ctx, s->group_names[i]);
  lth_free(ctx, s->group_names);
  lth_free(ctx, s->points);
  lth_free(ctx, s->poly_off);
  lth_free(ctx, s->poly_point);
  lth_free(ctx, s->uvs);
  lth_free(ctx, s->poly_uv);
  lth_free(ctx, s->poly_group);
  lth_free(ctx, s);
  *soup = NULL;
}

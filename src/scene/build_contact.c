/// What touches colliders: the points of the embedded surface, coarse nodes of the mesh, or both.
#include "scene/body.h"

#include "base/tensor.h"
#include "disc/cg/cg_disc.h"
#include "embed/contact.h"

/// Longest edge of a polygon, squared.
static double longest_edge(const LthSoup *soup, LitheIndex polygon) {
  LitheIndex begin = soup->poly_off[polygon], end = soup->poly_off[polygon + 1];
  double longest = 0;
  for (LitheIndex i = begin; i < end; i++) {
    double edge[3];
    lth_v3_sub(soup->points + 3 * (LitheCount)soup->poly_point[i + 1 < end ? i + 1 : begin],
               soup->points + 3 * (LitheCount)soup->poly_point[i], edge);
    longest = fmax(longest, lth_v3_dot(edge, edge));
  }
  return longest;
}

/// A flat face of a part has points at its corners only: between them it would sink into a floor.
static bool has_large_polygons(const LthBody *body) {
  double limit = 2 * body->cell_size;
  for (LitheIndex p = 0; p < body->soup->n_polys; p++)
    if (longest_edge(body->soup, p) > limit * limit) return true;
  return false;
}

/// Faces of quadratic elements, which are the body's whole boundary: an embedded surface has nothing to add.
static LitheStatus create_on_faces(LitheCtx *ctx, LthBody *body) {
  LthTouchPoints t;
  LITHE_TRY(lth_cg_touch_points(ctx, body->disc, &t));
  LitheStatus status =
      lth_embedding_create_direct(ctx, body->disc, t.n, t.points, t.cells, &body->nodes);
  if (status == LITHE_OK) {
    body->nodes->area = t.area;
    t.area = NULL;
  }
  lth_touch_points_free(ctx, &t);
  return status;
}

static LitheStatus create_nodes(LitheCtx *ctx, LthBody *body, const LthEmbedding *surface) {
  if (body->staggered) return lth_build_grid_nodes(ctx, body, surface, &body->nodes);
  if (!body->space && lth_cg_touches_by_faces(body->disc)) return create_on_faces(ctx, body);
  return lth_embedding_create_nodes(ctx, body->disc, body->space, surface, &body->nodes);
}

static LitheStatus choose_points(LitheCtx *ctx, LthBody *body) {
  LthContactPoints points = body->scene->contact_points;
  if (points == LTH_POINTS_NODES || !body->embedding) return create_nodes(ctx, body, NULL);
  if (!has_large_polygons(body)) return LITHE_OK;
  if (points == LTH_POINTS_SURFACE) {
    lth_warn(ctx, "contact.points: the embedded surface has polygons larger than the elements, and "
                  "nothing touches between their points; `auto` adds the nodes");
    return LITHE_OK;
  }
  return create_nodes(ctx, body, body->embedding);
}

double lth_body_modulus(const LthBody *body) {
  double modulus = 0;
  for (LitheIndex c = 0; c < body->disc->n_cells; c++) {
    double lambda, mu, young, poisson;
    lth_body_elastic(body, c, &young, &poisson);
    lth_lame(young, fmin(poisson, 0.45), &lambda,
             &mu); // what does not shrink bulges where it is pressed
    modulus = fmax(modulus, lambda + 2 * mu);
  }
  return modulus;
}

double lth_body_weight(const LthBody *body) {
  const double weight = body->mass * lth_v3_norm(body->scene->gravity);
  return body->scene->dimension == 2 ? weight * LTH_CONTACT_SPOT * body->size : weight;
}

LitheStatus lth_build_contact(LitheCtx *ctx, LthBody *body) {
  const LthScene *scene = body->scene;
  if (scene->n_colliders == 0) return LITHE_OK;
  LITHE_TRY(choose_points(ctx, body));
  LthContactDef def = {.points = body->nodes ? body->nodes : body->embedding,
                       .colliders = scene->colliders,
                       .n_colliders = scene->n_colliders,
                       .stiffness = scene->contact_stiffness,
                       .friction = scene->contact_friction,
                       .damping = scene->contact_damping,
                       .modulus = lth_body_modulus(body),
                       .cell_size = body->cell_size,
                       .body_size = body->size,
                       .body_weight = lth_body_weight(body)};
  return lth_contact_create(ctx, &def, &body->contact);
}

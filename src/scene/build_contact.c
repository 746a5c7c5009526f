/// What touches colliders: the points of the embedded surface, or coarse nodes of the mesh.
#include "scene/body.h"

#include "base/tensor.h"

LitheStatus lth_build_contact(LitheCtx *ctx, LthBody *body) {
  const LthScene *scene = body->scene;
  if (scene->n_colliders == 0) return LITHE_OK;
  if (scene->contact_nodes || !body->embedding)
    LITHE_TRY(lth_embedding_create_nodes(ctx, body->space, &body->nodes));
  LthContactDef def = {.points = body->nodes ? body->nodes : body->embedding,
                       .colliders = scene->colliders,
                       .n_colliders = scene->n_colliders,
                       .stiffness = scene->contact_stiffness,
                       .friction = scene->contact_friction,
                       .damping = scene->contact_damping,
                       .cell_size = body->mesh->cell_size,
                       .body_size = body->size,
                       .body_weight = body->mass * lth_v3_norm(scene->gravity)};
  for (LitheIndex c = 0; c < body->mesh->n_cells; c++) {
    double lambda, mu;
    lth_lame(body->young[c], body->poisson[c], &lambda, &mu);
    def.modulus = fmax(def.modulus, lambda + 2 * mu);
  }
  return lth_contact_create(ctx, &def, &body->contact);
}

/// What touches colliders: the points of the embedded surface, or coarse nodes of the mesh.
#include "scene/body.h"

#include "base/tensor.h"

/// Boundary points of the mesh that lie on at least two grid planes, with their share of the boundary.
static LitheStatus collect_nodes(LitheCtx *ctx, const LthMesh *mesh, LitheIndex *n, double *points,
                                 LitheIndex *cells, double *area) {
  LitheStatus status = LITHE_OK;
  LitheIndex *node = NULL, *seen = NULL;
  double *loose = NULL; // area of a cell's boundary faces without nodes
  LTH_NEW_OR(done, ctx, node, mesh->n_points);
  LTH_NEW_OR(done, ctx, seen, mesh->n_cells);
  LTH_NEW_OR(done, ctx, loose, mesh->n_cells);
  *n = 0;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex cell = mesh->face_cell[2 * f];
    if (mesh->face_cell[2 * f + 1] >= 0) continue;
    LitheIndex begin = mesh->loop_off[mesh->face_loop_off[f]];
    LitheIndex end = mesh->loop_off[mesh->face_loop_off[f + 1]], n_nodes = 0;
    for (LitheIndex i = begin; i < end; i++) n_nodes += mesh->point_rank[mesh->loop_point[i]] >= 2;
    if (n_nodes == 0) loose[cell] += mesh->face_area[f];
    seen[cell] += n_nodes;
    for (LitheIndex i = begin; i < end; i++) {
      LitheIndex p = mesh->loop_point[i];
      if (mesh->point_rank[p] < 2) continue;
      if (node[p] == 0) {
        lth_v3_copy(mesh->points + 3 * (LitheCount)p, points + 3 * (LitheCount)*n);
        cells[*n] = cell;
        node[p] = ++*n;
      }
      area[node[p] - 1] += mesh->face_area[f] / n_nodes;
    }
  }
  // a fine surface has many faces without nodes: they go to the nodes of their cell
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex cell = mesh->face_cell[2 * f];
    if (mesh->face_cell[2 * f + 1] >= 0 || seen[cell] == 0) continue;
    for (LitheIndex i = mesh->loop_off[mesh->face_loop_off[f]];
         i < mesh->loop_off[mesh->face_loop_off[f + 1]]; i++)
      if (node[mesh->loop_point[i]] > 0)
        area[node[mesh->loop_point[i]] - 1] += loose[cell] / seen[cell];
  }

done:
  lth_free(ctx, node);
  lth_free(ctx, seen);
  lth_free(ctx, loose);
  return status;
}

static LitheStatus embed_nodes(LitheCtx *ctx, LthBody *body) {
  LitheStatus status = LITHE_OK;
  LitheIndex n = 0, *cells = NULL;
  double *points = NULL, *area = NULL;
  LTH_NEW_OR(done, ctx, cells, body->mesh->n_points);
  LTH_NEW_OR(done, ctx, points, 3 * (LitheCount)body->mesh->n_points);
  LTH_NEW_OR(done, ctx, area, body->mesh->n_points);
  LITHE_TRY_OR(done, collect_nodes(ctx, body->mesh, &n, points, cells, area));
  LITHE_TRY_OR(done, lth_embedding_create(ctx, body->space, n, points, cells, LTH_EMBED_MLS,
                                          LTH_SAMPLE_NODES, &body->nodes));
  body->nodes->area = area;
  area = NULL;

done:
  lth_free(ctx, cells);
  lth_free(ctx, points);
  lth_free(ctx, area);
  return status;
}

LitheStatus lth_build_contact(LitheCtx *ctx, LthBody *body) {
  const LthScene *scene = body->scene;
  if (scene->n_colliders == 0) return LITHE_OK;
  if (scene->contact_nodes || !body->embedding) LITHE_TRY(embed_nodes(ctx, body));
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

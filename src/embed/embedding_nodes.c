/// The coarse nodes of a mesh's boundary, embedded: contact points of a body without a surface, or with
/// one whose polygons are larger than its elements.
#include "base/tensor.h"
#include "embed/embedding.h"

#include <string.h>

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

/// Put the points of an embedded surface behind the nodes.
static void add_surface(const LthEmbedding *surface, LitheIndex *n, double *points,
                        LitheIndex *cells, double *area) {
  const size_t count = (size_t)surface->n_points;
  for (LitheIndex i = 0; i < *n; i++) area[i] *= 0.5;
  memcpy(points + 3 * (LitheCount)*n, surface->rest, 3 * count * sizeof *points);
  memcpy(cells + *n, surface->cell, count * sizeof *cells);
  for (LitheIndex i = 0; i < surface->n_points; i++) area[*n + i] = 0.5 * surface->area[i];
  *n += surface->n_points;
}

LitheStatus lth_embedding_create_nodes(LitheCtx *ctx, const LthDisc *disc, const LthDgSpace *space,
                                       const LthEmbedding *surface, LthEmbedding **embedding) {
  LitheStatus status = LITHE_OK;
  const LthMesh *mesh = disc->mesh;
  const LitheCount cap = mesh->n_points + (surface ? (LitheCount)surface->n_points : 0);
  LitheIndex n = 0, *cells = NULL;
  double *points = NULL, *area = NULL;
  *embedding = NULL;
  LTH_NEW_OR(done, ctx, cells, cap);
  LTH_NEW_OR(done, ctx, points, 3 * cap);
  LTH_NEW_OR(done, ctx, area, cap);
  LITHE_TRY_OR(done, collect_nodes(ctx, mesh, &n, points, cells, area));
  if (surface) add_surface(surface, &n, points, cells, area);
  status = space ? lth_embedding_create(ctx, space, n, points, cells, LTH_EMBED_MLS,
                                        LTH_SAMPLE_NODES, embedding)
                 : lth_embedding_create_direct(ctx, disc, n, points, cells, embedding);
  if (status != LITHE_OK) goto done;
  (*embedding)->area = area;
  area = NULL;
done:
  lth_free(ctx, cells);
  lth_free(ctx, points);
  lth_free(ctx, area);
  return status;
}

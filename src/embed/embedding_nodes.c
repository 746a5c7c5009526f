/// The coarse nodes of a mesh's boundary, embedded: contact points of a body without a surface, or with
/// one whose polygons are larger than its elements.
#include "base/tensor.h"
#include "embed/around.h"
#include "embed/embedding.h"

#include <string.h>

/// Contact points in the making. A point on a cut is one on each side of it.
typedef struct Nodes {
  const LthMesh *mesh;
  LthAround around;
  LitheIndex *number; ///< of each entry of `around`: contact point + 1, 0: none
  LitheIndex *seen;   ///< boundary corners of each cell that are nodes      (n_cells)
  double *loose;      ///< area of a cell's boundary faces without nodes     (n_cells)
  LitheIndex n;
  LitheIndex *cells;
  double *points, *area;
} Nodes;

/// Number of the node at a mesh point on the side of a cell: that of the first entry of its part.
static LitheIndex *find_node(const Nodes *w, LitheIndex point, LitheIndex cell) {
  const LthAround *at = &w->around;
  LitheIndex part = lth_around_part(at, point, cell);
  LitheCount i = at->off[point];
  while (at->part[i] != part) i++;
  return w->number + i;
}

static void take_face(Nodes *w, LitheIndex face, LitheIndex begin, LitheIndex end) {
  const LthMesh *mesh = w->mesh;
  LitheIndex cell = mesh->face_cell[2 * face], n_nodes = 0;
  for (LitheIndex i = begin; i < end; i++) n_nodes += mesh->point_rank[mesh->loop_point[i]] >= 2;
  if (n_nodes == 0) w->loose[cell] += mesh->face_area[face];
  w->seen[cell] += n_nodes;
  for (LitheIndex i = begin; i < end; i++) {
    LitheIndex p = mesh->loop_point[i];
    if (mesh->point_rank[p] < 2) continue;
    LitheIndex *node = find_node(w, p, cell);
    if (*node == 0) {
      lth_v3_copy(mesh->points + 3 * (LitheCount)p, w->points + 3 * (LitheCount)w->n);
      w->cells[w->n] = cell;
      *node = ++w->n;
    }
    w->area[*node - 1] += mesh->face_area[face] / n_nodes;
  }
}

/// A fine surface has many faces without nodes: they go to the nodes of their cell.
static void share_loose(Nodes *w, LitheIndex cell, LitheIndex begin, LitheIndex end) {
  for (LitheIndex i = begin; i < end; i++) {
    LitheIndex p = w->mesh->loop_point[i], node;
    if (w->mesh->point_rank[p] < 2) continue;
    node = *find_node(w, p, cell);
    w->area[node - 1] += w->loose[cell] / w->seen[cell];
  }
}

/// Boundary points of the mesh that lie on at least two grid planes, with their share of the boundary.
static LitheStatus collect_nodes(LitheCtx *ctx, Nodes *w) {
  const LthMesh *mesh = w->mesh;
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, lth_around_create(ctx, mesh, &w->around));
  LTH_NEW_OR(done, ctx, w->number, w->around.off[mesh->n_points]);
  LTH_NEW_OR(done, ctx, w->seen, mesh->n_cells);
  LTH_NEW_OR(done, ctx, w->loose, mesh->n_cells);
  for (int pass = 0; pass < 2; pass++)
    for (LitheIndex f = 0; f < mesh->n_faces; f++) {
      LitheIndex cell = mesh->face_cell[2 * f], begin = mesh->loop_off[mesh->face_loop_off[f]],
                 end = mesh->loop_off[mesh->face_loop_off[f + 1]];
      if (mesh->face_cell[2 * f + 1] >= 0) continue;
      if (pass == 0)
        take_face(w, f, begin, end);
      else if (w->seen[cell] > 0)
        share_loose(w, cell, begin, end);
    }
done:
  lth_around_free(ctx, &w->around);
  lth_free(ctx, w->number);
  lth_free(ctx, w->seen);
  lth_free(ctx, w->loose);
  return status;
}

/// Room: points of the boundary, as often as boundary faces have them.
static LitheCount count_corners(const LthMesh *mesh) {
  LitheCount n = 0;
  for (LitheIndex f = 0; f < mesh->n_faces; f++)
    if (mesh->face_cell[2 * f + 1] < 0)
      for (LitheIndex i = mesh->loop_off[mesh->face_loop_off[f]];
           i < mesh->loop_off[mesh->face_loop_off[f + 1]]; i++)
        n += mesh->point_rank[mesh->loop_point[i]] >= 2;
  return n;
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
  Nodes w = {.mesh = disc->mesh};
  const LitheCount cap = count_corners(disc->mesh) + (surface ? (LitheCount)surface->n_points : 0);
  *embedding = NULL;
  LTH_NEW_OR(done, ctx, w.cells, cap);
  LTH_NEW_OR(done, ctx, w.points, 3 * cap);
  LTH_NEW_OR(done, ctx, w.area, cap);
  LITHE_TRY_OR(done, collect_nodes(ctx, &w));
  if (surface) add_surface(surface, &w.n, w.points, w.cells, w.area);
  status = space ? lth_embedding_create(ctx, space, w.n, w.points, w.cells, LTH_EMBED_MLS,
                                        LTH_SAMPLE_NODES, embedding)
                 : lth_embedding_create_direct(ctx, disc, w.n, w.points, w.cells, embedding);
  if (status != LITHE_OK) goto done;
  (*embedding)->area = w.area;
  w.area = NULL;
done:
  lth_free(ctx, w.cells);
  lth_free(ctx, w.points);
  lth_free(ctx, w.area);
  return status;
}

/// Nodes that point forces act on, with the elements around them.
#include "mesh/node_selection.h"
#include "scene/change.h"

#include <stdlib.h>
#include <string.h>

/// A chosen node and a cell that touches it.
typedef struct NodeCell {
  LitheIndex node, cell;
} NodeCell;

typedef struct NodeCells {
  NodeCell *pair;
  LitheCount n, cap;
} NodeCells;

static int compare(const void *a, const void *b) {
  const NodeCell *p = a, *q = b;
  if (p->node != q->node) return p->node < q->node ? -1 : 1;
  return (p->cell > q->cell) - (p->cell < q->cell);
}

static LitheStatus add(LitheCtx *ctx, NodeCells *list, LitheIndex node, LitheIndex cell) {
  LTH_RESERVE(ctx, list->pair, list->cap, list->n + 1);
  list->pair[list->n++] = (NodeCell){node, cell};
  return LITHE_OK;
}

/// Corners of the cells' faces.
static LitheStatus pair_points(LitheCtx *ctx, const LthMesh *mesh, const uint8_t *chosen,
                               NodeCells *list) {
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex first = mesh->loop_off[mesh->face_loop_off[f]];
    LitheIndex end = mesh->loop_off[mesh->face_loop_off[f + 1]];
    for (LitheIndex k = first; k < end; k++)
      for (int s = 0; s < 2 && chosen[mesh->loop_point[k]]; s++)
        if (mesh->face_cell[2 * f + s] >= 0)
          LITHE_TRY(add(ctx, list, mesh->loop_point[k], mesh->face_cell[2 * f + s]));
  }
  return LITHE_OK;
}

/// Cell k of a mesh is element k.
static LitheStatus pair_elements(LitheCtx *ctx, const LthElementMesh *elements,
                                 const uint8_t *chosen, NodeCells *list) {
  for (LitheIndex e = 0; e < elements->n_elements; e++)
    for (LitheIndex k = elements->element_off[e]; k < elements->element_off[e + 1]; k++)
      if (chosen[elements->element_node[k]])
        LITHE_TRY(add(ctx, list, elements->element_node[k], e));
  return LITHE_OK;
}

/// Pairs in order and once each, as places with their cells.
static LitheStatus take(LitheCtx *ctx, const NodeCells *list, const double *nodes,
                        LthPlaces *places) {
  LTH_NEW(ctx, places->at, 3 * list->n);
  LTH_NEW(ctx, places->cell_off, list->n + 1);
  LTH_NEW(ctx, places->cell, list->n);
  LitheIndex n_cells = 0;
  for (LitheCount i = 0; i < list->n; i++) {
    const NodeCell *p = &list->pair[i];
    if (i > 0 && compare(p - 1, p) == 0) continue;
    if (i == 0 || p->node != p[-1].node) {
      memcpy(places->at + 3 * (LitheCount)places->n, nodes + 3 * (LitheCount)p->node,
             3 * sizeof *nodes);
      places->n++;
    }
    places->cell[n_cells++] = p->cell;
    places->cell_off[places->n] = n_cells;
  }
  return LITHE_OK;
}

static LitheStatus none_chosen(LitheCtx *ctx, const LthBody *body, const LthSceneLoad *load) {
  const double *box = body->box;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s.where: selects no node of the mesh; the body reaches from (%g, %g, %g) to (%g, "
             "%g, %g), and shapes, planes and labels select nodes",
             load->place, box[0], box[1], box[2], box[3], box[4], box[5]);
}

LitheStatus lth_build_places(LitheCtx *ctx, const LthBody *body, const LthSceneLoad *load,
                             LthPlaces **places) {
  // where cells are parts of elements, nodes are the corners of the cells
  const LthElementMesh *elements = body->cell_element ? NULL : body->elements;
  LitheIndex n = elements ? elements->n_nodes : body->mesh->n_points;
  LitheStatus status = LITHE_OK;
  uint8_t *chosen = NULL;
  NodeCells list = {0};
  LTH_NEW_OR(done, ctx, chosen, n);
  LITHE_TRY_OR(done, lth_select_nodes(ctx, body->mesh, elements, &load->where, chosen));
  LITHE_TRY_OR(done, elements ? pair_elements(ctx, elements, chosen, &list)
                              : pair_points(ctx, body->mesh, chosen, &list));
  if (list.n == 0) {
    bool is_loss;
    LITHE_TRY_OR(done, lth_body_lose(ctx, body, load->place, &is_loss));
    if (!is_loss) status = none_chosen(ctx, body, load);
    goto done;
  }
  qsort(list.pair, (size_t)list.n, sizeof *list.pair, compare);
  LTH_NEW_OR(done, ctx, *places, 1);
  status = take(ctx, &list, elements ? elements->nodes : body->mesh->points, *places);
done:
  lth_free(ctx, list.pair);
  lth_free(ctx, chosen);
  return status;
}

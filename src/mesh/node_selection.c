/// `where` asked of nodes, as sets of bytes: each part of the tree answers for all nodes at once.
#include "mesh/node_selection.h"

#include "base/tensor.h"

#include <math.h>
#include <string.h>

/// What the whole tree shares. An answer is 0, 1 (what only faces can say) or 2, as in where.c.
typedef struct NodeQuestion {
  LitheCtx *ctx;
  const LthElementMesh *elements; ///< or NULL
  const double *nodes;            ///< (n x 3)
  LitheIndex n;
  double tolerance; ///< [m]
} NodeQuestion;

enum { NO, UNKNOWN, YES };

bool lth_where_has_label(const LthWhere *where) {
  if (where->kind == LTH_WHERE_LABEL) return true;
  for (LitheIndex i = 0; i < where->n_children; i++)
    if (lth_where_has_label(&where->children[i])) return true;
  return false;
}

static void mark_element(const LthElementMesh *m, LitheIndex e, uint8_t *answer) {
  for (LitheIndex k = m->element_off[e]; k < m->element_off[e + 1]; k++)
    answer[m->element_node[k]] = YES;
}

/// Polyhedra list faces of their own; `member`: 8 * element + local face.
static void mark_face(const LthElementMesh *m, LitheIndex member, uint8_t *answer) {
  LitheIndex e = member / 8, local = member % 8;
  if (m->kind[e] == LTH_POLYHEDRON) {
    const LitheIndex *at = m->poly_face + m->poly_off[e] + 1;
    for (LitheIndex f = 0; f < local; f++) at += *at + 1;
    for (LitheIndex k = 0; k < at[0]; k++) answer[at[1 + k]] = YES;
    return;
  }
  const LthElementShape *shape = lth_element_shape((LthElementKind)m->kind[e]);
  for (int k = 0; k < shape->face[local].n_nodes; k++)
    answer[m->element_node[m->element_off[e] + shape->face[local].node[k]]] = YES;
}

static LitheStatus ask_label(const NodeQuestion *q, const char *label, uint8_t *answer) {
  static const LthGroupOf order[] = {LTH_GROUP_NODES, LTH_GROUP_FACES, LTH_GROUP_ELEMENTS};
  const LthElementGroup *group = NULL;
  for (int i = 0; i < 3 && !group && q->elements; i++)
    group = lth_element_group(q->elements, order[i], label);
  if (!group && q->elements && q->elements->n_groups > 0)
    LITHE_FAIL(q->ctx, LITHE_BAD_INPUT,
               "where: label %s: the mesh file has no set of this name; it has %s%s", label,
               q->elements->groups[0].name, q->elements->n_groups > 1 ? " and others" : "");
  if (!group)
    LITHE_FAIL(q->ctx, LITHE_BAD_INPUT,
               "where: label %s: this mesh has no labels; select by a shape or a plane instead",
               label);
  for (LitheIndex i = 0; i < group->n; i++) {
    if (group->of == LTH_GROUP_NODES)
      answer[group->member[i]] = YES;
    else if (group->of == LTH_GROUP_FACES)
      mark_face(q->elements, group->member[i], answer);
    else
      mark_element(q->elements, group->member[i], answer);
  }
  return LITHE_OK;
}

static bool is_in_half_space(const NodeQuestion *q, const LthWhere *w, const double x[3]) {
  double d[3];
  lth_v3_sub(x, w->point, d);
  return lth_v3_dot(d, w->normal) >= -q->tolerance;
}

static LitheStatus ask(const NodeQuestion *q, const LthWhere *w, uint8_t *answer);

static LitheStatus ask_children(const NodeQuestion *q, const LthWhere *w, uint8_t *answer) {
  LitheStatus status = LITHE_OK;
  uint8_t *child = NULL;
  bool all = w->kind == LTH_WHERE_AND;
  LTH_NEW_OR(done, q->ctx, child, q->n);
  memset(answer, all ? YES : NO, (size_t)q->n);
  for (LitheIndex i = 0; i < w->n_children; i++) {
    memset(child, NO, (size_t)q->n);
    LITHE_TRY_OR(done, ask(q, &w->children[i], child));
    for (LitheIndex k = 0; k < q->n; k++)
      if (all ? child[k] < answer[k] : child[k] > answer[k]) answer[k] = child[k];
  }
done:
  lth_free(q->ctx, child);
  return status;
}

/// `answer` comes in as NO everywhere.
static LitheStatus ask(const NodeQuestion *q, const LthWhere *w, uint8_t *answer) {
  switch (w->kind) {
  case LTH_WHERE_LABEL:
    return ask_label(q, w->label, answer);
  case LTH_WHERE_AND:
  case LTH_WHERE_OR:
    return ask_children(q, w, answer);
  case LTH_WHERE_NOT:
    LITHE_TRY(ask(q, &w->children[0], answer));
    for (LitheIndex k = 0; k < q->n; k++) answer[k] = (uint8_t)(YES - answer[k]);
    return LITHE_OK;
  case LTH_WHERE_NORMAL:
  case LTH_WHERE_FACE:
    memset(answer, UNKNOWN, (size_t)q->n);
    return LITHE_OK;
  case LTH_WHERE_ALL:
    memset(answer, YES, (size_t)q->n);
    return LITHE_OK;
  case LTH_WHERE_SHAPE:
  case LTH_WHERE_PLANE:
    for (LitheIndex k = 0; k < q->n; k++) {
      const double *x = q->nodes + 3 * (LitheCount)k;
      bool yes = w->kind == LTH_WHERE_PLANE ? is_in_half_space(q, w, x)
                                            : lth_shape_value(&w->shape, x) <= q->tolerance;
      answer[k] = yes ? YES : NO;
    }
    return LITHE_OK;
  }
  return LITHE_OK;
}

LitheStatus lth_select_nodes(LitheCtx *ctx, const LthMesh *mesh, const LthElementMesh *elements,
                             const LthWhere *where, uint8_t *chosen) {
  double min[3], max[3];
  lth_mesh_bounds(mesh, min, max);
  double size = fmax(fmax(max[0] - min[0], max[1] - min[1]), max[2] - min[2]);
  NodeQuestion q = {.ctx = ctx,
                    .elements = elements,
                    .nodes = elements ? elements->nodes : mesh->points,
                    .n = elements ? elements->n_nodes : mesh->n_points,
                    .tolerance = 1e-9 * size};
  memset(chosen, NO, (size_t)q.n);
  LITHE_TRY(ask(&q, where, chosen));
  for (LitheIndex k = 0; k < q.n; k++) chosen[k] = chosen[k] == YES;
  return LITHE_OK;
}

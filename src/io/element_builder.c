/// Nodes, elements and groups of a mesh file while it is read.
#include "io/element_builder.h"

#include <string.h>
#include <strings.h>

void lth_element_builder_free(LthElementBuilder *b) {
  for (LitheIndex g = 0; g < b->n_groups; g++) {
    lth_free(b->ctx, b->groups[g].name);
    lth_free(b->ctx, b->groups[g].member);
  }
  void *blocks[] = {b->x,        b->node_id, b->kind,     b->reduced, b->element_id,  b->line,
                    b->node_off, b->node,    b->poly_off, b->poly,    b->face_corner, b->groups};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(b->ctx, blocks[i]);
  *b = (LthElementBuilder){0};
}

LitheStatus lth_builder_node(LthElementBuilder *b, int64_t id, const double x[3]) {
  if (b->n_nodes >= INT32_MAX / 3)
    LITHE_FAIL(b->ctx, LITHE_UNSUPPORTED, "%s: it has more nodes than a mesh can hold", b->file);
  LTH_RESERVE(b->ctx, b->x, b->cap_x, 3 * ((LitheCount)b->n_nodes + 1));
  LTH_RESERVE(b->ctx, b->node_id, b->cap_id, b->n_nodes + 1);
  memcpy(b->x + 3 * (LitheCount)b->n_nodes, x, 3 * sizeof *x);
  b->node_id[b->n_nodes++] = id;
  return LITHE_OK;
}

/// Room for one more element with n_node nodes and n_poly numbers of faces; starts it.
static LitheStatus begin_element(LthElementBuilder *b, LthElementKind kind, bool reduced,
                                 int64_t id, LitheIndex line, LitheCount n_node,
                                 LitheCount n_poly) {
  LitheIndex e = b->n_elements;
  if (e >= INT32_MAX / 8 - 1 || b->n_node + n_node >= INT32_MAX || b->n_poly + n_poly >= INT32_MAX)
    LITHE_FAIL(b->ctx, LITHE_UNSUPPORTED, "%s: it has more elements than a mesh can hold", b->file);
  LTH_RESERVE(b->ctx, b->kind, b->cap_kind, e + 1);
  LTH_RESERVE(b->ctx, b->reduced, b->cap_reduced, e + 1);
  LTH_RESERVE(b->ctx, b->element_id, b->cap_element_id, e + 1);
  LTH_RESERVE(b->ctx, b->line, b->cap_line, e + 1);
  LTH_RESERVE(b->ctx, b->node_off, b->cap_off, e + 2);
  LTH_RESERVE(b->ctx, b->poly_off, b->cap_poly_off, e + 2);
  LTH_RESERVE(b->ctx, b->node, b->cap_node, b->n_node + n_node);
  LTH_RESERVE(b->ctx, b->poly, b->cap_poly, b->n_poly + n_poly);
  b->kind[e] = (uint8_t)kind;
  b->reduced[e] = reduced;
  b->element_id[e] = id;
  b->line[e] = line;
  return LITHE_OK;
}

static void end_element(LthElementBuilder *b) {
  b->n_elements++;
  b->node_off[b->n_elements] = b->n_node;
  b->poly_off[b->n_elements] = b->n_poly;
}

LitheStatus lth_builder_element(LthElementBuilder *b, LthElementKind kind, bool reduced, int64_t id,
                                LitheIndex line, const int64_t *node) {
  int n = lth_element_shape(kind)->n_nodes;
  LITHE_TRY(begin_element(b, kind, reduced, id, line, n, 0));
  memcpy(b->node + b->n_node, node, sizeof *node * (size_t)n);
  b->n_node += n;
  end_element(b);
  return LITHE_OK;
}

LitheStatus lth_builder_polyhedron(LthElementBuilder *b, int64_t id, LitheIndex line,
                                   const int64_t *faces, LitheCount n) {
  // its nodes are found from its faces when the numbers are resolved
  LITHE_TRY(begin_element(b, LTH_POLYHEDRON, false, id, line, 0, n));
  memcpy(b->poly + b->n_poly, faces, sizeof *faces * (size_t)n);
  b->n_poly += n;
  end_element(b);
  return LITHE_OK;
}

static bool has_name(const LthBuilderGroup *group, LthWord name, bool any_case) {
  return any_case ? lth_word_is_any_case(name, group->name) : lth_word_is(name, group->name);
}

LitheStatus lth_builder_group(LthElementBuilder *b, LthGroupOf of, LthWord name, LitheIndex tag,
                              bool any_case, LitheIndex *group) {
  for (LitheIndex g = 0; g < b->n_groups; g++)
    if (b->groups[g].of == of && b->groups[g].tag == tag &&
        has_name(&b->groups[g], name, any_case)) {
      *group = g;
      return LITHE_OK;
    }
  LTH_RESERVE(b->ctx, b->groups, b->cap_groups, b->n_groups + 1);
  LthBuilderGroup *made = &b->groups[b->n_groups];
  *made = (LthBuilderGroup){.tag = tag, .of = of};
  LTH_NEW(b->ctx, made->name, (LitheCount)name.length + 1);
  if (name.length > 0) memcpy(made->name, name.at, name.length);
  *group = b->n_groups++;
  return LITHE_OK;
}

static LitheStatus add_members(LthElementBuilder *b, LitheIndex group, LitheCount n,
                               const int64_t *value) {
  LthBuilderGroup *g = &b->groups[group];
  if (g->n + n >= INT32_MAX)
    LITHE_FAIL(b->ctx, LITHE_UNSUPPORTED, "%s: the set %s has more entries than a mesh can hold",
               b->file, g->name);
  LTH_RESERVE(b->ctx, g->member, g->cap, g->n + n);
  for (LitheCount i = 0; i < n; i++) g->member[g->n++] = value[i];
  return LITHE_OK;
}

LitheStatus lth_builder_member(LthElementBuilder *b, LitheIndex group, int64_t id) {
  return add_members(b, group, 1, &id);
}

LitheStatus lth_builder_face(LthElementBuilder *b, LitheIndex group, int64_t element, int face) {
  int64_t entry[3] = {0, element, face};
  return add_members(b, group, 3, entry);
}

LitheStatus lth_builder_face_of_corners(LthElementBuilder *b, LitheIndex group, int n,
                                        const int64_t *corner) {
  int64_t entry[3] = {1, b->n_face_corner, n};
  LTH_RESERVE(b->ctx, b->face_corner, b->cap_corner, b->n_face_corner + n);
  for (int i = 0; i < n; i++) b->face_corner[b->n_face_corner++] = corner[i];
  return add_members(b, group, 3, entry);
}

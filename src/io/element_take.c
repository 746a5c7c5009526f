/// From what a mesh file says to an LthElementMesh: numbers become indices, unused nodes go, groups are sorted.
#include "io/element_builder.h"

#include "base/order.h"
#include "base/tensor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// What lth_builder_take() works with.
typedef struct Take {
  LthElementBuilder *b;
  LthElementMesh *m;
  LthIdMap nodes, elements;
  LitheIndex *node_at; ///< index in the mesh of a node of the builder, -1  (b->n_nodes)
  LthElementSides *sides;
  LthHash side_of; ///< sides by their corners, where groups need them
} Take;

static LitheStatus map_nodes(Take *t) {
  LthElementBuilder *b = t->b;
  LitheIndex twice = -1;
  LITHE_TRY(lth_id_map_create(b->ctx, b->node_id, b->n_nodes, &t->nodes, &twice));
  if (twice >= 0 && !b->keeps_last)
    LITHE_FAIL(b->ctx, LITHE_BAD_INPUT, "%s: node %lld is there twice", b->file,
               (long long)b->node_id[twice]);
  return LITHE_OK;
}

static LitheStatus map_elements(Take *t) {
  LthElementBuilder *b = t->b;
  LitheIndex twice = -1;
  LITHE_TRY(lth_id_map_create(b->ctx, b->element_id, b->n_elements, &t->elements, &twice));
  if (twice < 0) return LITHE_OK;
  char line[24] = "";
  if (b->line[twice] > 0) snprintf(line, sizeof line, ":%d", b->line[twice]);
  LITHE_FAIL(b->ctx, LITHE_BAD_INPUT, "%s%s: element %lld is there twice", b->file, line,
             (long long)b->element_id[twice]);
}

/// The builder's index of the node that an element names; marks it as used.
static LitheStatus find_node(Take *t, LitheIndex element, int64_t id, LitheIndex *index) {
  char text[LTH_ELEMENT_TEXT_MAX];
  *index = lth_id_map_find(&t->nodes, id);
  if (*index < 0)
    LITHE_FAIL(t->b->ctx, LITHE_BAD_INPUT, "%s names node %lld, which the file does not have",
               lth_element_text(t->m, t->b->file, element, text), (long long)id);
  t->node_at[*index] = 1;
  return LITHE_OK;
}

/// Faces of polyhedron e into the mesh, still as the builder's indices; its distinct nodes are appended.
static LitheStatus take_polyhedron(Take *t, LitheIndex e, LitheCount *n_node, LitheCount *cap,
                                   LitheIndex *seen) {
  LthElementBuilder *b = t->b;
  LthElementMesh *m = t->m;
  LitheCount k = b->poly_off[e];
  LitheIndex *to = m->poly_face + k;
  *to++ = (LitheIndex)b->poly[k++];
  while (k < b->poly_off[e + 1]) {
    LitheIndex n = (LitheIndex)b->poly[k++];
    *to++ = n;
    for (LitheIndex i = 0; i < n; i++, to++) {
      LITHE_TRY(find_node(t, e, b->poly[k++], to));
      if (seen[*to] == e + 1) continue;
      seen[*to] = e + 1;
      LTH_RESERVE(b->ctx, m->element_node, *cap, *n_node + 1);
      m->element_node[(*n_node)++] = *to;
    }
  }
  return LITHE_OK;
}

static LitheStatus take_elements(Take *t, LitheIndex *seen) {
  LthElementBuilder *b = t->b;
  LthElementMesh *m = t->m;
  LitheCount n_node = 0, cap = 0;
  if (b->n_poly > 0) {
    LTH_NEW(b->ctx, m->poly_face, b->n_poly);
    LTH_NEW(b->ctx, m->poly_off, (LitheCount)b->n_elements + 1);
  }
  LTH_NEW(b->ctx, m->element_off, (LitheCount)b->n_elements + 1);
  LTH_RESERVE(b->ctx, m->element_node, cap, b->n_node + 1);
  for (LitheIndex e = 0; e < b->n_elements; e++) {
    LTH_RESERVE(b->ctx, m->element_node, cap, n_node + LTH_ELEMENT_MAX_NODES);
    for (LitheCount k = b->node_off[e]; k < b->node_off[e + 1]; k++)
      LITHE_TRY(find_node(t, e, b->node[k], &m->element_node[n_node++]));
    if (m->kind[e] == LTH_POLYHEDRON) LITHE_TRY(take_polyhedron(t, e, &n_node, &cap, seen));
    if (n_node >= INT32_MAX)
      LITHE_FAIL(b->ctx, LITHE_UNSUPPORTED, "%s: it has more elements than a mesh can hold",
                 b->file);
    m->element_off[e + 1] = (LitheIndex)n_node;
    if (m->poly_off) m->poly_off[e + 1] = (LitheIndex)b->poly_off[e + 1];
  }
  return LITHE_OK;
}

/// Used nodes in the order of the file.
static LitheStatus take_nodes(Take *t, double unit_scale) {
  LthElementBuilder *b = t->b;
  LthElementMesh *m = t->m;
  for (LitheIndex i = 0; i < b->n_nodes; i++) t->node_at[i] = t->node_at[i] ? m->n_nodes++ : -1;
  LTH_NEW(b->ctx, m->nodes, 3 * (LitheCount)m->n_nodes);
  LTH_NEW(b->ctx, m->node_id, m->n_nodes);
  for (LitheIndex i = 0; i < b->n_nodes; i++) {
    if (t->node_at[i] < 0) continue;
    m->node_id[t->node_at[i]] = b->node_id[i];
    for (int a = 0; a < 3; a++)
      m->nodes[3 * (LitheCount)t->node_at[i] + a] = unit_scale * b->x[3 * (LitheCount)i + a];
  }
  m->rounding = unit_scale * b->rounding;
  return LITHE_OK;
}

static void renumber(Take *t) {
  LthElementMesh *m = t->m;
  for (LitheIndex k = 0; k < m->element_off[m->n_elements]; k++)
    m->element_node[k] = t->node_at[m->element_node[k]];
  for (LitheIndex e = 0; m->poly_face && e < m->n_elements; e++) {
    if (m->kind[e] != LTH_POLYHEDRON) continue;
    LitheIndex *at = m->poly_face + m->poly_off[e];
    for (LitheIndex f = *at++; f > 0; f--) {
      LitheIndex n = *at++;
      for (LitheIndex i = 0; i < n; i++, at++) *at = t->node_at[*at];
    }
  }
}

/// Volume that the corners of a face and the place o span, times six.
static double cone(const LthElementMesh *m, const double o[3], const LitheIndex *v, LitheIndex n) {
  double a[3], b[3], c[3], cross[3], sum = 0;
  lth_v3_sub(m->nodes + 3 * (LitheCount)v[0], o, a);
  for (LitheIndex i = 1; i + 1 < n; i++) {
    lth_v3_sub(m->nodes + 3 * (LitheCount)v[i], o, b);
    lth_v3_sub(m->nodes + 3 * (LitheCount)v[i + 1], o, c);
    lth_v3_cross(b, c, cross);
    sum += lth_v3_dot(a, cross);
  }
  return sum;
}

/// Turn all faces of a polyhedron outward.
static LitheStatus turn_polyhedron(LitheCtx *ctx, LthElementMesh *m, LitheIndex e) {
  LitheIndex *faces = m->poly_face + m->poly_off[e], *at = faces + 1;
  const double *o = m->nodes + 3 * (LitheCount)m->element_node[m->element_off[e]];
  double volume = 0;
  LITHE_TRY(lth_polyhedron_orient(ctx, faces));
  for (LitheIndex f = 0; f < faces[0]; f++, at += 1 + *at) volume += cone(m, o, at + 1, *at);
  if (!(volume < 0)) return LITHE_OK;
  at = faces + 1;
  for (LitheIndex f = 0; f < faces[0]; f++, at += 1 + *at)
    for (LitheIndex i = 0, j = *at - 1; i < j; i++, j--) {
      LitheIndex swap = at[1 + i];
      at[1 + i] = at[1 + j];
      at[1 + j] = swap;
    }
  return LITHE_OK;
}

/// Wedges whose first triangle turns the other way round: both triangles, and with them all edges, are reversed.
static void mirror_wedge(LthElementMesh *m, LitheIndex e) {
  static const int8_t order[18] = {0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13, 17, 16, 15};
  LitheIndex *v = m->element_node + m->element_off[e], old[18];
  int n = lth_element_shape(m->kind[e])->n_nodes;
  double base[3], a[3], b[3], up[3];
  const double *o = m->nodes + 3 * (LitheCount)v[0];
  lth_v3_sub(m->nodes + 3 * (LitheCount)v[1], o, a);
  lth_v3_sub(m->nodes + 3 * (LitheCount)v[2], o, b);
  lth_v3_cross(a, b, base);
  lth_v3_sub(m->nodes + 3 * (LitheCount)v[3], o, up);
  if (!(lth_v3_dot(base, up) < 0)) return;
  memcpy(old, v, sizeof *v * (size_t)n);
  for (int i = 0; i < n; i++) v[i] = old[order[i]];
}

static LitheStatus turn_elements(Take *t) {
  LthElementMesh *m = t->m;
  for (LitheIndex e = 0; e < m->n_elements; e++) {
    bool is_wedge = m->kind[e] >= LTH_WEDGE6 && m->kind[e] <= LTH_WEDGE18;
    if (is_wedge && t->b->may_mirror) mirror_wedge(m, e);
    if (m->kind[e] == LTH_POLYHEDRON) LITHE_TRY(turn_polyhedron(t->b->ctx, m, e));
  }
  return LITHE_OK;
}

/// Ownership of the arrays that need no change moves to the mesh.
static void move_arrays(Take *t) {
  LthElementBuilder *b = t->b;
  LthElementMesh *m = t->m;
  bool has_lines = false, has_reduced = false;
  for (LitheIndex e = 0; e < b->n_elements; e++) {
    has_lines = has_lines || b->line[e] > 0;
    has_reduced = has_reduced || b->reduced[e];
  }
  m->n_elements = b->n_elements;
  m->kind = b->kind;
  b->kind = NULL;
  m->element_id = b->element_id;
  b->element_id = NULL;
  if (has_lines) m->line = b->line, b->line = NULL;
  if (has_reduced) m->reduced = b->reduced, b->reduced = NULL;
}

/// Sides of all elements by their corners, made once.
static LitheStatus need_sides(Take *t, bool by_corners) {
  LitheCtx *ctx = t->b->ctx;
  if (!t->sides) LITHE_TRY(lth_element_sides_list(ctx, t->m, &t->sides));
  if (!by_corners || t->side_of.n > 0) return LITHE_OK;
  const LthElementSides *s = t->sides;
  LITHE_TRY(lth_hash_reserve(ctx, &t->side_of, s->n));
  for (LitheIndex f = 0; f < s->n; f++) {
    LitheIndex n = s->corner_off[f + 1] - s->corner_off[f], kept = 0;
    uint64_t key[2];
    if (n == 0) continue;
    lth_corner_key(s->corner + s->corner_off[f], n, key);
    LITHE_TRY(lth_hash_insert(ctx, &t->side_of, key[0], key[1], f, &kept));
  }
  return LITHE_OK;
}

static LitheStatus find_corners(Take *t, const int64_t entry[3], LitheIndex *member) {
  LitheIndex corner[4], n = (LitheIndex)entry[2];
  uint64_t key[2];
  LITHE_TRY(need_sides(t, true));
  for (LitheIndex i = 0; i < n; i++) {
    LitheIndex at = lth_id_map_find(&t->nodes, t->b->face_corner[entry[1] + i]);
    corner[i] = at < 0 ? -1 : t->node_at[at];
    if (corner[i] < 0) return LITHE_OK;
  }
  lth_corner_key(corner, n, key);
  LitheIndex side = lth_hash_find(&t->side_of, key[0], key[1]);
  if (side < 0) return LITHE_OK;
  LitheIndex e = t->sides->element[side];
  if (side - t->sides->element_side[e] < 8) *member = 8 * e + (side - t->sides->element_side[e]);
  return LITHE_OK;
}

/// Index of a member in the mesh; -1 where the file has no such thing, -2 where nothing uses it.
static LitheStatus find_member(Take *t, const LthBuilderGroup *from, LitheCount k,
                               LitheIndex *member) {
  LitheIndex at;
  *member = -1;
  switch (from->of) {
  case LTH_GROUP_ELEMENTS:
    *member = lth_id_map_find(&t->elements, from->member[k]);
    return LITHE_OK;
  case LTH_GROUP_NODES:
    at = lth_id_map_find(&t->nodes, from->member[k]);
    *member = at < 0 ? -1 : t->node_at[at] < 0 ? -2 : t->node_at[at];
    return LITHE_OK;
  case LTH_GROUP_FACES:
    if (from->member[k] == 1) return find_corners(t, from->member + k, member);
    at = lth_id_map_find(&t->elements, from->member[k + 1]);
    if (at < 0 || from->member[k + 2] >= lth_element_shape(t->m->kind[at])->n_faces)
      return LITHE_OK;
    *member = 8 * at + (LitheIndex)from->member[k + 2];
    return LITHE_OK;
  }
  return LITHE_OK;
}

static LitheStatus take_group(Take *t, LthBuilderGroup *from) {
  LthElementMesh *m = t->m;
  LthElementGroup *g = &m->groups[m->n_groups++];
  int step = from->of == LTH_GROUP_FACES ? 3 : 1;
  LitheCount n_missing = 0;
  *g = (LthElementGroup){.name = from->name, .tag = from->tag, .of = from->of};
  from->name = NULL;
  LTH_NEW(t->b->ctx, g->member, from->n / step);
  for (LitheCount k = 0; k < from->n; k += step) {
    LitheIndex member = -1;
    LITHE_TRY(find_member(t, from, k, &member));
    if (member >= 0) g->member[g->n++] = member;
    n_missing += member == -1;
  }
  g->n = lth_sort_unique(g->member, g->n);
  static const char *const what[] = {"elements", "nodes", "faces of elements"};
  if (n_missing > 0)
    lth_warn(t->b->ctx,
             "%s: the set %s names %lld %s that the file's solid does not have; left out",
             t->b->file, g->name, (long long)n_missing, what[g->of]);
  return LITHE_OK;
}

static LitheStatus take_all(Take *t, LitheIndex *seen, double unit_scale) {
  LthElementBuilder *b = t->b;
  LTH_NEW(b->ctx, t->node_at, b->n_nodes);
  LITHE_TRY(map_nodes(t));
  LITHE_TRY(map_elements(t));
  move_arrays(t);
  LITHE_TRY(take_elements(t, seen));
  LITHE_TRY(take_nodes(t, unit_scale));
  renumber(t);
  LITHE_TRY(turn_elements(t));
  LITHE_TRY(lth_element_mesh_check(b->ctx, t->m, b->file));
  LTH_NEW(b->ctx, t->m->groups, b->n_groups);
  for (LitheIndex g = 0; g < b->n_groups; g++) LITHE_TRY(take_group(t, &b->groups[g]));
  return LITHE_OK;
}

LitheStatus lth_builder_take(LthElementBuilder *b, double unit_scale, LthElementMesh **mesh) {
  LitheStatus status = LITHE_OK;
  Take t = {.b = b};
  LitheIndex *seen = NULL;
  *mesh = NULL;
  LTH_NEW_OR(done, b->ctx, t.m, 1);
  LTH_NEW_OR(done, b->ctx, seen, b->n_nodes);
  LITHE_TRY_OR(done, take_all(&t, seen, unit_scale));
  *mesh = t.m;
  t.m = NULL;
done:
  lth_element_mesh_destroy(b->ctx, &t.m);
  lth_element_sides_destroy(b->ctx, &t.sides);
  lth_hash_free(b->ctx, &t.side_of);
  lth_id_map_free(b->ctx, &t.nodes);
  lth_id_map_free(b->ctx, &t.elements);
  lth_free(b->ctx, t.node_at);
  lth_free(b->ctx, seen);
  return status;
}

/// Element types of Gmsh: their nodes in VTK's order, and what their physical groups are here.
#include "io/msh_reader.h"

#include <stdio.h>
#include <string.h>

static const LthMshType types[] = {{1, 1, 2, 2, 0},
                                   {2, 2, 3, 3, 0},
                                   {3, 2, 4, 4, 0},
                                   {4, 3, 4, 4, LTH_TET4},
                                   {5, 3, 8, 8, LTH_HEX8},
                                   {6, 3, 6, 6, LTH_WEDGE6},
                                   {7, 3, 5, 5, LTH_PYRAMID5},
                                   {8, 1, 3, 2, 0},
                                   {9, 2, 6, 3, 0},
                                   {10, 2, 9, 4, 0},
                                   {11, 3, 10, 4, LTH_TET10},
                                   {12, 3, 27, 8, LTH_HEX27},
                                   {13, 3, 18, 6, LTH_WEDGE18},
                                   {14, 3, 14, 5, LTH_PYRAMID14},
                                   {15, 0, 1, 1, 0},
                                   {16, 2, 8, 4, 0},
                                   {17, 3, 20, 8, LTH_HEX20},
                                   {18, 3, 15, 6, LTH_WEDGE15},
                                   {19, 3, 13, 5, LTH_PYRAMID13}};

const LthMshType *lth_msh_type(LitheIndex number) {
  for (size_t i = 0; i < sizeof types / sizeof types[0]; i++)
    if (types[i].number == number) return &types[i];
  return NULL;
}

/// Where node i of VTK's order stands in Gmsh's, which runs through the edges by their lower corners.
static const int8_t tet_order[10] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
static const int8_t hex_order[27] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18,
                                     19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26};
static const int8_t wedge_order[18] = {0,  1,  2,  3, 4,  5,  6,  9,  7,
                                       12, 14, 13, 8, 10, 11, 15, 17, 16};
static const int8_t pyramid_order[14] = {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12, 13};

static const int8_t *order_of(int n_corners) {
  switch (n_corners) {
  case 4:
    return tet_order;
  case 5:
    return pyramid_order;
  case 6:
    return wedge_order;
  default:
    return hex_order;
  }
}

/// The group of a dimension and physical number; without a name it is called by its number.
static LitheStatus find_group(LthMshReader *r, int dimension, LitheIndex tag, LitheIndex *group) {
  static const LthGroupOf of[4] = {LTH_GROUP_NODES, LTH_GROUP_NODES, LTH_GROUP_FACES,
                                   LTH_GROUP_ELEMENTS};
  char number[16];
  LitheIndex name = lth_hash_find(&r->name_of, lth_hash_pair(dimension, tag), 0);
  snprintf(number, sizeof number, "%d", tag);
  LthWord word = name < 0 ? (LthWord){number, strlen(number)} : r->names[name];
  return lth_builder_group(r->b, of[dimension], word, tag, false, group);
}

static LitheStatus add_to_group(LthMshReader *r, const LthMshType *type, LitheIndex group,
                                int64_t id, const int64_t *node) {
  if (type->dimension == 3) return lth_builder_member(r->b, group, id);
  if (type->dimension == 2) return lth_builder_face_of_corners(r->b, group, type->n_corners, node);
  for (int i = 0; i < type->n_nodes; i++) LITHE_TRY(lth_builder_member(r->b, group, node[i]));
  return LITHE_OK;
}

/// Version 2 writes an element once for each of its groups: the number of the first of them, if any.
static LitheStatus find_repeated(LthMshReader *r, const LthMshType *type, const int64_t *node,
                                 int64_t *id, bool *is_repeated) {
  LthElementBuilder *b = r->b;
  uint64_t key[2] = {(uint64_t)type->number, 0};
  LitheIndex e = 0;
  for (int i = 0; i < type->n_nodes; i++) {
    key[0] = (key[0] ^ (uint64_t)node[i]) * 0x9E3779B97F4A7C15u;
    key[0] ^= key[0] >> 31;
    key[1] = (key[1] + (uint64_t)node[i]) * 0xD6E8FEB86659FD93u;
    key[1] ^= key[1] >> 29;
  }
  LITHE_TRY(lth_hash_insert(b->ctx, &r->volume_of, key[0], key[1], b->n_elements, &e));
  *is_repeated = e < b->n_elements && b->kind[e] == type->kind;
  for (int i = 0; *is_repeated && i < type->n_nodes; i++)
    *is_repeated = b->node[b->node_off[e] + i] == node[i];
  if (*is_repeated) *id = b->element_id[e];
  return LITHE_OK;
}

LitheStatus lth_msh_element(LthMshReader *r, const LthMshType *type, int64_t id, LitheIndex line,
                            const int64_t *node, LitheIndex n_groups, const LitheIndex *groups) {
  int64_t ordered[LTH_ELEMENT_MAX_NODES];
  bool is_repeated = false;
  if (type->dimension == 3) {
    const int8_t *order = order_of(type->n_corners);
    for (int i = 0; i < type->n_nodes; i++) ordered[i] = node[order[i]];
    if (r->version == 2 && n_groups > 0)
      LITHE_TRY(find_repeated(r, type, ordered, &id, &is_repeated));
    if (!is_repeated) LITHE_TRY(lth_builder_element(r->b, type->kind, false, id, line, ordered));
  }
  for (LitheIndex g = 0; g < n_groups; g++) {
    LitheIndex group = 0;
    LITHE_TRY(find_group(r, type->dimension, groups[g], &group));
    LITHE_TRY(add_to_group(r, type, group, id, node));
  }
  return LITHE_OK;
}

/// Selections: `where` of constraints, loads and materials.
#include "scene/reader.h"

#include "base/tensor.h"

#define DEGREE 0.017453292519943295769

static const LthPlacement in_place = {.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};

static LitheStatus read_children(LthReader *r, const LthNode *first, LitheIndex n,
                                 LthWhere *where) {
  LTH_NEW(r->ctx, where->children, n);
  for (const LthNode *child = first; child && where->n_children < n; child = child->next)
    LITHE_TRY(lth_read_where(r, child, &where->children[where->n_children++]));
  return LITHE_OK;
}

static void read_face(const LthNode *face, LthWhere *where) {
  where->kind = LTH_WHERE_FACE;
  lth_read_vector(face, "at", where->point);
  where->angle = lth_read_number(face, "angle", 20 * DEGREE);
}

static void check_within(LthReader *r, const LthNode *node) {
  LthNode *within = lth_node_find(node, "within");
  if (within && !lth_node_find(node, "normal"))
    lth_report_key(r->report, within,
                   "it goes with normal, got no normal; expected {normal, within}");
}

LitheStatus lth_read_where(LthReader *r, const LthNode *node, LthWhere *where) {
  *where = (LthWhere){.kind = LTH_WHERE_ALL};
  if (!node || node->bad || node->kind != LTH_NODE_MAP) return LITHE_OK;
  check_within(r, node);
  const LthNode *value = NULL;
  if ((value = lth_node_get(node, "plane"))) {
    where->kind = LTH_WHERE_PLANE;
    lth_read_vector(value, "point", where->point);
    lth_read_direction(r, value, "normal", where->normal);
  } else if (lth_node_get(node, "normal")) {
    where->kind = LTH_WHERE_NORMAL;
    lth_read_direction(r, node, "normal", where->normal);
    where->angle = lth_read_number(node, "within", 30 * DEGREE);
  } else if ((value = lth_node_get(node, "face"))) {
    read_face(value, where);
  } else if ((value = lth_node_get(node, "not"))) {
    where->kind = LTH_WHERE_NOT;
    LTH_NEW(r->ctx, where->children, 1);
    where->n_children = 1;
    return lth_read_where(r, value, &where->children[0]);
  } else if ((value = lth_node_get(node, "and"))) {
    where->kind = LTH_WHERE_AND;
    return read_children(r, value->first, value->n_children, where);
  } else if ((value = lth_node_get(node, "or"))) {
    where->kind = LTH_WHERE_OR;
    return read_children(r, value->first, value->n_children, where);
  } else if ((value = lth_node_get(node, "label"))) {
    if (r->image) return lth_read_image_label(r, value, where);
    if (r->image_is_missing) return LITHE_OK;
    where->kind = LTH_WHERE_LABEL;
    lth_check_label(r, value);
    return lth_copy_text(r->ctx, value->text, &where->label);
  } else {
    where->kind = LTH_WHERE_SHAPE;
    return lth_read_shape(r, node, &in_place, NULL, true, &where->shape);
  }
  return LITHE_OK;
}

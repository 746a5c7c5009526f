/// Numbers, vectors, words and placements out of checked nodes.
#include "scene/reader.h"

#include "base/tensor.h"

#include <string.h>

double lth_read_number(const LthNode *map, const char *key, double otherwise) {
  const LthNode *node = lth_node_get(map, key);
  return node && node->has_value && !node->value.eval ? node->value.constant : otherwise;
}

LitheIndex lth_read_integer(const LthNode *map, const char *key, LitheIndex otherwise) {
  return (LitheIndex)lth_read_number(map, key, otherwise);
}

LthValue lth_read_value(const LthNode *map, const char *key) {
  const LthNode *node = lth_node_get(map, key);
  return node && node->has_value ? node->value : (LthValue){0};
}

bool lth_read_flag(const LthNode *map, const char *key) {
  return lth_node_is_text(lth_node_get(map, key), "true");
}

const char *lth_read_text(const LthNode *map, const char *key) {
  const LthNode *node = lth_node_get(map, key);
  return node && node->kind == LTH_NODE_SCALAR && !lth_node_is_null(node) ? node->text : NULL;
}

static bool read_list(const LthNode *list, int n, LthValue *v) {
  memset(v, 0, (size_t)n * sizeof *v);
  if (!list || list->kind != LTH_NODE_LIST || list->n_children != n) return false;
  bool is_whole = true;
  for (const LthNode *item = list->first; item; item = item->next, v++) {
    if (item->has_value && !item->bad)
      *v = item->value;
    else
      is_whole = is_whole && lth_node_is_null(item);
  }
  return is_whole;
}

bool lth_read_values(const LthNode *map, const char *key, LthValue v[3]) {
  return read_list(lth_node_get(map, key), 3, v);
}

bool lth_read_vector(const LthNode *map, const char *key, double v[3]) {
  LthValue values[3];
  bool is_there = lth_read_values(map, key, values);
  for (int i = 0; i < 3; i++) v[i] = values[i].constant;
  return is_there;
}

bool lth_read_tensor(const LthNode *map, const char *key, LthValue v[9]) {
  const LthNode *rows = lth_node_get(map, key);
  memset(v, 0, 9 * sizeof *v);
  if (!rows || rows->n_children != 3) return false;
  bool is_whole = true;
  for (const LthNode *row = rows->first; row; row = row->next, v += 3)
    is_whole = read_list(row, 3, v) && is_whole;
  return is_whole;
}

bool lth_read_direction(LthReader *r, const LthNode *map, const char *key, double v[3]) {
  if (!lth_read_vector(map, key, v)) return false;
  // scaled first: squares of tiny and of huge entries leave the range of numbers
  double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
  if (largest > 0) {
    for (int i = 0; i < 3; i++) v[i] /= largest;
    lth_v3_normalize(v);
    return true;
  }
  lth_report(
      r->report, lth_node_find(map, key),
      r->scene->dimension == 2
          ? "a direction without length, got [0, 0]; expected two numbers that are not both 0"
          : "a direction without length, got [0, 0, 0]; expected three numbers that are not all 0");
  return false;
}

int lth_read_word(const LthNode *map, const char *key, const char *const *words) {
  const LthNode *node = lth_node_get(map, key);
  for (int i = 0; words[i]; i++)
    if (lth_node_is_text(node, words[i])) return i;
  return 0;
}

void *lth_read_array(LthReader *r, const LthNode *list, size_t size) {
  return lth_arena_take(r->arena, size * (size_t)(list ? list->n_children + 1 : 1));
}

void lth_read_placement(LthReader *r, const LthNode *place, LthPlacement *placement) {
  *placement = (LthPlacement){0};
  lth_m3_identity(placement->rotation);
  lth_read_vector(place, "translate", placement->translation);
  const LthNode *rotate = lth_node_get(place, "rotate");
  if (!rotate) return;
  bool is_plane = r->scene->dimension == 2, is_map = rotate->kind == LTH_NODE_MAP;
  double axis[3] = {0, 0, 1};
  double angle = lth_read_number(is_map ? rotate : place, is_map ? "angle" : "rotate", 0);
  if (!is_map && !is_plane)
    lth_report(r->report, rotate, "a rotation in space has an axis, got %s; expected {axis, angle}",
               lth_show(r->arena, rotate));
  if (is_map && !is_plane && !lth_read_direction(r, rotate, "axis", axis)) return;
  if (angle == 0) return;
  placement->rotates = true;
  lth_m3_rotation(axis, angle, placement->rotation);
}

void lth_place_point(const LthPlacement *p, const double x[3], double placed[3]) {
  // without a rotation coordinates stay exact
  double turned[3] = {x[0], x[1], x[2]};
  if (p->rotates) lth_m3_apply(p->rotation, x, turned);
  lth_v3_add(turned, p->translation, placed);
}

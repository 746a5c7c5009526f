/// Mesh files of a body: `method: {mesh: {file: part.msh}}` and the groups that `where: {label: name}` names.
#include "scene/reader.h"

#include "io/mesh_file.h"

#include <math.h>
#include <string.h>

/// The box of the nodes, which the shape's would be otherwise.
static void measure(const LthElementMesh *m, double box[6]) {
  for (int a = 0; a < 3; a++) box[a] = INFINITY, box[3 + a] = -INFINITY;
  for (LitheIndex i = 0; i < m->n_nodes; i++)
    for (int a = 0; a < 3; a++) {
      double x = m->nodes[3 * (LitheCount)i + a];
      box[a] = fmin(box[a], x);
      box[3 + a] = fmax(box[3 + a], x);
    }
}

/// x_scene = R (unit x) + t; the file was read with its unit.
static void place_nodes(LthElementMesh *m, const LthPlacement *place) {
  for (LitheIndex i = 0; i < m->n_nodes; i++) {
    double *x = m->nodes + 3 * (LitheCount)i, old[3] = {x[0], x[1], x[2]};
    lth_place_point(place, old, x);
  }
}

LitheStatus lth_read_elements(LthReader *r, const LthNode *node, const LthPlacement *place,
                              LthSceneBody *body) {
  const LthNode *file = lth_node_get(node, "file");
  const char *path = NULL;
  double unit = lth_read_unit(r, node);
  if (!file || !r->opens_files) return LITHE_OK;
  LITHE_TRY(lth_find_file(r, file, &path));
  if (!path) return LITHE_OK;
  LitheStatus status = lth_mesh_file_read(r->ctx, path, unit, &body->elements);
  if (status == LITHE_BAD_INPUT || status == LITHE_UNSUPPORTED) {
    lth_report(r->report, file, "%s", lithe_ctx_message(r->ctx));
    return LITHE_OK;
  }
  if (status != LITHE_OK) return status;
  place_nodes(body->elements, place);
  measure(body->elements, body->elements_box);
  body->elements_file = path;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) body->file_to_scene[4 * i + j] = unit * place->rotation[3 * i + j];
  return LITHE_OK;
}

bool lth_method_has_file(const LthNode *method) {
  const LthNode *mesh = lth_node_find(method, "mesh");
  return mesh && mesh->kind == LTH_NODE_MAP;
}

/// Names of the groups of a mesh, at most so many.
#define NAMES_MAX 40

/// Whether a label names a group of any sort, or spells its number.
static bool is_known(const LthElementMesh *m, const char *label) {
  for (int of = LTH_GROUP_ELEMENTS; of <= LTH_GROUP_FACES; of++)
    if (lth_element_group(m, (LthGroupOf)of, label)) return true;
  return false;
}

void lth_check_label(LthReader *r, const LthNode *label) {
  const LthElementMesh *m = r->elements;
  const char *names[NAMES_MAX], *list = NULL;
  int n = 0;
  if (r->labels == LTH_LABELS_UNKNOWN) return;
  if (r->labels == LTH_LABELS_NONE || !m || m->n_groups == 0) {
    lth_report(r->report, label,
               "a group of a mesh file, and this body has none, got %s; expected a shape, plane, "
               "normal or face",
               lth_show(r->arena, label));
    return;
  }
  if (is_known(m, label->text)) return;
  for (LitheIndex g = 0; g < m->n_groups && n < NAMES_MAX; g++) {
    bool is_listed = false;
    for (int i = 0; i < n; i++) is_listed = is_listed || strcmp(names[i], m->groups[g].name) == 0;
    if (is_listed) continue;
    names[n++] = m->groups[g].name;
    list = list ? lth_arena_print(r->arena, "%s, %s", list, m->groups[g].name) : m->groups[g].name;
  }
  const char *nearest = lth_nearest_word(label->text, names, n);
  lth_report(r->report, label, "no group of the mesh file, got %s; expected one of %s%s%s%s",
             lth_show(r->arena, label), list ? list : "", nearest ? ", did you mean " : "",
             nearest ? nearest : "", nearest ? "?" : "");
}

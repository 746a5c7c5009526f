/// Elements of mesh files: freeing and finding groups.
#include "mesh/element_mesh.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

void lth_element_mesh_destroy(LitheCtx *ctx, LthElementMesh **mesh) {
  if (!mesh || !*mesh) return;
  LthElementMesh *m = *mesh;
  for (LitheIndex g = 0; m->groups && g < m->n_groups; g++) {
    lth_free(ctx, m->groups[g].name);
    lth_free(ctx, m->groups[g].member);
  }
  void *blocks[] = {m->nodes,       m->node_id,      m->kind,       m->reduced,
                    m->element_off, m->element_node, m->element_id, m->line,
                    m->poly_off,    m->poly_face,    m->groups,     m};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  *mesh = NULL;
}

static bool spells(LitheIndex tag, const char *name) {
  char text[16];
  snprintf(text, sizeof text, "%d", tag);
  return tag >= 0 && strcmp(text, name) == 0;
}

/// How well a group answers to a name: 3 exactly, 2 but for upper and lower case, 1 by its number, 0 not.
static int match_of(const LthElementGroup *group, const char *name) {
  if (strcmp(group->name, name) == 0) return 3;
  if (strcasecmp(group->name, name) == 0) return 2;
  return spells(group->tag, name) ? 1 : 0;
}

const LthElementGroup *lth_element_group(const LthElementMesh *mesh, LthGroupOf of,
                                         const char *name) {
  const LthElementGroup *best = NULL;
  int best_match = 0;
  for (LitheIndex g = 0; g < mesh->n_groups; g++) {
    int found = mesh->groups[g].of == of ? match_of(&mesh->groups[g], name) : 0;
    if (found > best_match) best = &mesh->groups[g], best_match = found;
  }
  return best;
}

const char *lth_element_text(const LthElementMesh *mesh, const char *file, LitheIndex element,
                             char text[LTH_ELEMENT_TEXT_MAX]) {
  char line[16] = "";
  long long id = mesh->element_id ? (long long)mesh->element_id[element] : element;
  if (mesh->line && mesh->line[element] > 0)
    snprintf(line, sizeof line, ":%d", mesh->line[element]);
  snprintf(text, LTH_ELEMENT_TEXT_MAX, "%.160s%s: element %lld (%s)", file, line, id,
           lth_element_shape(mesh->kind[element])->name);
  return text;
}

/// Elements of mesh files: freeing and finding groups.
#include "mesh/element_mesh.h"

#include <stdio.h>
#include <string.h>

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

const LthElementGroup *lth_element_group(const LthElementMesh *mesh, LthGroupOf of,
                                         const char *name) {
  for (LitheIndex g = 0; g < mesh->n_groups; g++)
    if (mesh->groups[g].of == of && strcmp(mesh->groups[g].name, name) == 0)
      return &mesh->groups[g];
  for (LitheIndex g = 0; g < mesh->n_groups; g++)
    if (mesh->groups[g].of == of && spells(mesh->groups[g].tag, name)) return &mesh->groups[g];
  return NULL;
}

/// Groups of a mesh by their names: what `where: {label: name}` selects.
#include "mesh/where.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

/// How well a group answers to a label: 3 exactly, 2 but for upper and lower case, 1 by its number, 0 not.
static int match_of(const LthMeshGroup *group, const char *label) {
  char number[16];
  if (strcmp(group->name, label) == 0) return 3;
  if (strcasecmp(group->name, label) == 0) return 2;
  snprintf(number, sizeof number, "%d", group->tag);
  return group->tag >= 0 && strcmp(number, label) == 0 ? 1 : 0;
}

/// The first of the groups that answer best; NULL.
static const LthMeshGroup *find(const LthMesh *mesh, bool of_cells, const char *label) {
  const LthMeshGroup *best = NULL;
  int best_match = 0;
  for (LitheIndex g = 0; g < mesh->n_groups; g++) {
    int found = mesh->groups[g].of_cells == of_cells ? match_of(&mesh->groups[g], label) : 0;
    if (found > best_match) best = &mesh->groups[g], best_match = found;
  }
  return best;
}

/// Names of all groups, as far as they fit.
static const char *list_groups(const LthMesh *mesh, char *text, size_t room) {
  size_t n = 0;
  text[0] = 0;
  for (LitheIndex g = 0; g < mesh->n_groups; g++) {
    const char *name = mesh->groups[g].name;
    if (n + strlen(name) + 8 > room) {
      snprintf(text + n, room - n, " ...");
      break;
    }
    n += (size_t)snprintf(text + n, room - n, "%s%s", g ? ", " : "", name);
  }
  return text;
}

static LitheStatus mark(LitheCtx *ctx, const LthMeshGroup *group, LitheIndex n, uint8_t **member) {
  if (!group) return LITHE_OK;
  LTH_NEW(ctx, *member, n);
  for (LitheIndex i = 0; i < group->n; i++) (*member)[group->member[i]] = 1;
  return LITHE_OK;
}

LitheStatus lth_mesh_label(LitheCtx *ctx, const LthMesh *mesh, const char *label,
                           LthFacePatch *patch) {
  const LthMeshGroup *faces = find(mesh, false, label), *cells = find(mesh, true, label);
  char list[512];
  if (!faces && !cells && mesh->n_groups == 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "where.label: %s is to be a group of the mesh, and this mesh has none; select by a "
               "shape, plane, normal or face",
               label);
  if (!faces && !cells)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "where.label: the mesh has no group %s; it has %s", label,
               list_groups(mesh, list, sizeof list));
  LITHE_TRY(mark(ctx, faces, mesh->n_faces, &patch->member));
  return mark(ctx, cells, mesh->n_cells, &patch->cell);
}

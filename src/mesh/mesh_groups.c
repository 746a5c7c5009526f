/// Named sets of a mesh file as sets of cells and boundary faces.
#include "mesh/mesh_from_elements.h"

#include <string.h>

/// Groups of faces stand before those of nodes and elements, so that a name finds the boundary first.
static const LthGroupOf order[] = {LTH_GROUP_FACES, LTH_GROUP_NODES, LTH_GROUP_ELEMENTS};

static LitheStatus copy_cells(LitheCtx *ctx, const LthElementGroup *group, LthMeshGroup *made) {
  LTH_NEW(ctx, made->member, group->n);
  if (group->n > 0) memcpy(made->member, group->member, sizeof *made->member * (size_t)group->n);
  made->n = group->n;
  made->of_cells = true;
  return LITHE_OK;
}

static bool has_all_corners(const LthElementSides *s, LitheIndex side, const uint8_t *is_in) {
  for (LitheIndex i = s->corner_off[side]; i < s->corner_off[side + 1]; i++)
    if (!is_in[s->corner[i]]) return false;
  return true;
}

/// Boundary faces whose side is in the group, or all of whose corners are. `is_in`: zeroed bytes, one for
/// each side or node.
static LitheStatus collect_faces(LitheCtx *ctx, const LthElementsAsMesh *w, const LthMesh *mesh,
                                 const LthElementGroup *group, uint8_t *is_in, LthMeshGroup *made) {
  const LthElementSides *s = w->sides;
  LitheCount cap = 0;
  for (LitheIndex i = 0; i < group->n; i++) {
    LitheIndex k = group->member[i];
    is_in[group->of == LTH_GROUP_NODES ? k : s->element_side[k / 8] + k % 8] = 1;
  }
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LitheIndex side = w->face_side[f];
    if (mesh->face_cell[2 * f + 1] >= 0) continue;
    if (!(group->of == LTH_GROUP_NODES ? has_all_corners(s, side, is_in) : is_in[side])) continue;
    LTH_RESERVE(ctx, made->member, cap, made->n + 1);
    made->member[made->n++] = f;
  }
  return LITHE_OK;
}

static LitheStatus make_group(LitheCtx *ctx, const LthElementsAsMesh *w, LthMesh *mesh,
                              const LthElementGroup *group) {
  LthMeshGroup *made = &mesh->groups[mesh->n_groups++];
  made->tag = group->tag;
  LITHE_TRY(lth_copy_text(ctx, group->name, &made->name));
  if (group->of == LTH_GROUP_ELEMENTS) return copy_cells(ctx, group, made);
  uint8_t *is_in = NULL;
  LTH_NEW(ctx, is_in, group->of == LTH_GROUP_NODES ? w->elements->n_nodes : w->sides->n);
  LitheStatus status = collect_faces(ctx, w, mesh, group, is_in, made);
  lth_free(ctx, is_in);
  return status;
}

LitheStatus lth_mesh_groups_from_elements(LitheCtx *ctx, const LthElementsAsMesh *w,
                                          LthMesh *mesh) {
  const LthElementMesh *m = w->elements;
  LTH_NEW(ctx, mesh->groups, m->n_groups);
  for (int k = 0; k < 3; k++)
    for (LitheIndex g = 0; g < m->n_groups; g++)
      if (m->groups[g].of == order[k]) LITHE_TRY(make_group(ctx, w, mesh, &m->groups[g]));
  return LITHE_OK;
}

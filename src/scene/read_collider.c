/// Colliders and how they move.
#include "scene/reader.h"

#include "base/tensor.h"

static const LthPlacement in_place = {.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};

static LitheStatus read_plane(LthReader *r, const LthNode *node, LthCollider *collider) {
  collider->kind = LTH_COLLIDER_PLANE;
  lth_read_vector(node, "point", collider->point);
  lth_read_direction(r, node, "normal", collider->normal);
  return LITHE_OK;
}

static LitheStatus read_mesh(LthReader *r, const LthNode *node, LthCollider *collider,
                             LthSurface **kept) {
  LthPlacement place;
  LthMeshFile mesh;
  collider->kind = LTH_COLLIDER_MESH;
  collider->shape = (LthShape){.kind = LTH_SHAPE_SPHERE, .radius = 1};
  lth_read_placement(r, lth_node_get(node, "place"), &place);
  LITHE_TRY(lth_read_mesh(r, node, &place, true, &mesh));
  *kept = mesh.surface;
  if (!mesh.surface) return LITHE_OK;
  collider->shape = (LthShape){.kind = LTH_SHAPE_MESH, .soup = mesh.soup, .surface = mesh.surface};
  return lth_shape_prepare(r->ctx, &collider->shape);
}

static LitheStatus read_collider(LthReader *r, const LthNode *node, LthCollider *collider,
                                 LthSurface **surface) {
  static const struct {
    const char *key;
    LthColliderKind kind;
  } shapes[] = {{"sphere", LTH_COLLIDER_SPHERE},
                {"disk", LTH_COLLIDER_SPHERE}, // z is 0 in plane scenes
                {"box", LTH_COLLIDER_BOX},
                {"capsule", LTH_COLLIDER_CAPSULE}};
  const LthNode *plane = lth_node_get(node, "plane"), *mesh = lth_node_get(node, "mesh"),
                *value = NULL;
  if (plane) {
    LITHE_TRY(read_plane(r, plane, collider));
    return lth_read_motion(r, lth_node_get(plane, "motion"), collider);
  }
  if (mesh) {
    LITHE_TRY(read_mesh(r, mesh, collider, surface));
    return lth_read_motion(r, lth_node_get(mesh, "motion"), collider);
  }
  for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
    if (!(value = lth_node_get(node, shapes[i].key))) continue;
    collider->kind = shapes[i].kind;
    LITHE_TRY(lth_read_shape(r, node, &in_place, NULL, false, &collider->shape));
    return lth_read_motion(r, lth_node_get(value, "motion"), collider);
  }
  return LITHE_OK;
}

LitheStatus lth_read_colliders(LthReader *r) {
  LthScene *scene = r->scene;
  const LthNode *list = lth_node_get(r->root, "colliders");
  scene->colliders = lth_read_array(r, list, sizeof *scene->colliders);
  scene->collider_surfaces = lth_read_array(r, list, sizeof(LthSurface *));
  if (!scene->colliders || !scene->collider_surfaces)
    LITHE_FAIL(r->ctx, LITHE_NO_MEMORY, "out of memory while reading the scene");
  for (const LthNode *node = list ? list->first : NULL; node; node = node->next) {
    LitheIndex i = scene->n_colliders++;
    LITHE_TRY(read_collider(r, node, &scene->colliders[i], &scene->collider_surfaces[i]));
  }
  return LITHE_OK;
}

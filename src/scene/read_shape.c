/// Shapes of a scene, placed: primitives, surface files and their combinations.
#include "scene/reader.h"

#include "base/tensor.h"

#include <math.h>
#include <string.h>

static LitheStatus read_tree(LthReader *r, const LthNode *node, const LthPlacement *place,
                             LthShape *shape);

/// A turned box has no axes: it goes on as its twelve triangles.
static LitheStatus turn_box(LthReader *r, const LthPlacement *place, LthShape *shape) {
  LthSurface *surface = NULL;
  LITHE_TRY(lth_shape_tessellate(r->ctx, shape, 0, &surface));
  LITHE_TRY(lth_own_surface(r, surface));
  for (LitheIndex p = 0; p < surface->n_points; p++) {
    double *x = surface->points + 3 * (size_t)p, old[3] = {x[0], x[1], x[2]};
    lth_place_point(place, old, x);
  }
  *shape = (LthShape){.kind = LTH_SHAPE_MESH, .surface = surface};
  return LITHE_OK;
}

static LitheStatus read_box(LthReader *r, const LthNode *node, const LthPlacement *place,
                            LthShape *shape) {
  shape->kind = LTH_SHAPE_BOX;
  double min[3], max[3];
  if (!lth_read_vector(node, "min", min) || !lth_read_vector(node, "max", max)) return LITHE_OK;
  for (int i = 0; i < r->scene->dimension; i++) {
    if (min[i] < max[i]) continue;
    lth_report(r->report, lth_node_find(node, "max"),
               "an empty box, got %g..%g along %c; expected max > min", min[i], max[i], "xyz"[i]);
    return LITHE_OK;
  }
  if (r->scene->dimension == 2) return lth_read_plane_box(r, min, max, place, shape);
  if (place->rotates) {
    lth_v3_copy(min, shape->a), lth_v3_copy(max, shape->b);
    return turn_box(r, place, shape);
  }
  lth_place_point(place, min, shape->a);
  lth_place_point(place, max, shape->b);
  return LITHE_OK;
}

static void read_ball(LthReader *r, const LthNode *node, const LthPlacement *place,
                      LthShape *shape) {
  bool is_shell = shape->kind == LTH_SHAPE_SHELL;
  double center[3];
  lth_read_vector(node, "center", center);
  lth_place_point(place, center, shape->a);
  shape->radius = lth_read_number(node, is_shell ? "outer" : "radius", 1);
  shape->inner = is_shell ? lth_read_number(node, "inner", 0) : 0;
  if (shape->inner >= shape->radius && lth_node_get(node, "outer"))
    lth_report(r->report, lth_node_find(node, "inner"),
               "not inside the outer radius, got %g and %g; expected "
               "inner < outer",
               shape->inner, shape->radius);
}

static void read_rod(LthReader *r, const LthNode *node, const LthPlacement *place,
                     LthShape *shape) {
  double from[3], to[3];
  bool is_whole = lth_read_vector(node, "from", from);
  is_whole = lth_read_vector(node, "to", to) && is_whole;
  lth_place_point(place, from, shape->a);
  lth_place_point(place, to, shape->b);
  shape->radius = lth_read_number(node, "radius", 1);
  if (is_whole && lth_v3_distance(from, to) == 0)
    lth_report(r->report, lth_node_find(node, "to"),
               "an axis without length, got from and to at one place; "
               "expected two places");
}

static LitheStatus read_mesh_shape(LthReader *r, const LthNode *node, const LthPlacement *place,
                                   LthShape *shape) {
  LthMeshFile mesh;
  shape->kind = LTH_SHAPE_MESH;
  LITHE_TRY(lth_read_mesh(r, node, place, true, &mesh));
  shape->soup = mesh.soup;
  shape->surface = mesh.surface;
  memcpy(r->mesh_to_scene, mesh.to_scene, sizeof mesh.to_scene);
  if (mesh.wrap) {
    shape->kind = LTH_SHAPE_WRAP;
    shape->wrap = mesh.wrap;
    shape->resolution = mesh.resolution;
  } else if (
      !mesh.surface) // a stand-in, so that the rest of a scene with a bad file can be checked
    *shape = (LthShape){.kind = LTH_SHAPE_SPHERE, .radius = 1};
  return LITHE_OK;
}

static LitheStatus read_children(LthReader *r, const LthNode *list, const LthPlacement *place,
                                 LthShape *shape) {
  if (list->kind != LTH_NODE_LIST) return LITHE_OK;
  LTH_NEW(r->ctx, shape->children, list->n_children);
  for (const LthNode *child = list->first; child; child = child->next) {
    const LthNode *resolution = lth_node_find(child, "resolution");
    if (!resolution) resolution = lth_node_find(lth_node_find(child, "mesh"), "resolution");
    if (resolution)
      lth_report_key(
          r->report, resolution,
          "it belongs to the whole shape, got it in a part; expected it beside the outermost "
          "union, intersection or difference");
    LITHE_TRY(read_tree(r, child, place, &shape->children[shape->n_children++]));
  }
  return LITHE_OK;
}

static LitheStatus read_kind(LthReader *r, LthShapeKind kind, const LthNode *node,
                             const LthPlacement *place, LthShape *shape) {
  shape->kind = kind;
  switch (kind) {
  case LTH_SHAPE_BOX:
    return read_box(r, node, place, shape);
  case LTH_SHAPE_SPHERE:
  case LTH_SHAPE_SHELL:
    read_ball(r, node, place, shape);
    return LITHE_OK;
  case LTH_SHAPE_CYLINDER:
  case LTH_SHAPE_CAPSULE:
    read_rod(r, node, place, shape);
    return LITHE_OK;
  case LTH_SHAPE_MESH:
    return read_mesh_shape(r, node, place, shape);
  case LTH_SHAPE_IMPLICIT:
    return lth_read_implicit(r, node, place, shape);
  case LTH_SHAPE_IMAGE:
    return lth_read_image(r, node, place, shape);
  case LTH_SHAPE_DISK:
  case LTH_SHAPE_ANNULUS:
    lth_read_disk(r, node, place, shape);
    return LITHE_OK;
  case LTH_SHAPE_POLYGON:
    return lth_read_polygon(r, node, place, shape);
  default:
    return read_children(r, node, place, shape);
  }
}

static LitheStatus read_tree(LthReader *r, const LthNode *node, const LthPlacement *place,
                             LthShape *shape) {
  static const struct {
    const char *key;
    LthShapeKind kind;
  } kinds[] = {{"box", LTH_SHAPE_BOX},
               {"sphere", LTH_SHAPE_SPHERE},
               {"cylinder", LTH_SHAPE_CYLINDER},
               {"capsule", LTH_SHAPE_CAPSULE},
               {"shell", LTH_SHAPE_SHELL},
               {"mesh", LTH_SHAPE_MESH},
               {"implicit", LTH_SHAPE_IMPLICIT},
               {"union", LTH_SHAPE_UNION},
               {"intersection", LTH_SHAPE_INTERSECTION},
               {"difference", LTH_SHAPE_DIFFERENCE},
               {"image", LTH_SHAPE_IMAGE},
               {"disk", LTH_SHAPE_DISK},
               {"annulus", LTH_SHAPE_ANNULUS},
               {"polygon", LTH_SHAPE_POLYGON}};
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
    const LthNode *value = lth_node_get(node, kinds[k].key);
    if (value) return read_kind(r, kinds[k].kind, value, place, shape);
  }
  *shape = (LthShape){.kind = LTH_SHAPE_SPHERE, .radius = 1}; // reported before
  return LITHE_OK;
}

LitheStatus lth_read_shape(LthReader *r, const LthNode *node, const LthPlacement *place,
                           const double *search, bool may_be_unbounded, LthShape *shape) {
  *shape = (LthShape){.kind = LTH_SHAPE_SPHERE, .radius = 1};
  if (!node) return LITHE_OK;
  LITHE_TRY(read_tree(r, node, place, shape));
  if (!may_be_unbounded) lth_bound_shape(r, node, shape, search);
  return lth_shape_prepare(r->ctx, shape);
}

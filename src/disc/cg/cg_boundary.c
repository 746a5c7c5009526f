/// Integrals over pieces of the boundary: on the elements' own curved faces where a piece is a whole face, on
/// the planar piece where a cut divides it or elements reach beyond the body.
#include "disc/cg/cg_priv.h"

/// Local corner of an element at a place, -1.
static int find_corner(const LthCgDisc *d, LitheIndex e, const double x[3], double tolerance) {
  const LitheIndex *node = lth_cg_nodes(d, e);
  for (int i = 0; i < lth_cg_kind(d, e)->shape->n_corners; i++)
    if (lth_v3_distance(x, lth_cg_node(d, node[i])) <= tolerance) return i;
  return -1;
}

static bool face_has(const LthElementShape *shape, int face, int corner) {
  for (int k = 0; k < shape->face[face].n_corners; k++)
    if (shape->face[face].node[k] == corner) return true;
  return false;
}

/// The element's face that has all corners of a mesh face.
static LthCgFace match_face(const LthCgDisc *d, LitheIndex f) {
  const LthMesh *mesh = d->disc.mesh;
  LthFaceView view = lth_mesh_face(mesh, f);
  LitheIndex e = lth_cg_element(d, mesh->face_cell[2 * f]);
  LitheIndex n = view.loop_off[view.n_loops] - view.loop_off[0];
  const LthElementShape *shape = lth_cg_kind(d, e)->shape;
  LthCgFace found = {0};
  if (n != 3 && n != 4) return found;
  double tolerance = 1e-9 * sqrt(mesh->face_area[f]);
  for (LitheIndex k = 0; k < n; k++) {
    LitheIndex point = view.loop_point[view.loop_off[0] + k];
    int corner = find_corner(d, e, mesh->points + 3 * (LitheCount)point, tolerance);
    if (corner < 0) return found;
    found.corner[k] = (int8_t)corner;
  }
  for (int face = 0; face < shape->n_faces; face++) {
    LitheIndex has = 0;
    for (LitheIndex k = 0; k < n; k++) has += face_has(shape, face, found.corner[k]);
    if (has < n) continue;
    found.face = (int8_t)face;
    found.n_corners = (int8_t)n;
    break;
  }
  return found;
}

LitheStatus lth_cg_build_faces(LitheCtx *ctx, LthCgDisc *d) {
  const LthMesh *mesh = d->disc.mesh;
  double min[3], max[3];
  lth_mesh_bounds(mesh, min, max);
  d->extent = lth_v3_distance(min, max);
  LTH_NEW(ctx, d->face, mesh->n_faces);
  if (d->cell_element) return LITHE_OK; // cells fill a part of their elements only
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheIndex f = 0; f < mesh->n_faces; f++)
    if (mesh->face_cell[2 * f + 1] < 0) d->face[f] = match_face(d, f);
  return LITHE_OK;
}

bool lth_cg_patch_is_whole(const LthCgDisc *d, const LthPatches *patches, LitheIndex i) {
  LitheIndex f = patches->face[i];
  double whole = d->disc.mesh->face_area[f];
  return d->face[f].n_corners > 0 && fabs(patches->area[i] - whole) <= 1e-9 * whole;
}

/// Points on the curved face of the element.
static void visit_whole(const LthCgDisc *d, LthCgPoint *point,
                        void (*visit)(void *self, const LthCgPoint *point), void *self,
                        const LthCgFace *face) {
  const LthCgKind *kind = lth_cg_kind(d, point->element);
  LthCgFaceRule rule;
  lth_cg_face_rule(kind, face->n_corners, face->corner,
                   &d->plane[kind->shape->degree - 1][face->n_corners - 3], &rule);
  for (int q = 0; q < rule.n; q++) {
    double J[9], a[3], b[3];
    lth_cg_map(d, point->element, rule.xi[q], point->at, J, point->phi, point->dphi);
    lth_m3_apply(J, rule.a[q], a);
    lth_m3_apply(J, rule.b[q], b);
    lth_v3_cross(a, b, point->normal);
    point->weight = rule.weight[q] * lth_v3_normalize(point->normal);
    lth_cg_space_gradients(kind->n, J, point->dphi);
    visit(self, point);
  }
}

/// Rule for a triangle of a planar piece: full where its edges u, v compare with the element's size, fewer points on
/// the fine surface of a body that its elements reach beyond.
static const LthCgPlaneRule *triangle_rule(const LthCgDisc *d, LitheIndex e, const double u[3],
                                           const double v[3]) {
  double size = cbrt(d->classes[d->class_of[e]].volume_exact);
  double edge = fmax(lth_v3_norm(u), lth_v3_norm(v));
  if (d->cell_element && edge < 0.5 * size) return &d->small[edge < 0.125 * size ? 0 : 1];
  return &d->plane[lth_cg_kind(d, e)->shape->degree - 1][0];
}

/// Points on one signed triangle of a planar piece.
static void visit_triangle(const LthCgDisc *d, LthCgPoint *point,
                           void (*visit)(void *self, const LthCgPoint *point), void *self,
                           const LthFaceView *view, const LitheIndex corner[3]) {
  const double *origin = view->points + 3 * (LitheCount)corner[0];
  double u[3], v[3], w[3];
  lth_v3_sub(view->points + 3 * (LitheCount)corner[1], origin, u);
  lth_v3_sub(view->points + 3 * (LitheCount)corner[2], origin, v);
  lth_v3_cross(u, v, w);
  double area = lth_v3_dot(w, view->normal);
  if (area == 0) return;
  const LthCgPlaneRule *rule = triangle_rule(d, point->element, u, v);
  for (int q = 0; q < rule->n; q++) {
    lth_v3_copy(origin, point->at);
    lth_v3_axpy(rule->at[q][0], u, point->at);
    lth_v3_axpy(rule->at[q][1], v, point->at);
    lth_v3_copy(view->normal, point->normal);
    point->weight = rule->weight[q] * area;
    lth_cg_eval_local(d, point->element, point->at, point->phi, point->dphi);
    visit(self, point);
  }
}

void lth_cg_visit_patch(const LthCgDisc *d, const LthPatches *patches, LitheIndex i,
                        void (*visit)(void *self, const LthCgPoint *point), void *self) {
  LitheIndex f = patches->face[i], corner[3];
  LthCgPoint point = {.cell = d->disc.mesh->face_cell[2 * f], .patch = i};
  point.element = lth_cg_element(d, point.cell);
  if (lth_cg_patch_is_whole(d, patches, i)) {
    visit_whole(d, &point, visit, self, &d->face[f]);
    return;
  }
  LthFaceView view = lth_patches_view(d->disc.mesh, patches, i);
  for (LthFan fan = lth_fan(&view); lth_fan_next(&fan, corner);)
    visit_triangle(d, &point, visit, self, &view, corner);
}

/// Nodes of a whole face: those of the element's face, or of half of one what lies on its own corners and sides.
static void mark_whole(const LthCgDisc *d, LitheIndex e, const LthCgFace *face, uint8_t *node) {
  const LthCgKind *kind = lth_cg_kind(d, e);
  int n_nodes = kind->shape->face[face->face].n_nodes;
  for (int k = 0; k < n_nodes; k++) {
    int local = kind->shape->face[face->face].node[k];
    bool belongs = face->n_corners == kind->shape->face[face->face].n_corners;
    for (int c = 0; c < face->n_corners && !belongs; c++) {
      const double *p = kind->node[face->corner[c]],
                   *q = kind->node[face->corner[(c + 1) % face->n_corners]];
      double r[3] = {0};
      lth_v3_axpy(0.5, p, r);
      lth_v3_axpy(0.5, q, r);
      belongs = local == face->corner[c] || lth_v3_distance(r, kind->node[local]) < 1e-12;
    }
    if (belongs) node[lth_cg_nodes(d, e)[local]] = 1;
  }
}

/// Nodes of the element that lie in a planar piece.
static void mark_inside(const LthCgDisc *d, LitheIndex e, const LthFaceView *view, uint8_t *node) {
  double tolerance = 1e-9 * d->extent;
  for (int i = 0; i < lth_cg_kind(d, e)->n; i++) {
    LitheIndex index = lth_cg_nodes(d, e)[i];
    if (lth_face_distance2(view, lth_cg_node(d, index)) <= tolerance * tolerance) node[index] = 1;
  }
}

void lth_cg_patch_nodes(const LthDisc *disc, const LthPatches *patches, LitheIndex i,
                        uint8_t *node) {
  const LthCgDisc *d = lth_cg_of(disc);
  LitheIndex f = patches->face[i], e = lth_cg_element(d, disc->mesh->face_cell[2 * f]);
  LthFaceView view = lth_patches_view(disc->mesh, patches, i);
  if (d->cell_element)
    for (int k = 0; k < lth_cg_kind(d, e)->n; k++) node[lth_cg_nodes(d, e)[k]] = 1;
  else if (lth_cg_patch_is_whole(d, patches, i))
    mark_whole(d, e, &d->face[f], node);
  else
    mark_inside(d, e, &view, node);
}

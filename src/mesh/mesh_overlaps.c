/// Boundary faces of two elements that lie on each other: what an interface that is not conforming looks like.
#include "mesh/mesh_from_elements.h"

#include "base/tensor.h"
#include "geometry/bvh.h"

/// Two faces lie on each other where the centroid of the smaller is this share of its size from the other...
#define TOUCHING 1e-6
/// ... and their normals are opposite but for this.
#define OPPOSITE 1e-6

typedef struct Search {
  const LthMesh *mesh;
  const LitheIndex *face; ///< boundary faces behind the items of the tree
  LitheIndex own, found;
} Search;

static bool lies_on(const LthMesh *m, LitheIndex f, LitheIndex other) {
  double size = sqrt(m->face_area[f]);
  LthFaceView view = lth_mesh_face(m, other);
  if (lth_v3_dot(m->face_normal + 3 * (LitheCount)f, m->face_normal + 3 * (LitheCount)other) >
      -1 + OPPOSITE)
    return false;
  return lth_face_distance2(&view, m->face_centroid + 3 * (LitheCount)f) <=
         TOUCHING * TOUCHING * size * size;
}

static bool visit(void *self, LitheIndex item) {
  Search *s = self;
  LitheIndex other = s->face[item];
  bool is_smaller = s->mesh->face_area[s->own] <= s->mesh->face_area[other];
  if (other != s->own && is_smaller && lies_on(s->mesh, s->own, other)) s->found = other;
  return s->found < 0;
}

/// Boxes of the boundary faces, and their numbers.
static LitheStatus list_boundary(LitheCtx *ctx, const LthMesh *m, LitheIndex **face, double **box,
                                 LitheIndex *n) {
  *n = 0;
  LTH_NEW(ctx, *face, m->n_faces);
  for (LitheIndex f = 0; f < m->n_faces; f++)
    if (m->face_cell[2 * f + 1] < 0) (*face)[(*n)++] = f;
  LTH_NEW(ctx, *box, 6 * (LitheCount)*n);
  for (LitheIndex k = 0; k < *n; k++) {
    LitheIndex f = (*face)[k];
    double *b = *box + 6 * (LitheCount)k;
    for (int a = 0; a < 3; a++) b[a] = INFINITY, b[3 + a] = -INFINITY;
    for (LitheIndex i = m->loop_off[m->face_loop_off[f]]; i < m->loop_off[m->face_loop_off[f + 1]];
         i++)
      for (int a = 0; a < 3; a++) {
        double x = m->points[3 * (LitheCount)m->loop_point[i] + a];
        b[a] = fmin(b[a], x);
        b[3 + a] = fmax(b[3 + a], x);
      }
  }
  return LITHE_OK;
}

LitheStatus lth_mesh_warn_overlaps(LitheCtx *ctx, const LthElementsAsMesh *w, const LthMesh *mesh) {
  LitheStatus status = LITHE_OK;
  LthBvh *bvh = NULL;
  LitheIndex *face = NULL, n = 0, count = 0, pair[2] = {0, 0};
  double *box = NULL;
  LITHE_TRY_OR(done, list_boundary(ctx, mesh, &face, &box, &n));
  LITHE_TRY_OR(done, lth_bvh_create_boxes(ctx, n, box, &bvh));
  for (LitheIndex k = 0; k < n; k++) {
    Search s = {.mesh = mesh, .face = face, .own = face[k], .found = -1};
    double reach = TOUCHING * sqrt(mesh->face_area[s.own]);
    lth_bvh_visit(bvh, mesh->face_centroid + 3 * (LitheCount)s.own, reach, visit, &s);
    if (s.found < 0) continue;
    if (count++ == 0) pair[0] = mesh->face_cell[2 * s.own], pair[1] = mesh->face_cell[2 * s.found];
  }
  if (count > 0) {
    char a[LTH_ELEMENT_TEXT_MAX], b[LTH_ELEMENT_TEXT_MAX];
    const double *x = mesh->cell_centroid + 3 * (LitheCount)pair[0];
    lth_warn(
        ctx,
        "%s and %s near (%g, %g, %g) touch without sharing the corners of a face, as %d faces in "
        "all do: they are not joined there",
        lth_element_text(w->elements, w->file, pair[0], a),
        lth_element_text(w->elements, w->file, pair[1], b), x[0], x[1], x[2], count);
  }
done:
  lth_bvh_destroy(ctx, &bvh);
  lth_free(ctx, face);
  lth_free(ctx, box);
  return status;
}

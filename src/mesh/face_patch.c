/// Growing a patch of boundary faces: nearest face, then a walk across edges.
#include "mesh/face_patch.h"

#include "base/tensor.h"

#include <stdlib.h>

/// An undirected edge (smaller point first) and a boundary face that has it.
typedef struct Edge {
  LitheIndex a, b, face;
} Edge;

static int compare_edges(const void *left, const void *right) {
  const Edge *p = left, *q = right;
  if (p->a != q->a) return p->a < q->a ? -1 : 1;
  if (p->b != q->b) return p->b < q->b ? -1 : 1;
  return p->face < q->face ? -1 : p->face > q->face;
}

static LitheIndex face_corners(const LthFaceView *face) {
  return face->loop_off[face->n_loops] - face->loop_off[0];
}

/// Edge that leaves corner k of loop l.
static Edge edge_at(const LthFaceView *face, LitheIndex l, LitheIndex k, LitheIndex f) {
  LitheIndex next = k + 1 < face->loop_off[l + 1] ? k + 1 : face->loop_off[l];
  LitheIndex a = face->loop_point[k], b = face->loop_point[next];
  return a < b ? (Edge){a, b, f} : (Edge){b, a, f};
}

/// Square of the distance from x to the segment a b.
static double segment_distance2(const double *a, const double *b, const double x[3]) {
  double ab[3], ax[3], r[3];
  lth_v3_sub(b, a, ab);
  lth_v3_sub(x, a, ax);
  double length2 = lth_v3_dot(ab, ab), t = length2 > 0 ? lth_v3_dot(ax, ab) / length2 : 0;
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  for (int i = 0; i < 3; i++) r[i] = ax[i] - t * ab[i];
  return lth_v3_dot(r, r);
}

/// Square of the distance from x to a face: to its plane where x lies above it, else to its edges.
static double face_distance2(const LthFaceView *face, const double x[3]) {
  double t1[3], t2[3], d[3], nearest = INFINITY;
  bool above = false;
  lth_face_frame(face->normal, t1, t2);
  for (LitheIndex l = 0; l < face->n_loops; l++)
    for (LitheIndex k = face->loop_off[l]; k < face->loop_off[l + 1]; k++) {
      LitheIndex next = k + 1 < face->loop_off[l + 1] ? k + 1 : face->loop_off[l];
      const double *a = face->points + 3 * (LitheCount)face->loop_point[k];
      const double *b = face->points + 3 * (LitheCount)face->loop_point[next];
      nearest = fmin(nearest, segment_distance2(a, b, x));
      // does the ray from x along t1 cross this edge?
      double u[3], v[3];
      lth_v3_sub(a, x, u);
      lth_v3_sub(b, x, v);
      double ua = lth_v3_dot(u, t2), vb = lth_v3_dot(v, t2);
      if ((ua > 0) == (vb > 0)) continue;
      double w = ua / (ua - vb);
      if ((1 - w) * lth_v3_dot(u, t1) + w * lth_v3_dot(v, t1) > 0) above = !above;
    }
  if (!above) return nearest;
  lth_v3_sub(x, face->points + 3 * (LitheCount)face->loop_point[face->loop_off[0]], d);
  double height = lth_v3_dot(d, face->normal);
  return height * height;
}

static LitheIndex nearest_boundary_face(const LthMesh *mesh, const double x[3]) {
  LitheIndex best = -1;
  double least = INFINITY;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    if (mesh->face_cell[2 * f + 1] >= 0) continue;
    LthFaceView face = lth_mesh_face(mesh, f);
    double distance2 = face_distance2(&face, x);
    if (best < 0 || distance2 < least) best = f, least = distance2;
  }
  return best;
}

/// All edges of all boundary faces, sorted.
static LitheStatus boundary_edges(LitheCtx *ctx, const LthMesh *mesh, LitheCount *n, Edge **edges) {
  *n = 0;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    LthFaceView face = lth_mesh_face(mesh, f);
    if (mesh->face_cell[2 * f + 1] < 0) *n += face_corners(&face);
  }
  LTH_NEW(ctx, *edges, *n);
  *n = 0;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    if (mesh->face_cell[2 * f + 1] >= 0) continue;
    LthFaceView face = lth_mesh_face(mesh, f);
    for (LitheIndex l = 0; l < face.n_loops; l++)
      for (LitheIndex k = face.loop_off[l]; k < face.loop_off[l + 1]; k++)
        (*edges)[(*n)++] = edge_at(&face, l, k, f);
  }
  qsort(*edges, (size_t)*n, sizeof **edges, compare_edges);
  return LITHE_OK;
}

static double normal_angle(const LthMesh *mesh, LitheIndex f, LitheIndex g) {
  const double *n = mesh->face_normal + 3 * (LitheCount)f,
               *m = mesh->face_normal + 3 * (LitheCount)g;
  double cross[3];
  lth_v3_cross(n, m, cross);
  return atan2(lth_v3_norm(cross), lth_v3_dot(n, m));
}

/// First edge that is not before `key` (which has face -1).
static LitheCount lower_bound(LitheCount n, const Edge *edges, const Edge *key) {
  LitheCount low = 0, high = n;
  while (low < high) {
    LitheCount middle = (low + high) / 2;
    if (compare_edges(&edges[middle], key) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

LitheStatus lth_face_patch_grow(LitheCtx *ctx, const LthMesh *mesh, const double point[3],
                                double angle, uint8_t *member) {
  LitheStatus status = LITHE_OK;
  Edge *edges = NULL;
  LitheIndex *stack = NULL, depth = 0;
  LitheCount n = 0;
  memset(member, 0, (size_t)mesh->n_faces);
  LITHE_TRY_OR(done, boundary_edges(ctx, mesh, &n, &edges));
  LTH_NEW_OR(done, ctx, stack, mesh->n_faces);
  LitheIndex seed = nearest_boundary_face(mesh, point);
  if (seed < 0) goto done;
  member[seed] = 1;
  stack[depth++] = seed;
  while (depth > 0) {
    LitheIndex f = stack[--depth];
    LthFaceView face = lth_mesh_face(mesh, f);
    for (LitheIndex l = 0; l < face.n_loops; l++)
      for (LitheIndex k = face.loop_off[l]; k < face.loop_off[l + 1]; k++) {
        Edge key = edge_at(&face, l, k, -1);
        for (LitheCount e = lower_bound(n, edges, &key);
             e < n && edges[e].a == key.a && edges[e].b == key.b; e++) {
          LitheIndex g = edges[e].face;
          if (member[g] || normal_angle(mesh, f, g) > angle + 1e-9) continue;
          member[g] = 1;
          stack[depth++] = g;
        }
      }
  }
done:
  lth_free(ctx, edges);
  lth_free(ctx, stack);
  return status;
}

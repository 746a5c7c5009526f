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

static LitheIndex nearest_boundary_face(const LthMesh *mesh, const double x[3]) {
  LitheIndex best = -1;
  double least = INFINITY;
  for (LitheIndex f = 0; f < mesh->n_faces; f++) {
    if (mesh->face_cell[2 * f + 1] >= 0) continue;
    LthFaceView face = lth_mesh_face(mesh, f);
    double distance2 = lth_face_distance2(&face, x);
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

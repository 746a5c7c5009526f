/// Quadrature over cells and the L2 projection of fields onto the space.
#include "base/tensor.h"
#include "disc/dg/dg_space.h"
#include "geometry/quadrature.h"

/// Number of tetrahedra: fan triangles of all faces that do not touch their base point.
static LitheIndex count_tetrahedra(const LthMesh *mesh, LitheIndex cell) {
  LitheIndex n = 0;
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LthFaceView face = lth_mesh_face(mesh, mesh->cell_face[c]);
    n += face.loop_off[face.n_loops] - face.loop_off[0];
  }
  return n;
}

/// Points and weights of one tetrahedron (corner 0 is the centroid); returns their number.
static LitheIndex tetrahedron_points(const LthSimplexRule *rule, const double *corner[4],
                                     double sign, double *points, double *weights) {
  double edge[3][3], w[3];
  for (int i = 0; i < 3; i++) lth_v3_sub(corner[i + 1], corner[0], edge[i]);
  lth_v3_cross(edge[1], edge[2], w);
  double volume = sign * lth_v3_dot(edge[0], w) / 6;
  int n = lth_simplex_rule_points(rule);
  for (int g = 0; g < n; g++) {
    double bary[4];
    weights[g] = volume * lth_simplex_rule_point(rule, g, bary);
    lth_v3_copy(corner[0], points + 3 * g);
    for (int i = 0; i < 3; i++) lth_v3_axpy(bary[i + 1], edge[i], points + 3 * g);
  }
  return n;
}

LitheStatus lth_dg_cell_quadrature(LitheCtx *ctx, const LthMesh *mesh, LitheIndex cell, int degree,
                                   LitheIndex *n, double **points, double **weights) {
  LitheStatus status = LITHE_OK;
  LthSimplexRule rule;
  *n = 0;
  *points = *weights = NULL;
  LITHE_TRY(lth_simplex_rule(ctx, 3, degree, &rule));
  LitheCount size = (LitheCount)count_tetrahedra(mesh, cell) * lth_simplex_rule_points(&rule);
  LTH_NEW_OR(done, ctx, *points, 3 * size);
  LTH_NEW_OR(done, ctx, *weights, size);
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LitheIndex f = mesh->cell_face[c];
    LthFaceView face = lth_mesh_face(mesh, f);
    LitheIndex base = face.loop_point[face.loop_off[0]];
    for (LitheIndex l = 0; l < face.n_loops; l++)
      for (LitheIndex k = face.loop_off[l]; k < face.loop_off[l + 1]; k++) {
        LitheIndex next = k + 1 < face.loop_off[l + 1] ? k + 1 : face.loop_off[l];
        LitheIndex a = face.loop_point[k], b = face.loop_point[next];
        if (a == base || b == base) continue;
        const double *corner[4] = {
            mesh->cell_centroid + 3 * (LitheCount)cell, face.points + 3 * (LitheCount)base,
            face.points + 3 * (LitheCount)a, face.points + 3 * (LitheCount)b};
        *n += tetrahedron_points(&rule, corner, lth_mesh_side(mesh, f, cell), *points + 3 * *n,
                                 *weights + *n);
      }
  }
done:
  if (status != LITHE_OK) {
    lth_free(ctx, *points);
    lth_free(ctx, *weights);
    *points = *weights = NULL;
  }
  return status;
}

typedef void (*FieldFn)(const void *self, const double x[3], double value[3]);

/// coef_i = int phi_i field / int phi_0
static LitheStatus project_cell(LitheCtx *ctx, const LthDgSpace *s, LitheIndex cell, FieldFn field,
                                const void *self, int quad_degree, double *coef) {
  int nb = lth_dg_funcs(s, cell), least = 2 * s->degree[cell];
  LitheIndex n;
  double *points, *weights, volume = 0;
  LITHE_TRY(lth_dg_cell_quadrature(ctx, s->mesh, cell, quad_degree > least ? quad_degree : least,
                                   &n, &points, &weights));
  memset(coef, 0, 3 * (size_t)nb * sizeof *coef);
  for (LitheIndex g = 0; g < n; g++) {
    double phi[LTH_DG_MAX_FUNCS], value[3];
    lth_dg_eval(s, cell, points + 3 * g, phi);
    field(self, points + 3 * g, value);
    volume += weights[g];
    for (int i = 0; i < nb; i++) lth_v3_axpy(weights[g] * phi[i], value, coef + 3 * i);
  }
  for (int i = 0; i < 3 * nb; i++) coef[i] /= volume;
  lth_free(ctx, points);
  lth_free(ctx, weights);
  return LITHE_OK;
}

LitheStatus lth_dg_project(LitheCtx *ctx, const LthDgSpace *space,
                           void (*field)(const void *self, const double x[3], double value[3]),
                           const void *self, int quad_degree, double *coef) {
  LthSimplexRule rule; // a wrong degree is told here, once
  LITHE_TRY(lth_simplex_rule(ctx, 3, quad_degree, &rule));
  int worst = LITHE_OK; // of type LitheStatus
#pragma omp parallel for schedule(dynamic, 16) num_threads(lth_threads(ctx)) reduction(max : worst)
  for (LitheIndex c = 0; c < space->n_cells; c++) {
    int status = (int)project_cell(ctx, space, c, field, self, quad_degree,
                                   coef + 3 * (LitheCount)space->func_off[c]);
    worst = status > worst ? status : worst;
  }
  return (LitheStatus)worst;
}

/// Quadrature over cells and the L2 projection of fields onto the space.
#include "base/tensor.h"
#include "disc/dg/dg_space.h"
#include "geometry/quadrature.h"

/// The points of one tetrahedron (corner 0 is the centroid).
static void visit_tetrahedron(const LthSimplexRule *rule, const double *corner[4], double sign,
                              LthDgPointFn visit, void *self) {
  double edge[3][3], w[3];
  for (int i = 0; i < 3; i++) lth_v3_sub(corner[i + 1], corner[0], edge[i]);
  lth_v3_cross_sharp(edge[1], edge[2], w);
  double volume = sign * lth_v3_dot(edge[0], w) / 6;
  for (int g = 0; g < lth_simplex_rule_points(rule); g++) {
    double bary[4], x[3], weight = volume * lth_simplex_rule_point(rule, g, bary);
    lth_v3_copy(corner[0], x);
    for (int i = 0; i < 3; i++) lth_v3_axpy(bary[i + 1], edge[i], x);
    visit(self, x, weight);
  }
}

void lth_dg_visit_cell(const LthSimplexRule *rule, const LthMesh *mesh, LitheIndex cell,
                       LthDgPointFn visit, void *self) {
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LitheIndex f = mesh->cell_face[c];
    LthFaceView face = lth_mesh_face(mesh, f);
    LitheIndex t[3];
    for (LthFan fan = lth_fan(&face); lth_fan_next(&fan, t);) {
      const double *corner[4] = {
          mesh->cell_centroid + 3 * (LitheCount)cell, face.points + 3 * (LitheCount)t[0],
          face.points + 3 * (LitheCount)t[1], face.points + 3 * (LitheCount)t[2]};
      visit_tetrahedron(rule, corner, lth_mesh_side(mesh, f, cell), visit, self);
    }
  }
}

/// A bound of the number of tetrahedra.
static LitheCount count_edges(const LthMesh *mesh, LitheIndex cell) {
  LitheCount n = 0;
  for (LitheIndex c = mesh->cell_face_off[cell]; c < mesh->cell_face_off[cell + 1]; c++) {
    LthFaceView face = lth_mesh_face(mesh, mesh->cell_face[c]);
    n += face.loop_off[face.n_loops] - face.loop_off[0];
  }
  return n;
}

typedef struct PointList {
  LitheIndex n;
  double *points, *weights;
} PointList;

static void append_point(void *self, const double x[3], double weight) {
  PointList *list = self;
  lth_v3_copy(x, list->points + 3 * (LitheCount)list->n);
  list->weights[list->n++] = weight;
}

LitheStatus lth_dg_cell_quadrature(LitheCtx *ctx, const LthMesh *mesh, LitheIndex cell, int degree,
                                   LitheIndex *n, double **points, double **weights) {
  LitheStatus status = LITHE_OK;
  LthSimplexRule rule;
  PointList list = {0};
  *n = 0;
  *points = *weights = NULL;
  LITHE_TRY(lth_simplex_rule(ctx, 3, degree, &rule));
  LitheCount size = count_edges(mesh, cell) * lth_simplex_rule_points(&rule);
  LTH_NEW_OR(done, ctx, list.points, 3 * size);
  LTH_NEW_OR(done, ctx, list.weights, size);
  lth_dg_visit_cell(&rule, mesh, cell, append_point, &list);
  *n = list.n;
  *points = list.points;
  *weights = list.weights;
  list = (PointList){0};
done:
  lth_free(ctx, list.points);
  lth_free(ctx, list.weights);
  return status;
}

/// Sums of a projection over one cell.
typedef struct Projection {
  const LthDgSpace *space;
  LitheIndex cell;
  void (*field)(const void *self, const double x[3], double value[3]);
  const void *field_self;
  double volume, *coef;
} Projection;

static void add_to_projection(void *self, const double x[3], double weight) {
  Projection *p = self;
  double phi[LTH_DG_MAX_FUNCS], value[3];
  lth_dg_eval(p->space, p->cell, x, phi);
  p->field(p->field_self, x, value);
  p->volume += weight;
  for (int i = 0; i < lth_dg_funcs(p->space, p->cell); i++)
    lth_v3_axpy(weight * phi[i], value, p->coef + 3 * i);
}

LitheStatus lth_dg_project(LitheCtx *ctx, const LthDgSpace *space,
                           void (*field)(const void *self, const double x[3], double value[3]),
                           const void *self, int quad_degree, double *coef) {
  LthSimplexRule rules[LTH_DG_MAX_DEGREE + 1];
  for (int k = 0; k <= LTH_DG_MAX_DEGREE; k++)
    LITHE_TRY(lth_simplex_rule(ctx, 3, quad_degree > 2 * k ? quad_degree : 2 * k, &rules[k]));
  memset(coef, 0, (size_t)space->n_dofs * sizeof *coef);
#pragma omp parallel for schedule(dynamic, 16) num_threads(lth_threads(ctx))
  for (LitheIndex c = 0; c < space->n_cells; c++) {
    // coef_i = int phi_i field / int phi_0
    Projection p = {space, c, field, self, 0, coef + 3 * (LitheCount)space->func_off[c]};
    lth_dg_visit_cell(&rules[space->degree[c]], space->mesh, c, add_to_projection, &p);
    for (int i = 0; i < 3 * lth_dg_funcs(space, c); i++) p.coef[i] /= p.volume;
  }
  return LITHE_OK;
}

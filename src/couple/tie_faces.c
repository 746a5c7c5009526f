/// The elements' own face terms on the common pieces of two bodies: a mesh and a space of the cells that
/// meet there, and an operator that knows faces only.
#include "base/order.h"
#include "base/tensor.h"
#include "couple/tie_priv.h"

#include <stdlib.h>

typedef struct TieFaces {
  LthMesh *mesh;
  LthDgSpace *space;
  LthDgOperator *op;
  double *young, *poisson; ///< (n_cells)
  uint8_t *from;           ///< body of each cell                            (n_cells)
  LitheIndex *of;          ///< its cell there                               (n_cells)
  bool turns[2];           ///< corotated bodies
  double *x, *rest, *f0;   ///< of the cells here                            (n_dofs)
  LthTieMatrix matrix;
} TieFaces;

/// Cells of one body that meet the overlap, ascending and once each, behind the `n` there are.
static LitheIndex list_cells(const LthTieDef *def, const LthOverlap *o, int side, LitheIndex n,
                             TieFaces *t) {
  LitheIndex first = n;
  for (LitheIndex i = 0; i < o->pieces.n; i++)
    t->of[n++] = lth_tie_cell(&def->side[side], o->patch[2 * i + side]);
  const LitheIndex kept = first + lth_sort_unique(t->of + first, n - first);
  for (LitheIndex i = first; i < kept; i++) t->from[i] = (uint8_t)side;
  return kept;
}

static LitheStatus copy_faces(LitheCtx *ctx, const LthTieDef *def, const LthOverlap *o,
                              const LitheIndex first[3], const TieFaces *t, LthMesh *m) {
  const LthPieces *p = &o->pieces;
  m->n_faces = p->n, m->n_points = p->n_points;
  LTH_NEW(ctx, m->points, 3 * (LitheCount)p->n_points);
  LTH_NEW(ctx, m->face_loop_off, (LitheCount)p->n + 1);
  LTH_NEW(ctx, m->loop_off, (LitheCount)p->n_loops + 1);
  LTH_NEW(ctx, m->loop_point, p->n_points);
  LTH_NEW(ctx, m->face_cell, 2 * (LitheCount)p->n);
  LTH_NEW(ctx, m->face_normal, 3 * (LitheCount)p->n);
  LTH_NEW(ctx, m->face_area, p->n);
  LTH_NEW(ctx, m->face_centroid, 3 * (LitheCount)p->n);
  memcpy(m->points, p->points, sizeof *p->points * 3 * (size_t)p->n_points);
  memcpy(m->face_loop_off, p->piece_loop_off, sizeof(LitheIndex) * ((size_t)p->n + 1));
  memcpy(m->loop_off, p->loop_off, sizeof(LitheIndex) * ((size_t)p->n_loops + 1));
  memcpy(m->loop_point, p->loop_point, sizeof(LitheIndex) * (size_t)p->n_points);
  for (LitheIndex f = 0; f < p->n; f++) {
    LitheIndex face = def->side[0].patches->face[o->patch[2 * f]];
    for (int s = 0; s < 2; s++)
      m->face_cell[2 * f + s] = (LitheIndex)lth_lower_bound(
          t->of, first[s], first[s + 1], lth_tie_cell(&def->side[s], o->patch[2 * f + s]));
    lth_v3_copy(def->side[0].disc->mesh->face_normal + 3 * (size_t)face,
                m->face_normal + 3 * (size_t)f);
    LthFaceView view = lth_mesh_face(m, f);
    m->face_area[f] = lth_face_area_centroid(&view, m->face_centroid + 3 * (size_t)f);
  }
  return LITHE_OK;
}

/// Faces of every cell, ascending.
static LitheStatus list_faces(LitheCtx *ctx, LthMesh *m) {
  LTH_NEW(ctx, m->cell_face_off, (LitheCount)m->n_cells + 2);
  LTH_NEW(ctx, m->cell_face, 2 * (LitheCount)m->n_faces);
  for (LitheIndex i = 0; i < 2 * m->n_faces; i++) m->cell_face_off[m->face_cell[i] + 2]++;
  for (LitheIndex c = 0; c < m->n_cells; c++) m->cell_face_off[c + 2] += m->cell_face_off[c + 1];
  for (LitheIndex i = 0; i < 2 * m->n_faces; i++)
    m->cell_face[m->cell_face_off[m->face_cell[i] + 1]++] = i / 2;
  return LITHE_OK;
}

static LitheStatus copy_cells(LitheCtx *ctx, const LthTieDef *def, TieFaces *t, LthMesh *m) {
  LTH_NEW(ctx, m->cell_volume, m->n_cells);
  LTH_NEW(ctx, m->cell_centroid, 3 * (LitheCount)m->n_cells);
  LTH_NEW(ctx, m->cell_box, 6 * (LitheCount)m->n_cells);
  LTH_NEW(ctx, t->young, m->n_cells);
  LTH_NEW(ctx, t->poisson, m->n_cells);
  for (LitheIndex c = 0; c < m->n_cells; c++) {
    const LthTieSide *side = &def->side[t->from[c]];
    const LthMesh *body = side->disc->mesh;
    size_t cell = (size_t)t->of[c], at = (size_t)c;
    m->cell_volume[c] = body->cell_volume[cell];
    lth_v3_copy(body->cell_centroid + 3 * cell, m->cell_centroid + 3 * at);
    memcpy(m->cell_box + 6 * at, body->cell_box + 6 * cell, 6 * sizeof *m->cell_box);
    t->young[c] = side->young[cell];
    t->poisson[c] = side->poisson[cell];
  }
  m->cell_size = fmin(def->side[0].disc->mesh->cell_size, def->side[1].disc->mesh->cell_size);
  return LITHE_OK;
}

/// The cells of both bodies at the overlap, those of the first first, with the common pieces as inner faces.
static LitheStatus make_mesh(LitheCtx *ctx, const LthTieDef *def, const LthOverlap *o,
                             TieFaces *t) {
  LTH_NEW(ctx, t->of, 2 * (LitheCount)o->pieces.n);
  LTH_NEW(ctx, t->from, 2 * (LitheCount)o->pieces.n);
  LTH_NEW(ctx, t->mesh, 1);
  LitheIndex first[3] = {0};
  for (int s = 0; s < 2; s++) first[s + 1] = list_cells(def, o, s, first[s], t);
  t->mesh->n_cells = first[2];
  LITHE_TRY(copy_faces(ctx, def, o, first, t, t->mesh));
  LITHE_TRY(list_faces(ctx, t->mesh));
  return copy_cells(ctx, def, t, t->mesh);
}

/// The flux and penalty that both bodies have; those that are always stable where they differ.
static LitheStatus make_operator(LitheCtx *ctx, const LthTieDef *def, TieFaces *t) {
  const LthTieSide *a = &def->side[0], *b = &def->side[1];
  LthDgOperatorDef op = {.space = t->space,
                         .young = t->young,
                         .poisson = t->poisson,
                         .flux = a->flux == b->flux ? a->flux : LTH_FLUX_IP,
                         .penalty = a->penalty == b->penalty ? a->penalty : LTH_PENALTY_AUTO,
                         .eta = fmax(a->eta, b->eta),
                         .warped = a->warped || b->warped,
                         .faces_only = true};
  return lth_dg_operator_create(ctx, &op, &t->op);
}

static LitheStatus map_rows(LitheCtx *ctx, const LthTieDef *def, TieFaces *t) {
  LTH_NEW(ctx, t->matrix.row, t->mesh->n_cells);
  LTH_NEW(ctx, t->matrix.dof, t->mesh->n_cells);
  for (LitheIndex c = 0; c < t->mesh->n_cells; c++) {
    const LthTieSide *side = &def->side[t->from[c]];
    t->matrix.row[c] = side->first_row + t->of[c];
    t->matrix.dof[c] = side->first_dof + 3 * (LitheCount)side->space->func_off[t->of[c]];
  }
  return LITHE_OK;
}

/// The system's vector on the cells here; bodies that do not turn keep their places at rest for their rotations.
static void gather(const TieFaces *t, const double *x, bool for_rotation) {
  for (LitheIndex c = 0; c < t->mesh->n_cells; c++) {
    LitheCount first = 3 * (LitheCount)t->space->func_off[c];
    const double *from =
        for_rotation && !t->turns[t->from[c]] ? t->rest + first : x + t->matrix.dof[c];
    memcpy(t->x + first, from, sizeof *x * 3 * (size_t)lth_dg_funcs(t->space, c));
  }
}

static void update_rotations(void *self, const double *x) {
  TieFaces *t = self;
  if (!x) {
    lth_dg_reset_rotations(t->op);
    return;
  }
  if (!t->turns[0] && !t->turns[1]) return;
  gather(t, x, true);
  lth_dg_update_rotations(t->op, t->x);
}

static void scatter_load(const TieFaces *t, double *f0) {
  for (LitheIndex c = 0; c < t->mesh->n_cells; c++) {
    LitheCount first = 3 * (LitheCount)t->space->func_off[c];
    for (int i = 0; i < 3 * lth_dg_funcs(t->space, c); i++)
      f0[t->matrix.dof[c] + i] += t->f0[first + i];
  }
}

static void add(void *self, double time, LthBlockMatrix *A, double *f0) {
  TieFaces *t = self;
  lth_dg_assemble(t->op, time, t->matrix.K, t->f0);
  lth_tie_matrix_add(&t->matrix, A);
  scatter_load(t, f0);
}

static void add_load(void *self, double time, double *f0) {
  TieFaces *t = self;
  lth_dg_assemble_load(t->op, time, t->f0);
  scatter_load(t, f0);
}

static double energy(void *self, double time, const double *x) {
  TieFaces *t = self;
  gather(t, x, false);
  return lth_dg_energy(t->op, time, t->x);
}

static LitheStatus create(LitheCtx *ctx, const LthTieDef *def, const LthOverlap *overlap,
                          TieFaces *t, LthCoupling *coupling) {
  const LthDgSpace *spaces[2] = {def->side[0].space, def->side[1].space};
  LITHE_TRY(make_mesh(ctx, def, overlap, t));
  LITHE_TRY(lth_dg_space_gather(ctx, t->mesh, spaces, t->from, t->of, &t->space));
  LITHE_TRY(make_operator(ctx, def, t));
  LITHE_TRY(map_rows(ctx, def, t));
  for (int s = 0; s < 2; s++) t->turns[s] = def->side[s].warped;
  LTH_NEW(ctx, t->x, t->space->n_dofs);
  LTH_NEW(ctx, t->rest, t->space->n_dofs);
  LTH_NEW(ctx, t->f0, t->space->n_dofs);
  lth_dg_rest(t->space, t->rest);
  LITHE_TRY(lth_dg_matrix_create(ctx, t->op, &t->matrix.K));
  return lth_tie_matrix_list(ctx, &t->matrix, coupling);
}

static void destroy(LitheCtx *ctx, void *self) {
  TieFaces *t = self;
  lth_tie_matrix_free(ctx, &t->matrix);
  lth_dg_operator_destroy(ctx, &t->op);
  lth_dg_space_destroy(ctx, &t->space);
  lth_mesh_destroy(ctx, &t->mesh);
  void *blocks[] = {t->young, t->poisson, t->from, t->of, t->x, t->rest, t->f0, t};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(ctx, blocks[i]);
}

LitheStatus lth_tie_faces_create(LitheCtx *ctx, const LthTieDef *def, const LthOverlap *overlap,
                                 LthTie *tie, LthCoupling *coupling) {
  TieFaces *t = NULL;
  LTH_NEW(ctx, t, 1);
  *coupling = (LthCoupling){.self = t,
                            .update_rotations = update_rotations,
                            .add = add,
                            .add_load = add_load,
                            .energy = energy,
                            .destroy = destroy,
                            .is_nonlinear = def->side[0].warped || def->side[1].warped};
  LITHE_TRY(create(ctx, def, overlap, t, coupling));
  tie->n_faces = t->mesh->n_faces;
  for (LitheIndex f = 0; f < t->mesh->n_faces; f++) tie->face_area += t->mesh->face_area[f];
  return LITHE_OK;
}

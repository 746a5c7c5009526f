/// The tetrahedra that a solid's boundary may cross: those in which its fields' signs leave open on which side all is.
#include "geometry/sharp_priv.h"

#include "base/tensor.h"

#include <math.h>

#define LOOP_MAX LTH_CELL_SIDES

/// What one layer of cells is marched with.
typedef struct March {
  LthSharp *s;
  LthCell cell;
  LthFieldSide *side; ///< of all fields in the present lattice cell and tetrahedron (2 n_fields)
  double *value;      ///< at the corners of the present cell     (8 n_fields)
  LitheCount *stamp;  ///< cell for which a value was computed, + 1 (8 n_fields)
  LitheCount number;  ///< of the present cell
  LitheIndex at[3];   ///< its lowest corner
  LthPolygonWork work;
} March;

static const uint64_t *negative_at(const LthSharp *s, LitheIndex i, LitheIndex j, int layer) {
  return s->negative[layer] + ((size_t)j * (size_t)s->n[0] + (size_t)i) * (size_t)s->n_words;
}

static void fill_layer(LthSharp *s, LitheIndex k, int layer) {
  const LthSolid *solid = s->solid;
#pragma omp parallel for schedule(static) num_threads(lth_threads(s->ctx))
  for (LitheIndex j = 0; j < s->n[1]; j++)
    for (LitheIndex i = 0; i < s->n[0]; i++) {
      uint64_t *word =
          s->negative[layer] + ((size_t)j * (size_t)s->n[0] + (size_t)i) * (size_t)s->n_words;
      double x[3];
      lth_sharp_place(s, (LitheIndex[]){i, j, k}, x);
      memset(word, 0, (size_t)s->n_words * sizeof *word);
      for (LitheIndex f = 0; f < solid->n_fields; f++)
        if (lth_field_value(&solid->field[f], x) < 0) word[f / 64] |= (uint64_t)1 << f % 64;
    }
}

/// Sides of all fields among some corners (bit masks of axes) of the present cell; false where all are known.
static bool find_sides(const March *m, int n, const int *corner, LthFieldSide *side) {
  const LthSharp *s = m->s;
  bool is_mixed = false;
  for (LitheIndex w = 0; w < s->n_words; w++) {
    uint64_t any = 0, all = ~(uint64_t)0;
    for (int k = 0; k < n; k++) {
      int c = corner[k];
      uint64_t word = negative_at(s, m->at[0] + (c & 1), m->at[1] + (c >> 1 & 1), c >> 2)[w];
      any |= word, all &= word;
    }
    is_mixed = is_mixed || any != all;
    LitheIndex end = s->solid->n_fields - 64 * w < 64 ? s->solid->n_fields - 64 * w : 64;
    for (LitheIndex f = 0; f < end; f++)
      side[64 * w + f] = (LthFieldSide)((all >> f & 1) ? -1 : (any >> f & 1) ? 0 : 1);
  }
  return is_mixed;
}

static double corner_value(March *m, LitheIndex field, int corner) {
  LitheIndex slot = 8 * field + corner;
  if (m->stamp[slot] != m->number + 1) {
    double x[3];
    lth_sharp_place(m->s,
                    (LitheIndex[]){m->at[0] + (corner & 1), m->at[1] + (corner >> 1 & 1),
                                   m->at[2] + (corner >> 2)},
                    x);
    m->value[slot] = lth_field_value(&m->s->solid->field[field], x);
    m->stamp[slot] = m->number + 1;
  }
  return m->value[slot];
}

/// Of what a vertex of the present tetrahedron is made, in terms of the lattice.
static LthSharpPoint name_vertex(const March *m, const int corner[4], const LthCellVertex *v) {
  LthSharpPoint p = {.n = v->n};
  int lowest = -1, n = 0;
  for (int k = 0; k < 4; k++) {
    if (!(v->simplex >> k & 1)) continue;
    if (lowest < 0)
      lowest = corner[k];
    else
      p.step[n++] = corner[k] - lowest;
  }
  for (int a = 0; a < 3; a++) p.corner[a] = m->at[a] + (lowest >> a & 1);
  for (int i = 0; i < v->n; i++) p.field[i] = m->cell.field[v->field[i]];
  return p;
}

/// From the weights of the corners; planes across axes give their coordinate themselves.
static void place_point(const March *m, const int corner[4], const LthCellVertex *v, double x[3]) {
  for (int a = 0; a < 3; a++) {
    double along = 0;
    for (int k = 0; k < 4; k++) along += v->weight[k] * (corner[k] >> a & 1);
    x[a] = m->s->origin[a] + m->s->h * (m->at[a] + along);
  }
  for (int i = 0; i < v->n; i++) {
    const LthField *f = &m->s->solid->field[m->cell.field[v->field[i]]];
    if (f->kind == LTH_FIELD_PLANE && f->axis >= 0) x[f->axis] = f->at[f->axis];
  }
}

static LitheStatus find_point(March *m, const int corner[4], const LthCellVertex *v,
                              LitheIndex *point) {
  LthSharp *s = m->s;
  LthSharpPoint p = name_vertex(m, corner, v);
  uint64_t at =
      ((uint64_t)p.corner[2] * (uint64_t)s->n[1] + (uint64_t)p.corner[1]) * (uint64_t)s->n[0] +
      (uint64_t)p.corner[0];
  uint64_t key0 = at << 9 | (uint64_t)(p.step[0] | p.step[1] << 3 | p.step[2] << 6);
  uint64_t key1 = 0;
  for (int i = 0; i < p.n; i++) key1 |= (uint64_t)(p.field[i] + 1) << 21 * i;
  LITHE_TRY(lth_hash_insert(s->ctx, &s->hash, key0, key1, s->n_points, point));
  if (*point < s->n_points) return LITHE_OK;
  LTH_RESERVE(s->ctx, s->source, s->source_cap, (LitheCount)s->n_points + 1);
  LTH_RESERVE(s->ctx, s->points, s->points_cap, 3 * ((LitheCount)s->n_points + 1));
  s->source[s->n_points] = p;
  place_point(m, corner, v, s->points + 3 * (size_t)s->n_points);
  s->n_points++;
  return LITHE_OK;
}

static LitheStatus add_piece(March *m, const int corner[4], const LthCellPiece *p) {
  LthSharp *s = m->s;
  LitheIndex loop[LOOP_MAX];
  for (int k = 0; k < p->n; k++) {
    int at = p->is_turned ? p->n - 1 - k : k;
    LITHE_TRY(find_point(m, corner, &m->cell.vertex[p->vertex[at]], &loop[k]));
  }
  LTH_RESERVE(s->ctx, s->tris, s->tris_cap, 3 * ((LitheCount)s->n_tris + p->n - 2));
  LITHE_TRY(lth_polygon_triangulate(s->ctx, &m->work, s->points, p->n, loop,
                                    s->tris + 3 * (size_t)s->n_tris));
  s->n_tris += p->n - 2;
  return LITHE_OK;
}

static LitheStatus march_tetrahedron(March *m, const int corner[4], bool is_odd) {
  LthSharp *s = m->s;
  LthCell *c = &m->cell;
  if (!find_sides(m, 4, corner, c->side) || lth_solid_side(s->solid, c->side) != 0) return LITHE_OK;
  c->n = lth_solid_undecided(s->solid, c->side, LTH_CELL_FIELDS, c->field);
  c->is_odd = is_odd;
  s->is_bad = c->n > LTH_CELL_FIELDS;
  if (s->is_bad) return LITHE_OK;
  for (int i = 0; i < c->n; i++)
    for (int k = 0; k < 4; k++) c->value[i][k] = corner_value(m, c->field[i], corner[k]);
  s->is_bad = !lth_cell_surface(c);
  if (s->is_bad) return LITHE_OK;
  LitheIndex first = s->n_tris;
  for (int p = 0; p < c->n_pieces; p++)
    if (c->piece[p].is_kept) LITHE_TRY(add_piece(m, corner, &c->piece[p]));
  if (c->n == 1 || s->n_tris == first) return LITHE_OK;
  LTH_RESERVE(s->ctx, s->group, s->group_cap, 2 * ((LitheCount)s->n_groups + 1));
  s->group[2 * s->n_groups] = first;
  s->group[2 * s->n_groups++ + 1] = s->n_tris;
  return LITHE_OK;
}

static LitheStatus march_layer(March *m) {
  static const int paths[6][4] = {{0, 1, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7},
                                  {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 4, 6, 7}};
  static const int corners[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  const LthSharp *s = m->s;
  for (m->at[1] = 0; m->at[1] + 1 < s->n[1]; m->at[1]++)
    for (m->at[0] = 0; m->at[0] + 1 < s->n[0]; m->at[0]++, m->number++) {
      if (!find_sides(m, 8, corners, m->side) || lth_solid_side(s->solid, m->side) != 0) continue;
      for (int t = 0; t < 6 && !s->is_bad; t++) LITHE_TRY(march_tetrahedron(m, paths[t], t >= 3));
    }
  return LITHE_OK;
}

static LitheStatus march_all(March *m) {
  LthSharp *s = m->s;
  fill_layer(s, 0, 0);
  for (LitheIndex k = 0; k + 1 < s->n[2] && !s->is_bad; k++) {
    if (lth_cancelled(s->ctx))
      LITHE_FAIL(s->ctx, LITHE_INTERRUPTED, "interrupted while tessellating");
    fill_layer(s, k + 1, 1);
    m->at[2] = k;
    LITHE_TRY(march_layer(m));
    uint64_t *lower = s->negative[0];
    s->negative[0] = s->negative[1], s->negative[1] = lower;
  }
  return LITHE_OK;
}

LitheStatus lth_sharp_march(LthSharp *s) {
  LitheStatus status = LITHE_OK;
  LitheCount n = s->solid->n_fields;
  March *m = NULL;
  LTH_NEW_OR(done, s->ctx, m, 1);
  m->s = s;
  m->cell.solid = s->solid;
  LTH_NEW_OR(done, s->ctx, m->side, 2 * n);
  LTH_NEW_OR(done, s->ctx, m->value, 8 * n);
  LTH_NEW_OR(done, s->ctx, m->stamp, 8 * n);
  m->cell.side = m->side + n;
  LITHE_TRY_OR(done, march_all(m));
done:
  if (m) {
    lth_polygon_work_free(s->ctx, &m->work);
    lth_free(s->ctx, m->side);
    lth_free(s->ctx, m->value);
    lth_free(s->ctx, m->stamp);
  }
  lth_free(s->ctx, m);
  return status;
}

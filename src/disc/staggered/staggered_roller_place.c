/// Where rollers that are not along an axis act: the surface within each part of a cell is taken as plane.
#include "disc/staggered/staggered_fringe.h"
#include "disc/staggered/staggered_roller.h"

#include "geometry/shape_foot.h"

#define CORNERS 12   // of a rectangle cut by a box, at most
#define NEAR 0.1     // of a part's diagonal: so far a plane may be from the surface
#define CLOSE 1e-3   // of it: on the surface
#define AGREE 0.9    // cosine between their normals
#define NOTHING 1e-9 // of a part's face: no area

/// The surface within a part of a cell.
typedef struct Piece {
  int n;
  double x[CORNERS][3];
} Piece;

/// Keep what is on the low (sign 1) or high (sign -1) side of a place along an axis.
static void cut(Piece *p, int axis, double sign, double place) {
  Piece from = *p;
  p->n = 0;
  for (int i = 0; i < from.n; i++) {
    const double *a = from.x[i], *b = from.x[(i + 1) % from.n];
    double da = sign * (a[axis] - place), db = sign * (b[axis] - place);
    if (da <= 0) lth_v3_copy(a, p->x[p->n++]);
    if ((da <= 0) == (db <= 0)) continue;
    for (int k = 0; k < 3; k++) p->x[p->n][k] = a[k] + da / (da - db) * (b[k] - a[k]);
    p->n++;
  }
}

/// A square of half width `reach` in the tangent plane of a boundary point.
static void span(const LthFoot *foot, double reach, Piece *p) {
  const double *n = foot->normal;
  int least = fabs(n[0]) <= fabs(n[1]) && fabs(n[0]) <= fabs(n[2]) ? 0
              : fabs(n[1]) <= fabs(n[2])                           ? 1
                                                                   : 2;
  double e[2][3], axis[3] = {least == 0, least == 1, least == 2};
  lth_v3_cross(n, axis, e[0]);
  lth_v3_normalize(e[0]);
  lth_v3_cross(n, e[0], e[1]);
  p->n = 4;
  for (int k = 0; k < 4; k++) {
    lth_v3_copy(foot->point, p->x[k]);
    lth_v3_axpy(k == 0 || k == 3 ? reach : -reach, e[0], p->x[k]);
    lth_v3_axpy(k < 2 ? reach : -reach, e[1], p->x[k]);
  }
}

/// Area of a piece and its centroid.
static double measure(const Piece *p, double center[3]) {
  double sum = 0;
  for (int a = 0; a < 3; a++) center[a] = 0;
  for (int i = 1; i + 1 < p->n; i++) {
    double u[3], v[3], c[3];
    lth_v3_sub(p->x[i], p->x[0], u);
    lth_v3_sub(p->x[i + 1], p->x[0], v);
    lth_v3_cross(u, v, c);
    double area = lth_v3_norm(c) / 2;
    sum += area;
    for (int a = 0; a < 3; a++) center[a] += area / 3 * (p->x[0][a] + p->x[i][a] + p->x[i + 1][a]);
  }
  if (sum > 0) lth_v3_scale(1 / sum, center);
  return sum;
}

/// The boundary nearest to a place, or, where that is on it and its normal would be that of rounding, to one inside beside it.
static bool find_foot(const LthStaggered *s, const double x[3], double diagonal, LthFoot *foot) {
  for (int k = 0; k <= 2 * s->dim; k++) {
    double at[3];
    lth_v3_copy(x, at);
    if (k > 0) at[(k - 1) / 2] += (k % 2 ? NEAR : -NEAR) * diagonal;
    if (!lth_shape_foot(s->shape, at, diagonal, foot)) return false;
    if (k == 0 ? fabs(foot->distance) > CLOSE * diagonal : foot->distance < -CLOSE * diagonal)
      return true;
  }
  return false;
}

/// The piece of surface in a box, as its place on the surface and area; false where there is none.
static bool find_piece(const LthStaggered *s, const double low[3], const double size[3],
                       LthRollerPoint *point) {
  LthFoot foot, own;
  Piece piece;
  double middle[3], diagonal = 0, reach;
  for (int a = 0; a < 3; a++) {
    middle[a] = low[a] + size[a] / 2;
    if (a < s->dim) diagonal += size[a] * size[a];
  }
  diagonal = sqrt(diagonal);
  reach = diagonal + (s->dim == 2 ? size[2] : 0);
  if (!find_foot(s, middle, diagonal, &foot) || fabs(foot.distance) > diagonal) return false;
  span(&foot, reach, &piece);
  for (int a = 0; a < 3; a++) {
    cut(&piece, a, 1, low[a] + size[a]);
    cut(&piece, a, -1, low[a]);
  }
  *point = (LthRollerPoint){.area = measure(&piece, middle)};
  if (!(point->area > NOTHING * diagonal * diagonal)) return false;
  lth_v3_axpy(-NEAR * diagonal, foot.normal,
              middle); // on the surface normals would be those of rounding
  if (!lth_shape_foot(s->shape, middle, diagonal, &own)) return false;
  lth_v3_copy(own.point, point->x);
  lth_v3_copy(own.normal, point->normal);
  return own.distance < 0 && own.distance > -2 * NEAR * diagonal &&
         lth_v3_dot(own.normal, foot.normal) > AGREE;
}

/// Points of a cell, by the first roller that holds them.
static LitheStatus add_cell(LitheCtx *ctx, const LthStaggered *s, LitheCount slot,
                            LthStaggeredRollers *r) {
  const LthSparseGrid *g = s->grid;
  LitheIndex cell[3];
  lth_sparse_grid_cell(g, slot, cell);
  for (int q = 0; q < 1 << s->dim; q++) {
    double low[3], size[3], offset[3] = {0.5 * (q & 1), 0.5 * (q >> 1 & 1), 0.5 * (q >> 2)};
    LthRollerPoint point;
    lth_sparse_grid_place(g, cell, offset, low);
    for (int a = 0; a < 3; a++) size[a] = a < s->dim ? g->h[a] / 2 : g->h[a];
    if (!find_piece(s, low, size, &point)) continue;
    while (point.roller < s->n_rollers &&
           !s->roller[point.roller].selects(s->roller[point.roller].self, point.x, point.normal))
      point.roller++;
    if (point.roller == s->n_rollers) continue;
    LTH_RESERVE(ctx, r->point, r->cap_points, r->n_points + 1);
    r->point[r->n_points++] = point;
  }
  return LITHE_OK;
}

LitheStatus lth_rollers_place(LitheCtx *ctx, const LthStaggered *s, LthStaggeredRollers *r) {
  const LthSparseGrid *g = s->grid;
  for (LitheIndex block = 0; block < g->n_blocks; block++) {
    LthHalo halo;
    lth_halo_fill(g, block, &halo);
    for (LitheIndex local = 0; local < g->block_cells; local++) {
      const LitheCount *slot = halo.slot + lth_halo_at(g, &halo, local);
      if (!lth_fringe_is_inside(s, slot, halo.stride)) LITHE_TRY(add_cell(ctx, s, *slot, r));
    }
  }
  return LITHE_OK;
}

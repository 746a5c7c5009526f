/// Parts by closed forms: of each part only those shapes of a tree count that its boundary passes through; where that is
/// one, its own form is taken, elsewhere boxes are halved (docs/theory/fractions.md).
#include "geometry/fractions_fill.h"

#include "base/tensor.h"
#include "geometry/box_overlap.h"
#include "geometry/wrap_local.h"

#define MESHES_MAX 64
#define HALVINGS 3      ///< of parts that two shapes pass through
#define LEAF_HALVINGS 1 ///< of parts of shapes without a form
#define LINES 6         ///< along the sides of the last boxes
#define PLANES_MAX 16
#define SNAP 1e-12 ///< of a part: rounding of what is empty or full

/// A row of blocks while it is filled.
typedef struct Exact {
  const LthProbe *probe;
  const LthFractionFrame *frame;
  const LthFractionRow *row;
  int n_meshes;
  const LthProbe *mesh[MESHES_MAX]; ///< prepared surfaces in the tree
  double *part[MESHES_MAX];         ///< theirs, as row->part
  LitheIndex m;                     ///< block that is filled
} Exact;

/// A box: a part, or a piece of one.
typedef struct Box {
  double center[3], half[3];
  LitheIndex place; ///< of the part in its block, -1: a piece
  int depth;        ///< halvings of the part
} Box;

static double fraction(const Exact *e, const LthProbe *p, const Box *box);

/// --- shapes by themselves ---

static const double *find_mesh(const Exact *e, const LthProbe *p) {
  for (int i = 0; i < e->n_meshes; i++)
    if (e->mesh[i] == p)
      return e->part[i] + (LitheCount)e->m * e->frame->block_cells * e->frame->n_parts;
  return NULL;
}

static bool is_surface(const LthShape *s) {
  return (s->kind == LTH_SHAPE_MESH && s->bvh) || s->kind == LTH_SHAPE_WRAP;
}

/// As lth_probe_side(); surfaces are known by their parts.
static LthSide side_of(const Exact *e, const LthProbe *p, const Box *box) {
  const double *mesh = box->place >= 0 && is_surface(p->shape) ? find_mesh(e, p) : NULL;
  if (!mesh) return lth_probe_side(p, box->center, box->half);
  double share = mesh[box->place];
  return share <= SNAP ? LTH_SIDE_OUTSIDE : share >= 1 - SNAP ? LTH_SIDE_INSIDE : LTH_SIDE_MIXED;
}

/// Voxels along each axis of space, where they are parallel to the axes.
static bool is_parallel(const LthVolume *v) {
  for (int i = 0; i < 3; i++) {
    double most = 0, sum = 0;
    for (int j = 0; j < 3; j++) {
      most = fmax(most, fabs(v->to_voxel[4 * i + j]));
      sum += fabs(v->to_voxel[4 * i + j]);
    }
    if (sum - most > 1e-12 * most) return false;
  }
  return true;
}

/// Share of the box in whole voxels that are inside, of an image parallel to the axes.
static double voxel_fraction(const LthImage *m, const Box *box) {
  const LthVolume *v = m->volume;
  double at[3], from[3], to[3], sum = 0, all = 1;
  LitheIndex first[3], last[3];
  lth_volume_locate(v, box->center, at);
  for (int i = 0; i < 3; i++) {
    double reach = 0;
    for (int j = 0; j < 3; j++) reach += fabs(v->to_voxel[4 * i + j]) * box->half[j];
    from[i] = at[i] - reach + 0.5;
    to[i] = at[i] + reach + 0.5;
    first[i] = (LitheIndex)fmin(fmax(floor(from[i]), 0), v->n[i] - 1);
    last[i] = (LitheIndex)fmin(fmax(floor(to[i]), 0), v->n[i] - 1);
    if (to[i] > from[i]) all *= to[i] - from[i];
  }
  for (LitheIndex k = first[2]; k <= last[2]; k++)
    for (LitheIndex j = first[1]; j <= last[1]; j++)
      for (LitheIndex i = first[0]; i <= last[0]; i++) {
        LitheIndex voxel[3] = {i, j, k};
        double share = 1;
        if (!(m->level[lth_volume_index(v, i, j, k)] < 0)) continue;
        for (int a = 0; a < 3; a++)
          if (to[a] > from[a])
            share *= fmax(0, fmin(to[a], voxel[a] + 1) - fmax(from[a], voxel[a]));
        sum += share;
      }
  return sum / all;
}

/// The plane nearby: signed distance of a box's middle, and unit gradient. False where there is none.
static bool find_plane(const LthProbe *p, const Box *box, double *d, double n[3]) {
  double step = INFINITY;
  for (int a = 0; a < 3; a++) step = fmin(step, box->half[a]);
  n[0] = n[1] = n[2] = 0;
  for (int a = 0; a < 3; a++) {
    double low[3], high[3];
    lth_v3_copy(box->center, low);
    lth_v3_copy(box->center, high);
    low[a] -= 0.5 * step;
    high[a] += 0.5 * step;
    n[a] = (lth_shape_value(p->shape, high) - lth_shape_value(p->shape, low)) / step;
  }
  double slope = lth_v3_normalize(n);
  *d = lth_shape_value(p->shape, box->center) / slope;
  return slope > 0 && isfinite(slope) && isfinite(*d);
}

static double samples_fraction(const LthProbe *p, const Box *box) {
  int n = 2, count = 0, all = n * n * n;
  double x[3];
  for (int s = 0; s < all; s++) {
    int place[3] = {s % n, s / n % n, s / (n * n)};
    for (int a = 0; a < 3; a++)
      x[a] = box->center[a] + box->half[a] * ((2 * place[a] + 1.0) / n - 1);
    count += lth_probe_inside(p, x);
  }
  return (double)count / all;
}

/// Piece q of the halves of a box.
static Box half_of(const Box *box, int q) {
  Box piece = {.place = -1, .depth = box->depth + 1};
  for (int a = 0; a < 3; a++) {
    piece.half[a] = 0.5 * box->half[a];
    piece.center[a] = box->center[a] + (q >> a & 1 ? piece.half[a] : -piece.half[a]);
  }
  return piece;
}

static double plane_fraction(const LthProbe *p, const Box *box) {
  double n[3], d;
  if (!find_plane(p, box, &d, n)) return samples_fraction(p, box);
  return lth_box_overlap_plane(box->half, n, d);
}

/// A plane's share is wrong by what grows with the square of the box: two sizes give a better one.
static double level_fraction(const LthProbe *p, const Box *box) {
  int n = 8;
  double whole = plane_fraction(p, box), halves = 0;
  for (int q = 0; q < n; q++) {
    Box piece = half_of(box, q);
    halves += plane_fraction(p, &piece) / n;
  }
  return fmin(fmax((4 * halves - whole) / 3, 0), 1);
}

static double halved(const Exact *e, const LthProbe *p, const Box *box) {
  int n = 8;
  double sum = 0;
  for (int q = 0; q < n; q++) {
    Box piece = half_of(box, q);
    sum += fraction(e, p, &piece);
  }
  return sum / n;
}

static double leaf_fraction(const Exact *e, const LthProbe *p, const Box *box) {
  const LthShape *s = p->shape;
  double low[3], high[3], volume, all = 1;
  const double *mesh = box->place >= 0 ? find_mesh(e, p) : NULL;
  if (mesh) return mesh[box->place];
  for (int a = 0; a < 3; a++) {
    low[a] = box->center[a] - box->half[a];
    high[a] = box->center[a] + box->half[a];
    all *= 2 * box->half[a];
  }
  if (lth_box_overlap(s, low, high, &volume)) return volume / all;
  if (s->kind == LTH_SHAPE_IMAGE && !s->image->is_smoothed && is_parallel(s->image->volume))
    return voxel_fraction(s->image, box);
  if (s->kind == LTH_SHAPE_WRAP) return lth_wrap_local_share(p->map, NULL, box->center, box->half);
  if (s->kind == LTH_SHAPE_IMAGE && !s->image->is_smoothed)
    return box->depth < LEAF_HALVINGS ? halved(e, p, box) : samples_fraction(p, box);
  return level_fraction(p, box);
}

/// --- several shapes in one box ---

/// Leaves of a tree in order, each a plane, or on one side of the box.
typedef struct Planes {
  int n;
  double d[PLANES_MAX], normal[PLANES_MAX][3]; ///< d = -INFINITY: inside
} Planes;

static bool find_planes(const LthProbe *p, const Box *box, Planes *planes) {
  if (p->shape->n_children > 0) {
    for (LitheIndex i = 0; i < p->shape->n_children; i++)
      if (!find_planes(&p->children[i], box, planes)) return false;
    return true;
  }
  if (planes->n == PLANES_MAX || p->shape->kind == LTH_SHAPE_WRAP ||
      (p->shape->kind == LTH_SHAPE_IMAGE && !p->shape->image->is_smoothed))
    return false;
  int i = planes->n++;
  LthSide side = lth_probe_side(p, box->center, box->half);
  memset(planes->normal[i], 0, sizeof planes->normal[i]);
  if (side == LTH_SIDE_MIXED) return find_plane(p, box, &planes->d[i], planes->normal[i]);
  planes->d[i] = side == LTH_SIDE_INSIDE ? -INFINITY : INFINITY;
  return true;
}

/// Value of the tree of planes at x, from the middle of the box; `at` runs over the leaves.
static double planes_value(const LthProbe *p, const Planes *planes, const double x[3], int *at) {
  const LthShape *s = p->shape;
  if (s->n_children == 0) {
    int i = (*at)++;
    return planes->d[i] + lth_v3_dot(planes->normal[i], x);
  }
  double value = 0;
  for (LitheIndex i = 0; i < s->n_children; i++) {
    double v = planes_value(&p->children[i], planes, x, at);
    if (i > 0 && s->kind == LTH_SHAPE_DIFFERENCE) v = -v;
    value = i == 0 ? v : s->kind == LTH_SHAPE_UNION ? fmin(value, v) : fmax(value, v);
  }
  return value;
}

/// Share of the line along an axis through x0 that is inside, exactly.
static double line_fraction(const LthProbe *p, const Planes *planes, const Box *box, int axis,
                            const double x0[3]) {
  double cut[PLANES_MAX + 2], sum = 0, half = box->half[axis];
  int n = 0;
  cut[n++] = -half;
  for (int i = 0; i < planes->n; i++) {
    double slope = planes->normal[i][axis];
    if (slope == 0) continue;
    double t = -(planes->d[i] + lth_v3_dot(planes->normal[i], x0)) / slope;
    if (!(t > -half && t < half)) continue;
    int k = n++;
    for (; cut[k - 1] > t; k--) cut[k] = cut[k - 1];
    cut[k] = t;
  }
  cut[n++] = half;
  for (int k = 0; k + 1 < n; k++) {
    double x[3];
    int at = 0;
    lth_v3_copy(x0, x);
    x[axis] = 0.5 * (cut[k] + cut[k + 1]);
    if (planes_value(p, planes, x, &at) <= 0) sum += cut[k + 1] - cut[k];
  }
  return sum / (2 * half);
}

/// Mean over lines along the axis that most planes cross best.
static double planes_fraction(const LthProbe *p, const Box *box, const Planes *planes) {
  double steep[3] = {0, 0, 0}, sum = 0;
  for (int i = 0; i < planes->n; i++)
    for (int a = 0; a < 3; a++) steep[a] += fabs(planes->normal[i][a]);
  int axis = 0;
  for (int a = 1; a < 3; a++)
    if (steep[a] > steep[axis]) axis = a;
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (int k = 0; k < LINES; k++)
    for (int j = 0; j < LINES; j++) {
      double x[3] = {0, 0, 0};
      x[u] = box->half[u] * ((2 * j + 1.0) / LINES - 1);
      x[v] = box->half[v] * ((2 * k + 1.0) / LINES - 1);
      sum += line_fraction(p, planes, box, axis, x);
    }
  return sum / (LINES * LINES);
}

/// What is left of a combination in a box: a number, one child that is mixed (`turned`: its outside counts), or more.
typedef struct Rest {
  double value;
  const LthProbe *child;
  bool turned;
  int n_mixed;
} Rest;

static Rest find_rest(const Exact *e, const LthProbe *p, const Box *box) {
  const LthShape *s = p->shape;
  bool is_union = s->kind == LTH_SHAPE_UNION;
  Rest rest = {.value = is_union ? 0 : 1};
  if (s->n_children == 0) rest.value = 0;
  for (LitheIndex i = 0; i < s->n_children; i++) {
    bool turned = s->kind == LTH_SHAPE_DIFFERENCE && i > 0;
    LthSide side = side_of(e, &p->children[i], box);
    if (side == LTH_SIDE_MIXED) {
      rest.child = &p->children[i];
      rest.turned = turned;
      rest.n_mixed++;
    } else if (((side == LTH_SIDE_INSIDE) != turned) == is_union) { // decides
      return (Rest){.value = is_union};
    }
  }
  return rest;
}

static double fraction(const Exact *e, const LthProbe *p, const Box *box) {
  LthSide side = side_of(e, p, box);
  if (side != LTH_SIDE_MIXED) return side == LTH_SIDE_INSIDE;
  if (p->shape->kind < LTH_SHAPE_UNION || p->shape->kind > LTH_SHAPE_DIFFERENCE)
    return leaf_fraction(e, p, box);
  Rest rest = find_rest(e, p, box);
  if (rest.n_mixed == 0) return rest.value;
  if (rest.n_mixed == 1) {
    double of_child = fraction(e, rest.child, box);
    return rest.turned ? 1 - of_child : of_child;
  }
  if (box->depth < HALVINGS) return halved(e, p, box);
  Planes planes = {.n = 0};
  if (!find_planes(p, box, &planes)) return samples_fraction(p, box);
  return planes_fraction(p, box, &planes);
}

/// --- rows ---

static LthSide exact_side(const void *self, const double center[3], const double half[3]) {
  const Exact *e = self;
  return lth_probe_side(e->probe, center, half);
}

static double exact_part(const void *self, const LthFractionFrame *f, const double low[3],
                         const int at[3]) {
  const Exact *e = self;
  Box box = {.place = lth_fraction_place(f, at[0], at[1], at[2])};
  for (int a = 0; a < 3; a++) {
    box.half[a] = 0.25 * f->h[a];
    box.center[a] = low[a] + 0.5 * f->h[a] * (at[a] + 0.5);
  }
  return fraction(e, e->probe, &box);
}

/// Parts of all surfaces in the tree.
static LitheStatus fill_meshes(Exact *e, LitheCtx *ctx, const LthProbe *p) {
  const LthShape *s = p->shape;
  for (LitheIndex i = 0; i < s->n_children; i++) LITHE_TRY(fill_meshes(e, ctx, &p->children[i]));
  if (!is_surface(s) || e->n_meshes == MESHES_MAX) return LITHE_OK;
  int i = e->n_meshes++;
  e->mesh[i] = p;
  LTH_NEW(ctx, e->part[i], (LitheCount)e->row->n * e->frame->block_cells * e->frame->n_parts);
  if (s->kind == LTH_SHAPE_WRAP)
    return lth_fraction_fill_wrap(ctx, p, 0, e->frame, e->row, e->part[i]);
  return lth_fraction_fill_surface(ctx, s, 0, e->frame, e->row, e->part[i]);
}

LitheStatus lth_fraction_fill_exact(const void *probe, LitheCtx *ctx, const LthFractionFrame *f,
                                    const LthFractionRow *row) {
  LitheStatus status = LITHE_OK;
  Exact e = {.probe = probe, .frame = f, .row = row};
  LthFractionFiller filler = {.self = &e, .side = exact_side};
  const LthShape *shape = e.probe->shape;
  if (shape->kind == LTH_SHAPE_MESH && shape->bvh)
    return lth_fraction_fill_surface(ctx, shape, 0, f, row, row->part);
  if (shape->kind == LTH_SHAPE_WRAP)
    return lth_fraction_fill_wrap(ctx, probe, 0, f, row, row->part);
  LITHE_TRY_OR(done, fill_meshes(&e, ctx, e.probe));
  for (e.m = 0; e.m < row->n; e.m++) {
    double low[3];
    lth_fraction_corner(f, row->at[e.m], row->j, row->k, low);
    lth_fraction_halve(&filler, exact_part, 2, f, low,
                       row->part + (LitheCount)e.m * f->block_cells * f->n_parts);
  }
done:
  for (int i = 0; i < e.n_meshes; i++) lth_free(ctx, e.part[i]);
  return status;
}

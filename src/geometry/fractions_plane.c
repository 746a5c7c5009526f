/// Exact fractions in the plane: a part is cut along straight sides into convex cells until shapes decide, or until
/// one circle is left, whose area in a convex cell has a closed form (docs/theory/fractions-plane.md).
#include "geometry/fractions_plane.h"

#include "base/tensor.h"
#include "geometry/fractions_fill.h"

#define DEPTH_MEET 44  ///< halvings of a cell in which two circles meet
#define DEPTH_CURVED 8 ///< of one in which something else is curved: by then it counts as straight
#define WORK_MAX 1500  ///< cells that a part may be cut into before depth is given up
#define CORNERS_MAX 30 ///< of cells that are cut along sides
#define LINES_MAX 16   ///< curved things in one cell
#define ROUNDING 0x1p-48 ///< of coordinates: what passes through less of a cell does not pass

/// What is known of a part while it is cut.
typedef struct Cutter {
  double tolerance; ///< [m]
  int work, depth_meet;
} Cutter;

/// A curved leaf of the tree and the line that stands for it.
typedef struct Tangent {
  const LthProbe *leaf;
  LthLine line;
} Tangent;

/// What a look at a cell finds.
typedef struct Finding {
  const Cutter *cutter;
  const LthConvex *cell;
  const Tangent *tangents; ///< in the place of curved leaves, NULL: none
  int n_tangents;
  bool has_line;
  LthLine line; ///< a straight side that passes through the cell
  int n_curved;
  const LthProbe *curved[LINES_MAX]; ///< leaves with curved sides in the cell
  bool is_outside;                   ///< of the last: what is inside it is outside the tree's shape
} Finding;

/// Does the line pass through the cell? If so, it is kept. Otherwise where the cell lies.
static LthSide line_side(Finding *f, const LthLine *line) {
  double low, high;
  lth_convex_range(f->cell, line, &low, &high);
  if (high <= f->cutter->tolerance) return LTH_SIDE_INSIDE;
  if (low >= -f->cutter->tolerance) return LTH_SIDE_OUTSIDE;
  if (!f->has_line) f->line = *line;
  f->has_line = true;
  return LTH_SIDE_MIXED;
}

static LthSide box_side(Finding *f, const LthShape *s) {
  LthSide side = LTH_SIDE_INSIDE;
  for (int k = 0; k < 4; k++) {
    int axis = k / 2, sign = k % 2 ? 1 : -1;
    LthLine line = {.offset = sign > 0 ? s->b[axis] : -s->a[axis]};
    line.normal[axis] = sign;
    bool had_line = f->has_line;
    LthSide of_line = line_side(f, &line);
    if (of_line == LTH_SIDE_OUTSIDE) {
      f->has_line = had_line; // of another side, which does not matter any more
      return LTH_SIDE_OUTSIDE;
    }
    if (of_line == LTH_SIDE_MIXED) side = LTH_SIDE_MIXED;
  }
  return side;
}

/// --- polygons ---

typedef struct EdgeSearch {
  Finding *finding;
  const LthLoops *loops;
  bool is_found;
} EdgeSearch;

static bool visit_edge(void *self, LitheIndex i) {
  EdgeSearch *e = self;
  const LthLoops *l = e->loops;
  const double *p = l->points + 2 * (size_t)i, *q = l->points + 2 * (size_t)l->next[i];
  double length = hypot(q[0] - p[0], q[1] - p[1]);
  LthLine line = {.normal = {(q[1] - p[1]) / length, (p[0] - q[0]) / length}};
  line.offset = line.normal[0] * p[0] + line.normal[1] * p[1];
  double low, high;
  lth_convex_range(e->finding->cell, &line, &low, &high);
  if (low >= -e->finding->cutter->tolerance || high <= e->finding->cutter->tolerance) return true;
  if (!(lth_convex_chord(e->finding->cell, p, q) > e->finding->cutter->tolerance)) return true;
  e->is_found = true;
  line_side(e->finding, &line);
  return false;
}

static LthSide polygon_side(Finding *f, const LthShape *s) {
  double min[2], max[2], middle[3] = {0, 0, 0};
  EdgeSearch e = {.finding = f, .loops = s->loops};
  lth_convex_bounds(f->cell, min, max);
  for (int a = 0; a < 2; a++) middle[a] = min[a] + (max[a] - min[a]) / 2;
  double reach = hypot(max[0] - min[0], max[1] - min[1]) * (0.5 + 1e-9);
  lth_bvh_visit(s->loops->bvh, middle, reach, visit_edge, &e);
  if (e.is_found) return LTH_SIDE_MIXED;
  lth_convex_middle(f->cell, middle);
  return lth_loops_distance(s->loops, middle, NULL, NULL) <= 0 ? LTH_SIDE_INSIDE : LTH_SIDE_OUTSIDE;
}

/// --- images ---

/// A side of a voxel in the cell: the one in the middle of those that pass through, along the first axis that
/// has any.
static LthSide image_side(Finding *f, const LthProbe *p) {
  const LthVolume *v = p->shape->image->volume;
  double min[2], max[2], center[3] = {0, 0, 0}, half[3] = {0, 0, 0};
  lth_convex_bounds(f->cell, min, max);
  for (int a = 0; a < 2; a++) {
    half[a] = (max[a] - min[a]) / 2;
    center[a] = min[a] + half[a];
  }
  LthSide side = lth_probe_side(p, center, half);
  if (side != LTH_SIDE_MIXED) return side;
  for (int a = 0; a < 2; a++) {
    // voxel coordinate a of x is slope . x + constant
    const double *row = v->to_voxel + 4 * a;
    double length = hypot(row[0], row[1]);
    LthLine line = {.normal = {row[0] / length, row[1] / length}};
    double low, high;
    lth_convex_range(f->cell, &line, &low, &high);
    double first = ceil(low * length + row[3] + 0.5 + length * f->cutter->tolerance),
           last = floor(high * length + row[3] + 0.5 - length * f->cutter->tolerance);
    first = fmax(first, 0), last = fmin(last, v->n[a]);
    if (first > last) continue;
    line.offset = (floor((first + last) / 2) - 0.5 - row[3]) / length;
    if (line_side(f, &line) == LTH_SIDE_MIXED) return LTH_SIDE_MIXED;
  }
  lth_convex_middle(f->cell, center);
  return lth_probe_inside(p, center) ? LTH_SIDE_INSIDE : LTH_SIDE_OUTSIDE;
}

/// --- curved leaves ---

static LthSide circles_side(const Finding *f, const LthShape *s) {
  double low, high, tolerance = f->cutter->tolerance;
  lth_convex_distances(f->cell, s->a, &low, &high);
  bool has_hole = s->kind == LTH_SHAPE_ANNULUS;
  if (low >= s->radius - tolerance || (has_hole && high <= s->inner + tolerance))
    return LTH_SIDE_OUTSIDE;
  bool is_in = high <= s->radius + tolerance && (!has_hole || low >= s->inner - tolerance);
  return is_in ? LTH_SIDE_INSIDE : LTH_SIDE_MIXED;
}

static LthSide other_side(const Finding *f, const LthProbe *p) {
  double min[2], max[2], center[3] = {0, 0, 0}, half[3] = {0, 0, 0};
  lth_convex_bounds(f->cell, min, max);
  for (int a = 0; a < 2; a++) {
    half[a] = (max[a] - min[a]) / 2;
    center[a] = min[a] + half[a];
  }
  return lth_probe_side(p, center, half);
}

static LthSide curved_side(Finding *f, const LthProbe *p, bool is_outside) {
  for (int k = 0; k < f->n_tangents; k++)
    if (f->tangents[k].leaf == p) return line_side(f, &f->tangents[k].line);
  if (f->n_tangents > 0) { // it did not pass through the whole
    double middle[3] = {0, 0, 0};
    lth_convex_middle(f->cell, middle);
    return lth_probe_inside(p, middle) ? LTH_SIDE_INSIDE : LTH_SIDE_OUTSIDE;
  }
  bool is_round = p->shape->kind == LTH_SHAPE_DISK || p->shape->kind == LTH_SHAPE_ANNULUS;
  LthSide side = is_round ? circles_side(f, p->shape) : other_side(f, p);
  if (side != LTH_SIDE_MIXED) return side;
  if (f->n_curved < LINES_MAX) f->curved[f->n_curved] = p;
  f->n_curved++;
  f->is_outside = is_outside;
  return side;
}

/// --- trees ---

static LthSide look(Finding *f, const LthProbe *p, bool is_outside);

static LthSide look_at_children(Finding *f, const LthProbe *p, LthSide decides, bool is_outside) {
  LthSide side = decides == LTH_SIDE_INSIDE ? LTH_SIDE_OUTSIDE : LTH_SIDE_INSIDE;
  bool is_difference = p->shape->kind == LTH_SHAPE_DIFFERENCE;
  Finding before = *f;
  for (LitheIndex i = 0; i < p->shape->n_children; i++) {
    bool is_taken = is_difference && i > 0;
    LthSide of_child = look(f, &p->children[i], is_outside != is_taken);
    if (is_taken && of_child != LTH_SIDE_MIXED)
      of_child = of_child == LTH_SIDE_INSIDE ? LTH_SIDE_OUTSIDE : LTH_SIDE_INSIDE;
    if (of_child == decides) { // what the others are does not matter
      *f = before;
      return decides;
    }
    if (of_child == LTH_SIDE_MIXED) side = LTH_SIDE_MIXED;
  }
  return p->shape->n_children > 0 ? side : LTH_SIDE_OUTSIDE;
}

static LthSide look(Finding *f, const LthProbe *p, bool is_outside) {
  switch (p->shape->kind) {
  case LTH_SHAPE_UNION:
    return look_at_children(f, p, LTH_SIDE_INSIDE, is_outside);
  case LTH_SHAPE_INTERSECTION:
  case LTH_SHAPE_DIFFERENCE:
    return look_at_children(f, p, LTH_SIDE_OUTSIDE, is_outside);
  case LTH_SHAPE_BOX:
    return box_side(f, p->shape);
  case LTH_SHAPE_POLYGON:
    return polygon_side(f, p->shape);
  case LTH_SHAPE_IMAGE:
    if (!p->shape->image->is_smoothed) return image_side(f, p);
    return curved_side(f, p, is_outside);
  default:
    return curved_side(f, p, is_outside);
  }
}

/// --- areas ---

static double area_of(Cutter *c, const LthProbe *p, const LthConvex *cell, int depth,
                      const Tangent *tangents, int n_tangents);

static double cut_area(Cutter *c, const LthProbe *p, const LthConvex *cell, const LthLine *line,
                       int depth, const Tangent *tangents, int n_tangents) {
  LthConvex half[2];
  double area = 0;
  lth_convex_cut(cell, line, &half[0], &half[1]);
  for (int k = 0; k < 2; k++)
    if (half[k].n) area += area_of(c, p, &half[k], depth, tangents, n_tangents);
  return area;
}

/// The line that halves a cell across its longer extent.
static LthLine middle_line(const LthConvex *cell) {
  double min[2], max[2], middle[2];
  lth_convex_bounds(cell, min, max);
  lth_convex_middle(cell, middle);
  int axis = max[1] - min[1] > max[0] - min[0];
  LthLine line = {.offset = middle[axis]};
  line.normal[axis] = 1;
  return line;
}

/// The line that stands for a curved leaf in a cell: through its nearest boundary, to first order.
static bool tangent(const LthProbe *leaf, const LthConvex *cell, LthLine *line) {
  double min[2], max[2], x[3] = {0, 0, 0};
  lth_convex_bounds(cell, min, max);
  lth_convex_middle(cell, x);
  double step = 0.25 * fmax(max[0] - min[0], max[1] - min[1]), slope[2];
  for (int a = 0; a < 2; a++) {
    double low[3] = {x[0], x[1], 0}, high[3] = {x[0], x[1], 0};
    low[a] -= step, high[a] += step;
    slope[a] =
        (lth_shape_value(leaf->shape, high) - lth_shape_value(leaf->shape, low)) / (2 * step);
  }
  double length = hypot(slope[0], slope[1]);
  if (!(length > 0) || !isfinite(length)) return false;
  for (int a = 0; a < 2; a++) line->normal[a] = slope[a] / length;
  line->offset =
      line->normal[0] * x[0] + line->normal[1] * x[1] - lth_shape_value(leaf->shape, x) / length;
  return true;
}

/// A cell so small that curved sides count as straight.
static double straight_area(Cutter *c, const LthProbe *p, const LthConvex *cell, const Finding *f) {
  Tangent tangents[LINES_MAX];
  bool is_good = f->n_curved <= LINES_MAX;
  for (int k = 0; k < f->n_curved && is_good; k++) {
    tangents[k].leaf = f->curved[k];
    is_good = tangent(f->curved[k], cell, &tangents[k].line);
  }
  if (is_good) return area_of(c, p, cell, 0, tangents, f->n_curved);
  double middle[3] = {0, 0, 0};
  lth_convex_middle(cell, middle);
  return lth_probe_inside(p, middle) ? lth_convex_area(cell) : 0;
}

/// Only one circle or annulus passes through.
static double round_area(const LthShape *s, const LthConvex *cell) {
  double area = lth_convex_disk(cell, s->a, s->radius);
  return s->kind == LTH_SHAPE_ANNULUS ? area - lth_convex_disk(cell, s->a, s->inner) : area;
}

static double area_of(Cutter *c, const LthProbe *p, const LthConvex *cell, int depth,
                      const Tangent *tangents, int n_tangents) {
  Finding f = {.cutter = c, .cell = cell, .tangents = tangents, .n_tangents = n_tangents};
  c->work++;
  LthSide side = look(&f, p, false);
  if (side == LTH_SIDE_OUTSIDE) return 0;
  if (side == LTH_SIDE_INSIDE) return lth_convex_area(cell);
  if (f.has_line && cell->n <= CORNERS_MAX)
    return cut_area(c, p, cell, &f.line, depth, tangents, n_tangents);
  LthLine middle = middle_line(cell);
  if (f.has_line) return cut_area(c, p, cell, &middle, depth, tangents, n_tangents);
  const LthShape *leaf = f.curved[0]->shape;
  bool is_round = leaf->kind == LTH_SHAPE_DISK || leaf->kind == LTH_SHAPE_ANNULUS;
  if (f.n_curved == 1 && is_round) {
    double area = round_area(leaf, cell);
    return f.is_outside ? lth_convex_area(cell) - area : area;
  }
  bool all_round = true;
  for (int k = 0; k < f.n_curved && k < LINES_MAX; k++)
    all_round = all_round && (f.curved[k]->shape->kind == LTH_SHAPE_DISK ||
                              f.curved[k]->shape->kind == LTH_SHAPE_ANNULUS);
  int deepest = all_round ? c->depth_meet : DEPTH_CURVED;
  if (depth >= deepest || (c->work > WORK_MAX && depth >= DEPTH_CURVED))
    return straight_area(c, p, cell, &f);
  return cut_area(c, p, cell, &middle, depth + 1, tangents, n_tangents);
}

double lth_plane_area(const LthProbe *p, const double min[2], const double max[2]) {
  const LthShape *s = p->shape;
  LthConvex box = lth_convex_box(min, max);
  if (s->kind == LTH_SHAPE_POLYGON) return lth_loops_area(s->loops, min, max);
  if (s->kind == LTH_SHAPE_DISK || s->kind == LTH_SHAPE_ANNULUS) return round_area(s, &box);
  double largest = 0;
  for (int a = 0; a < 2; a++) largest = fmax(largest, fmax(fabs(min[a]), fabs(max[a])));
  Cutter c = {.tolerance = ROUNDING * largest, .depth_meet = DEPTH_MEET};
  double area = area_of(&c, p, &box, 0, NULL, 0);
  if (c.work <= WORK_MAX) return area;
  c = (Cutter){.tolerance = c.tolerance, .depth_meet = DEPTH_CURVED}; // circles side by side
  return area_of(&c, p, &box, 0, NULL, 0);
}

/// --- fractions ---

static LthSide plane_side(const void *probe, const double center[3], const double half[3]) {
  return lth_probe_side(probe, center, half);
}

static double plane_part(const void *probe, const LthFractionFrame *f, const double low[3],
                         const int at[3]) {
  double min[2], max[2];
  for (int a = 0; a < 2; a++) {
    min[a] = low[a] + 0.5 * f->h[a] * at[a];
    max[a] = low[a] + 0.5 * f->h[a] * (at[a] + 1);
  }
  return lth_plane_area(probe, min, max) / ((max[0] - min[0]) * (max[1] - min[1]));
}

static LitheStatus fill_plane(const void *probe, LitheCtx *ctx, const LthFractionFrame *f,
                              const LthFractionRow *row) {
  LthFractionFiller filler = {.self = probe, .side = plane_side};
  (void)ctx;
  for (LitheIndex m = 0; m < row->n; m++) {
    double low[3];
    lth_fraction_corner(f, row->at[m], row->j, row->k, low);
    lth_fraction_halve(&filler, plane_part, 1, f, low,
                       row->part + (LitheCount)m * f->block_cells * f->n_parts);
  }
  return LITHE_OK;
}

LthFractionFiller lth_fraction_plane_filler(const LthProbe *probe) {
  return (LthFractionFiller){probe, plane_side, fill_plane};
}

/// Smooth fractions of a shape that goes on beyond planes of symmetry: its signed distance without the sides that lie in them.
#include "geometry/fractions_mirror.h"

#include "base/tensor.h"
#include "geometry/fractions_complete.h"
#include "geometry/fractions_fill.h"
#include "geometry/shape_foot.h"

#define SAME 1e-3    ///< of the width: lengths that are equal
#define DEEPER 1.5   ///< of the width: the second place that a distance is continued from
#define MIRRORS 3    ///< that meet in a point
#define IN_PLANE 0.5 ///< of a part: half its length

typedef struct Mirrored {
  const LthFractions *fractions;
  LthSmoother smoother;
  const LthMirror *mirrors;
  LitheIndex n_mirrors;
  double scale; ///< shortest edge of a cell [m]
} Mirrored;

/// Depth behind the plane of a mirror, negative beyond it.
static double depth_of(const LthMirror *m, const double x[3]) {
  return m->sign * (m->place - x[m->axis]);
}

static void move_to(const LthMirror *m, double depth, const double x[3], double y[3]) {
  lth_v3_copy(x, y);
  y[m->axis] = m->place - m->sign * depth;
}

static double distance_at(const Mirrored *s, const double x[3]) {
  return lth_probe_distance(s->smoother.probe, x, s->smoother.dim, s->smoother.step);
}

/// Is the place of a mirror's plane beside x one of its side, or (`or_edge`) what is nearest to that place an edge of the side?
static bool faces(const Mirrored *s, const LthMirror *m, const double x[3], bool or_edge) {
  const LthShape *shape = s->smoother.probe->shape;
  double tolerance = SAME * s->smoother.width, p[3];
  LthFoot foot;
  move_to(m, 0, x, p);
  double value = lth_shape_value(shape, p);
  if (value > tolerance && or_edge) {
    if (!lth_shape_foot(shape, p, s->scale, &foot)) return false;
    move_to(m, 0, foot.point, p);
    value = fabs(depth_of(m, foot.point));
  }
  return fabs(value) <= tolerance && m->contains(m->self, p);
}

/// Signed distance of the continued shape at x behind the mirrors. Near a mirror the side itself is what is nearest, and hides what
/// is behind it; deeper by the width it does not, and what is even in the depth is continued from there.
static double mirrored_distance(const Mirrored *s, const double x[3], int n_left) {
  double d = distance_at(s, x), width = s->smoother.width, y[3];
  for (LitheIndex k = 0; k < s->n_mirrors && n_left > 0; k++) {
    const LthMirror *m = &s->mirrors[k];
    double t = depth_of(m, x);
    if (t < -SAME * width || t >= (1 - SAME) * width || fabs(d + t) > SAME * width) continue;
    if (!faces(s, m, x, false)) continue;
    move_to(m, width, x, y);
    double near = mirrored_distance(s, y, n_left - 1);
    if (near <= -(1 - SAME) * width) return -width;
    move_to(m, DEEPER * width, x, y);
    double far = mirrored_distance(s, y, n_left - 1);
    double slope = (far - near) / (DEEPER * DEEPER - 1);
    return near + (t * t / (width * width) - 1) * slope;
  }
  return d;
}

/// Fraction of a part with its middle at x; `value` is what it was.
static double part_at(const Mirrored *s, const double x[3], double value) {
  const double *h = s->fractions->grid->h;
  double share = 1, y[3];
  bool is_near = false;
  lth_v3_copy(x, y);
  for (LitheIndex k = 0; k < s->n_mirrors; k++) {
    const LthMirror *m = &s->mirrors[k];
    double t = depth_of(m, x), half = IN_PLANE * h[m->axis] / 2;
    if (fabs(t) >= s->smoother.width + half) continue;
    is_near = true;
    if (t >= half * (1 - SAME)) continue;
    if (t < 0 && distance_at(s, x) <= 0) continue;
    if (!faces(s, m, x, true)) continue;
    share *= fmax(0, 0.5 + 0.5 * t / half);
    if (share < SAME) return 0;
    move_to(m, fabs(t), y, y);
  }
  if (!is_near) return value;
  return share * lth_fraction_profile(mirrored_distance(s, y, MIRRORS) / s->smoother.width);
}

static void change_parts(const void *mirrored, LitheCount slot, double *part) {
  const Mirrored *s = mirrored;
  const LthFractions *f = s->fractions;
  const LthSparseGrid *g = f->grid;
  LitheIndex at[3];
  if (f->cell[slot] < LTH_CELL_CUT) return;
  lth_sparse_grid_cell(g, slot, at);
  for (int q = 0; q < f->n_parts; q++) {
    double x[3] = {0}, offset[3];
    for (int a = 0; a < 3; a++) offset[a] = q >> a & 1 ? 0.75 : 0.25;
    lth_sparse_grid_place(g, at, offset, x);
    if (g->dim == 2) x[2] = 0;
    part[q] = part_at(s, x, part[q]);
  }
}

LitheStatus lth_fractions_mirror(LitheCtx *ctx, LthFractions *fractions, const LthShape *shape,
                                 const LthFractionDef *def, const LthMirror *mirrors,
                                 LitheIndex n_mirrors) {
  LitheStatus status = LITHE_OK;
  const LthSparseGrid *g = fractions->grid;
  Mirrored s = {.fractions = fractions, .mirrors = mirrors, .n_mirrors = n_mirrors};
  LthProbe *probe = NULL;
  LthFractions before = {0};
  s.scale = fmin(g->h[0], g->dim == 3 ? fmin(g->h[1], g->h[2]) : g->h[1]);
  LITHE_TRY_OR(done, lth_probe_create(ctx, shape, s.scale, &probe));
  s.smoother = lth_fraction_smoother(probe, def, g->dim, g->h);
  LITHE_TRY_OR(done, lth_fractions_change(ctx, fractions, change_parts, &s, &before));
done:
  lth_fractions_forget(ctx, &before);
  lth_probe_destroy(ctx, &probe);
  return status;
}

/// The loops of pieces to connected parts: outer loops with their holes.
#include "mesh/slice.h"

#include "base/tensor.h"

#include <math.h>

/// A loop whose area is below this share of its squared length has no inside worth telling from its
/// outside: it is neither a hole nor has it any.
#define FLAT_LOOP 1e-14

void lth_slice_free_parts(LitheCtx *ctx, SliceParts *parts) {
  lth_free(ctx, parts->piece);
  lth_free(ctx, parts->loop_off);
  lth_free(ctx, parts->off);
  lth_free(ctx, parts->point);
  lth_free(ctx, parts->area);
  *parts = (SliceParts){0};
}

/// The loops of one piece while they are sorted into parts.
typedef struct CapLoop {
  LitheIndex first, n; ///< points, copied out of the parts' list
  double area;         ///< signed; 0 where it is flat
  LitheIndex outer;    ///< loop that holds this one, itself for an outer loop
} CapLoop;

static double loop_length(const double *points, const LitheIndex *loop, LitheIndex n) {
  double length = 0;
  for (LitheIndex i = 0; i < n; i++)
    length += lth_v3_distance(points + 3 * (LitheCount)loop[i],
                              points + 3 * (LitheCount)loop[i + 1 < n ? i + 1 : 0]);
  return length;
}

/// True if x is inside the loop, by counting the edges to its right (half-open in v).
static bool is_inside(const double *points, const LitheIndex *loop, LitheIndex n, int axis,
                      const double *x) {
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  bool inside = false;
  for (LitheIndex i = 0; i < n; i++) {
    const double *a = points + 3 * (LitheCount)loop[i];
    const double *b = points + 3 * (LitheCount)loop[i + 1 < n ? i + 1 : 0];
    if ((a[v] > x[v]) == (b[v] > x[v])) continue;
    double at = a[u] + (x[v] - a[v]) / (b[v] - a[v]) * (b[u] - a[u]);
    if (at > x[u]) inside = !inside;
  }
  return inside;
}

/// True if most corners of the hole are inside the loop: one that touches it may round to either side.
static bool holds(const Slicer *s, const LitheIndex *point, int axis, const CapLoop *outer,
                  const CapLoop *hole) {
  LitheIndex n_inside = 0;
  for (LitheIndex i = 0; i < hole->n; i++)
    n_inside += is_inside(s->point, point + outer->first, outer->n, axis,
                          s->point + 3 * (LitheCount)point[hole->first + i]);
  return 2 * n_inside > hole->n;
}

/// Find the outer loop of each hole: the only one, or the smallest that holds it.
static void assign_holes(const Slicer *s, const LitheIndex *point, int axis, CapLoop *loop,
                         LitheIndex n) {
  LitheIndex n_outer = 0;
  for (LitheIndex i = 0; i < n; i++) n_outer += loop[i].area > 0;
  for (LitheIndex i = 0; i < n; i++) {
    loop[i].outer = i;
    if (loop[i].area >= 0) continue;
    for (LitheIndex j = 0; j < n; j++) {
      bool is_best = loop[i].outer == i || loop[j].area < loop[loop[i].outer].area;
      if (loop[j].area > 0 && is_best &&
          (n_outer == 1 || holds(s, point, axis, loop + j, loop + i)))
        loop[i].outer = j;
    }
  }
}

static LitheStatus begin_part(Slicer *s, LitheIndex piece) {
  SliceParts *parts = &s->parts;
  if (parts->n >= INT32_MAX / 2 - 1)
    LITHE_FAIL(s->ctx, LITHE_UNSUPPORTED, "slicing: more than 2^30 face pieces; use larger cells");
  LTH_RESERVE(s->ctx, parts->loop_off, parts->loop_off_cap, parts->n + 2);
  LTH_RESERVE(s->ctx, parts->area, parts->area_cap, parts->n + 1);
  LTH_RESERVE(s->ctx, parts->piece, parts->cap, parts->n + 1);
  parts->piece[parts->n++] = piece;
  return LITHE_OK;
}

static void end_part(Slicer *s) {
  SliceParts *parts = &s->parts;
  LitheIndex first = parts->loop_off[parts->n - 1];
  double sum[3] = {0, 0, 0};
  for (LitheIndex l = first; l < parts->n_loops; l++) {
    double vector[3];
    lth_slice_area_vector(s->point, parts->point + parts->off[l], parts->off[l + 1] - parts->off[l],
                          vector);
    lth_v3_add(sum, vector, sum);
  }
  parts->area[parts->n - 1] = lth_v3_norm(sum);
  parts->loop_off[parts->n] = (LitheIndex)parts->n_loops;
}

static LitheStatus write_loop(Slicer *s, const LitheIndex *point, const CapLoop *loop) {
  for (LitheIndex i = 0; i < loop->n; i++)
    LITHE_TRY(lth_slice_add_loop_point(s, point[loop->first + i]));
  return lth_slice_end_loop(s);
}

/// Write loops back in the order of parts: each outer loop and then its holes.
static LitheStatus write_parts(Slicer *s, LitheIndex piece, const LitheIndex *point,
                               const CapLoop *loop, LitheIndex n) {
  for (LitheIndex i = 0; i < n; i++) {
    if (loop[i].outer != i) continue;
    LITHE_TRY(begin_part(s, piece));
    LITHE_TRY(write_loop(s, point, loop + i));
    for (LitheIndex j = 0; j < n; j++)
      if (j != i && loop[j].outer == i) LITHE_TRY(write_loop(s, point, loop + j));
    end_part(s);
  }
  return LITHE_OK;
}

/// Area of a loop that tells an outer loop from a hole; 0 where it is flat. A triangle's pieces are
/// convex: where rounding gives one several loops, each of them is taken for itself.
static double decisive_area(const Slicer *s, const LitheIndex *loop, LitheIndex n, int axis) {
  if (axis == SLICE_BOUNDARY) return 0;
  double area = lth_slice_loop_area(s->point, loop, n, axis),
         length = loop_length(s->point, loop, n);
  return fabs(area) > FLAT_LOOP * length * length ? area : 0;
}

/// Regroup the loops that were just traced of a piece: `first` is the first of them.
static LitheStatus group_loops(Slicer *s, LitheIndex piece, LitheIndex first) {
  SliceParts *parts = &s->parts;
  int axis = s->pieces.piece[piece].axis;
  LitheIndex n = (LitheIndex)parts->n_loops - first, base = parts->off[first];
  LitheIndex *point = NULL;
  CapLoop *loop = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, s->ctx, point, parts->n_points - base);
  LTH_NEW_OR(done, s->ctx, loop, n);
  for (LitheIndex i = base; i < parts->n_points; i++) point[i - base] = parts->point[i];
  for (LitheIndex i = 0; i < n; i++) {
    CapLoop *l = loop + i;
    l->first = parts->off[first + i] - base;
    l->n = parts->off[first + i + 1] - base - l->first;
    l->area = decisive_area(s, point + l->first, l->n, axis);
  }
  assign_holes(s, point, axis, loop, n);
  parts->n_loops = first;
  parts->n_points = base;
  LITHE_TRY_OR(done, write_parts(s, piece, point, loop, n));
done:
  lth_free(s->ctx, point);
  lth_free(s->ctx, loop);
  return status;
}

static LitheStatus make_part(Slicer *s, LitheIndex p) {
  const SlicePiece *piece = s->pieces.piece + p;
  if (piece->count == 0) return LITHE_OK;
  LitheIndex first = (LitheIndex)s->parts.n_loops;
  LITHE_TRY(lth_slice_trace(s, piece->axis, s->pieces.edge + 2 * piece->first, piece->count));
  if (s->parts.n_loops > first + 1) return group_loops(s, p, first);
  LITHE_TRY(begin_part(s, p));
  end_part(s);
  return LITHE_OK;
}

LitheStatus lth_slice_make_parts(Slicer *s) {
  LTH_RESERVE(s->ctx, s->parts.off, s->parts.off_cap, 2);
  LTH_RESERVE(s->ctx, s->parts.loop_off, s->parts.loop_off_cap, 2);
  for (LitheIndex p = 0; p < s->pieces.n; p++) {
    if (p % 65536 == 0 && lth_cancelled(s->ctx))
      LITHE_FAIL(s->ctx, LITHE_INTERRUPTED, "interrupted");
    LITHE_TRY(make_part(s, p));
  }
  return LITHE_OK;
}

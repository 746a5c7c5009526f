/// Chains of directed edges in a plane to loops, and loops to connected parts: outer loops with their holes.
/// As slice_trace.c and slice_loops.c, for planes of any direction.
#include "mesh/topology_priv.h"

#include <stdlib.h>

/// A loop whose area is below this share of its squared length has no inside: it is a part of its own.
#define FLAT_LOOP 1e-14

LitheStatus lth_topology_chain_add(LitheCtx *ctx, TopologyChain *chain, LitheIndex from,
                                   LitheIndex to) {
  if (from == to) return LITHE_OK;
  LTH_RESERVE(ctx, chain->edge, chain->cap, 2 * (chain->n + 1));
  chain->edge[2 * chain->n] = from;
  chain->edge[2 * chain->n + 1] = to;
  chain->n++;
  return LITHE_OK;
}

static int compare_undirected(const void *a, const void *b) {
  const LitheIndex *x = a, *y = b;
  uint64_t i = lth_topology_edge_key(x[0], x[1]), j = lth_topology_edge_key(y[0], y[1]);
  if (i != j) return i < j ? -1 : 1;
  return (x[0] > y[0]) - (x[0] < y[0]);
}

void lth_topology_cancel(TopologyChain *chain) {
  LitheIndex *edge = chain->edge;
  LitheCount kept = 0, n = chain->n;
  if (n == 0) return;
  qsort(edge, (size_t)n, 2 * sizeof *edge, compare_undirected);
  for (LitheCount i = 0, j; i < n; i = j) {
    uint64_t key = lth_topology_edge_key(edge[2 * i], edge[2 * i + 1]);
    LitheIndex winding = 0, low = (LitheIndex)(key >> 32), high = (LitheIndex)(uint32_t)key;
    for (j = i; j < n && lth_topology_edge_key(edge[2 * j], edge[2 * j + 1]) == key; j++)
      winding += edge[2 * j] == low ? 1 : -1;
    for (; winding != 0; winding += winding > 0 ? -1 : 1, kept++) {
      edge[2 * kept] = winding > 0 ? low : high;
      edge[2 * kept + 1] = winding > 0 ? high : low;
    }
  }
  chain->n = kept;
}

/// Edges of one chain in the order of their starts, and the axes of the plane.
typedef struct Tracer {
  const LthTopology *t;
  LitheIndex *edge; ///< from, to, 1 for a divider (n x 3)
  bool *used;
  LitheIndex n;
  int u, v;
} Tracer;

static int compare_starts(const void *a, const void *b) {
  const LitheIndex *x = a, *y = b;
  for (int i = 0; i < 3; i++)
    if (x[i] != y[i]) return x[i] < y[i] ? -1 : 1;
  return 0;
}

static LitheIndex first_from(const Tracer *r, LitheIndex point) {
  LitheIndex lo = 0, hi = r->n;
  while (lo < hi) {
    LitheIndex mid = (lo + hi) / 2;
    if (r->edge[3 * mid] < point)
      lo = mid + 1;
    else
      hi = mid;
  }
  return lo;
}

/// Clockwise angle from looking back along a b to looking on along b c, in (0, 2 pi].
static double turn(const Tracer *r, LitheIndex a, LitheIndex b, LitheIndex c) {
  const double *p = r->t->points;
  double in[3], out[3];
  lth_v3_sub(p + 3 * (LitheCount)a, p + 3 * (LitheCount)b, in);
  lth_v3_sub(p + 3 * (LitheCount)c, p + 3 * (LitheCount)b, out);
  double angle = atan2(out[r->u] * in[r->v] - out[r->v] * in[r->u],
                       out[r->u] * in[r->u] + out[r->v] * in[r->v]);
  return angle > 0 ? angle : angle + 2 * M_PI;
}

/// The edge to follow, the sharpest left turn; -1 where the loop that began with `start` closes.
static LitheIndex next_edge(const Tracer *r, LitheIndex e, LitheIndex start) {
  LitheIndex at = r->edge[3 * e + 1], first = first_from(r, at), best = start;
  double best_turn = INFINITY;
  for (LitheIndex i = first; i < r->n && r->edge[3 * i] == at; i++) {
    if (r->used[i] && i != start) continue;
    bool is_only = i == first && (i + 1 == r->n || r->edge[3 * i + 3] != at);
    double angle = is_only ? 0 : turn(r, r->edge[3 * e], at, r->edge[3 * i + 1]);
    if (angle >= best_turn) continue;
    best_turn = angle;
    best = i;
  }
  return best == start ? -1 : best;
}

/// Take out corners at which a loop turns back; returns its new length, 0 where nothing is left.
static LitheIndex remove_spurs(LitheIndex *loop, LitheIndex n) {
  LitheIndex m = 0;
  for (LitheIndex i = 0; i < n; i++) {
    if (m >= 2 && loop[m - 2] == loop[i])
      m--;
    else
      loop[m++] = loop[i];
  }
  LitheIndex begin = 0;
  while (m - begin > 2) {
    if (loop[m - 2] == loop[begin])
      m -= 2;
    else if (loop[m - 1] == loop[begin + 1])
      m--, begin++;
    else
      break;
  }
  if (m - begin < 3) return 0;
  memmove(loop, loop + begin, sizeof *loop * (size_t)(m - begin));
  return m - begin;
}

static LitheStatus trace_from(LitheCtx *ctx, LthTopologyWork *w, Tracer *r, LitheIndex start) {
  LitheIndex first = w->raw_off[w->n_raw], at = first;
  for (LitheIndex e = start; e >= 0; e = next_edge(r, e, start)) {
    r->used[e] = true;
    LTH_RESERVE(ctx, w->raw_corner, w->raw_corner_cap, at + 1);
    w->raw_corner[at++] = r->edge[3 * e];
  }
  LitheIndex n = remove_spurs(w->raw_corner + first, at - first);
  if (n == 0) return LITHE_OK;
  LTH_RESERVE(ctx, w->raw_off, w->raw_off_cap, w->n_raw + 2);
  w->raw_off[++w->n_raw] = first + n;
  return LITHE_OK;
}

/// All loops, as raw_off and raw_corner. Loops of the chain come first: dividers outside of them find no more edges
/// than their own.
static LitheStatus trace_all(LitheCtx *ctx, LthTopology *t, const TopologyChain *chain,
                             const TopologyChain *divider, Tracer *r) {
  LthTopologyWork *w = t->work;
  LitheCount n = chain->n + (divider ? divider->n : 0);
  LTH_RESERVE(ctx, w->trace_edge, w->trace_cap, 3 * n);
  LTH_RESERVE(ctx, w->trace_used, w->used_cap, n);
  LTH_RESERVE(ctx, w->raw_off, w->raw_off_cap, 2);
  for (LitheCount i = 0; i < n; i++) {
    bool is_divider = i >= chain->n;
    const LitheIndex *edge = is_divider ? divider->edge + 2 * (i - chain->n) : chain->edge + 2 * i;
    w->trace_edge[3 * i] = edge[0];
    w->trace_edge[3 * i + 1] = edge[1];
    w->trace_edge[3 * i + 2] = is_divider;
    w->trace_used[i] = false;
  }
  qsort(w->trace_edge, (size_t)n, 3 * sizeof *w->trace_edge, compare_starts);
  r->t = t;
  r->edge = w->trace_edge;
  r->used = w->trace_used;
  r->n = (LitheIndex)n;
  w->n_raw = 0;
  w->raw_off[0] = 0;
  for (int pass = 0; pass < 2; pass++)
    for (LitheIndex i = 0; i < n; i++)
      if (!r->used[i] && r->edge[3 * i + 2] == pass) LITHE_TRY(trace_from(ctx, w, r, i));
  return LITHE_OK;
}

/// Area of a loop about the normal; 0 where it is flat.
static double decisive_area(const LthTopology *t, const double normal[3], const LitheIndex *loop,
                            LitheIndex n) {
  const double *o = t->points + 3 * (LitheCount)loop[0];
  double sum[3] = {0, 0, 0}, length = 0;
  for (LitheIndex i = 0; i < n; i++) {
    const double *a = t->points + 3 * (LitheCount)loop[i],
                 *b = t->points + 3 * (LitheCount)loop[i + 1 < n ? i + 1 : 0];
    double p[3], q[3], c[3];
    lth_v3_sub(a, o, p);
    lth_v3_sub(b, o, q);
    lth_v3_cross(p, q, c);
    lth_v3_add(sum, c, sum);
    length += lth_v3_distance(a, b);
  }
  double area = lth_v3_dot(sum, normal) / 2;
  return fabs(area) > FLAT_LOOP * length * length ? area : 0;
}

static bool is_inside(const Tracer *r, const LitheIndex *loop, LitheIndex n, const double *x) {
  const double *p = r->t->points;
  bool inside = false;
  for (LitheIndex i = 0; i < n; i++) {
    const double *a = p + 3 * (LitheCount)loop[i],
                 *b = p + 3 * (LitheCount)loop[i + 1 < n ? i + 1 : 0];
    if ((a[r->v] > x[r->v]) == (b[r->v] > x[r->v])) continue;
    double at = a[r->u] + (x[r->v] - a[r->v]) / (b[r->v] - a[r->v]) * (b[r->u] - a[r->u]);
    if (at > x[r->u]) inside = !inside;
  }
  return inside;
}

/// True if most corners of the hole are inside the loop: one that touches it may round to either side.
static bool holds(const Tracer *r, const LthTopologyWork *w, LitheIndex outer, LitheIndex hole) {
  LitheIndex n_inside = 0, first = w->raw_off[hole], n = w->raw_off[hole + 1] - first;
  for (LitheIndex i = 0; i < n; i++)
    n_inside +=
        is_inside(r, w->raw_corner + w->raw_off[outer], w->raw_off[outer + 1] - w->raw_off[outer],
                  r->t->points + 3 * (LitheCount)w->raw_corner[first + i]);
  return 2 * n_inside > n;
}

/// raw_outer: the loop around each hole (the only one, or the smallest that holds it), itself for others.
static bool assign_holes(const Tracer *r, LthTopologyWork *w) {
  LitheIndex n_outer = 0;
  bool is_clean = true;
  for (LitheIndex i = 0; i < w->n_raw; i++) n_outer += w->raw_area[i] > 0;
  for (LitheIndex i = 0; i < w->n_raw; i++) {
    w->raw_outer[i] = i;
    if (w->raw_area[i] >= 0) continue;
    for (LitheIndex j = 0; j < w->n_raw; j++) {
      bool is_best = w->raw_outer[i] == i || w->raw_area[j] < w->raw_area[w->raw_outer[i]];
      if (w->raw_area[j] > 0 && is_best && (n_outer == 1 || holds(r, w, j, i))) w->raw_outer[i] = j;
    }
    is_clean &= w->raw_outer[i] != i;
  }
  return is_clean;
}

static LitheStatus write_loop(LitheCtx *ctx, LthTopologyWork *w, LitheIndex raw) {
  LitheIndex n = w->raw_off[raw + 1] - w->raw_off[raw];
  LTH_RESERVE(ctx, w->corner, w->corner_cap, w->n_corners + n);
  LTH_RESERVE(ctx, w->loop_off, w->loop_off_cap, w->n_loops + 2);
  memcpy(w->corner + w->n_corners, w->raw_corner + w->raw_off[raw], sizeof *w->corner * (size_t)n);
  w->loop_off[w->n_loops] = w->n_corners;
  w->n_corners += n;
  w->loop_off[++w->n_loops] = w->n_corners;
  return LITHE_OK;
}

LitheStatus lth_topology_trace(LitheCtx *ctx, LthTopology *t, TopologyChain *chain,
                               const TopologyChain *divider, const double normal[3],
                               LitheIndex face, int side, bool *is_clean) {
  LthTopologyWork *w = t->work;
  Tracer r = {0};
  int axis = 0;
  for (int i = 1; i < 3; i++)
    if (fabs(normal[i]) > fabs(normal[axis])) axis = i;
  r.u = (axis + (normal[axis] < 0 ? 2 : 1)) % 3;
  r.v = (axis + (normal[axis] < 0 ? 1 : 2)) % 3;
  lth_topology_cancel(chain);
  LITHE_TRY(trace_all(ctx, t, chain, divider, &r));
  LTH_RESERVE(ctx, w->raw_area, w->raw_area_cap, w->n_raw);
  LTH_RESERVE(ctx, w->raw_outer, w->raw_outer_cap, w->n_raw);
  for (LitheIndex i = 0; i < w->n_raw; i++)
    w->raw_area[i] =
        decisive_area(t, normal, w->raw_corner + w->raw_off[i], w->raw_off[i + 1] - w->raw_off[i]);
  *is_clean &= assign_holes(&r, w);
  for (LitheIndex i = 0; i < w->n_raw; i++) {
    if (w->raw_outer[i] != i) continue;
    LTH_RESERVE(ctx, w->parts, w->parts_cap, w->n_parts + 1);
    TopologyPart *part = w->parts + w->n_parts++;
    *part = (TopologyPart){.face = face, .first_loop = w->n_loops, .side = side, .cell = {-1, -1}};
    LITHE_TRY(write_loop(ctx, w, i));
    for (LitheIndex j = 0; j < w->n_raw; j++)
      if (j != i && w->raw_outer[j] == i) LITHE_TRY(write_loop(ctx, w, j));
    part->n_loops = w->n_loops - part->first_loop;
  }
  return LITHE_OK;
}

LthFaceView lth_topology_part(const LthTopology *t, const TopologyPart *part) {
  const LthTopologyWork *w = t->work;
  if (part->n_loops == 0) return lth_topology_face(t, part->face);
  const double *normal = part->face < 0 ? w->plane : t->faces[part->face].plane;
  return (LthFaceView){t->points, w->loop_off + part->first_loop, w->corner, part->n_loops, normal};
}

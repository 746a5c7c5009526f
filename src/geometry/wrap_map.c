/// Maps of wrapped surfaces: blocks of space far from all triangles are asked once, and lines meet the
/// surface on triangles.
#include "geometry/wrap.h"

#include "base/tensor.h"

#define STACK_MAX 96
#define BLOCK 16      ///< cells of the blocks that are tried first, a power of two
#define CELLS_MAX 512 ///< along an axis
#define HITS_MAX 32
#define CLEARANCE 2.3 ///< of half a block's width: free of triangles around it; corners are at 1.73
#define SURE 0.35     ///< distance of a number from one half that leaves no doubt around it
#define OPENING 2.0   ///< of groups for that
#define BESIDE 1e-6   ///< of a line: where the sides of a triangle are asked
#define EXACTNESS 0x1p-20 ///< of a line, in holes

/// --- building ---

static LitheIndex smaller(LitheIndex a, LitheIndex b) { return a < b ? a : b; }

/// State of a block of size^3 cells as a whole.
static uint8_t block_state(const LthWrapMap *m, const LitheIndex at[3], LitheIndex size) {
  double x[3], half = 0.5 * size * m->cell, bound;
  LthBvhPoint closest;
  for (int i = 0; i < 3; i++) x[i] = m->origin[i] + at[i] * m->cell + half;
  if (lth_bvh_closest(m->wrap->bvh, x, CLEARANCE * half, NULL, NULL, &closest))
    return LTH_WRAP_UNKNOWN;
  double number = lth_winding_number(m->wrap->winding, x, OPENING, &bound);
  if (number - 0.5 > SURE + bound) return LTH_WRAP_INSIDE;
  return 0.5 - number > SURE + bound ? LTH_WRAP_OUTSIDE : LTH_WRAP_UNKNOWN;
}

static void fill_block(LthWrapMap *m, const LitheIndex at[3], LitheIndex size) {
  for (int i = 0; i < 3; i++)
    if (at[i] >= m->n[i]) return;
  uint8_t state = block_state(m, at, size);
  if (state == LTH_WRAP_UNKNOWN && size > 1) {
    LitheIndex half = size / 2;
    for (int corner = 0; corner < 8; corner++)
      fill_block(m,
                 (LitheIndex[3]){at[0] + (corner & 1) * half, at[1] + (corner >> 1 & 1) * half,
                                 at[2] + (corner >> 2) * half},
                 half);
    return;
  }
  for (LitheIndex k = at[2]; k < smaller(at[2] + size, m->n[2]); k++)
    for (LitheIndex j = at[1]; j < smaller(at[1] + size, m->n[1]); j++)
      for (LitheIndex i = at[0]; i < smaller(at[0] + size, m->n[0]); i++)
        m->state[((size_t)k * (size_t)m->n[1] + (size_t)j) * (size_t)m->n[0] + (size_t)i] = state;
}

static void fill_map(LitheCtx *ctx, LthWrapMap *m) {
  LitheIndex blocks[3], n_blocks = 1;
  for (int i = 0; i < 3; i++) blocks[i] = (m->n[i] + BLOCK - 1) / BLOCK, n_blocks *= blocks[i];
#pragma omp parallel for schedule(dynamic, 1) num_threads(lth_threads(ctx))
  for (LitheIndex b = 0; b < n_blocks; b++) {
    LitheIndex at[3] = {BLOCK * (b % blocks[0]), BLOCK * (b / blocks[0] % blocks[1]),
                        BLOCK * (b / blocks[0] / blocks[1])};
    if (!lth_cancelled(ctx)) fill_block(m, at, BLOCK);
  }
}

LitheStatus lth_wrap_map_create(LitheCtx *ctx, const LthWrap *wrap, double cell, LthWrapMap **map) {
  LitheStatus status = LITHE_OK;
  LthWrapMap *m = NULL;
  double longest = 0;
  *map = NULL;
  LTH_NEW_OR(done, ctx, m, 1);
  m->wrap = wrap;
  lth_v3_copy(wrap->box, m->origin);
  for (int i = 0; i < 3; i++) longest = fmax(longest, wrap->box[3 + i] - wrap->box[i]);
  m->cell = fmax(cell, longest / CELLS_MAX);
  for (int i = 0; i < 3; i++)
    m->n[i] = 1 + (LitheIndex)((wrap->box[3 + i] - wrap->box[i]) / m->cell);
  LTH_NEW_OR(done, ctx, m->state, (LitheCount)m->n[0] * m->n[1] * m->n[2]);
  fill_map(ctx, m);
done:
  if (status != LITHE_OK) lth_wrap_map_destroy(ctx, &m);
  *map = m;
  return status;
}

void lth_wrap_map_destroy(LitheCtx *ctx, LthWrapMap **map) {
  if (!map || !*map) return;
  lth_free(ctx, (*map)->state);
  lth_free(ctx, *map);
  *map = NULL;
}

/// --- asking ---

bool lth_wrap_map_inside(const LthWrapMap *m, const double x[3]) {
  size_t cell[3];
  for (int i = 0; i < 3; i++) {
    if (!(x[i] >= m->wrap->box[i] && x[i] <= m->wrap->box[3 + i])) return false;
    cell[i] = (size_t)smaller((LitheIndex)((x[i] - m->origin[i]) / m->cell), m->n[i] - 1);
  }
  uint8_t state = m->state[(cell[2] * (size_t)m->n[1] + cell[1]) * (size_t)m->n[0] + cell[0]];
  if (state == LTH_WRAP_UNKNOWN) return lth_winding_inside(m->wrap->winding, x);
  return state == LTH_WRAP_INSIDE;
}

/// Where a line from a to b meets triangles, in order, and by how much the number changes there.
typedef struct Line {
  const double *a, *b;
  double hit[HITS_MAX], jump[HITS_MAX];
  int n;
  bool is_full;
} Line;

/// Part t of the line at which it goes through a triangle, *jump: +1 where it goes in, -1 where it comes
/// out; false where it does not.
static bool pierce(const double a[3], const double d[3], const double *p, const double *q,
                   const double *r, double *t, double *jump) {
  double e[3], f[3], g[3], n[3], c[3];
  lth_v3_sub(q, p, e);
  lth_v3_sub(r, p, f);
  lth_v3_sub(p, a, g);
  lth_v3_cross(e, f, n);
  double below = lth_v3_dot(n, d);
  if (below == 0) return false;
  lth_v3_cross(g, d, c);
  double u = lth_v3_dot(c, f) / below, v = -lth_v3_dot(c, e) / below;
  *t = lth_v3_dot(n, g) / below;
  *jump = below < 0 ? 1 : -1;
  return u >= 0 && v >= 0 && u + v <= 1 && *t > 0 && *t < 1;
}

static void insert(Line *line, double t, double jump) {
  if (line->n == HITS_MAX) {
    line->is_full = true;
    return;
  }
  int i = line->n++;
  for (; i > 0 && line->hit[i - 1] > t; i--) {
    line->hit[i] = line->hit[i - 1];
    line->jump[i] = line->jump[i - 1];
  }
  line->hit[i] = t;
  line->jump[i] = jump;
}

static void find_hits(const LthWrap *w, Line *line) {
  const LthBvh *tree = w->bvh;
  const LthSurface *s = w->raw;
  LitheIndex stack[STACK_MAX];
  double d[3], t, jump;
  int top = 0;
  lth_v3_sub(line->b, line->a, d);
  stack[top++] = 0;
  while (top > 0) {
    LitheIndex node = stack[--top];
    const double *box = tree->box + 6 * (size_t)node;
    bool meets = true;
    for (int i = 0; i < 3; i++)
      meets = meets && box[i] <= fmax(line->a[i], line->b[i]) &&
              fmin(line->a[i], line->b[i]) <= box[3 + i];
    if (!meets) continue;
    if (tree->right[node] >= 0) {
      LITHE_ASSERT(top + 2 <= STACK_MAX);
      stack[top++] = tree->right[node];
      stack[top++] = node + 1;
      continue;
    }
    for (LitheIndex i = tree->first[node]; i < tree->first[node] + tree->count[node]; i++) {
      const LitheIndex *p = s->tris + 3 * (size_t)tree->item[i];
      if (pierce(line->a, d, s->points + 3 * (size_t)p[0], s->points + 3 * (size_t)p[1],
                 s->points + 3 * (size_t)p[2], &t, &jump))
        insert(line, t, jump);
    }
  }
}

static bool inside_at(const LthWrapMap *m, const Line *line, double t) {
  double x[3];
  for (int i = 0; i < 3; i++) x[i] = line->a[i] + t * (line->b[i] - line->a[i]);
  return lth_wrap_map_inside(m, x);
}

/// Inside before and behind a triangle: from the number before it where that leaves no doubt.
static void ask_sides(const LthWrapMap *m, const Line *line, int hit, bool *before, bool *behind) {
  double t = line->hit[hit] - BESIDE, x[3], bound;
  for (int i = 0; i < 3; i++) x[i] = line->a[i] + t * (line->b[i] - line->a[i]);
  double number = lth_winding_number(m->wrap->winding, x, OPENING, &bound);
  double next = number + line->jump[hit];
  bool is_sure = fabs(number - 0.5) > bound && fabs(next - 0.5) > bound;
  *before = is_sure ? number > 0.5 : inside_at(m, line, t);
  *behind = is_sure ? next > 0.5 : inside_at(m, line, line->hit[hit] + BESIDE);
}

/// The change lies between two places, off all triangles.
static double bisect(const LthWrapMap *m, const Line *line, double low, double high,
                     bool starts_inside) {
  while (high - low > EXACTNESS) {
    double middle = 0.5 * (low + high);
    if (inside_at(m, line, middle) == starts_inside)
      low = middle;
    else
      high = middle;
  }
  return 0.5 * (low + high);
}

double lth_wrap_map_crossing(const LthWrapMap *m, const double a[3], const double b[3],
                             bool starts_inside) {
  Line line = {.a = a, .b = b};
  find_hits(m->wrap, &line);
  if (line.is_full) line.n = 0;

  // behind hit `from` the answer is that of the start, before hit `to` it is not
  int from = -1, to = line.n;
  while (to - from > 1) {
    int middle = (from + to) / 2;
    bool before, behind;
    ask_sides(m, &line, middle, &before, &behind);
    if (before != starts_inside)
      to = middle;
    else if (behind != starts_inside)
      return line.hit[middle];
    else
      from = middle;
  }
  double low = from < 0 ? 0 : line.hit[from], high = to == line.n ? 1 : line.hit[to];
  return bisect(m, &line, low, high, starts_inside);
}

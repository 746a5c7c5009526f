/// Cells that hang loose are found by growing rigid groups: 2 x 2 (x 2) live cells are rigid, two such blocks that share
/// a side are one, and an unknown whose strain sample knows all others belongs to them (docs/theory/staggered.md).
#include "disc/staggered/staggered_loose.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"
#include "disc/staggered/staggered_halo.h"
#include "disc/staggered/staggered_hierarchy.h"

#include <math.h>
#include <string.h>

#define NONE (-1)   // in no group
#define GROUND (-2) // held, or fixed by what is held
#define SINGULAR                                                                                   \
  1e-9 // of a scaled Gram matrix of rigid motions; independent ones are above 1 / (cells along a seam)^2

/// Two groups that share samples, and what these say of their motion against each other.
typedef struct Pair {
  LitheIndex group[2];
  double place[3];
  double gram[36];
} Pair;

typedef struct Finder {
  LitheCtx *ctx;
  LthStaggeredLevel *level;
  const LthSparseGrid *grid;
  int dim;
  LitheIndex *label[3]; ///< group of an unknown, NONE or GROUND            (n_slots each)
  LitheIndex *corner;   ///< set of a slot's low corner, NONE: not rigid    (n_slots)
  LitheIndex *parent;   ///< of groups, as disjoint sets                    (n_groups)
  LitheCount *size;     ///< unknowns                                       (n_groups)
  double *ground;       ///< Gram matrices of held unknowns                 (n_groups x 36)
  LitheIndex n_groups;
  LitheCount *open; ///< unknowns without a group: dim slot + component
  LitheCount n_open, cap_open;
  Pair *pairs;
  LitheCount n_pairs, cap_pairs;
  uint8_t *drop; ///< (n_slots)
} Finder;

/// The unknowns of a strain sample.
typedef struct Sample {
  int n, a[4];
  LitheCount slot[4];
  double c[4];
} Sample;

static bool is_live(const LthStaggeredLevel *l, LitheCount slot) {
  return slot >= 0 && l->mu[slot] > 0;
}

static LitheCount step(const LthSparseGrid *g, LitheCount slot, int axis, int by) {
  LitheIndex cell[3];
  lth_sparse_grid_cell(g, slot, cell);
  return lth_sparse_grid_along(g, cell, axis, by);
}

/// False where the cell holds nothing.
static bool normal_sample(const Finder *f, LitheCount slot, int a, Sample *s) {
  if (!is_live(f->level, slot)) return false;
  *s = (Sample){2, {a, a}, {slot, step(f->grid, slot, a, 1)}, {-1, 1}};
  return true;
}

/// False where the sample holds nothing.
static bool shear_sample(const Finder *f, LitheCount slot, int a, int b, Sample *s) {
  if (slot < 0 || !(f->level->shear[3 - a - b][slot] > 0)) return false;
  double ratio = f->grid->h[b] / f->grid->h[a];
  *s = (Sample){4,
                {a, a, b, b},
                {slot, step(f->grid, slot, b, -1), slot, step(f->grid, slot, a, -1)},
                {1, -1, ratio, -ratio}};
  return true;
}

// --- groups of full blocks ---

/// The cells around a low corner are all there, and so are the shear samples between them.
static bool corner_is_rigid(const Finder *f, const LitheCount *slot, const int stride[3]) {
  for (int k = 0; k < 1 << f->dim; k++) {
    int at = 0;
    for (int a = 0; a < f->dim; a++) at -= (k >> a & 1) * stride[a];
    if (!is_live(f->level, slot[at])) return false;
  }
  for (int e = f->dim == 3 ? 0 : 2; e < 3; e++) {
    const double *shear = f->level->shear[e];
    if (!(shear[slot[0]] > 0) || (f->dim == 3 && !(shear[slot[-stride[e]]] > 0))) return false;
  }
  return true;
}

static void find_corners(Finder *f) {
  const LthSparseGrid *g = f->grid;
#pragma omp parallel for schedule(static) num_threads(lth_threads(f->ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++) {
    LthHalo halo;
    lth_halo_fill(g, block, &halo);
    for (LitheIndex local = 0; local < g->block_cells; local++) {
      const LitheCount *slot = halo.slot + lth_halo_at(g, &halo, local);
      f->corner[*slot] = corner_is_rigid(f, slot, halo.stride) ? (LitheIndex)*slot : NONE;
    }
  }
  for (LitheIndex block = 0; block < g->n_blocks; block++) {
    LthHalo halo;
    lth_halo_fill(g, block, &halo);
    for (LitheIndex local = 0; local < g->block_cells; local++) {
      const LitheCount *slot = halo.slot + lth_halo_at(g, &halo, local);
      for (int a = 0; a < f->dim && f->corner[*slot] != NONE; a++) {
        LitheCount other = slot[-halo.stride[a]];
        if (other >= 0 && f->corner[other] != NONE)
          lth_sets_unite(f->corner, (LitheIndex)*slot, (LitheIndex)other);
      }
    }
  }
}

/// Numbers for the sets of corners.
static void number_groups(Finder *f) {
  f->n_groups = 0;
  for (LitheCount s = 0; s < f->grid->n_slots; s++)
    if (f->corner[s] != NONE) f->corner[s] = lth_sets_root(f->corner, (LitheIndex)s);
  for (LitheCount s = 0; s < f->grid->n_slots; s++) {
    if (f->corner[s] == NONE) continue;
    f->corner[s] = f->corner[s] == s ? f->n_groups++ : f->corner[f->corner[s]];
  }
}

/// The group of a block that the face's cells are in.
static LitheIndex label_of(const Finder *f, const LitheCount *slot, const int stride[3], int a) {
  for (int side = 0; side < 2; side++) {
    int cell = side ? -stride[a] : 0;
    if (!is_live(f->level, slot[cell])) continue;
    for (int k = 0; k < 1 << f->dim; k++) {
      int at = cell;
      for (int b = 0; b < f->dim; b++) at += (k >> b & 1) * stride[b];
      if (slot[at] >= 0 && f->corner[slot[at]] != NONE) return f->corner[slot[at]];
    }
  }
  return NONE;
}

static void label_unknowns(Finder *f) {
  const LthSparseGrid *g = f->grid;
#pragma omp parallel for schedule(static) num_threads(lth_threads(f->ctx))
  for (LitheIndex block = 0; block < g->n_blocks; block++) {
    LthHalo halo;
    lth_halo_fill(g, block, &halo);
    for (LitheIndex local = 0; local < g->block_cells; local++) {
      const LitheCount *slot = halo.slot + lth_halo_at(g, &halo, local);
      for (int a = 0; a < f->dim; a++)
        f->label[a][*slot] = f->level->state[a][*slot] == LTH_UNKNOWN_DEAD
                                 ? NONE
                                 : label_of(f, slot, halo.stride, a);
    }
  }
}

// --- growth over single samples ---

static LitheStatus list_open(Finder *f) {
  f->n_open = 0;
  for (LitheCount s = 0; s < f->grid->n_slots; s++)
    for (int a = 0; a < f->dim; a++) {
      if (f->level->state[a][s] == LTH_UNKNOWN_DEAD || f->label[a][s] != NONE) continue;
      LTH_RESERVE(f->ctx, f->open, f->cap_open, f->n_open + 1);
      f->open[f->n_open++] = f->dim * s + a;
    }
  return LITHE_OK;
}

/// The group that a label stands for by now.
static LitheIndex root(Finder *f, LitheIndex label) {
  return label < 0 ? label : lth_sets_root(f->parent, label);
}

/// Group that all other unknowns of the sample are in (GROUND goes with any), or NONE.
static LitheIndex group_of_others(Finder *f, const Sample *s, LitheCount slot, int a) {
  LitheIndex group = GROUND;
  for (int i = 0; i < s->n; i++) {
    if (s->slot[i] == slot && s->a[i] == a) continue;
    LitheIndex other = root(f, f->label[s->a[i]][s->slot[i]]);
    if (other == GROUND) continue;
    if (other == NONE || (group != GROUND && group != other)) return NONE;
    group = other;
  }
  return group;
}

static LitheIndex grown_label(Finder *f, LitheCount slot, int a) {
  Sample s;
  for (int side = 0; side < 2; side++) {
    LitheCount cell = side ? step(f->grid, slot, a, -1) : slot;
    if (!normal_sample(f, cell, a, &s)) continue;
    LitheIndex group = group_of_others(f, &s, slot, a);
    if (group != NONE) return group;
  }
  for (int b = 0; b < f->dim; b++)
    for (int side = 0; side < 2 && b != a; side++) {
      LitheCount edge = side ? step(f->grid, slot, b, 1) : slot;
      if (!shear_sample(f, edge, a, b, &s)) continue;
      LitheIndex group = group_of_others(f, &s, slot, a);
      if (group != NONE) return group;
    }
  return NONE;
}

/// Until nothing changes.
static void grow(Finder *f) {
  for (LitheCount before = -1; f->n_open != before;) {
    before = f->n_open;
    f->n_open = 0;
    for (LitheCount i = 0; i < before; i++) {
      LitheCount slot = f->open[i] / f->dim;
      int a = (int)(f->open[i] % f->dim);
      f->label[a][slot] = grown_label(f, slot, a);
      if (f->label[a][slot] == NONE) f->open[f->n_open++] = f->open[i];
    }
  }
}

static void ground_held(Finder *f) {
  for (LitheCount i = 0; i < f->n_open; i++) {
    LitheCount slot = f->open[i] / f->dim;
    int a = (int)(f->open[i] % f->dim);
    if (f->level->state[a][slot] == LTH_UNKNOWN_HELD) f->label[a][slot] = GROUND;
  }
}

// --- groups that meet ---

/// Row of rigid motions (translations, rotations about `origin`, in cells) at an unknown, times c.
static void add_motion(const Finder *f, LitheCount slot, int a, const double origin[3], double c,
                       double row[6]) {
  LitheIndex cell[3];
  double offset[3] = {0.5, 0.5, 0.5}, x[3], h = f->grid->h[0];
  offset[a] = 0;
  lth_sparse_grid_cell(f->grid, slot, cell);
  lth_sparse_grid_place(f->grid, cell, offset, x);
  for (int b = 0; b < 3; b++) x[b] = (x[b] - origin[b]) / h;
  row[a] += c;
  for (int axis = 0; axis < 3; axis++) { // (e_axis x x)_a
    if (a == (axis + 1) % 3) row[3 + axis] -= c * x[(axis + 2) % 3];
    if (a == (axis + 2) % 3) row[3 + axis] += c * x[(axis + 1) % 3];
  }
}

static void add_row(const double row[6], double gram[36]) {
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++) gram[6 * i + j] += row[i] * row[j];
}

/// The rows admit no motion but zero: elimination of the scaled Gram matrix.
static bool is_rigid(int dim, const double gram[36]) {
  static const int plane[3] = {0, 1, 5};
  int n = dim == 3 ? 6 : 3;
  double G[6][6], scale[6];
  for (int i = 0; i < n; i++) {
    int k = dim == 3 ? i : plane[i];
    if (!(gram[7 * k] > 0)) return false;
    scale[i] = 1 / sqrt(gram[7 * k]);
  }
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++)
      G[i][j] =
          gram[6 * (dim == 3 ? i : plane[i]) + (dim == 3 ? j : plane[j])] * scale[i] * scale[j];
  for (int k = 0; k < n; k++) {
    if (!(G[k][k] > SINGULAR)) return false;
    for (int i = k + 1; i < n; i++)
      for (int j = k + 1; j < n; j++) G[i][j] -= G[i][k] * G[k][j] / G[k][k];
  }
  return true;
}

static LitheStatus find_pair(Finder *f, LitheIndex g, LitheIndex h, const double place[3],
                             Pair **pair) {
  for (LitheCount i = 0; i < f->n_pairs; i++) {
    *pair = &f->pairs[i];
    if ((*pair)->group[0] == g && (*pair)->group[1] == h) return LITHE_OK;
  }
  LTH_RESERVE(f->ctx, f->pairs, f->cap_pairs, f->n_pairs + 1);
  *pair = &f->pairs[f->n_pairs++];
  **pair = (Pair){.group = {g, h}};
  lth_v3_copy(place, (*pair)->place);
  return LITHE_OK;
}

/// What a sample of two groups says of their motion against each other.
static LitheStatus add_sample(Finder *f, const Sample *s) {
  LitheIndex first = NONE, second = NONE;
  for (int i = 0; i < s->n; i++) {
    LitheIndex group = root(f, f->label[s->a[i]][s->slot[i]]);
    if (group < 0) return LITHE_OK; // it may move as it likes
    if (group == first || group == second) continue;
    if (second != NONE) return LITHE_OK; // three of them: left out
    *(first == NONE ? &first : &second) = group;
  }
  if (second == NONE) return LITHE_OK;
  if (first > second) {
    LitheIndex swap = first;
    first = second;
    second = swap;
  }
  LitheIndex cell[3];
  double place[3], row[6] = {0};
  Pair *pair;
  lth_sparse_grid_cell(f->grid, s->slot[0], cell);
  lth_sparse_grid_place(f->grid, cell, (const double[3]){0, 0, 0}, place);
  LITHE_TRY(find_pair(f, first, second, place, &pair));
  for (int i = 0; i < s->n; i++)
    if (root(f, f->label[s->a[i]][s->slot[i]]) == second)
      add_motion(f, s->slot[i], s->a[i], pair->place, s->c[i], row);
  add_row(row, pair->gram);
  return LITHE_OK;
}

static LitheStatus list_pairs(Finder *f) {
  f->n_pairs = 0;
  for (LitheCount slot = 0; slot < f->grid->n_slots; slot++)
    for (int a = 0; a < f->dim; a++) {
      Sample s;
      if (normal_sample(f, slot, a, &s)) LITHE_TRY(add_sample(f, &s));
      for (int b = a + 1; b < f->dim; b++)
        if (shear_sample(f, slot, a, b, &s)) LITHE_TRY(add_sample(f, &s));
    }
  return LITHE_OK;
}

/// Unite groups that hold each other; true where there are some.
static LitheStatus unite_groups(Finder *f, bool *changed) {
  *changed = false;
  f->n_pairs = 0;
  if (f->n_groups < 2) return LITHE_OK;
  LITHE_TRY(list_pairs(f));
  for (LitheCount i = 0; i < f->n_pairs; i++)
    if (is_rigid(f->dim, f->pairs[i].gram))
      *changed |= lth_sets_unite(f->parent, f->pairs[i].group[0], f->pairs[i].group[1]);
  return LITHE_OK;
}

/// Grow, unite, grow on.
static LitheStatus join_groups(Finder *f) {
  bool changed = true;
  LITHE_TRY(list_open(f));
  while (changed) {
    grow(f);
    LITHE_TRY(unite_groups(f, &changed));
  }
  ground_held(f);
  grow(f);
  return LITHE_OK;
}

static LitheStatus make_groups(Finder *f) {
  lth_free(f->ctx, f->parent);
  lth_free(f->ctx, f->size);
  lth_free(f->ctx, f->ground);
  f->parent = NULL, f->size = NULL, f->ground = NULL;
  LTH_NEW(f->ctx, f->parent, f->n_groups);
  LTH_NEW(f->ctx, f->size, f->n_groups);
  LTH_NEW(f->ctx, f->ground, 36 * (LitheCount)f->n_groups);
  lth_sets_reset(f->parent, f->n_groups);
  return LITHE_OK;
}

/// Unknowns of groups, and what holds them.
static void measure_groups(Finder *f) {
  for (LitheCount slot = 0; slot < f->grid->n_slots && f->n_pairs > 0; slot++)
    for (int a = 0; a < f->dim; a++) {
      LitheIndex group = root(f, f->label[a][slot]);
      if (group < 0) continue;
      f->size[group]++;
      if (f->level->state[a][slot] != LTH_UNKNOWN_HELD) continue;
      double row[6] = {0};
      add_motion(f, slot, a, f->grid->origin, 1, row);
      add_row(row, f->ground + 36 * (LitheCount)group);
    }
}

/// Groups that hang on others by a hinge alone: of two the one that nothing else holds, or the smaller.
static void choose_hinged(Finder *f, uint8_t *goes) {
  for (LitheCount i = 0; i < f->n_pairs; i++) {
    LitheIndex g = root(f, f->pairs[i].group[0]), h = root(f, f->pairs[i].group[1]);
    if (g == h || goes[g] || goes[h]) continue;
    bool held[2] = {is_rigid(f->dim, f->ground + 36 * (LitheCount)g),
                    is_rigid(f->dim, f->ground + 36 * (LitheCount)h)};
    if (held[0] && held[1]) continue;
    if (held[0] != held[1])
      goes[held[0] ? h : g] = 1;
    else
      goes[f->size[g] < f->size[h] ? g : h] = 1;
  }
}

static void drop_beside(Finder *f, LitheCount slot, int a) {
  LitheCount low = step(f->grid, slot, a, -1);
  if (is_live(f->level, slot)) f->drop[slot] = 1;
  if (is_live(f->level, low)) f->drop[low] = 1;
}

/// Mark the cells that go: those with an unknown of a group that goes, or where none does, with one that is loose.
static LitheStatus mark_cells(Finder *f) {
  uint8_t *goes = NULL;
  bool any = false;
  LTH_NEW(f->ctx, goes, f->n_groups);
  memset(f->drop, 0, (size_t)f->grid->n_slots);
  choose_hinged(f, goes);
  for (LitheIndex g = 0; g < f->n_groups; g++) any |= goes[g];
  for (LitheCount slot = 0; any && slot < f->grid->n_slots; slot++)
    for (int a = 0; a < f->dim; a++) {
      LitheIndex group = root(f, f->label[a][slot]);
      if (group >= 0 && goes[group]) drop_beside(f, slot, a);
    }
  for (LitheCount i = 0; i < f->n_open && !any; i++)
    drop_beside(f, f->open[i] / f->dim, (int)(f->open[i] % f->dim));
  lth_free(f->ctx, goes);
  return LITHE_OK;
}

static LitheCount drop_cells(Finder *f, LthLoose *loose) {
  LthStaggeredLevel *l = f->level;
  LitheCount n = 0;
  for (LitheCount slot = 0; slot < f->grid->n_slots; slot++) {
    if (!f->drop[slot]) continue;
    LitheIndex cell[3];
    lth_sparse_grid_cell(f->grid, slot, cell);
    lth_sparse_grid_place(f->grid, cell, (const double[3]){0.5, 0.5, 0.5}, loose->place);
    l->lambda[slot] = l->mu[slot] = 0;
    if (l->compliance) l->compliance[slot] = 0;
    n++;
  }
  loose->n_cells += n;
  return n;
}

/// Every round leaves out one live cell at least, or is the last.
static LitheStatus find(Finder *f, LthLoose *loose) {
  for (;;) {
    find_corners(f);
    number_groups(f);
    label_unknowns(f);
    LITHE_TRY(make_groups(f));
    LITHE_TRY(join_groups(f));
    measure_groups(f);
    LITHE_TRY(mark_cells(f));
    if (drop_cells(f, loose) == 0) return LITHE_OK;
    lth_staggered_rule_a(f->ctx, f->level);
  }
}

LitheStatus lth_staggered_drop_loose(LitheCtx *ctx, LthStaggeredLevel *level, LthLoose *loose) {
  LitheStatus status = LITHE_OK;
  Finder f = {.ctx = ctx, .level = level, .grid = level->grid, .dim = level->grid->dim};
  *loose = (LthLoose){0};
  for (int a = 0; a < f.dim; a++) LTH_NEW_OR(done, ctx, f.label[a], f.grid->n_slots);
  LTH_NEW_OR(done, ctx, f.corner, f.grid->n_slots);
  LTH_NEW_OR(done, ctx, f.drop, f.grid->n_slots);
  LITHE_TRY_OR(done, find(&f, loose));
done:;
  void *blocks[] = {f.label[0], f.label[1], f.label[2], f.corner, f.parent,
                    f.size,     f.ground,   f.open,     f.pairs,  f.drop};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  return status;
}

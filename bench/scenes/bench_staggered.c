/// The staggered multigrid: an annulus in the plane and a ball (or a surface from a file) in space, held inside (at
/// the bottom), under gravity. Phases in seconds (on one thread of the processor), unknowns a second from the shape to a true residual of 1e-8, bytes an
/// unknown (fractions, discretisation, solver, right-hand side and solution), full multigrid in applications of the
/// operator - its time over that of one, and its work, counted as it goes - and the operator against two memory bounds, both at the speed of STREAM's triad (24 bytes an entry) on as many
/// threads in the same run: "memory", 16 bytes a free unknown (each value of x read once, each of y written once, no
/// coefficients), and "moved", the bytes that it cannot but move as things are stored: also places of x and y that are
/// not free, samples of cells and edges where rows differ, and states near boundaries. "dense" is what plain loops over a full box
/// take of the first bound (dense_stencil.h).
///
///   bench_staggered [--csv] [--threads N] [--dim 2|3] [--cells N] [--nu X] [--mesh FILE] [--export FILE]
///                   [--displacement]
///
/// From nu = 0.45 on the mixed form is measured, unless `--displacement` is given. Where there are pressures, the operator and full multigrid are
/// those of its displacements, a first guess.
/// `--cells N`: this size alone, else a few. `--export FILE`: the matrix over free unknowns, for bench/peers/staggered.py.
#include "base/tensor.h"
#include "dense_stencil.h"
#include "disc/staggered/staggered.h"
#include "disc/staggered/staggered_coarsest.h"
#include "disc/staggered/staggered_multigrid.h"
#include "disc/staggered/staggered_priv.h"
#include "io/surface_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct Options {
  bool csv;
  int threads, dim;
  LitheIndex cells;
  double nu;
  const char *mesh, *file;
  bool displacement; ///< this form also near nu = 1/2
} Options;

typedef struct Body {
  const Options *options;
  LthShape shape;
  LthSoup *soup;
  LthSurface *surface;
  LthFractions *fractions;
  LthDisc *disc;
  LthStaggered *s;
  LitheCount unknowns;
  double bottom; ///< held below [m]; 2D: held within this radius
  double *rhs, *w, *r;
} Body;

static void check(LitheCtx *ctx, LitheStatus status) {
  if (status == LITHE_OK) return;
  fprintf(stderr, "%s\n", lithe_ctx_message(ctx));
  exit(1);
}

static void material(const void *self, const double x[3], double *E, double *nu, double *rho) {
  (void)x;
  *E = 1e5;
  *nu = *(const double *)self;
  *rho = 1000;
}

/// As `formulation: auto` chooses.
static bool is_mixed(const Options *o) { return o->nu >= 0.45 && !o->displacement; }

static bool is_held(const void *self, const double x[3]) {
  const Body *b = self;
  if (b->options->dim == 2) return x[0] * x[0] + x[1] * x[1] <= b->bottom * b->bottom;
  return x[2] <= b->bottom;
}

static void make_shape(LitheCtx *ctx, Body *b) {
  const Options *o = b->options;
  if (o->dim == 2) {
    b->shape = (LthShape){.kind = LTH_SHAPE_DISK, .radius = 0.8};
    b->bottom = 0.325;
  } else if (o->mesh) {
    check(ctx, lth_soup_read(ctx, o->mesh, &b->soup));
    check(ctx, lth_surface_from_soup(ctx, b->soup, o->mesh, NULL, &b->surface));
    b->shape = (LthShape){.kind = LTH_SHAPE_MESH, .surface = b->surface};
  } else {
    b->shape = (LthShape){.kind = LTH_SHAPE_SPHERE, .radius = 1};
  }
  check(ctx, lth_shape_prepare(ctx, &b->shape));
}

static void make_fractions(LitheCtx *ctx, Body *b, LitheIndex cells) {
  double min[3], max[3], origin[3], h[3], longest = 0;
  LitheIndex n[3];
  const int dim = b->options->dim;
  const LthFractionDef def = {.method = LTH_FRACTIONS_SAMPLES, .samples = 4};
  lth_shape_bounds(&b->shape, min, max);
  for (int a = 0; a < dim; a++) longest = fmax(longest, max[a] - min[a]);
  for (int a = 0; a < 3; a++) {
    bool flat = dim == 2 && a == 2;
    h[a] = flat ? 1 : longest / (cells - 2.67);
    n[a] = flat ? 1 : (LitheIndex)ceil((max[a] - min[a]) / h[a] + 2.67);
    origin[a] = flat ? 0 : 0.5 * (min[a] + max[a] - h[a] * n[a]);
  }
  if (dim == 3) b->bottom = min[2] + 0.1 * (max[2] - min[2]);
  check(ctx, lth_fractions_create(ctx, &b->shape, dim, origin, h, n, &def, &b->fractions));
}

static void make_disc(LitheCtx *ctx, Body *b, const LthStaggeredHold *hold) {
  const LthStaggeredDef def = {
      .fractions = b->fractions,
      .shape = &b->shape,
      .material = {.eval = material, .self = &b->options->nu, .is_uniform = true},
      .formulation = is_mixed(b->options) ? LTH_FORM_MIXED : LTH_FORM_DISPLACEMENT,
      .holds = hold,
      .n_holds = 1};
  check(ctx, lth_staggered_create(ctx, &def, &b->disc));
  b->s = lth_staggered_of(b->disc);
  LitheCount n = b->disc->n_dofs;
  b->rhs = lth_alloc(ctx, n, sizeof *b->rhs);
  b->w = lth_alloc(ctx, n, sizeof *b->w);
  if (!b->rhs || !b->w) check(ctx, LITHE_NO_MEMORY);
  b->disc->table->add_gravity(b->disc, (double[3]){3, -9.81, -5}, b->rhs);
  b->unknowns = 0;
  for (LitheCount i = 0; i < n; i++) {
    if (b->s->held[i]) b->rhs[i] = 0;
    b->unknowns += !b->s->held[i];
  }
}

static void body_free(LitheCtx *ctx, Body *b) {
  lth_free(ctx, b->rhs);
  lth_free(ctx, b->w);
  lth_free(ctx, b->r);
  lth_disc_destroy(ctx, &b->disc);
  lth_fractions_destroy(ctx, &b->fractions);
  lth_shape_free(ctx, &b->shape);
  lth_surface_destroy(ctx, &b->surface);
  lth_soup_destroy(ctx, &b->soup);
}

enum { TRIAD = 8000000, ROUNDS = 25 };

/// STREAM's triad, a = b + c d.
typedef struct Triad {
  double *a, *b, *c;
} Triad;

/// Arrays that have been written: pages that nobody has written are one page of zeros, which the cache holds.
static void triad_create(LitheCtx *ctx, Triad *t) {
  t->a = lth_alloc(ctx, TRIAD, 8);
  t->b = lth_alloc(ctx, TRIAD, 8);
  t->c = lth_alloc(ctx, TRIAD, 8);
  if (!t->a || !t->b || !t->c) check(ctx, LITHE_NO_MEMORY);
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount i = 0; i < TRIAD; i++) t->a[i] = 0, t->b[i] = 1, t->c[i] = 2;
}

static void triad_run(const LitheCtx *ctx, const Triad *t, double by) {
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx))
  for (LitheCount i = 0; i < TRIAD; i++) t->a[i] = t->b[i] + by * t->c[i];
}

static void triad_free(LitheCtx *ctx, Triad *t) {
  lth_free(ctx, t->a);
  lth_free(ctx, t->b);
  lth_free(ctx, t->c);
}

static double norm(LitheCount n, const double *x) { return sqrt(lth_dot(1, n, x, x)); }

/// Free unknowns as numbers 0, 1, ... in the order of functions, -1 elsewhere.
static LitheIndex *number_free(LitheCtx *ctx, const Body *b) {
  LitheIndex *index = lth_alloc(ctx, b->disc->n_dofs, sizeof *index), n = 0;
  if (!index) check(ctx, LITHE_NO_MEMORY);
  for (LitheCount i = 0; i < b->disc->n_dofs; i++) index[i] = b->s->held[i] ? -1 : n++;
  return index;
}

/// Entries of row i over free unknowns; returns how many.
static int32_t free_row(const Body *b, const LitheIndex *index, LitheCount i, int32_t *col,
                        double *value) {
  LthStaggeredEntry entry[LTH_STAGGERED_ROW];
  int32_t n = 0;
  int all = lth_staggered_row(&b->s->level, 0, 1, (int)(i % 3), b->s->slot[i / 3], entry);
  for (int e = 0; e < all; e++) {
    LitheIndex to = index[3 * (LitheCount)b->s->func[entry[e].slot] + entry[e].b];
    if (to < 0) continue;
    col[n] = to;
    value[n++] = entry[e].value;
  }
  return n;
}

/// Little-endian: n, entries (int64); entries of all rows (int32); columns (int32); values; right-hand side; then
/// 3 x function + component and the place of every unknown, four numbers each.
static void export_matrix(LitheCtx *ctx, const Body *b, const char *path) {
  enum { COUNTS, COLUMNS, VALUES, PARTS };
  FILE *file = fopen(path, "wb");
  if (!file) {
    fprintf(stderr, "cannot write %s\n", path);
    exit(1);
  }
  LitheIndex *index = number_free(ctx, b);
  int64_t head[2] = {b->unknowns, 0};
  fwrite(head, 8, 2, file);
  for (int part = COUNTS; part < PARTS; part++)
    for (LitheCount i = 0; i < b->disc->n_dofs; i++) {
      if (index[i] < 0) continue;
      int32_t col[LTH_STAGGERED_ROW];
      double value[LTH_STAGGERED_ROW];
      int32_t n = free_row(b, index, i, col, value);
      if (part == COUNTS) head[1] += n, fwrite(&n, 4, 1, file);
      if (part == COLUMNS) fwrite(col, 4, (size_t)n, file);
      if (part == VALUES) fwrite(value, 8, (size_t)n, file);
    }
  for (LitheCount i = 0; i < b->disc->n_dofs; i++)
    if (index[i] >= 0) fwrite(b->rhs + i, 8, 1, file);
  for (LitheCount i = 0; i < b->disc->n_dofs; i++) {
    if (index[i] < 0) continue;
    double at[4] = {(double)i};
    lth_staggered_place(b->s, (LitheIndex)(i / 3), (int)(i % 3), at + 1);
    fwrite(at, 8, 4, file);
  }
  rewind(file);
  fwrite(head, 8, 2, file);
  fclose(file);
  lth_free(ctx, index);
}

typedef struct Row {
  double fractions, disc, prepare, solve, residual, triad, apply, ratio, dense, moved, full,
      full_work, full_error, bytes;
  LitheIndex iterations;
} Row;

static int by_value(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median(double v[ROUNDS]) {
  qsort(v, ROUNDS, sizeof *v, by_value);
  return v[ROUNDS / 2];
}

/// The operator against the triad and against plain loops, which take turns; ratios are medians over rounds, since others use the memory
/// too. One application on vectors that lie as the solver's do is what a step of conjugate gradients costs: the call adds the
/// way there and back.
static void time_operator(LitheCtx *ctx, Body *b, Row *row) {
  double ratio[ROUNDS], dense_ratio[ROUNDS], bytes[ROUNDS];
  const double least = 16.0 * (double)b->unknowns;
  Triad t;
  DenseStencil box;
  triad_create(ctx, &t);
  check(ctx, dense_stencil_create(ctx, b->options->dim, b->unknowns, &box));
  row->apply = 1e9;
  for (int run = 0; run < ROUNDS; run++) {
    double at[3];
    at[0] = lth_now();
    triad_run(ctx, &t, run);
    at[1] = lth_now();
    dense_stencil_apply(ctx, &box);
    at[2] = lth_now();
    const double seconds = lth_staggered_multigrid_time_apply(ctx, b->s->solver);
    bytes[run] = 24.0 * TRIAD / (at[1] - at[0]);
    ratio[run] = seconds * bytes[run] / least;
    dense_ratio[run] = (at[2] - at[1]) * box.share * bytes[run] / least;
    row->apply = fmin(row->apply, seconds);
  }
  row->ratio = median(ratio);
  row->dense = median(dense_ratio);
  row->triad = median(bytes);
  row->moved = row->ratio * least / (double)lth_staggered_multigrid_apply_bytes(b->s->solver);
  dense_stencil_free(ctx, &box);
  triad_free(ctx, &t);
}

static void time_full(LitheCtx *ctx, Body *b, Row *row) {
  LitheCount n = b->disc->n_dofs;
  row->full = 1e9;
  for (int run = 0; run < 3; run++) {
    double seconds;
    check(ctx, lth_staggered_multigrid_time_full(ctx, b->s->solver, b->rhs, 2, &seconds,
                                                 &row->full_work));
    row->full = fmin(row->full, seconds);
  }
  if (!b->s->mixed) check(ctx, lth_staggered_multigrid_full(ctx, b->s->solver, b->rhs, b->r));
  for (LitheCount i = 0; i < n; i++) b->r[i] -= b->w[i];
  row->full_error = norm(n, b->r) / norm(n, b->w);
}

/// On one thread processor time, which other programs on the machine disturb less.
static double now(const Options *o) {
  struct timespec at;
  if (o->threads != 1) return lth_now();
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &at);
  return (double)at.tv_sec + 1e-9 * (double)at.tv_nsec;
}

static void measure(LitheCtx *ctx, const Options *o, LitheIndex cells) {
  Body b = {.options = o};
  Row row = {0};
  const LthStaggeredHold hold = {.selects = is_held, .self = &b, .fixed = {true, true, true}};
  LthSolveReport report;
  double start = now(o);
  LitheCount before = lth_alloc_bytes(ctx);
  make_shape(ctx, &b);
  make_fractions(ctx, &b, cells);
  row.fractions = now(o) - start, start = now(o);
  make_disc(ctx, &b, &hold);
  row.disc = now(o) - start, start = now(o);
  check(ctx, b.disc->table->solver->prepare(ctx, b.disc, 0, 1));
  row.prepare = now(o) - start;
  if (b.disc->table->solver->aim) check(ctx, b.disc->table->solver->aim(ctx, b.disc, b.w));
  start = now(o);
  check(ctx, b.disc->table->solver->solve(ctx, b.disc, NULL, 1, b.rhs, b.w, 1e-8, 200, &report));
  row.solve = now(o) - start;
  row.bytes = (double)(lth_alloc_bytes(ctx) - before) / (double)b.unknowns;
  b.r = lth_alloc(ctx, b.disc->n_dofs, sizeof *b.r); // for the checks below alone
  if (!b.r) check(ctx, LITHE_NO_MEMORY);
  double solver_bytes = (double)b.disc->table->solver->bytes(b.disc) / (double)b.unknowns;
  b.disc->table->solver->apply(b.disc, lth_threads(ctx), 0, 1, b.w, b.r);
  for (LitheCount i = 0; i < b.disc->n_dofs; i++) b.r[i] = b.s->held[i] ? 0 : b.rhs[i] - b.r[i];
  row.residual = norm(b.disc->n_dofs, b.r) / norm(b.disc->n_dofs, b.rhs);
  if (o->nu == 0.5) row.residual = report.residual; // K alone does not balance without pressures
  time_operator(ctx, &b, &row);
  time_full(ctx, &b, &row);
  printf(
      o->csv
          ? "%d,%d,%g,%d,%.1f,%lld,%.3f,%.3f,%.3f,%.3f,%d,%.1e,%.0f,%.1f,%.1f,%.2e,%.2f,%.2f,%.2f,%"
            ".1f,%.1f,%.1e\n"
          : "%dD %5d nu %-5g threads %d triad %.1f GB/s %10lld unknowns: fractions %.3f disc %.3f "
            "prepare %.3f solve %.3f s, "
            "%d iterations, residual %.1e, %.0f unknowns/s, %.1f bytes an unknown (solver %.1f), "
            "operator %.2e s, %.2f x memory (dense %.2f), %.2f x moved, full multigrid %.1f "
            "operators, work %.1f, error %.1e\n",
      o->dim, cells, o->nu, lth_threads(ctx), row.triad * 1e-9, (long long)b.unknowns,
      row.fractions, row.disc, row.prepare, row.solve, report.iterations, row.residual,
      (double)b.unknowns / (row.prepare + row.solve), row.bytes, solver_bytes, row.apply, row.ratio,
      row.dense, row.moved, row.full / row.apply, row.full_work, row.full_error);
  fflush(stdout);
  if (o->file) export_matrix(ctx, &b, o->file);
  body_free(ctx, &b);
}

static Options read_options(int argc, char **argv) {
  Options o = {.dim = 0, .nu = 0.3};
  for (int i = 1; i < argc; i++) {
    const char *value = i + 1 < argc ? argv[i + 1] : "";
    if (strcmp(argv[i], "--csv") == 0) {
      o.csv = true;
      continue;
    }
    if (strcmp(argv[i], "--displacement") == 0) {
      o.displacement = true;
      continue;
    }
    i++;
    if (strcmp(argv[i - 1], "--threads") == 0)
      o.threads = atoi(value);
    else if (strcmp(argv[i - 1], "--dim") == 0)
      o.dim = atoi(value);
    else if (strcmp(argv[i - 1], "--cells") == 0)
      o.cells = atoi(value);
    else if (strcmp(argv[i - 1], "--nu") == 0)
      o.nu = atof(value);
    else if (strcmp(argv[i - 1], "--mesh") == 0)
      o.mesh = value;
    else if (strcmp(argv[i - 1], "--export") == 0)
      o.file = value;
    else {
      fprintf(stderr, "unknown option %s\n", argv[i - 1]);
      exit(2);
    }
  }
  return o;
}

int main(int argc, char **argv) {
  Options o = read_options(argc, argv);
  LitheCtxDef def = lithe_ctx_def_default();
  LitheCtx *ctx = lithe_ctx_create(&def);
  lth_set_threads(ctx, o.threads);
  if (o.csv)
    printf("dim,cells,nu,threads,triad GB/s,unknowns,fractions s,disc s,prepare s,solve "
           "s,iterations,residual,"
           "unknowns/s,bytes/unknown,solver bytes/unknown,operator s,"
           "operator/memory bound,dense/memory bound,operator/moved bound,fmg operators,fmg "
           "work,fmg error\n");
  int wanted = o.dim;
  for (o.dim = 2; o.dim <= 3; o.dim++) {
    if (wanted && wanted != o.dim) continue;
    LitheIndex first = o.dim == 2 ? 256 : 32, last = o.dim == 2 ? 1024 : 128;
    if (o.cells) first = last = o.cells;
    for (LitheIndex cells = first; cells <= last; cells *= 2) measure(ctx, &o, cells);
  }
  lithe_ctx_destroy(&ctx);
  return 0;
}

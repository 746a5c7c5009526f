/// What can move without energy: whole pieces and nothing else, on shapes cut at random.
#include "staggered_body.h"

#include "base/eigen.h"

/// Random voxels of about `share`, cut down a bit at random where `cut`.
typedef struct Noise {
  uint64_t seed;
  double share;
  bool cut;
  double h;
} Noise;

static double hash(uint64_t seed, const LitheIndex c[3]) {
  uint64_t state = seed * 1000003 + (uint64_t)(c[0] + 100) * 7919 +
                   (uint64_t)(c[1] + 100) * 104729 + (uint64_t)(c[2] + 100) * 1299709;
  for (int i = 0; i < 4; i++) test_random(&state);
  return test_random(&state);
}

static double noise_part(const void *self, const double low[3], const double size[3]) {
  const Noise *n = self;
  LitheIndex cell[3] = {0}, part[3] = {0};
  for (int a = 0; a < 3; a++) {
    if (size[a] == 0) continue;
    double at = low[a] + 0.5 * size[a];
    cell[a] = (LitheIndex)floor(at / n->h);
    part[a] = (LitheIndex)floor(2 * at / n->h);
    if (at < 0 || at > 1) return 0;
  }
  if (hash(n->seed, cell) > n->share) return 0;
  return n->cut ? fmax(0, 2 * hash(n->seed + 1, part) - 0.7) / 1.3 : 1;
}

/// Pieces of live cells that share faces.
static int count_pieces(const SgBody *b) {
  const LthStaggered *s = b->s;
  LitheIndex n = b->disc->n_cells, pieces = 0, *stack = malloc(sizeof *stack * (size_t)n);
  uint8_t *seen = calloc((size_t)n, 1);
  for (LitheIndex first = 0; first < n; first++) {
    LitheIndex top = 0;
    if (seen[first]) continue;
    pieces++;
    seen[first] = 1;
    stack[top++] = first;
    while (top > 0) {
      LitheIndex c = stack[--top];
      for (int k = 0; k < 2 * s->dim; k++) {
        int d[3] = {0};
        d[k / 2] = k % 2 ? 1 : -1;
        LitheCount slot = lth_sparse_grid_step(s->grid, s->cell_slot[c], d);
        if (slot < 0 || s->cell[slot] < 0 || seen[s->cell[slot]]) continue;
        seen[s->cell[slot]] = 1;
        stack[top++] = s->cell[slot];
      }
    }
  }
  free(stack);
  free(seen);
  return pieces;
}

/// Eigenvalues of the matrix of free unknowns with unit diagonal that are zero to rounding.
static int count_zero(const SgBody *b, double *least) {
  LitheCount n = b->disc->n_dofs, m = 0;
  LitheIndex *row = malloc(sizeof *row * (size_t)n);
  for (LitheCount k = 0; k < n; k++) row[k] = sg_is_free(b, k) ? (LitheIndex)m++ : -1;
  double *A = calloc((size_t)(m * m), sizeof *A), *values = malloc(sizeof *values * (size_t)m);
  double *scale = malloc(sizeof *scale * (size_t)m);
  for (int pass = 0; pass < 2; pass++)
    for (LitheIndex i = 0; i < b->K->n_rows; i++)
      for (LitheCount e = b->K->block_off[i]; e < b->K->block_off[i + 1]; e++)
        for (int k = 0; k < 9; k++) {
          LitheCount p = row[3 * i + k / 3], q = row[3 * b->K->block_col[e] + k % 3];
          double v = b->K->values[b->K->value_off[e] + k];
          if (p < 0 || q < 0) continue;
          if (pass == 0 && p == q) scale[p] = 1 / sqrt(v);
          if (pass == 1) A[p * m + q] = v * scale[p] * scale[q];
        }
  lth_symmetric_eigen((int)m, A, values, NULL);
  int zero = 0;
  while (zero < m && values[zero] < 1e-11) zero++;
  *least = zero < m ? values[zero] : 1;
  free(row), free(A), free(values), free(scale);
  return zero;
}

static void check_modes(int dim, LitheIndex n, Noise noise) {
  SgBody b = {.ctx = test_ctx()};
  SgDef def = {.dim = dim, .high = {1, 1, 1}, .n = {n, n, n}, .part = noise_part};
  noise.h = 1.0 / n;
  def.part_self = &noise;
  b.def = def;
  b.def.material = (LthMaterialField){.eval = sg_material, .self = &b.def, .is_uniform = true};
  sg_fractions(&b);
  LitheStatus status = sg_try(&b); // nothing may be left
  lth_disc_destroy(b.ctx, &b.disc);
  lth_fractions_destroy(b.ctx, &b.fractions);
  lithe_ctx_destroy(&b.ctx);
  if (status != LITHE_OK) return;
  sg_create(&b, &def);
  sg_assemble(&b);
  double least;
  int zero = count_zero(&b, &least), pieces = count_pieces(&b), rigid = dim == 2 ? 3 : 6;
  if (zero % rigid || zero < rigid || zero > rigid * pieces)
    fail_msg("dim %d seed %d: %d motions without energy, %d pieces", dim, (int)noise.seed, zero,
             pieces);
  sg_free(&b);
}

static void only_whole_pieces_move_freely_whatever_the_shape(void **state) {
  (void)state;
  for (int k = 0; k < 30; k++) {
    check_modes(2, 7, (Noise){.seed = (uint64_t)k + 1, .share = 0.5 + 0.015 * k});
    check_modes(2, 6, (Noise){.seed = (uint64_t)k + 100, .share = 0.6 + 0.015 * k, .cut = true});
  }
  for (int k = 0; k < 3; k++) {
    check_modes(3, 4, (Noise){.seed = (uint64_t)k + 1, .share = 0.6 + 0.12 * k});
    check_modes(3, 4, (Noise){.seed = (uint64_t)k + 50, .share = 0.7 + 0.12 * k, .cut = true});
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(only_whole_pieces_move_freely_whatever_the_shape),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

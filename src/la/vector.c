/// Sums over vectors in fixed blocks and fixed order: the same bits for any number of threads.
#include "la/vector.h"

#include "base/clones.h"

#include <omp.h>

#define MAX_BLOCKS 512
#define MIN_BLOCK 2048 // doubles; smaller pieces are not worth a thread
#define LANES 8
#define PARALLEL_MIN                                                                               \
  40000 // entries; to wake a second thread costs some microseconds, or a lot on a busy machine

/// How n entries are cut; depends on n only.
typedef struct Blocks {
  LitheCount n, size;
  int count;
} Blocks;

static Blocks cut(LitheCount n) {
  LitheCount size = (n + MAX_BLOCKS - 1) / MAX_BLOCKS;
  if (size < MIN_BLOCK) size = MIN_BLOCK;
  return (Blocks){n, size, (int)((n + size - 1) / size)};
}

static LitheCount block_length(Blocks b, int i) {
  LitheCount left = b.n - i * b.size;
  return left < b.size ? left : b.size;
}

static double add_up(const double *part, int count) {
  double sum = 0;
  for (int i = 0; i < count; i++) sum += part[i];
  return sum;
}

static double lanes_sum(const double *lane) {
  double sum = 0;
  for (int l = 0; l < LANES; l++) sum += lane[l];
  return sum;
}

LTH_CLONES
static double dot_block(LitheCount n, const double *restrict x, const double *restrict y) {
  double lane[LANES] = {0}, tail = 0;
  LitheCount i = 0;
  for (; i + LANES <= n; i += LANES)
    for (int l = 0; l < LANES; l++) lane[l] += x[i + l] * y[i + l];
  for (; i < n; i++) tail += x[i] * y[i];
  return lanes_sum(lane) + tail;
}

LTH_CLONES
static double square_block(LitheCount n, const double *restrict x) {
  double lane[LANES] = {0}, tail = 0;
  LitheCount i = 0;
  for (; i + LANES <= n; i += LANES)
    for (int l = 0; l < LANES; l++) lane[l] += x[i + l] * x[i + l];
  for (; i < n; i++) tail += x[i] * x[i];
  return lanes_sum(lane) + tail;
}

LTH_CLONES
static void axpy_block(LitheCount n, double a, const double *restrict x, double *restrict y) {
  for (LitheCount i = 0; i < n; i++) y[i] += a * x[i];
}

LTH_CLONES
static void xpay_block(LitheCount n, const double *restrict x, double a, double *restrict y) {
  for (LitheCount i = 0; i < n; i++) y[i] = x[i] + a * y[i];
}

double lth_dot(int threads, LitheCount n, const double *x, const double *y) {
  double part[MAX_BLOCKS];
  Blocks b = cut(n);
#pragma omp parallel for schedule(static) num_threads(threads) if (n > PARALLEL_MIN)
  for (int i = 0; i < b.count; i++)
    part[i] = x == y ? square_block(block_length(b, i), x + i * b.size)
                     : dot_block(block_length(b, i), x + i * b.size, y + i * b.size);
  return add_up(part, b.count);
}

double lth_residual(int threads, LitheCount n, const double *b, const double *q, double *r) {
  double part[MAX_BLOCKS];
  Blocks k = cut(n);
#pragma omp parallel for schedule(static) num_threads(threads) if (n > PARALLEL_MIN)
  for (int i = 0; i < k.count; i++) {
    LitheCount first = i * k.size, length = block_length(k, i);
    for (LitheCount j = first; j < first + length; j++) r[j] = b[j] - q[j];
    part[i] = square_block(length, r + first);
  }
  return add_up(part, k.count);
}

void lth_direction(int threads, LitheCount n, const double *z, double beta, double *p) {
  Blocks b = cut(n);
#pragma omp parallel for schedule(static) num_threads(threads) if (n > PARALLEL_MIN)
  for (int i = 0; i < b.count; i++)
    xpay_block(block_length(b, i), z + i * b.size, beta, p + i * b.size);
}

double lth_advance(int threads, LitheCount n, double alpha, const double *p, const double *q,
                   double *x, double *r) {
  double part[MAX_BLOCKS];
  Blocks b = cut(n);
#pragma omp parallel for schedule(static) num_threads(threads) if (n > PARALLEL_MIN)
  for (int i = 0; i < b.count; i++) {
    LitheCount first = i * b.size, length = block_length(b, i);
    axpy_block(length, alpha, p + first, x + first);
    axpy_block(length, -alpha, q + first, r + first);
    part[i] = square_block(length, r + first);
  }
  return add_up(part, b.count);
}

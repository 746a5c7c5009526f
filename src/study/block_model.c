/// Bodies made of mapped blocks: their surface as a file to slice, and conforming meshes of them as files.
#include "study/block_model.h"

#include "base/hash.h"
#include "io/file.h"

#include <string.h>

#define GRAIN 1e-9 // of the body's size: places this close are one

/// Nodes of a 27-node hexahedron in Gmsh's order, as halves of its edges; the first 8 are the corners.
static const int node_place[27][3] = {
    {0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
    {0, 2, 2}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 1, 0}, {2, 0, 1}, {1, 2, 0},
    {2, 2, 1}, {0, 2, 1}, {1, 0, 2}, {0, 1, 2}, {2, 1, 2}, {1, 2, 2}, {1, 1, 0},
    {1, 0, 1}, {0, 1, 1}, {2, 1, 1}, {1, 2, 1}, {1, 1, 2}, {1, 1, 1}};

/// Sides of a hexahedron, outward.
static const int side_nodes[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                     {3, 7, 6, 2}, {0, 4, 7, 3}, {1, 2, 6, 5}};

/// Points and elements, while they are gathered.
typedef struct Build {
  LthStudyRun *run;
  const LthBlockModel *model;
  int level, n_nodes;
  double grain;
  LthHash index;
  double *point;
  LitheIndex *element; ///< (n_elements x n_nodes)
  LitheCount point_cap, element_cap;
  LitheIndex n_points, n_elements;
} Build;

/// Cells of a block along an axis.
static int cells_along(const Build *b, int axis) {
  return (axis == 2 && b->model->is_flat ? 1 : b->level) * b->model->cells[axis];
}

static double find_size(const LthBlockModel *m) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  double x[3], size = 0;
  for (int b = 0; b < m->n_blocks; b++)
    for (int k = 0; k < 27; k++) {
      double at[3];
      for (int a = 0; a < 3; a++) at[a] = node_place[k][a] / 2.0;
      m->map(b, at, x);
      for (int a = 0; a < 3; a++) {
        low[a] = fmin(low[a], x[a]);
        high[a] = fmax(high[a], x[a]);
      }
    }
  for (int a = 0; a < 3; a++) size = fmax(size, high[a] - low[a]);
  return size;
}

static LitheStatus add_point(Build *b, const double x[3], LitheIndex *number) {
  LitheIndex key[3];
  for (int a = 0; a < 3; a++) key[a] = (LitheIndex)lround(x[a] / b->grain);
  LITHE_TRY(lth_hash_insert(b->run->ctx, &b->index, lth_hash_pair(key[0], key[1]),
                            lth_hash_pair(key[2], 0), b->n_points, number));
  if (*number < b->n_points) return LITHE_OK;
  LTH_RESERVE(b->run->ctx, b->point, b->point_cap, 3 * ((LitheCount)b->n_points + 1));
  memcpy(b->point + 3 * (size_t)b->n_points++, x, 3 * sizeof *x);
  return LITHE_OK;
}

static LitheStatus add_element(Build *b, int block, const int cell[3]) {
  LTH_RESERVE(b->run->ctx, b->element, b->element_cap,
              ((LitheCount)b->n_elements + 1) * b->n_nodes);
  LitheIndex *node = b->element + (size_t)b->n_elements++ * (size_t)b->n_nodes;
  for (int k = 0; k < b->n_nodes; k++) {
    double at[3], x[3];
    for (int a = 0; a < 3; a++) at[a] = (cell[a] + node_place[k][a] / 2.0) / cells_along(b, a);
    b->model->map(block, at, x);
    LITHE_TRY(add_point(b, x, node + k));
  }
  return LITHE_OK;
}

static LitheStatus gather(Build *b) {
  const int n[3] = {cells_along(b, 0), cells_along(b, 1), cells_along(b, 2)};
  int cell[3];
  b->grain = GRAIN * find_size(b->model);
  for (int block = 0; block < b->model->n_blocks; block++)
    for (cell[2] = 0; cell[2] < n[2]; cell[2]++)
      for (cell[1] = 0; cell[1] < n[1]; cell[1]++)
        for (cell[0] = 0; cell[0] < n[0]; cell[0]++) LITHE_TRY(add_element(b, block, cell));
  return LITHE_OK;
}

static void free_build(Build *b) {
  lth_hash_free(b->run->ctx, &b->index);
  lth_free(b->run->ctx, b->point);
  lth_free(b->run->ctx, b->element);
}

/// The key of a side, whichever way round it is seen.
static void side_key(const LitheIndex *node, const int side[4], uint64_t key[2]) {
  LitheIndex sorted[4];
  for (int i = 0; i < 4; i++) {
    int j = i;
    for (; j > 0 && sorted[j - 1] > node[side[i]]; j--) sorted[j] = sorted[j - 1];
    sorted[j] = node[side[i]];
  }
  key[0] = lth_hash_pair(sorted[0], sorted[1]);
  key[1] = lth_hash_pair(sorted[2], sorted[3]);
}

static LitheIndex side_node(const Build *b, LitheIndex side, int k) {
  return b->element[(size_t)(side / 6) * (size_t)b->n_nodes + (size_t)side_nodes[side % 6][k]];
}

static void put_point(FILE *out, const char *word, const Build *b, LitheIndex i) {
  const double *x = b->point + 3 * (size_t)i;
  fprintf(out, "%s %.15g %.15g %.15g\n", word, x[0], x[1], x[2]);
}

/// Number of elements at every side: is_inner (n_elements x 6).
static LitheStatus find_inner_sides(const Build *b, bool *is_inner) {
  LthHash first = {0};
  LitheStatus status = LITHE_OK;
  for (LitheIndex s = 0; s < 6 * b->n_elements && status == LITHE_OK; s++) {
    uint64_t key[2];
    LitheIndex kept;
    side_key(b->element + (size_t)(s / 6) * (size_t)b->n_nodes, side_nodes[s % 6], key);
    status = lth_hash_insert(b->run->ctx, &first, key[0], key[1], s, &kept);
    if (status == LITHE_OK && kept != s) is_inner[s] = is_inner[kept] = true;
  }
  lth_hash_free(b->run->ctx, &first);
  return status;
}

/// The sides that belong to one element alone and their points, numbered anew: `number` (n_points) is zero.
static void put_surface(FILE *out, const Build *b, const bool *is_inner, LitheIndex *number) {
  LitheIndex n = 0;
  for (LitheIndex s = 0; s < 6 * b->n_elements; s++)
    for (int k = 0; k < 4 && !is_inner[s]; k++) {
      LitheIndex i = side_node(b, s, k);
      if (number[i]) continue;
      number[i] = ++n;
      put_point(out, "v", b, i);
    }
  for (LitheIndex s = 0; s < 6 * b->n_elements; s++)
    if (!is_inner[s])
      fprintf(out, "f %d %d %d %d\n", number[side_node(b, s, 0)], number[side_node(b, s, 1)],
              number[side_node(b, s, 2)], number[side_node(b, s, 3)]);
}

static LitheStatus write_surface(const Build *b, const char *path) {
  LitheCtx *ctx = b->run->ctx;
  LthFileWriter writer;
  bool *is_inner = NULL;
  LitheIndex *number = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, is_inner, 6 * (LitheCount)b->n_elements);
  LTH_NEW_OR(done, ctx, number, b->n_points);
  LITHE_TRY_OR(done, find_inner_sides(b, is_inner));
  LITHE_TRY_OR(done, lth_file_open(ctx, path, &writer));
  put_surface(writer.stream, b, is_inner, number);
  status = lth_file_commit(ctx, &writer);
done:
  lth_free(ctx, is_inner);
  lth_free(ctx, number);
  return status;
}

LitheStatus lth_block_model_surface(LthStudyRun *run, const LthBlockModel *model, int level,
                                    const char *name) {
  Build b = {.run = run, .model = model, .level = level, .n_nodes = 8};
  LITHE_TRY(lth_folder_make(run->ctx, run->folder));
  LitheStatus status = gather(&b);
  if (status == LITHE_OK)
    status = write_surface(&b, lth_study_print(run, "%s/%s.obj", run->folder, name));
  free_build(&b);
  return status;
}

static LitheStatus write_mesh(const Build *b, const char *path) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(b->run->ctx, path, &writer));
  FILE *out = writer.stream;
  fprintf(out, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", b->n_points);
  for (LitheIndex i = 0; i < b->n_points; i++) fprintf(out, "%d ", i + 1), put_point(out, "", b, i);
  fprintf(out, "$EndNodes\n$Elements\n%d\n", b->n_elements);
  for (LitheIndex e = 0; e < b->n_elements; e++) {
    fprintf(out, "%d %d 2 1 1", e + 1, b->n_nodes == 8 ? 5 : 12);
    for (int k = 0; k < b->n_nodes; k++)
      fprintf(out, " %d", b->element[(size_t)e * (size_t)b->n_nodes + (size_t)k] + 1);
    fputc('\n', out);
  }
  fputs("$EndElements\n", out);
  return lth_file_commit(b->run->ctx, &writer);
}

LitheStatus lth_block_model_mesh(LthStudyRun *run, const LthBlockModel *model, int level, int order,
                                 const char *name) {
  Build b = {.run = run, .model = model, .level = level, .n_nodes = order == 1 ? 8 : 27};
  LITHE_TRY(lth_folder_make(run->ctx, run->folder));
  LitheStatus status = gather(&b);
  if (status == LITHE_OK)
    status = write_mesh(&b, lth_study_print(run, "%s/%s.msh", run->folder, name));
  free_build(&b);
  return status;
}

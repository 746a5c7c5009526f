/// Parts to faces of the mesh; those that a merge left side by side in one plane are joined.
#include "mesh/slice.h"

#include "base/disjoint_sets.h"
#include "base/tensor.h"

#include <math.h>
#include <stdlib.h>

/// A face below this share of the area of an element at it is a line: it is left out.
#define NO_FACE 1e-15

/// A part between two final elements (the second is -1 beyond the boundary).
typedef struct FacePart {
  LitheIndex owner, neighbour, part;
  bool is_flipped;
  int64_t plane; ///< equal for parts that may be one face
} FacePart;

/// An undirected edge of one of several parts.
typedef struct RunEdge {
  uint64_t points;
  LitheIndex part;
} RunEdge;

typedef struct Faces {
  Slicer *s;
  FacePart *list;
  bool *is_merged; ///< groups of several elements
  LitheIndex *loop_off, *off, *point, *cell, *tag;
  LitheCount n_list, n, n_loops, n_points;
  LitheCount loop_off_cap, off_cap, point_cap, cell_cap, tag_cap;
  RunEdge *run_edge;
  LitheIndex *run_parent, *edge;
  LitheCount run_edge_cap, run_parent_cap, edge_cap;
} Faces;

static int compare_face_parts(const void *a, const void *b) {
  const FacePart *x = a, *y = b;
  if (x->owner != y->owner) return x->owner < y->owner ? -1 : 1;
  if (x->neighbour != y->neighbour) return x->neighbour < y->neighbour ? -1 : 1;
  if (x->plane != y->plane) return x->plane < y->plane ? -1 : 1;
  return (x->part > y->part) - (x->part < y->part);
}

static LitheIndex group_of(const SliceElements *e, LitheCount side) {
  return e->of[side] < 0 ? -1 : e->group[e->of[side]];
}

static LitheStatus list_parts(Faces *f) {
  Slicer *s = f->s;
  SliceElements *e = &s->elements;
  LTH_NEW(s->ctx, f->is_merged, e->n_groups);
  LTH_NEW(s->ctx, f->list, s->parts.n);
  LitheIndex *count = NULL;
  LTH_NEW(s->ctx, count, e->n_groups);
  for (LitheIndex i = 0; i < e->n; i++)
    if (e->group[i] >= 0) f->is_merged[e->group[i]] = ++count[e->group[i]] > 1;
  lth_free(s->ctx, count);
  for (LitheIndex p = 0; p < s->parts.n; p++) {
    const SlicePiece *piece = s->pieces.piece + s->parts.piece[p];
    LitheIndex a = group_of(e, 2 * (LitheCount)p), b = group_of(e, 2 * (LitheCount)p + 1);
    if (a == b) continue;
    bool flip = a < 0 || (b >= 0 && b < a);
    bool is_cap = piece->axis != SLICE_BOUNDARY;
    f->list[f->n_list++] =
        (FacePart){flip ? b : a, flip ? a : b, p, flip,
                   ((int64_t)piece->axis << 40) + (is_cap ? piece->slab[piece->axis] : piece->tag)};
  }
  qsort(f->list, (size_t)f->n_list, sizeof *f->list, compare_face_parts);
  return LITHE_OK;
}

/// Write the loops [first, last) of the parts' list as one face, unless it has no area.
static LitheStatus write_face(Faces *f, const FacePart *at, LitheIndex first, LitheIndex last) {
  LitheCtx *ctx = f->s->ctx;
  const SliceParts *parts = &f->s->parts;
  const double *element_area = f->s->elements.area;
  double sum[3] = {0, 0, 0}, least = element_area[at->owner];
  if (at->neighbour >= 0) least = fmin(least, element_area[at->neighbour]);
  for (LitheIndex l = first; l < last; l++) {
    double vector[3];
    lth_slice_area_vector(f->s->point, parts->point + parts->off[l],
                          parts->off[l + 1] - parts->off[l], vector);
    lth_v3_add(sum, vector, sum);
  }
  if (!(lth_v3_norm(sum) > NO_FACE * least)) return LITHE_OK;

  for (LitheIndex l = first; l < last; l++) {
    LitheIndex a = parts->off[l], b = parts->off[l + 1];
    LTH_RESERVE(ctx, f->point, f->point_cap, f->n_points + b - a);
    LTH_RESERVE(ctx, f->off, f->off_cap, f->n_loops + 2);
    for (LitheIndex i = a; i < b; i++)
      f->point[f->n_points++] = parts->point[at->is_flipped ? b - 1 - (i - a) : i];
    if (f->n_points > INT32_MAX)
      LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "slicing: more than 2^31 corners; use larger cells");
    f->off[++f->n_loops] = (LitheIndex)f->n_points;
  }
  LTH_RESERVE(ctx, f->loop_off, f->loop_off_cap, f->n + 2);
  LTH_RESERVE(ctx, f->cell, f->cell_cap, 2 * (f->n + 1));
  LTH_RESERVE(ctx, f->tag, f->tag_cap, f->n + 1);
  f->cell[2 * f->n] = at->owner;
  f->cell[2 * f->n + 1] = at->neighbour;
  f->tag[f->n] = f->s->pieces.piece[parts->piece[at->part]].tag;
  f->loop_off[++f->n] = (LitheIndex)f->n_loops;
  return LITHE_OK;
}

static LitheStatus write_part(Faces *f, const FacePart *at) {
  const LitheIndex *loop_off = f->s->parts.loop_off;
  return write_face(f, at, loop_off[at->part], loop_off[at->part + 1]);
}

static int compare_run_edges(const void *a, const void *b) {
  const RunEdge *x = a, *y = b;
  if (x->points != y->points) return x->points < y->points ? -1 : 1;
  return (x->part > y->part) - (x->part < y->part);
}

/// Unite the parts of a run that share edges: run_parent becomes their sets.
static LitheStatus connect_run(Faces *f, const FacePart *run, LitheIndex n) {
  const SliceParts *parts = &f->s->parts;
  LitheCount n_edges = 0;
  LTH_RESERVE(f->s->ctx, f->run_parent, f->run_parent_cap, n);
  lth_sets_reset(f->run_parent, n);
  for (LitheIndex i = 0; i < n; i++) {
    LitheIndex p = run[i].part;
    for (LitheIndex l = parts->loop_off[p]; l < parts->loop_off[p + 1]; l++) {
      LitheIndex first = parts->off[l], last = parts->off[l + 1];
      LTH_RESERVE(f->s->ctx, f->run_edge, f->run_edge_cap, n_edges + last - first);
      for (LitheIndex j = first; j < last; j++) {
        LitheIndex a = parts->point[j], b = parts->point[j + 1 < last ? j + 1 : first];
        f->run_edge[n_edges++] = (RunEdge){a < b ? lth_hash_pair(a, b) : lth_hash_pair(b, a), i};
      }
    }
  }
  qsort(f->run_edge, (size_t)n_edges, sizeof *f->run_edge, compare_run_edges);
  for (LitheCount i = 1; i < n_edges; i++) {
    if (f->run_edge[i].points != f->run_edge[i - 1].points) continue;
    lth_sets_unite(f->run_parent, f->run_edge[i].part, f->run_edge[i - 1].part);
  }
  return LITHE_OK;
}

/// Join the parts of one set: their common edges cancel.
static LitheStatus write_joined(Faces *f, const FacePart *run, LitheIndex n, LitheIndex root) {
  SliceParts *parts = &f->s->parts;
  LitheIndex n_edges = 0;
  for (LitheIndex i = root; i < n; i++) {
    if (lth_sets_root(f->run_parent, i) != root) continue;
    LitheIndex p = run[i].part;
    for (LitheIndex l = parts->loop_off[p]; l < parts->loop_off[p + 1]; l++) {
      LitheIndex first = parts->off[l], last = parts->off[l + 1];
      LTH_RESERVE(f->s->ctx, f->edge, f->edge_cap, 2 * (LitheCount)(n_edges + last - first));
      for (LitheIndex j = first; j < last; j++, n_edges++) {
        f->edge[2 * n_edges] = parts->point[j];
        f->edge[2 * n_edges + 1] = parts->point[j + 1 < last ? j + 1 : first];
      }
    }
  }
  n_edges = lth_slice_cancel(f->edge, n_edges);
  LitheIndex first = (LitheIndex)parts->n_loops;
  int axis = f->s->pieces.piece[parts->piece[run[root].part]].axis;
  LITHE_TRY(lth_slice_trace(f->s, axis, f->edge, n_edges));
  return write_face(f, run + root, first, (LitheIndex)parts->n_loops);
}

static LitheStatus write_run(Faces *f, const FacePart *run, LitheIndex n) {
  bool may_join = f->is_merged[run->owner] || (run->neighbour >= 0 && f->is_merged[run->neighbour]);
  if (n == 1 || !may_join) {
    for (LitheIndex i = 0; i < n; i++) LITHE_TRY(write_part(f, run + i));
    return LITHE_OK;
  }
  LITHE_TRY(connect_run(f, run, n));
  for (LitheIndex i = 0; i < n; i++) {
    if (lth_sets_root(f->run_parent, i) != i) continue;
    LitheIndex size = 0;
    for (LitheIndex j = i; j < n; j++) size += lth_sets_root(f->run_parent, j) == i;
    LITHE_TRY(size == 1 ? write_part(f, run + i) : write_joined(f, run, n, i));
  }
  return LITHE_OK;
}

static LitheStatus write_faces(Faces *f) {
  LTH_RESERVE(f->s->ctx, f->loop_off, f->loop_off_cap, 2);
  LTH_RESERVE(f->s->ctx, f->off, f->off_cap, 2);
  for (LitheCount i = 0, j; i < f->n_list; i = j) {
    const FacePart *a = f->list + i;
    for (j = i + 1; j < f->n_list; j++) {
      const FacePart *b = f->list + j;
      if (a->owner != b->owner || a->neighbour != b->neighbour || a->plane != b->plane) break;
    }
    LITHE_TRY(write_run(f, a, (LitheIndex)(j - i)));
  }
  return LITHE_OK;
}

/// Number of grid planes through a point.
static uint8_t rank_of(const Slicer *s, const double x[3]) {
  uint8_t rank = 0;
  for (int a = 0; a < 3; a++) {
    LitheIndex lo = 0, hi = s->cells[a];
    while (lo < hi) {
      LitheIndex mid = (lo + hi) / 2;
      if (s->plane[a][mid] + s->reach < x[a])
        lo = mid + 1;
      else
        hi = mid;
    }
    rank += fabs(s->plane[a][lo] - x[a]) <= s->reach;
  }
  return rank;
}

/// Keep the surface's points and those that faces use.
static LitheStatus pack_points(Faces *f, LitheIndex *index, double *points, uint8_t *rank,
                               LitheIndex *n_points) {
  const Slicer *s = f->s;
  LitheIndex n = s->surface->n_points;
  for (LitheCount i = 0; i < s->n_points; i++) index[i] = i < n ? (LitheIndex)i : -1;
  for (LitheCount i = 0; i < f->n_points; i++) {
    LitheIndex *at = index + f->point[i];
    if (*at < 0) *at = n++;
    f->point[i] = *at;
  }
  for (LitheCount i = 0; i < s->n_points; i++) {
    if (index[i] < 0) continue;
    lth_v3_copy(s->point + 3 * i, points + 3 * (LitheCount)index[i]);
    rank[index[i]] = rank_of(s, s->point + 3 * i);
  }
  *n_points = n;
  return LITHE_OK;
}

static LitheStatus create(Faces *f, LthMesh **mesh) {
  Slicer *s = f->s;
  LitheIndex *index = NULL, n_points = 0;
  double *points = NULL;
  uint8_t *rank = NULL;
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, s->ctx, index, s->n_points);
  LTH_NEW_OR(done, s->ctx, points, 3 * s->n_points);
  LTH_NEW_OR(done, s->ctx, rank, s->n_points);
  LITHE_TRY_OR(done, pack_points(f, index, points, rank, &n_points));
  LthMeshDef def = {.n_points = n_points,
                    .n_faces = (LitheIndex)f->n,
                    .n_cells = s->elements.n_groups,
                    .n_surface_points = s->surface->n_points,
                    .points = points,
                    .point_rank = rank,
                    .face_loop_off = f->loop_off,
                    .loop_off = f->off,
                    .loop_point = f->point,
                    .face_cell = f->cell,
                    .face_tag = f->tag,
                    .cell_size = cbrt(s->cell_volume),
                    .n_merged = s->elements.n_merged};
  LITHE_TRY_OR(done, lth_mesh_create(s->ctx, &def, mesh));
done:
  lth_free(s->ctx, index);
  lth_free(s->ctx, points);
  lth_free(s->ctx, rank);
  return status;
}

LitheStatus lth_slice_make_mesh(Slicer *s, LthMesh **mesh) {
  Faces f = {.s = s};
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, list_parts(&f));
  LITHE_TRY_OR(done, write_faces(&f));
  LITHE_TRY_OR(done, create(&f, mesh));
done:;
  void *blocks[] = {f.list, f.is_merged, f.loop_off, f.off,        f.point,
                    f.cell, f.tag,       f.run_edge, f.run_parent, f.edge};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(s->ctx, blocks[i]);
  return status;
}

/// Random solids as topologies, and random operations on them.
#pragma once

#include "check.h"
#include "mesh/topology.h"
#include "one_cell.h"
#include "slice_checks.h"
#include "solids.h"

static inline int topology_int(uint64_t *seed, int n) { return (int)(n * test_random(seed)); }

static inline void topology_direction(uint64_t *seed, double n[3]) {
  do {
    for (int a = 0; a < 3; a++) n[a] = 2 * test_random(seed) - 1;
  } while (!(lth_v3_norm(n) > 0.01));
  lth_v3_normalize(n);
}

/// A square ring of one cell: its two ends are faces with holes.
static inline LthMesh *topology_ring(LitheCtx *ctx) {
  TestSolid solid;
  double outer[8] = {-1, -1, 1, -1, 1, 1, -1, 1},
         inner[8] = {-0.5, -0.4, 0.6, -0.5, 0.5, 0.5, -0.4, 0.3};
  test_prism(&solid, 4, outer, 4, inner, 0, 0.7);
  return test_one_cell(ctx, &solid);
}

/// A U of seven cubes as one cell.
static inline LthMesh *topology_letter(LitheCtx *ctx, const char *full, int nx, int ny, int nz) {
  LthMesh *mesh = NULL;
  LthSurface *s = solid_cubes(ctx, full, nx, ny, nz);
  LthGrid g = cubic_grid(s, 1);
  for (int a = 0; a < 3; a++) g.cells[a] = 1;
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &mesh));
  solid_free(ctx, &s);
  return mesh;
}

static inline LthMesh *topology_sliced(LitheCtx *ctx, LthSurface *s, int cells) {
  LthMesh *mesh = NULL;
  LthGrid g = cubic_grid(s, cells);
  CHECK_OK(ctx, lth_mesh_slice(ctx, s, &g, 0, &mesh));
  solid_free(ctx, &s);
  return mesh;
}

enum { TOPOLOGY_SOLIDS = 9 };

static inline LthMesh *topology_solid(LitheCtx *ctx, int kind) {
  LthMesh *mesh = NULL;
  LthGrid cube = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  switch (kind) {
  case 0:
    CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &cube, &mesh));
    return mesh;
  case 1:
    cube.cells[0] = cube.cells[1] = cube.cells[2] = 1;
    CHECK_OK(ctx, lth_mesh_tetrahedra(ctx, &cube, &mesh));
    return mesh;
  case 2:
    return topology_sliced(ctx, solid_sphere(ctx, 4), 3);
  case 3:
    return topology_letter(ctx, "\1\1\1\0", 2, 1, 2);
  case 4:
    return topology_ring(ctx);
  case 5:
    return topology_letter(ctx, "\1\1\1\1\0\1\1\0\1", 3, 1, 3);
  case 6: // a ball with a cavity, one cell
    return topology_sliced(
        ctx,
        solid_join(ctx, solid_sphere(ctx, 3),
                   solid_flip(solid_move(solid_sphere(ctx, 2), NULL, 0.5, NULL))),
        1);
  case 7:
    return topology_sliced(ctx, solid_star(ctx, 5, 0.4, 1, 0.5), 1);
  default:
    return topology_sliced(ctx, solid_torus(ctx, 1, 0.4, 8, 6), 2);
  }
}

static inline LitheIndex topology_random_cell(const LthTopology *t, uint64_t *seed) {
  for (;;) {
    LitheIndex c = topology_int(seed, t->n_cells);
    if (t->cells[c].is_live) return c;
  }
}

static inline const double *topology_random_point(const LthTopology *t, LitheIndex cell,
                                                  uint64_t *seed) {
  LitheIndex f = lth_topology_cell_faces(t, cell)[topology_int(seed, t->cells[cell].n_faces)];
  LthFaceView view = lth_topology_face(t, f);
  return t->points + 3 * view.loop_point[topology_int(seed, t->faces[f].n_corners)];
}

/// A plane that means trouble for a cell: through corners, along and nearly along faces, along axes, the last one again.
static inline LthPlane topology_plane(const LthTopology *t, LitheIndex cell, const LthPlane *last,
                                      uint64_t *seed) {
  const LthTopologyCell *c = t->cells + cell;
  const LthTopologyFace *f =
      t->faces + lth_topology_cell_faces(t, cell)[topology_int(seed, c->n_faces)];
  LthPlane p;
  double a[3], b[3], tilt[3];
  for (int i = 0; i < 3; i++)
    p.point[i] = c->box[i] + (0.1 + 0.8 * test_random(seed)) * (c->box[3 + i] - c->box[i]);
  topology_direction(seed, p.normal);
  switch (topology_int(seed, 9)) {
  case 0: // through a corner
    lth_v3_copy(topology_random_point(t, cell, seed), p.point);
    break;
  case 1: // through three corners
    lth_v3_copy(topology_random_point(t, cell, seed), p.point);
    lth_v3_sub(topology_random_point(t, cell, seed), p.point, a);
    lth_v3_sub(topology_random_point(t, cell, seed), p.point, b);
    lth_v3_cross(a, b, tilt);
    if (lth_v3_norm(tilt) > 1e-9 * t->cell_size * t->cell_size) lth_v3_copy(tilt, p.normal);
    lth_v3_normalize(p.normal);
    break;
  case 2: // along a face
    lth_v3_copy(f->plane, p.normal);
    lth_v3_copy(f->centroid, p.point);
    break;
  case 3: // nearly along a face
    topology_direction(seed, tilt);
    lth_v3_copy(f->plane, p.normal);
    lth_v3_axpy(pow(10, -3 - 13 * test_random(seed)), tilt, p.normal);
    lth_v3_normalize(p.normal);
    lth_v3_copy(f->centroid, p.point);
    lth_v3_axpy((test_random(seed) - 0.5) * t->cell_size * pow(10, -3 - 13 * test_random(seed)),
                p.normal, p.point);
    break;
  case 4: // along an axis through the middle
    for (int i = 0; i < 3; i++) p.normal[i] = 0;
    p.normal[topology_int(seed, 3)] = 1;
    lth_v3_copy(c->centroid, p.point);
    break;
  case 5:
    if (last) return *last;
    break;
  default:
    break;
  }
  return p;
}

/// Merge a random cell into a random neighbour; returns whether it did.
static inline bool topology_random_merge(LitheCtx *ctx, LthTopology *t, uint64_t *seed) {
  LitheIndex cell = topology_random_cell(t, seed), merged = -1;
  LitheIndex f = lth_topology_cell_faces(t, cell)[topology_int(seed, t->cells[cell].n_faces)];
  LitheIndex other = t->faces[f].cell[t->faces[f].cell[0] == cell];
  if (other < 0 || !lth_topology_may_merge(t, cell, other)) return false;
  CHECK_OK(ctx, lth_topology_merge(ctx, t, cell, other, &merged));
  return true;
}

static inline void topology_random_separation(LitheCtx *ctx, LthTopology *t, uint64_t *seed) {
  LitheIndex cell = topology_random_cell(t, seed);
  LitheIndex f = lth_topology_cell_faces(t, cell)[topology_int(seed, t->cells[cell].n_faces)];
  if (t->faces[f].cell[1] < 0) return;
  CHECK_OK(ctx, lth_topology_separate(ctx, t, f, LTH_TAG_CUT - 1000, NULL));
}

/// Cut every cell by a plane; returns how many were split.
static inline LitheIndex topology_cut_all(LitheCtx *ctx, LthTopology *t, const LthPlane *plane,
                                          LitheIndex tag) {
  LitheIndex *cells = lth_alloc(ctx, t->n_live_cells, sizeof *cells), n = 0;
  for (LitheIndex c = 0; c < t->n_cells; c++)
    if (t->cells[c].is_live) cells[n++] = c;
  LthCut cut;
  CHECK_OK(ctx, lth_topology_cut(ctx, t, n, cells, 1, plane, tag, &cut));
  lth_free(ctx, cells);
  return cut.n_split;
}

/// What a random run may do, and its counts.
typedef struct TopologyRun {
  bool carves; ///< cells may be taken away
  int n_splits, n_missed, n_merges, n_cuts, n_carves;
} TopologyRun;

/// Which cells lie below all planes, by their centroids; returns how many.
static inline LitheIndex topology_below(const LthTopology *t, int n_planes, const LthPlane *planes,
                                        uint8_t *is_below) {
  LitheIndex n = 0;
  for (LitheIndex c = 0; c < t->n_cells; c++) {
    is_below[c] = t->cells[c].is_live;
    for (int i = 0; i < n_planes; i++) {
      double d[3];
      lth_v3_sub(t->cells[c].centroid, planes[i].point, d);
      is_below[c] = is_below[c] && lth_v3_dot(d, planes[i].normal) < 0;
    }
    n += is_below[c];
  }
  return n;
}

/// Carve a corner, a wedge or a half out of all cells: divide them by its planes, part what lies inside from what does
/// not, and take one of the two away, or none.
static inline void topology_random_carve(LitheCtx *ctx, LthTopology *t, const LthPlane *plane,
                                         uint64_t *seed, TopologyRun *run) {
  LthPlane planes[3] = {*plane};
  int n_planes = 1 + topology_int(seed, 3), keep = topology_int(seed, 3);
  for (int i = 1; i < n_planes; i++)
    planes[i] = topology_plane(t, topology_random_cell(t, seed), NULL, seed);
  for (int i = 0; i < n_planes; i++) topology_cut_all(ctx, t, planes + i, -1);
  uint8_t *is_below = lth_alloc(ctx, t->n_cells, 1);
  LitheIndex *cells = lth_alloc(ctx, t->n_live_cells, sizeof *cells), n = 0,
             n_below = topology_below(t, n_planes, planes, is_below), n_faces = t->n_faces;
  for (LitheIndex f = 0; f < n_faces; f++) {
    const LthTopologyFace *face = t->faces + f;
    if (face->is_live && face->cell[1] >= 0 && is_below[face->cell[0]] != is_below[face->cell[1]])
      CHECK_OK(ctx, lth_topology_separate(ctx, t, f, LTH_TAG_CUT - 2000 - run->n_carves, NULL));
  }
  for (LitheIndex c = 0; c < t->n_cells; c++)
    if (t->cells[c].is_live && is_below[c] == keep) cells[n++] = c;
  double gone = 0;
  for (LitheIndex i = 0; i < n; i++) gone += t->cells[cells[i]].volume;
  if (keep < 2 && n > 0 && gone < 0.9 * t->volume) // something is left
    CHECK_OK(ctx, lth_topology_remove(ctx, t, n, cells));
  run->n_carves += n_below > 0 && n_below < t->n_live_cells;
  lth_free(ctx, is_below);
  lth_free(ctx, cells);
}

/// One random operation. Bodies with many cells are merged rather than split.
static inline void topology_random_operation(LitheCtx *ctx, LthTopology *t, LthPlane *last,
                                             int most_cells, uint64_t *seed, TopologyRun *run) {
  LitheIndex cell = topology_random_cell(t, seed), n = 0;
  LthSplit split;
  LthPlane plane = topology_plane(t, cell, last, seed);
  int kind = topology_int(seed, run->carves ? 21 : 20);
  LitheIndex tag = topology_int(seed, 4) ? -1 : LTH_TAG_CUT - topology_int(seed, 100);
  if (t->n_live_cells > most_cells && (kind < 15 || kind == 20)) kind = 16;
  if (kind == 12) {
    run->n_cuts += topology_cut_all(ctx, t, &plane, tag);
  } else if (kind == 13) {
    CHECK_OK(ctx, lth_topology_split_eight(ctx, t, cell, &split));
    run->n_splits += split.n > 0;
  } else if (kind < 15) {
    CHECK_OK(ctx, lth_topology_split(ctx, t, cell, &plane, tag, &split));
    run->n_splits += split.n > 0;
    run->n_missed += split.n == 0;
  } else if (kind == 20) {
    topology_random_carve(ctx, t, &plane, seed, run);
  } else if (kind == 15) {
    topology_random_separation(ctx, t, seed);
  } else if (kind == 16) {
    CHECK_OK(ctx, lth_topology_merge_slivers(ctx, t, 0, NULL, 0.3 * t->volume / most_cells, &n));
    run->n_merges += n;
  } else {
    run->n_merges += topology_random_merge(ctx, t, seed);
  }
  *last = plane;
}

/// Cuts by another solid: elements that its surface passes are divided by the planes of its facets until each part is
/// inside or outside, parts on one side of one element are merged again, and the two sides are parted.
#include "scene/cut_priv.h"

#include "base/order.h"
#include "base/tensor.h"
#include "geometry/bvh.h"

#include <math.h>

#define FLAT 1e-9   ///< of a cell: facets whose corners are that close to a plane lie in it
#define MANY 96     ///< facets near a cell: it is halved first, so that each passes few parts
#define HALF 0.4871 ///< of a cell's box: where it is halved, off what is symmetric

enum { OUTSIDE = 1, INSIDE = 2 };

/// A part of a cell, so often halved.
typedef struct Block {
  LitheIndex cell;
  int depth;
} Block;

/// A carve in progress.
typedef struct Carving {
  LthCutting *c;
  LthSurface *surface;
  LthBvh *bvh;
  LthCutRoots roots;
  int8_t *side; ///< of live cells                                       (n_cells)
  LitheCount side_cap;
  LitheIndex *facets; ///< near the cell in hand
  LthPlane *planes;   ///< of facets near the root in hand, those that differ
  LitheIndex *plane_of,
      *plane_root; ///< of each facet: its plane, and root + 1 that this was found for
  Block *blocks;   ///< of the root in hand, that wait
  LitheIndex n_facets, n_planes, *parts, n_parts, *gone, n_blocks;
  LitheCount facets_cap, planes_cap, parts_cap, blocks_cap;
  LitheStatus status;
  LitheCtx *ctx;
} Carving;

static const double *corner(const Carving *v, LitheIndex tri, int k) {
  return v->surface->points + 3 * (size_t)v->surface->tris[3 * (size_t)tri + (size_t)k];
}

// --- dividing ---

static LitheStatus list_facet(Carving *v, LitheIndex tri) {
  LTH_RESERVE(v->ctx, v->facets, v->facets_cap, (LitheCount)v->n_facets + 1);
  v->facets[v->n_facets++] = tri;
  return LITHE_OK;
}

static bool visit_facet(void *self, LitheIndex tri) {
  Carving *v = self;
  v->status = list_facet(v, tri);
  return v->status == LITHE_OK;
}

/// Facets near a cell as it is now, in the order of their numbers.
static LitheStatus find_facets(Carving *v, LitheIndex cell) {
  const LthTopology *t = v->c->t;
  double center[3], reach = 0;
  lth_cutting_place(v->c, cell, t->cells[cell].centroid, center);
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LthFaceView face = lth_topology_face(t, lth_topology_cell_faces(t, cell)[i]);
    for (LitheIndex k = face.loop_off[0]; k < face.loop_off[face.n_loops]; k++) {
      double x[3];
      lth_cutting_place(v->c, cell, t->points + 3 * (size_t)face.loop_point[k], x);
      reach = fmax(reach, lth_v3_distance(x, center));
    }
  }
  v->n_facets = 0;
  v->status = LITHE_OK;
  lth_bvh_visit(v->bvh, center, reach, visit_facet, v);
  v->n_facets = lth_sort_unique(v->facets, v->n_facets);
  return v->status;
}

static LitheStatus add_part(Carving *v, LitheIndex cell) {
  LTH_RESERVE(v->ctx, v->parts, v->parts_cap, (LitheCount)v->n_parts + 1);
  v->parts[v->n_parts++] = cell;
  return LITHE_OK;
}

/// Divide a part where the facet itself passes through it.
static LitheStatus divide_part(Carving *v, LitheIndex i, const LthPlane *plane,
                               const LthWindow *window) {
  LthTopology *t = v->c->t;
  LitheIndex cell = v->parts[i];
  LthSplit split = {0};
  LthPlane rest;
  if (!lth_cutting_plane(v->c, plane, cell, &rest)) return LITHE_OK;
  if (!lth_plane_passes(t->cells + cell, &rest, 0)) return LITHE_OK;
  LITHE_TRY(lth_topology_section(v->ctx, t, cell, &rest, &v->c->section));
  if (!lth_cutting_meets(v->c, cell, window)) return LITHE_OK;
  LITHE_TRY(lth_topology_split(v->ctx, t, cell, &rest, -1, &split));
  if (split.n == 0) return LITHE_OK;
  v->parts[i] = t->log.births[split.first].cell;
  for (LitheIndex k = 1; k < split.n; k++)
    LITHE_TRY(add_part(v, t->log.births[split.first + k].cell));
  return LITHE_OK;
}

static bool lies_in(const Carving *v, LitheIndex tri, const LthPlane *plane) {
  double d[3], reach = FLAT * v->c->t->cell_size;
  for (int k = 0; k < 3; k++) {
    lth_v3_sub(corner(v, tri, k), plane->point, d);
    if (!(fabs(lth_v3_dot(plane->normal, d)) <= reach)) return false;
  }
  return true;
}

/// Number of the plane of a facet, or of one of those before that it lies in: facets of one flat side have one plane to the bit,
/// so that faces in it become one again. -1 where the facet has no area.
static LitheStatus find_plane(Carving *v, LitheIndex tri, LitheIndex *number) {
  const double *a = corner(v, tri, 0), *b = corner(v, tri, 1), *c = corner(v, tri, 2);
  LthPlane plane;
  double u[3], w[3];
  lth_v3_sub(b, a, u);
  lth_v3_sub(c, a, w);
  lth_v3_cross(u, w, plane.normal);
  lth_v3_copy(a, plane.point);
  *number = -1;
  if (!(lth_v3_normalize(plane.normal) > 0)) return LITHE_OK;
  for (*number = 0; *number < v->n_planes; ++*number)
    if (lies_in(v, tri, v->planes + *number)) return LITHE_OK;
  LTH_RESERVE(v->ctx, v->planes, v->planes_cap, (LitheCount)v->n_planes + 1);
  v->planes[v->n_planes++] = plane;
  return LITHE_OK;
}

static LitheStatus divide_by_facet(Carving *v, LitheIndex root, LitheIndex tri) {
  const double *a = corner(v, tri, 0), *b = corner(v, tri, 1), *c = corner(v, tri, 2);
  if (v->plane_root[tri] != root + 1) LITHE_TRY(find_plane(v, tri, v->plane_of + tri));
  v->plane_root[tri] = root + 1;
  if (v->plane_of[tri] < 0) return LITHE_OK;
  const LthPlane plane = v->planes[v->plane_of[tri]];
  LthWindow window = lth_window_make(3, (const double *const[]){a, b, c});
  LitheIndex n = v->n_parts;
  for (LitheIndex i = 0; i < n; i++) LITHE_TRY(divide_part(v, i, &plane, &window));
  return LITHE_OK;
}

static LitheStatus add_block(Carving *v, LitheIndex cell, int depth) {
  LTH_RESERVE(v->ctx, v->blocks, v->blocks_cap, (LitheCount)v->n_blocks + 1);
  v->blocks[v->n_blocks++] = (Block){cell, depth};
  return LITHE_OK;
}

/// Halve a block across its longest side; false where that does not come out.
static LitheStatus halve(Carving *v, const Block *block, bool *yes) {
  LthTopology *t = v->c->t;
  const double *box = t->cells[block->cell].box;
  LthSplit split = {0};
  LthPlane plane = {.normal = {0, 0, 0}};
  int longest = 0;
  for (int a = 0; a < 3; a++) {
    plane.point[a] = box[a] + HALF * (box[3 + a] - box[a]);
    if (box[3 + a] - box[a] > box[3 + longest] - box[longest]) longest = a;
  }
  plane.normal[longest] = 1;
  LITHE_TRY(lth_topology_split(v->ctx, t, block->cell, &plane, -1, &split));
  *yes = split.n > 0;
  for (LitheIndex k = 0; k < split.n; k++)
    LITHE_TRY(add_block(v, t->log.births[split.first + k].cell, block->depth + 1));
  return LITHE_OK;
}

/// Halvings until a surface that passes a cell evenly leaves few facets in each block: its blocks come by fours for eight.
static int most_halvings(LitheIndex n_facets) {
  int n = 0;
  for (double few = MANY; few < n_facets; few *= 4) n += 3;
  return n + 3;
}

/// Divide a cell by all facets that pass it, blocks by those near them.
static LitheStatus divide_cell(Carving *v, LitheIndex root) {
  int most = 0;
  v->n_planes = v->n_blocks = 0;
  LITHE_TRY(add_block(v, root, 0));
  while (v->n_blocks > 0) {
    const Block block = v->blocks[--v->n_blocks];
    bool is_halved = false;
    LITHE_TRY(find_facets(v, block.cell));
    if (block.depth == 0) most = most_halvings(v->n_facets);
    if (v->n_facets > MANY && block.depth < most) LITHE_TRY(halve(v, &block, &is_halved));
    if (is_halved) continue;
    v->n_parts = 0;
    LITHE_TRY(add_part(v, block.cell));
    for (LitheIndex i = 0; i < v->n_facets; i++) LITHE_TRY(divide_by_facet(v, root, v->facets[i]));
  }
  return LITHE_OK;
}

static LitheStatus divide_cells(Carving *v) {
  const LthTopology *t = v->c->t;
  LitheIndex n = t->n_cells;
  LTH_NEW(v->ctx, v->plane_of, v->surface->n_tris);
  LTH_NEW(v->ctx, v->plane_root, v->surface->n_tris);
  for (LitheIndex cell = 0; cell < n; cell++)
    if (t->cells[cell].is_live && v->roots.root[cell] == cell) LITHE_TRY(divide_cell(v, cell));
  return lth_cut_roots_follow(v->ctx, t, &v->roots);
}

// --- sides ---

/// And the volume outside and inside.
static LitheStatus find_sides(Carving *v, double volume[2]) {
  const LthTopology *t = v->c->t;
  LTH_RESERVE(v->ctx, v->side, v->side_cap, t->n_cells);
  volume[0] = volume[1] = 0;
  for (LitheIndex cell = 0; cell < t->n_cells; cell++) {
    double rest[3], x[3];
    if (!t->cells[cell].is_live) continue;
    lth_topology_inner_point(t, cell, rest);
    lth_cutting_place(v->c, cell, rest, x);
    bool is_inside = lth_bvh_signed_distance(v->bvh, x, NULL) < 0;
    v->side[cell] = is_inside ? INSIDE : OUTSIDE;
    volume[is_inside] += t->cells[cell].volume;
  }
  return LITHE_OK;
}

/// Part what is inside from what is outside.
static LitheStatus part_sides(Carving *v) {
  LthTopology *t = v->c->t;
  LthChangeNote *note = v->c->note;
  for (LitheIndex cell = 0; cell < t->n_cells; cell++) {
    if (!t->cells[cell].is_live || v->side[cell] != INSIDE) continue;
    for (LitheIndex i = 0; i < t->cells[cell].n_faces;) {
      LitheIndex face = lth_topology_cell_faces(t, cell)[i];
      const LthTopologyFace *f = t->faces + face;
      LitheIndex across = f->cell[f->cell[0] == cell];
      if (across < 0 || v->side[across] == INSIDE) {
        i++;
        continue;
      }
      if (!f->is_line) note->area += f->area;
      note->n_separated += !f->is_line && v->roots.root[cell] != v->roots.root[across];
      LITHE_TRY(lth_topology_separate(v->ctx, t, face, v->c->tag, NULL)); // another takes its place
    }
  }
  return LITHE_OK;
}

/// Cells that lay on both sides.
static LitheStatus count_split(Carving *v) {
  const LthTopology *t = v->c->t;
  int8_t *seen = NULL;
  LTH_NEW(v->ctx, seen, t->n_cells);
  for (LitheIndex cell = 0; cell < t->n_cells; cell++)
    if (t->cells[cell].is_live) seen[v->roots.root[cell]] |= v->side[cell];
  for (LitheIndex cell = 0; cell < t->n_cells; cell++)
    v->c->note->n_split += seen[cell] == (INSIDE | OUTSIDE);
  lth_free(v->ctx, seen);
  return LITHE_OK;
}

static LitheStatus remove_side(Carving *v) {
  LthTopology *t = v->c->t;
  int8_t kept = v->c->cut->keep == LTH_KEEP_INSIDE ? INSIDE : OUTSIDE;
  LitheIndex n = 0;
  if (v->c->cut->keep == LTH_KEEP_BOTH) return LITHE_OK;
  LTH_NEW(v->ctx, v->gone, t->n_live_cells);
  for (LitheIndex cell = 0; cell < t->n_cells; cell++)
    if (t->cells[cell].is_live && v->side[cell] != kept) v->gone[n++] = cell;
  v->c->note->n_removed = n;
  return n > 0 ? lth_topology_remove(v->ctx, t, n, v->gone) : LITHE_OK;
}

/// A body of which nothing would be left stays what it is: parts of its cells become whole again. Before the run it is
/// an error, for the scene asks for a body that is not there.
static LitheStatus refuse(Carving *v) {
  const LthSceneCut *cut = v->c->cut;
  const char *name = v->c->body->def->name,
             *side = cut->keep == LTH_KEEP_INSIDE ? "inside" : "outside";
  if (!(cut->at > 0))
    LITHE_FAIL(v->ctx, LITHE_BAD_INPUT,
               "%s.carve: nothing is left of the body `%s`, no part of which is %s the solid%s; "
               "move or turn it, or keep the other side",
               cut->place, name, side, v->c->x ? " at this moment" : "");
  lth_warn(v->ctx,
           "%s.carve: nothing would be left of the body `%s`, no part of which is %s the solid%s, "
           "and so it is not carved",
           cut->place, name, side, v->c->x ? " at this moment" : "");
  v->c->note->is_refused = true;
  for (LitheIndex cell = 0; cell < v->c->t->n_cells; cell++) v->side[cell] = OUTSIDE;
  return lth_cut_merge_roots(v->ctx, v->c, &v->roots, &v->side, &v->side_cap);
}

static bool leaves_nothing(const Carving *v, const double volume[2]) {
  LthKeep keep = v->c->cut->keep;
  return keep != LTH_KEEP_BOTH &&
         volume[keep == LTH_KEEP_INSIDE] < LTH_CRUMB_VOLUME * (volume[0] + volume[1]);
}

static LitheStatus carve(Carving *v) {
  const LthBody *body = v->c->body;
  const LthShape *shape = &v->c->cut->carve;
  double volume[2];
  LITHE_TRY(lth_shape_tessellate(v->ctx, shape, body->cell_size / 4, &v->surface));
  LITHE_TRY(lth_bvh_create_surface(v->ctx, v->surface, &v->bvh));
  LITHE_TRY(lth_cut_roots_begin(v->ctx, v->c->t, &v->roots));
  LITHE_TRY(divide_cells(v));
  LITHE_TRY(find_sides(v, volume));
  if (leaves_nothing(v, volume)) return refuse(v);
  LITHE_TRY(lth_cut_merge_roots(v->ctx, v->c, &v->roots, &v->side, &v->side_cap));
  LITHE_TRY(count_split(v));
  LITHE_TRY(part_sides(v));
  return remove_side(v);
}

LitheStatus lth_cut_by_carving(LitheCtx *ctx, LthCutting *c) {
  Carving v = {.c = c, .ctx = ctx};
  LitheStatus status = carve(&v);
  lth_bvh_destroy(ctx, &v.bvh);
  lth_surface_destroy(ctx, &v.surface);
  void *blocks[] = {v.roots.root, v.side,     v.facets,     v.planes, v.parts,
                    v.gone,       v.plane_of, v.plane_root, v.blocks};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  return status;
}

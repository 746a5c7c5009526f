/// Cuts by the facets of a blade, and its bends. In motion every element takes facets and bends back to rest by its own map, and those
/// of neighbours do not meet: what lies on two sides of the blade is parted then whichever facets it was cut by.
#include "scene/cut_priv.h"

#include "base/tensor.h"

#include <math.h>
#include <stdlib.h>

#define BEND_WIDTH 1e-3 ///< of a cell: so close to a bend is in it
/// In motion, where planes of elements stand for what they are curved to: an element that is divided in vain is put together again.
#define BEND_WIDTH_MOVING 0.05
#define TOUCHES 1e-6 ///< of a cell's height above a bend: no more than that only touches it

/// Corners of what an edge sweeps, and their plane.
static LthWindow facet_window(const LthSceneCut *cut, LitheIndex i, LthPlane *plane) {
  const double *p = cut->path[i], *q = cut->path[i + 1];
  double edge[3], far[2][3];
  lth_v3_add(q, cut->depth, far[0]);
  lth_v3_add(p, cut->depth, far[1]);
  lth_v3_sub(q, p, edge);
  lth_v3_copy(p, plane->point);
  lth_v3_cross(edge, cut->depth, plane->normal);
  lth_v3_normalize(plane->normal);
  return lth_window_make(4, (const double *const[]){p, q, far[0], far[1]});
}

/// The plane halfway between two edges in a bend, as far from both as one can be: next to an edge it would be taken for it, and the
/// edge would not end in the bend. False where the path goes straight on (or back).
static bool bend_plane(const LthSceneCut *cut, LitheIndex i, LthPlane *plane) {
  double a[3], b[3], turn[3], along[3];
  lth_v3_sub(cut->path[i], cut->path[i - 1], a);
  lth_v3_sub(cut->path[i + 1], cut->path[i], b);
  lth_v3_copy(cut->depth, along);
  lth_v3_normalize(along);
  lth_v3_axpy(-lth_v3_dot(along, a), along, a);
  lth_v3_axpy(-lth_v3_dot(along, b), along, b);
  lth_v3_normalize(a);
  lth_v3_normalize(b);
  lth_v3_cross(a, b, turn);
  lth_v3_copy(cut->path[i], plane->point);
  lth_v3_add(a, b, plane->normal);
  return lth_v3_norm(turn) > 1e-9 && lth_v3_normalize(plane->normal) > 1e-6;
}

/// A window that is next to a line: the bend's edge, as far as the blade reaches.
static LthWindow bend_window(const LthSceneCut *cut, LitheIndex i, const LthPlane *plane,
                             double width) {
  double corners[4][3], across[3];
  lth_v3_cross(plane->normal, cut->depth, across);
  lth_v3_normalize(across);
  for (int k = 0; k < 4; k++) {
    lth_v3_copy(cut->path[i], corners[k]);
    if (k == 1 || k == 2) lth_v3_add(corners[k], cut->depth, corners[k]);
    lth_v3_axpy((k >= 2 ? 1 : -1) * width, across, corners[k]);
  }
  return lth_window_make(4,
                         (const double *const[]){corners[0], corners[1], corners[2], corners[3]});
}

static LthCutFacet make_facet(const LthSceneCut *cut, LitheIndex i) {
  LthCutFacet f = {0};
  f.window = facet_window(cut, i, &f.plane);
  f.has_bend[0] = i > 0 && bend_plane(cut, i, f.bend);
  f.has_bend[1] = i + 2 < cut->n_path && bend_plane(cut, i + 1, f.bend + 1);
  return f;
}

// --- sides ---

/// Height of a place above a plane.
static double height_of(const LthPlane *plane, const double x[3]) {
  double d[3];
  lth_v3_sub(x, plane->point, d);
  return lth_v3_dot(d, plane->normal);
}

/// Lowest and highest corner of a cell above a plane at rest.
static void find_heights(const LthTopology *t, LitheIndex cell, const LthPlane *plane,
                         double height[2]) {
  height[0] = INFINITY, height[1] = -INFINITY;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    LthFaceView v = lth_topology_face(t, lth_topology_cell_faces(t, cell)[i]);
    for (LitheIndex k = v.loop_off[0]; k < v.loop_off[v.n_loops]; k++) {
      double h = height_of(plane, v.points + 3 * (LitheCount)v.loop_point[k]);
      height[0] = fmin(height[0], h), height[1] = fmax(height[1], h);
    }
  }
}

/// On which side of a plane of the moment a whole cell is: -1, 1; 0: the plane passes it.
static int side_of(const LthCutting *c, LitheIndex cell, const LthPlane *plane) {
  LthPlane rest;
  double height[2], at[3];
  if (!lth_cutting_plane(c, plane, cell, &rest)) return 0;
  find_heights(c->t, cell, &rest, height);
  double least = TOUCHES * (height[1] - height[0]);
  int side = height[0] >= -least ? 1 : height[1] <= least ? -1 : 0;
  // far from its point the plane at rest is not that of the moment
  lth_cutting_place(c, cell, c->t->cells[cell].centroid, at);
  return side * height_of(plane, at) > 0 ? side : 0;
}

bool lth_cut_is_beyond(const LthCutting *c, LitheIndex cell, const LthCutFacet *f) {
  return (f->has_bend[0] && side_of(c, cell, f->bend) < 0) ||
         (f->has_bend[1] && side_of(c, cell, f->bend + 1) > 0);
}

/// Is the middle of a cell nearer to this facet than to those beside it?
static bool is_beside(const LthCutting *c, LitheIndex cell, const LthCutFacet *f) {
  double at[3];
  lth_cutting_place(c, cell, c->t->cells[cell].centroid, at);
  return (!f->has_bend[0] || height_of(f->bend, at) >= 0) &&
         (!f->has_bend[1] || height_of(f->bend + 1, at) <= 0);
}

static LitheStatus begin_sides(LitheCtx *ctx, const LthTopology *t, LthCutSides *s) {
  LTH_RESERVE(ctx, s->of, s->cap, t->n_cells);
  s->n = t->n_cells;
  s->n_births = t->log.n_births;
  for (LitheIndex i = 0; i < s->n; i++) s->of[i] = 0;
  return LITHE_OK;
}

/// Births are where their parents are.
static LitheStatus follow_sides(LitheCtx *ctx, const LthTopology *t, LthCutSides *s) {
  LTH_RESERVE(ctx, s->of, s->cap, t->n_cells);
  for (; s->n < t->n_cells; s->n++) s->of[s->n] = 0;
  for (; s->n_births < t->log.n_births; s->n_births++) {
    const LthTopologyBirth *birth = t->log.births + s->n_births;
    s->of[birth->cell] = s->of[birth->parent];
  }
  return LITHE_OK;
}

/// Sides of what the facet has reached (and divided), and of what it passes by.
static void find_sides(const LthCutting *c, const LthCutFacet *f, LthCutSides *s) {
  for (LitheIndex i = 0; i < s->n; i++) {
    const LthTopologyCell *cell = c->t->cells + i;
    LthPlane rest;
    if (!cell->is_live || !lth_cutting_plane(c, &f->plane, i, &rest)) {
      s->of[i] = 0;
    } else if (s->of[i] != 0) {
      s->of[i] = height_of(&rest, cell->centroid) < 0 ? -LTH_CUT_REACHED : LTH_CUT_REACHED;
    } else if (lth_plane_passes(cell, &rest, LTH_CUT_NEAR) && is_beside(c, i, f)) {
      s->of[i] = (int8_t)side_of(c, i, &f->plane);
    }
  }
}

// --- parting ---

/// A blade in progress: the facet in hand [1] and the one before [0].
typedef struct Blade {
  LthCutFacet facet[2];
  LthCutSides sides[2];
  bool has_before;
} Blade;

/// Does a face have more in common with a facet than that it touches its edge, seen along the facet's normal?
static LitheStatus face_meets(LitheCtx *ctx, LthCutting *c, LitheIndex face, LitheIndex cell,
                              const LthCutFacet *f, bool *yes) {
  LthSection *s = &c->section;
  LthFaceView v = lth_topology_face(c->t, face);
  s->n = 0;
  LTH_RESERVE(ctx, s->ends, s->ends_cap, 6 * (LitheCount)v.loop_off[v.n_loops]);
  for (LitheIndex l = 0; l < v.n_loops; l++)
    for (LitheIndex i = v.loop_off[l]; i < v.loop_off[l + 1]; i++, s->n++) {
      LitheIndex next = i + 1 < v.loop_off[l + 1] ? i + 1 : v.loop_off[l];
      double *ends = s->ends + 6 * (LitheCount)s->n;
      lth_v3_copy(v.points + 3 * (LitheCount)v.loop_point[i], ends);
      lth_v3_copy(v.points + 3 * (LitheCount)v.loop_point[next], ends + 3);
    }
  *yes = lth_cutting_meets(c, cell, &f->window);
  return LITHE_OK;
}

/// What counts of a cell's sides: to have been reached by one facet is more than to be near the other.
static void count_sides(const Blade *b, LitheIndex cell, int side[2]) {
  for (int i = 0; i < 2; i++) side[i] = i == 1 || b->has_before ? b->sides[i].of[cell] : 0;
  for (int i = 0; i < 2; i++)
    if (abs(side[i]) < abs(side[!i])) side[i] = 0;
}

/// Does the blade pass between the two cells at a face? They are compared by the facet that both know, else by the two beside a bend.
static LitheStatus is_between(LitheCtx *ctx, LthCutting *c, const Blade *b, LitheIndex face,
                              bool *yes) {
  const LitheIndex *cell = c->t->faces[face].cell;
  int p[2], q[2];
  *yes = false;
  count_sides(b, cell[0], p);
  count_sides(b, cell[1], q);
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < 2 && !*yes; k++) {
      bool both_know = (p[0] && q[0]) || (p[1] && q[1]);
      if (p[i] * q[k] >= 0 || (i != k && both_know)) continue;
      *yes = abs(p[i] * q[k]) == LTH_CUT_REACHED * LTH_CUT_REACHED;
      if (!*yes) LITHE_TRY(face_meets(ctx, c, face, cell[0], b->facet + i, yes));
      if (!*yes && i != k) LITHE_TRY(face_meets(ctx, c, face, cell[0], b->facet + k, yes));
    }
  return LITHE_OK;
}

/// Part all faces that the facet in hand, or the bend before it, passes between two cells.
static LitheStatus part_sides(LitheCtx *ctx, LthCutting *c, const Blade *b) {
  LthTopology *t = c->t;
  LitheIndex n = t->n_faces;
  for (LitheIndex i = 0; i < n; i++) {
    bool yes = false;
    if (!t->faces[i].is_live || t->faces[i].cell[1] < 0) continue;
    LITHE_TRY(is_between(ctx, c, b, i, &yes));
    if (!yes) continue;
    c->note->area += t->faces[i].area;
    c->note->n_separated += !t->faces[i].is_line;
    LITHE_TRY(lth_topology_separate(ctx, t, i, c->tag, NULL));
  }
  return LITHE_OK;
}

static LitheStatus cut_facet(LitheCtx *ctx, LthCutting *c, Blade *b, LitheIndex i) {
  LthCutSides before = b->sides[1];
  b->sides[1] = b->sides[0];
  b->sides[0] = before;
  b->facet[0] = b->facet[1];
  b->facet[1] = make_facet(c->cut, i);
  b->has_before = b->facet[1].has_bend[0];
  LITHE_TRY(begin_sides(ctx, c->t, b->sides + 1));
  LITHE_TRY(lth_cut_along(ctx, c, &b->facet[1].plane, b->facet + 1, c->tag, b->sides + 1));
  if (!c->x) return LITHE_OK; // planes at rest are those of all elements
  for (int k = 0; k < 2; k++) LITHE_TRY(follow_sides(ctx, c->t, b->sides + k));
  find_sides(c, b->facet + 1, b->sides + 1);
  return part_sides(ctx, c, b);
}

static LitheStatus divide_bends(LitheCtx *ctx, LthCutting *c) {
  double width = (c->x ? BEND_WIDTH_MOVING : BEND_WIDTH) * c->t->cell_size;
  for (LitheIndex i = 1; i + 1 < c->cut->n_path; i++) {
    LthCutFacet bend = {0};
    if (!bend_plane(c->cut, i, &bend.plane)) continue;
    bend.window = bend_window(c->cut, i, &bend.plane, width);
    LITHE_TRY(lth_cut_along(ctx, c, &bend.plane, &bend, -1, NULL));
  }
  return LITHE_OK;
}

// Where the blade bends inside an element, each of its two facets takes the part of the element on its side of the bend:
// divided there, and put together again where the cut has left the parts joined.
LitheStatus lth_cut_by_blade(LitheCtx *ctx, LthCutting *c) {
  LitheStatus status = LITHE_OK;
  Blade blade = {0};
  LthCutRoots roots = {0};
  LITHE_TRY_OR(done, lth_cut_roots_begin(ctx, c->t, &roots));
  LITHE_TRY_OR(done, divide_bends(ctx, c));
  bool is_divided = c->t->log.n_births > roots.n_births;
  for (LitheIndex i = 0; i + 1 < c->cut->n_path; i++)
    LITHE_TRY_OR(done, cut_facet(ctx, c, &blade, i));
  if (!is_divided) goto done;
  LITHE_TRY_OR(done, lth_cut_roots_follow(ctx, c->t, &roots));
  LITHE_TRY_OR(done, lth_cut_merge_roots(ctx, c, &roots, NULL, NULL));
done:
  lth_free(ctx, roots.root);
  for (int i = 0; i < 2; i++) lth_free(ctx, blade.sides[i].of);
  return status;
}

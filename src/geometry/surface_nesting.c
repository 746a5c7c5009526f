/// Which shells lie inside which, and so which of them are solids and which are cavities.
#include "base/tensor.h"
#include "geometry/predicates.h"
#include "geometry/surface_clean.h"

#define STACK_MAX 128
#define VOLUME_MIN 1e-14 // of area times size: below it a volume is rounding

typedef struct Shell {
  double volume, area; ///< as oriented so far
  double start[3];     ///< a point of it that no other shell has
  LitheIndex depth;    ///< number of shells around it
  LitheIndex parent;   ///< the innermost of them, -1
  bool is_mixed;       ///< its orientation in the file means nothing
} Shell;

typedef struct Nest {
  LthCleaner *c;
  const LthBvh *bvh;
  Shell *shell;
  bool *is_inside;     ///< of each shell: the present ray crossed it an odd number of times
  LitheIndex *touched; ///< shells whose is_inside was changed
  LitheIndex n_touched;
} Nest;

static void measure_shells(Nest *nest) {
  LthCleaner *c = nest->c;
  double center[3], e[3], f[3], cross[3], to[3];
  for (int i = 0; i < 3; i++) center[i] = 0.5 * (c->min[i] + c->max[i]);
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    const LitheIndex *p = c->tris + 3 * (size_t)t;
    Shell *shell = &nest->shell[c->tri_shell[t]];
    lth_v3_sub(lth_clean_point(c, p[1]), lth_clean_point(c, p[0]), e);
    lth_v3_sub(lth_clean_point(c, p[2]), lth_clean_point(c, p[0]), f);
    lth_v3_sub(lth_clean_point(c, p[0]), center, to);
    lth_v3_cross(e, f, cross);
    shell->volume += lth_v3_dot(cross, to) / 6;
    shell->area += lth_v3_norm(cross) / 2;
    shell->is_mixed = shell->is_mixed || c->tri_is_mixed[t];
  }
}

/// A corner that belongs to one shell only; where a shell has none, the middle of a triangle.
static LitheStatus pick_starts(Nest *nest) {
  LthCleaner *c = nest->c;
  LitheIndex *point_shell = NULL; // shell + 1, or -1 where there are several
  LTH_NEW(c->ctx, point_shell, c->n_points);
  for (LitheIndex i = 0; i < 3 * c->n_tris; i++) {
    LitheIndex *owner = &point_shell[c->tris[i]], shell = c->tri_shell[i / 3] + 1;
    *owner = *owner == 0 || *owner == shell ? shell : -1;
  }
  for (LitheIndex t = c->n_tris - 1; t >= 0; t--) {
    Shell *shell = &nest->shell[c->tri_shell[t]];
    for (int k = 0; k < 3; k++) {
      shell->start[k] = 0;
      for (int i = 0; i < 3; i++) shell->start[k] += lth_clean_point(c, c->tris[3 * t + i])[k] / 3;
    }
  }
  for (LitheIndex i = 3 * c->n_tris - 1; i >= 0; i--)
    if (point_shell[c->tris[i]] > 0)
      lth_v3_copy(lth_clean_point(c, c->tris[i]), nest->shell[c->tri_shell[i / 3]].start);
  lth_free(c->ctx, point_shell);
  return LITHE_OK;
}

/// Side of x, moved by (e, e^2) for an infinitely small e > 0, of the line through a and b in (y, z).
static int side_moved(const double a[3], const double b[3], const double x[3]) {
  double p[2] = {a[1], a[2]}, q[2] = {b[1], b[2]}, r[2] = {x[1], x[2]};
  int side = lth_orient2d(p, q, r);
  if (side == 0) side = (p[1] > q[1]) - (p[1] < q[1]);
  if (side == 0) side = (q[0] > p[0]) - (q[0] < p[0]);
  return side;
}

/// The ray from x along +x, moved as above, passes through the triangle.
static bool ray_hits(const LthCleaner *c, LitheIndex tri, const double x[3]) {
  const double *p[3];
  int sides = 0;
  for (int i = 0; i < 3; i++) p[i] = lth_clean_point(c, c->tris[3 * tri + i]);
  for (int i = 0; i < 3; i++) {
    int side = side_moved(p[i], p[(i + 1) % 3], x);
    if (side == 0) return false;
    sides += side;
  }
  if (sides != 3 && sides != -3) return false;
  // a triangle that runs counter-clockwise in (y, z) has its normal along +x
  return lth_orient3d(p[0], p[1], p[2], x) == (sides > 0 ? -1 : 1);
}

static bool ray_meets_box(const double box[6], const double x[3]) {
  return box[3] >= x[0] && box[1] <= x[1] && x[1] <= box[4] && box[2] <= x[2] && x[2] <= box[5];
}

static void toggle(Nest *nest, LitheIndex shell) {
  nest->is_inside[shell] = !nest->is_inside[shell];
  nest->touched[nest->n_touched++] = shell;
}

/// Send a ray from a shell's start; `touched` then lists the shells hit, with repetition.
static void cast_ray(Nest *nest, LitheIndex shell) {
  const LthBvh *bvh = nest->bvh;
  const LthCleaner *c = nest->c;
  const double *x = nest->shell[shell].start;
  LitheIndex stack[STACK_MAX], top = 0;
  nest->n_touched = 0;
  stack[top++] = 0;
  while (top > 0) {
    LitheIndex node = stack[--top];
    if (!ray_meets_box(bvh->box + 6 * (size_t)node, x)) continue;
    if (bvh->right[node] >= 0) {
      stack[top++] = bvh->right[node];
      stack[top++] = node + 1;
      continue;
    }
    for (LitheIndex i = 0; i < bvh->count[node]; i++) {
      LitheIndex tri = bvh->item[bvh->first[node] + i];
      if (c->tri_shell[tri] != shell && ray_hits(c, tri, x)) toggle(nest, c->tri_shell[tri]);
    }
  }
}

/// Clear the marks of a ray, calling nothing back; returns how many shells were around its start and the
/// one among them with the given depth.
static LitheIndex count_around(Nest *nest, LitheIndex depth, LitheIndex *at_depth) {
  LitheIndex n = 0;
  for (LitheIndex i = 0; i < nest->n_touched; i++) {
    LitheIndex shell = nest->touched[i];
    if (!nest->is_inside[shell]) continue;
    nest->is_inside[shell] = false;
    n++;
    if (nest->shell[shell].depth == depth) *at_depth = shell;
  }
  return n;
}

static void find_depths(Nest *nest) {
  LitheIndex ignored = -1;
  for (LitheIndex s = 0; s < nest->c->n_shells; s++) {
    cast_ray(nest, s);
    nest->shell[s].depth = count_around(nest, -1, &ignored);
  }
  for (LitheIndex s = 0; s < nest->c->n_shells; s++) {
    nest->shell[s].parent = -1;
    if (nest->shell[s].depth == 0) continue;
    cast_ray(nest, s);
    count_around(nest, nest->shell[s].depth - 1, &nest->shell[s].parent);
  }
}

/// Where the file's orientation means something, a shell must face the other way than the one around it.
static LitheStatus check_nesting(Nest *nest) {
  LthCleaner *c = nest->c;
  for (LitheIndex s = 0; s < c->n_shells; s++) {
    const Shell *shell = &nest->shell[s],
                *around = &nest->shell[shell->parent < 0 ? s : shell->parent];
    if (around == shell || shell->is_mixed || around->is_mixed) continue;
    if ((shell->volume > 0) != (around->volume > 0)) continue;
    LITHE_TRY(lth_defects_add(c->ctx, c->defects, LTH_DEFECT_NESTING, shell->start, around->start));
  }
  return LITHE_OK;
}

static LitheStatus check_volumes(const Nest *nest) {
  const LthCleaner *c = nest->c;
  for (LitheIndex s = 0; s < c->n_shells; s++) {
    const Shell *shell = &nest->shell[s];
    if (fabs(shell->volume) > VOLUME_MIN * shell->area * c->size) continue;
    LITHE_FAIL(c->ctx, LITHE_BAD_INPUT,
               "%s: the shell at (%g, %g, %g) encloses no volume, expected a solid; give it a "
               "thickness, in Blender with the Solidify modifier",
               c->name, shell->start[0], shell->start[1], shell->start[2]);
  }
  return LITHE_OK;
}

/// Solids outwards, cavities inwards.
static void turn_shells(Nest *nest) {
  LthCleaner *c = nest->c;
  LitheIndex n_turned = 0, n_cavities = 0;
  for (LitheIndex s = 0; s < c->n_shells; s++) {
    bool is_cavity = nest->shell[s].depth % 2;
    n_cavities += is_cavity;
    n_turned += (nest->shell[s].volume < 0) != is_cavity;
  }
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    const Shell *shell = &nest->shell[c->tri_shell[t]];
    if ((shell->volume < 0) == (bool)(shell->depth % 2)) continue;
    LitheIndex *p = c->tris + 3 * (size_t)t, keep = p[1];
    p[1] = p[2];
    p[2] = keep;
  }
  if (n_turned)
    lth_warn(c->ctx, "%s: %d of %d shells faced inwards and were turned", c->name, n_turned,
             c->n_shells);
  if (c->n_shells > 1)
    lth_warn(c->ctx, "%s: %d shells, of which %d are cavities", c->name, c->n_shells, n_cavities);
}

LitheStatus lth_clean_nest(LthCleaner *c, const LthBvh *bvh) {
  LitheStatus status = LITHE_OK;
  Nest nest = {.c = c, .bvh = bvh};
  LTH_NEW_OR(done, c->ctx, nest.shell, c->n_shells);
  LTH_NEW_OR(done, c->ctx, nest.is_inside, c->n_shells);
  LTH_NEW_OR(done, c->ctx, nest.touched, c->n_tris);
  measure_shells(&nest);
  LITHE_TRY_OR(done, pick_starts(&nest));
  LITHE_TRY_OR(done, check_volumes(&nest));
  find_depths(&nest);
  LITHE_TRY_OR(done, check_nesting(&nest));
  turn_shells(&nest);
done:
  lth_free(c->ctx, nest.shell);
  lth_free(c->ctx, nest.is_inside);
  lth_free(c->ctx, nest.touched);
  return status;
}

/// Where the lattice of a sharp surface lies.
#include "geometry/sharp_priv.h"

#include <math.h>

#define LATTICE_MAX 2e9 ///< lattice cells that are worth waiting for
#define TRIALS 16       ///< shifts that are looked at along each axis

static double to_whole(double x) { return fabs(x - floor(x + 0.5)); }

/// Place of a plane across an axis in lattice cells from the box's lower side; false for other fields.
static bool plane_at(const LthField *f, int axis, double min, double h, double *at) {
  if (f->kind != LTH_FIELD_PLANE || f->axis != axis) return false;
  *at = (f->at[axis] - min) / h;
  return true;
}

/// Least distance, in cells, of planes across `axis` from lattice planes, and from diagonal ones of edges that they
/// have with planes across the axes before.
static double clearance(const LthSharp *s, const double min[3], const double *shift, int axis) {
  double least = 1, p, q;
  for (LitheIndex i = 0; i < s->solid->n_fields; i++) {
    if (!plane_at(&s->solid->field[i], axis, min[axis], s->h, &p)) continue;
    least = fmin(least, to_whole(p + shift[axis]));
    for (int before = 0; before < axis; before++)
      for (LitheIndex j = 0; j < s->solid->n_fields; j++)
        if (plane_at(&s->solid->field[j], before, min[before], s->h, &q))
          least = fmin(least, to_whole(p + shift[axis] - q - shift[before]));
  }
  return least;
}

/// Parts of a cell by which the lattice begins before the box. The uneven first ones keep it off what shapes like to
/// be symmetric about.
static void choose_shifts(const LthSharp *s, const double min[3], int attempt, double shift[3]) {
  for (int a = 0; a < 3; a++) {
    double first = 0.37 + 0.02 * a + 0.0137 * attempt * (a + 1), best = first, most = -1;
    for (int trial = 0; trial < TRIALS; trial++) {
      shift[a] = fmod(first + (double)trial / TRIALS, 1);
      double clear = clearance(s, min, shift, a);
      if (clear > most) most = clear, best = shift[a];
    }
    shift[a] = best;
  }
}

LitheStatus lth_sharp_lay_out(LthSharp *s, const double min[3], const double max[3],
                              double resolution, int attempt) {
  double all = 1, shift[3];
  s->h = resolution;
  choose_shifts(s, min, attempt, shift);
  for (int a = 0; a < 3; a++) {
    double cells = ceil((max[a] - min[a]) / resolution) + 4;
    all *= cells;
    if (!(all < LATTICE_MAX))
      LITHE_FAIL(
          s->ctx, LITHE_BAD_INPUT,
          "a shape of size %g m cannot be tessellated at a resolution of %g m; give a coarser "
          "resolution",
          max[a] - min[a], resolution);
    s->n[a] = (LitheIndex)cells + 1;
    s->origin[a] = min[a] - (1 + shift[a]) * resolution;
  }
  s->n_words = (s->solid->n_fields + 63) / 64;
  for (int side = 0; side < 2; side++)
    LTH_NEW(s->ctx, s->negative[side], (LitheCount)s->n[0] * s->n[1] * s->n_words);
  return LITHE_OK;
}

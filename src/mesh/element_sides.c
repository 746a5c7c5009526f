/// The faces of elements: listed with their corners, and matched where two elements share one.
#include "base/hash.h"
#include "mesh/element_mesh.h"

#include <string.h>

void lth_element_sides_destroy(LitheCtx *ctx, LthElementSides **sides) {
  if (!sides || !*sides) return;
  LthElementSides *s = *sides;
  void *blocks[] = {s->element_side, s->corner_off, s->corner, s->element, s->mate, s};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
  *sides = NULL;
}

/// Number of faces of an element and of all their corners.
static LitheIndex count_faces(const LthElementMesh *m, LitheIndex e, LitheCount *n_corners) {
  const LthElementShape *shape = lth_element_shape(m->kind[e]);
  for (int f = 0; f < shape->n_faces; f++) *n_corners += shape->face[f].n_corners;
  if (m->kind[e] != LTH_POLYHEDRON) return shape->n_faces;
  const LitheIndex *at = m->poly_face + m->poly_off[e];
  LitheIndex n_faces = *at++;
  for (LitheIndex f = 0; f < n_faces; f++) {
    *n_corners += *at;
    at += 1 + *at;
  }
  return n_faces;
}

/// Append a corner unless it repeats the one before; collapsed edges of an element vanish.
static void add_corner(LthElementSides *s, LitheIndex first, LitheIndex *n, LitheIndex node) {
  if (*n > first && s->corner[*n - 1] == node) return;
  s->corner[(*n)++] = node;
}

static void end_side(LthElementSides *s, LitheIndex element, LitheIndex first, LitheIndex *n) {
  while (*n > first && s->corner[*n - 1] == s->corner[first]) (*n)--;
  if (*n - first < 3) *n = first;
  s->element[s->n++] = element;
  s->corner_off[s->n] = *n;
}

static void list_element(const LthElementMesh *m, LitheIndex e, LthElementSides *s, LitheIndex *n) {
  const LthElementShape *shape = lth_element_shape(m->kind[e]);
  const LitheIndex *node = m->element_node + m->element_off[e];
  for (int f = 0; f < shape->n_faces; f++) {
    LitheIndex first = *n;
    for (int i = 0; i < shape->face[f].n_corners; i++)
      add_corner(s, first, n, node[shape->face[f].node[i]]);
    end_side(s, e, first, n);
  }
  if (m->kind[e] != LTH_POLYHEDRON) return;
  const LitheIndex *at = m->poly_face + m->poly_off[e];
  for (LitheIndex f = *at++; f > 0; f--) {
    LitheIndex first = *n;
    for (LitheIndex i = 0; i < *at; i++) add_corner(s, first, n, at[1 + i]);
    at += 1 + *at;
    end_side(s, e, first, n);
  }
}

static LitheStatus list_sides(LitheCtx *ctx, const LthElementMesh *m, LthElementSides *s) {
  LitheCount n_corners = 0, n_sides = 0;
  LitheIndex n = 0;
  for (LitheIndex e = 0; e < m->n_elements; e++) n_sides += count_faces(m, e, &n_corners);
  if (n_corners >= INT32_MAX || n_sides >= INT32_MAX / 3)
    LITHE_FAIL(ctx, LITHE_UNSUPPORTED, "mesh: %d elements are more than a mesh can hold",
               m->n_elements);
  LTH_NEW(ctx, s->element_side, (LitheCount)m->n_elements + 1);
  LTH_NEW(ctx, s->corner_off, n_sides + 1);
  LTH_NEW(ctx, s->corner, n_corners);
  LTH_NEW(ctx, s->element, n_sides);
  LTH_NEW(ctx, s->mate, n_sides);
  for (LitheIndex e = 0; e < m->n_elements; e++) {
    list_element(m, e, s, &n);
    s->element_side[e + 1] = s->n;
  }
  return LITHE_OK;
}

static void sort(LitheIndex *v, LitheIndex n) {
  for (LitheIndex i = 1; i < n; i++)
    for (LitheIndex j = i; j > 0 && v[j] < v[j - 1]; j--) {
      LitheIndex swap = v[j];
      v[j] = v[j - 1], v[j - 1] = swap;
    }
}

void lth_corner_key(const LitheIndex *corner, LitheIndex n, uint64_t key[2]) {
  if (n <= 4) {
    LitheIndex v[4] = {-1, -1, -1, -1};
    memcpy(v, corner, (size_t)n * sizeof *v);
    sort(v, n);
    key[0] = lth_hash_pair(v[0], v[1]);
    key[1] = lth_hash_pair(v[2], v[3]);
    return;
  }
  // sums of two mixes of each corner do not depend on their order; the top bit keeps them apart from the above
  uint64_t sum[2] = {0, 0};
  for (LitheIndex i = 0; i < n; i++) {
    uint64_t x = ((uint64_t)corner[i] + 1) * 0x9E3779B97F4A7C15u;
    x ^= x >> 29;
    sum[0] += x * 0xBF58476D1CE4E5B9u;
    sum[1] += (x ^ x >> 31) * 0x94D049BB133111EBu;
  }
  key[0] = sum[0] | (uint64_t)1 << 63;
  key[1] = sum[1];
}

/// Whether loop b runs through the corners of a in the same (step 1) or the opposite (-1) order.
static bool runs_along(const LitheIndex *a, const LitheIndex *b, LitheIndex n, int step) {
  for (LitheIndex start = 0; start < n; start++) {
    LitheIndex i = 0;
    while (i < n && a[i] == b[(start + step * i + n) % n]) i++;
    if (i == n) return true;
  }
  return false;
}

static LitheStatus refuse(LitheCtx *ctx, const LthElementMesh *m, const char *file,
                          const LthElementSides *s, LitheIndex a, LitheIndex b, const char *what) {
  char first[LTH_ELEMENT_TEXT_MAX], second[LTH_ELEMENT_TEXT_MAX];
  lth_element_text(m, file, s->element[b], second);
  const char *other = lth_element_text(m, file, s->element[a], first);
  const double *x = m->nodes + 3 * (LitheCount)s->corner[s->corner_off[b]];
  LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s and %s: %s near (%g, %g, %g)", second, other, what, x[0],
             x[1], x[2]);
}

/// Enter side b: a first one, the mate of a first one, or an error.
static LitheStatus match(LitheCtx *ctx, const LthElementMesh *m, const char *file,
                         LthElementSides *s, LthHash *known, LitheIndex b) {
  const LitheIndex *corner = s->corner + s->corner_off[b];
  LitheIndex n = s->corner_off[b + 1] - s->corner_off[b], a = 0;
  uint64_t key[2];
  s->mate[b] = -1;
  if (n == 0) return LITHE_OK;
  lth_corner_key(corner, n, key);
  LITHE_TRY(lth_hash_insert(ctx, known, key[0], key[1], b, &a));
  if (a == b) return LITHE_OK;
  const LitheIndex *other = s->corner + s->corner_off[a];
  if (s->corner_off[a + 1] - s->corner_off[a] != n)
    return refuse(ctx, m, file, s, a, b, "their faces cannot be told apart");
  if (s->element[a] == s->element[b])
    return refuse(ctx, m, file, s, a, b, "the element touches itself at a face");
  if (runs_along(other, corner, n, 1))
    return refuse(ctx, m, file, s, a, b,
                  "both lie on the same side of a face: one is there twice, or turned inside out");
  if (!runs_along(other, corner, n, -1))
    return refuse(ctx, m, file, s, a, b,
                  "they share the corners of a face in different orders: one is twisted");
  if (s->mate[a] >= 0)
    return refuse(ctx, m, file, s, a, b, "a third element lies at the same face");
  s->mate[a] = b;
  s->mate[b] = a;
  return LITHE_OK;
}

LitheStatus lth_element_sides_list(LitheCtx *ctx, const LthElementMesh *mesh,
                                   LthElementSides **sides) {
  *sides = NULL;
  LTH_NEW(ctx, *sides, 1);
  LitheStatus status = list_sides(ctx, mesh, *sides);
  if (status != LITHE_OK) lth_element_sides_destroy(ctx, sides);
  return status;
}

LitheStatus lth_element_sides_match(LitheCtx *ctx, const LthElementMesh *mesh, const char *file,
                                    LthElementSides *sides) {
  LitheStatus status = LITHE_OK;
  LthHash known = {0};
  LITHE_TRY_OR(done, lth_hash_reserve(ctx, &known, sides->n));
  for (LitheIndex s = 0; s < sides->n; s++)
    LITHE_TRY_OR(done, match(ctx, mesh, file, sides, &known, s));
done:
  lth_hash_free(ctx, &known);
  return status;
}

/// Planes of fields cut into convex pieces by each other; each piece is surface where its two sides differ.
///
/// Whether a field is negative at a vertex is decided from the values at the corners of the vertex' own simplex, which
/// neighbours share, so that they agree to the bit: by exact determinants on edges and in faces.
#include "geometry/sharp_cell.h"

#include "geometry/predicates.h"

#include <math.h>
#include <string.h>

// ------------------------------------------------------------------ vertices

static bool is_negative(const LthCell *c, int field, int corner) {
  return c->value[field][corner] < 0;
}

static int list_corners(int simplex, int corner[4]) {
  int n = 0;
  for (int i = 0; i < 4; i++)
    if (simplex >> i & 1) corner[n++] = i;
  return n;
}

static double minor3(const double *a, const double *b, const double *c, int p, int q, int r) {
  return a[p] * (b[q] * c[r] - b[r] * c[q]) - a[q] * (b[p] * c[r] - b[r] * c[p]) +
         a[r] * (b[p] * c[q] - b[q] * c[p]);
}

/// Weights of the point where the fields are zero, not divided by their sum, which is returned.
static double weigh(const LthCell *c, const LthCellVertex *v, double w[4]) {
  double f[3][4] = {{0}};
  int corner[4], n = list_corners(v->simplex, corner);
  for (int i = 0; i < v->n; i++)
    for (int k = 0; k < n; k++) f[i][k] = c->value[v->field[i]][corner[k]];
  if (v->n == 1) {
    w[0] = f[0][1], w[1] = -f[0][0];
  } else if (v->n == 2) {
    for (int k = 0; k < 3; k++) {
      int p = (k + 1) % 3, q = (k + 2) % 3;
      w[k] = f[0][p] * f[1][q] - f[0][q] * f[1][p];
    }
  } else {
    w[0] = minor3(f[0], f[1], f[2], 1, 2, 3);
    w[1] = -minor3(f[0], f[1], f[2], 0, 2, 3);
    w[2] = minor3(f[0], f[1], f[2], 0, 1, 3);
    w[3] = -minor3(f[0], f[1], f[2], 0, 1, 2);
  }
  double sum = 0;
  for (int k = 0; k < n; k++) sum += w[k];
  return sum;
}

static void place_vertex(const LthCell *c, LthCellVertex *v) {
  double w[4];
  int corner[4], n = list_corners(v->simplex, corner);
  double sum = weigh(c, v, w);
  for (int k = 0; k < n; k++) v->weight[corner[k]] = w[k] / sum;
}

static int sign_of(double x) { return (x > 0) - (x < 0); }

/// On an edge. Where both fields are zero at one place, field i is taken as if it were raised by less than nothing, by more than
/// those of higher numbers.
static bool edge_negative(const LthCell *c, const LthCellVertex *v, int field) {
  static const double zero[2] = {0, 0};
  int corner[4];
  list_corners(v->simplex, corner);
  int own = v->field[0];
  double fa = c->value[own][corner[0]], fb = c->value[own][corner[1]],
         ga = c->value[field][corner[0]], gb = c->value[field][corner[1]];
  int rising = fb > fa ? 1 : -1;
  int sign = rising * lth_orient2d((double[]){fb, fa}, (double[]){gb, ga}, zero);
  if (sign == 0 && own < field) sign = rising * sign_of(ga - gb);
  return sign < 0;
}

static bool face_negative(const LthCell *c, const LthCellVertex *v, int field) {
  static const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
  int corner[4];
  double f[3][3];
  list_corners(v->simplex, corner);
  for (int k = 0; k < 3; k++) {
    f[0][k] = c->value[v->field[0]][corner[k]];
    f[1][k] = c->value[v->field[1]][corner[k]];
    f[2][k] = c->value[field][corner[k]];
  }
  return lth_orient3d(zero, f[0], f[1], f[2]) * lth_orient3d(zero, f[0], f[1], one) < 0;
}

static bool inner_negative(const LthCell *c, const LthCellVertex *v, int field) {
  double w[4], value = 0;
  double sum = weigh(c, v, w);
  for (int k = 0; k < 4; k++) value += w[k] * c->value[field][k];
  return sum < 0 ? value > 0 : value < 0;
}

static bool find_sign(const LthCell *c, const LthCellVertex *v, int field) {
  int corner[4], n = list_corners(v->simplex, corner), n_negative = 0;
  for (int k = 0; k < n; k++) n_negative += is_negative(c, field, corner[k]);
  if (n_negative == 0 || n_negative == n) return n_negative > 0;
  return v->n == 1   ? edge_negative(c, v, field)
         : v->n == 2 ? face_negative(c, v, field)
                     : inner_negative(c, v, field);
}

static bool vertex_negative(LthCell *c, int vertex, int field) {
  LthCellVertex *v = &c->vertex[vertex];
  uint32_t bit = (uint32_t)1 << field;
  if (!(v->asked & bit)) {
    v->asked |= bit;
    if (find_sign(c, v, field)) v->negative |= bit;
  }
  return v->negative & bit;
}

/// The vertex of some fields (not -1) in a simplex, made when it is first asked for; -1: no room.
static int find_vertex(LthCell *c, int simplex, int a, int b, int d) {
  LthCellVertex v = {.simplex = simplex};
  int list[3] = {a, b, d};
  for (int i = 0; i < 3; i++) {
    int at = v.n;
    if (list[i] < 0) continue;
    for (; at > 0 && v.field[at - 1] > list[i]; at--) v.field[at] = v.field[at - 1];
    v.field[at] = list[i];
    v.n++;
  }
  for (int i = 0; i < c->n_vertices; i++) {
    const LthCellVertex *o = &c->vertex[i];
    if (o->simplex == simplex && o->n == v.n && memcmp(o->field, v.field, sizeof v.field) == 0)
      return i;
  }
  if (c->n_vertices == LTH_CELL_VERTICES) return -1;
  place_vertex(c, &v);
  c->vertex[c->n_vertices] = v;
  return c->n_vertices++;
}

// ------------------------------------------------------------------ pieces

/// All of the plane where a field is zero: a triangle or a quadrilateral.
static bool start_piece(LthCell *c, int field, LthCellPiece *p) {
  int order[4], n_in = 0, n = 0;
  bool odd = c->is_odd;
  for (int pass = 0; pass < 2; pass++)
    for (int k = 0; k < 4; k++)
      if (is_negative(c, field, k) == (pass == 0)) order[n++] = k, n_in += pass == 0;
  for (int i = 0; i < 4; i++)
    for (int j = i + 1; j < 4; j++) odd ^= order[i] > order[j];
  static const int quad[4][2] = {{0, 2}, {0, 3}, {1, 3}, {1, 2}};
  *p = (LthCellPiece){.field = field, .n = n_in == 2 ? 4 : 3};
  for (int k = 0; k < p->n; k++) {
    int lone = n_in == 1 ? 0 : 3, at = odd ? p->n - 1 - k : k;
    int a = n_in == 2 ? quad[at][0] : lone, b = n_in == 2 ? quad[at][1] : (lone + 1 + at) % 4;
    p->vertex[k] = find_vertex(c, 1 << order[a] | 1 << order[b], field, -1, -1);
    if (p->vertex[k] < 0) return false;
  }
  for (int k = 0; k < p->n; k++)
    p->line[k] = (LthCellLine){
        c->vertex[p->vertex[k]].simplex | c->vertex[p->vertex[(k + 1) % p->n]].simplex, -1};
  return true;
}

static bool push(LthCellPiece *p, int vertex, LthCellLine line) {
  if (p->n == LTH_CELL_SIDES) return false;
  p->vertex[p->n] = vertex;
  p->line[p->n++] = line;
  return true;
}

/// Cut a piece where another field changes sign: what is positive goes into `rest`, which may get nothing.
static bool cut_piece(LthCell *c, LthCellPiece *p, int field, LthCellPiece *rest) {
  LthCellPiece part[2] = {{.field = p->field, .negative = p->negative},
                          {.field = p->field, .negative = p->negative}};
  LthCellLine cut = {15, field};
  int n_changes = 0;
  for (int k = 0; k < p->n; k++) {
    int here = p->vertex[k], next = p->vertex[(k + 1) % p->n];
    bool in = vertex_negative(c, here, field);
    if (!push(&part[!in], here, p->line[k])) return false;
    if (vertex_negative(c, next, field) == in) continue;
    int between = find_vertex(c, p->line[k].simplex, p->field, field, p->line[k].field);
    if (between < 0 || !push(&part[!in], between, cut) || !push(&part[in], between, p->line[k]))
      return false;
    n_changes++;
  }
  part[0].negative |= (uint32_t)1 << field;
  *p = part[part[0].n == 0];
  *rest = n_changes ? part[1] : (LthCellPiece){.n = 0};
  return n_changes == 0 || n_changes == 2;
}

/// Is the solid's inside on the negative, on the positive side of a piece, or on neither or both?
static void judge_piece(const LthCell *c, LthCellPiece *p) {
  LthFieldSide beside[2];
  for (int i = 0; i < c->n; i++) c->side[c->field[i]] = p->negative >> i & 1 ? -1 : 1;
  for (int positive = 0; positive < 2; positive++) {
    c->side[c->field[p->field]] = positive ? 1 : -1;
    beside[positive] = lth_solid_side(c->solid, c->side);
  }
  p->is_kept = beside[0] != beside[1];
  p->is_turned = beside[0] > beside[1];
}

/// The plane of one field, cut by all others.
static bool cut_plane(LthCell *c, int field) {
  int first = c->n_pieces;
  if (c->n_pieces == LTH_CELL_PIECES || !start_piece(c, field, &c->piece[c->n_pieces++]))
    return false;
  for (int other = 0; other < c->n; other++) {
    if (other == field) continue;
    int n = c->n_pieces;
    for (int p = first; p < n; p++) {
      LthCellPiece rest;
      if (!cut_piece(c, &c->piece[p], other, &rest)) return false;
      if (rest.n == 0) continue;
      if (c->n_pieces == LTH_CELL_PIECES) return false;
      c->piece[c->n_pieces++] = rest;
    }
  }
  int n = first;
  for (int p = first; p < c->n_pieces; p++) {
    judge_piece(c, &c->piece[p]);
    if (c->piece[p].is_kept) c->piece[n++] = c->piece[p];
  }
  c->n_pieces = n;
  return true;
}

// ------------------------------------------------------------------ vertices that the neighbour does not have

static int find_in(const LthCellPiece *p, int vertex, int from) {
  for (int k = from; k < p->n; k++)
    if (p->vertex[k] == vertex) return k;
  return -1;
}

/// Remove `count` vertices from `at` on, cyclically; the one after them becomes the first.
static void erase(LthCellPiece *p, int at, int count) {
  LthCellPiece old = *p;
  p->n = 0;
  for (int k = 0; k < old.n - count; k++) {
    int from = (at + count + k) % old.n;
    p->vertex[p->n] = old.vertex[from];
    p->line[p->n++] = old.line[from];
  }
}

/// Take back slits: sides that go to a vertex and back on the same way.
static void close_slits(LthCellPiece *p) {
  for (int k = 0; k < p->n && p->n >= 3; k++) {
    int back = (k + 2) % p->n;
    if (p->vertex[k] != p->vertex[back]) continue;
    p->line[k] = p->line[back];
    erase(p, (k + 1) % p->n, 2);
    k = -1;
  }
}

/// Two pieces with the side from v to w in common become one without it, and without v.
static bool join_pieces(LthCellPiece *a, LthCellPiece *b, int v) {
  int i = find_in(a, v, 0), j = find_in(b, v, 0);
  // the common side leaves v in one of them and comes to it in the other
  if (a->vertex[(i + 1) % a->n] != b->vertex[(j + b->n - 1) % b->n]) {
    LthCellPiece *swap = a;
    int t = i;
    a = b, b = swap, i = j, j = t;
    if (a->vertex[(i + 1) % a->n] != b->vertex[(j + b->n - 1) % b->n]) return false;
  }
  if (a->n + b->n - 3 > LTH_CELL_SIDES) return false;
  LthCellPiece whole = *a;
  whole.n = 0;
  // from w all around a to the corner before v, then b from the corner after v to the one before w
  for (int k = 1; k < a->n; k++) push(&whole, a->vertex[(i + k) % a->n], a->line[(i + k) % a->n]);
  for (int k = 1; k < b->n - 1; k++)
    push(&whole, b->vertex[(j + k) % b->n], b->line[(j + k) % b->n]);
  close_slits(&whole);
  whole.is_kept = whole.n >= 3;
  *a = whole;
  b->n = 0;
  b->is_kept = false;
  return true;
}

/// Coordinates of a vertex in the piece's plane, in a frame that is not at right angles.
static void project(const LthCell *c, const double normal[3], int vertex, double xy[2]) {
  int drop = 0;
  for (int a = 1; a < 3; a++)
    if (fabs(normal[a]) > fabs(normal[drop])) drop = a;
  xy[0] = c->vertex[vertex].weight[1 + (drop + 1) % 3];
  xy[1] = c->vertex[vertex].weight[1 + (drop + 2) % 3];
}

static bool segments_meet(const double a[2], const double b[2], const double p[2],
                          const double q[2]) {
  return lth_orient2d(a, b, p) * lth_orient2d(a, b, q) <= 0 &&
         lth_orient2d(p, q, a) * lth_orient2d(p, q, b) <= 0;
}

/// Does the way between two vertices of a piece meet one of its sides that ends at neither?
static bool is_blocked(const LthCell *c, const LthCellPiece *p, int from, int to) {
  double normal[3], a[2], b[2], x[2], y[2];
  for (int k = 0; k < 3; k++) // of the field in the frame of the weights
    normal[k] = c->value[p->field][k + 1] - c->value[p->field][0];
  project(c, normal, from, a);
  project(c, normal, to, b);
  for (int k = 0; k < p->n; k++) {
    int here = p->vertex[k], next = p->vertex[(k + 1) % p->n];
    if (here == from || here == to || next == from || next == to) continue;
    project(c, normal, here, x);
    project(c, normal, next, y);
    if (segments_meet(a, b, x, y)) return true;
  }
  return false;
}

static double gap2(const LthCell *c, int v, int w) {
  double sum = 0;
  for (int k = 0; k < 4; k++) {
    double d = c->vertex[v].weight[k] - c->vertex[w].weight[k];
    sum += d * d;
  }
  return sum;
}

/// A vertex that two rings of one piece hang together at, in places i and j, goes: another slit takes its part.
static bool bridge(const LthCell *c, LthCellPiece *p, int i, int j) {
  int v = p->vertex[i], n[2] = {j - i - 1, p->n - (j - i) - 1}, best[2] = {-1, -1};
  double least = INFINITY;
  LthCellPiece old = *p;
  // a ring that the slit led to begins and ends where it ended
  n[0] -= old.vertex[i + 1] == old.vertex[j - 1] && n[0] > 1;
  n[1] -= old.vertex[(j + 1) % old.n] == old.vertex[(i + old.n - 1) % old.n] && n[1] > 1;
  for (int a = 0; a < n[0]; a++)
    for (int b = 0; b < n[1]; b++) {
      int from = old.vertex[i + 1 + a], to = old.vertex[(j + 1 + b) % old.n];
      double gap = gap2(c, from, to);
      if (from == v || to == v || !(gap < least) || is_blocked(c, &old, from, to)) continue;
      least = gap;
      best[0] = a, best[1] = b;
    }
  if (best[0] < 0 || old.n > LTH_CELL_SIDES) return false;
  p->n = 0;
  for (int ring = 0; ring < 2; ring++)
    for (int k = 0; k <= n[ring]; k++) { // all around, and the vertex of the slit again
      int at = ((ring ? j : i) + 1 + (best[ring] + k) % n[ring]) % old.n;
      LthCellLine line = k == n[ring] ? (LthCellLine){15, -1} : old.line[at];
      if (!push(p, old.vertex[at], line)) return false;
    }
  return true;
}

/// The vertex in the middle of a straight side goes.
static bool smooth_out(const LthCell *c, LthCellPiece *p, int v) {
  int i = find_in(p, v, 0), j = find_in(p, v, i + 1);
  if (j >= 0 && find_in(p, v, j + 1) >= 0) return false;
  if (j >= 0) {
    if (!bridge(c, p, i, j)) return false;
  } else {
    erase(p, i, 1);
    if (p->vertex[0] == p->vertex[p->n - 1]) p->n--; // it was the tip of a slit
  }
  close_slits(p);
  p->is_kept = p->n >= 3;
  return true;
}

/// Fields that have pieces at a vertex.
static uint32_t fields_at(const LthCell *c, int vertex) {
  uint32_t fields = 0;
  for (int p = 0; p < c->n_pieces; p++)
    if (c->piece[p].is_kept && find_in(&c->piece[p], vertex, 0) >= 0)
      fields |= (uint32_t)1 << c->piece[p].field;
  return fields;
}

/// A vertex in a face that is no corner of the surface there: the neighbour may not know of the field that made it.
static bool drop_vertex(LthCell *c, int vertex) {
  int at[2], n = 0;
  for (int p = 0; p < c->n_pieces; p++) {
    if (!c->piece[p].is_kept || find_in(&c->piece[p], vertex, 0) < 0) continue;
    if (n == 2) return false;
    at[n++] = p;
  }
  return n == 2 ? join_pieces(&c->piece[at[0]], &c->piece[at[1]], vertex)
                : smooth_out(c, &c->piece[at[0]], vertex);
}

static bool drop_hidden(LthCell *c) {
  for (int i = 0; i < c->n_vertices; i++) {
    const LthCellVertex *v = &c->vertex[i];
    if (v->n != 2) continue;
    uint32_t own = (uint32_t)1 << v->field[0] | (uint32_t)1 << v->field[1], met = fields_at(c, i);
    if (met != 0 && met != own && !drop_vertex(c, i)) return false;
  }
  return true;
}

bool lth_cell_surface(LthCell *c) {
  c->n_vertices = c->n_pieces = 0;
  for (int i = 0; i < c->n; i++)
    if (!cut_plane(c, i)) return false;
  return drop_hidden(c);
}

/// Cutting a planar face with holes by a plane.
///
/// The part on one side consists of whole loops and of open chains that start and end on the cut line.
/// Walking along the line with the kept part on the left, the part's boundary runs from the end of a chain to
/// the next start. So ends and starts, each sorted along the line, pair in order; coinciding points and
/// touching loops need no special care.
#include "mesh/piece.h"

#include "base/tensor.h"

void lth_pieces_free(LitheCtx *ctx, LthPieces *pieces) {
  lth_free(ctx, pieces->piece_loop_off);
  lth_free(ctx, pieces->loop_off);
  lth_free(ctx, pieces->loop_point);
  lth_free(ctx, pieces->points);
  *pieces = (LthPieces){0};
}

void lth_pieces_clear(LthPieces *pieces) { pieces->n = pieces->n_loops = pieces->n_points = 0; }

LthFaceView lth_pieces_view(const LthPieces *pieces, LitheIndex i, const double *normal) {
  LitheIndex first = pieces->piece_loop_off[i];
  return (LthFaceView){.points = pieces->points,
                       .loop_off = pieces->loop_off + first,
                       .loop_point = pieces->loop_point,
                       .n_loops = pieces->piece_loop_off[i + 1] - first,
                       .normal = normal};
}

static LitheStatus add_point(LitheCtx *ctx, LthPieces *p, const double x[3]) {
  LTH_RESERVE(ctx, p->points, p->cap_points, 3 * ((LitheCount)p->n_points + 1));
  LTH_RESERVE(ctx, p->loop_point, p->cap_index, p->n_points + 1);
  p->loop_point[p->n_points] = p->n_points;
  lth_v3_copy(x, p->points + 3 * (LitheCount)p->n_points++);
  return LITHE_OK;
}

/// The points added since the last loop become a loop; fewer than `least` are dropped.
static LitheStatus end_loop(LitheCtx *ctx, LthPieces *p, LitheIndex least) {
  LTH_RESERVE(ctx, p->loop_off, p->cap_loops, p->n_loops + 2);
  if (p->n_points - p->loop_off[p->n_loops] < least) {
    p->n_points = p->loop_off[p->n_loops];
    return LITHE_OK;
  }
  p->loop_off[++p->n_loops] = p->n_points;
  return LITHE_OK;
}

/// The loops added since the last piece become a piece; none are no piece.
static LitheStatus end_piece(LitheCtx *ctx, LthPieces *p) {
  LTH_RESERVE(ctx, p->piece_loop_off, p->cap_pieces, p->n + 2);
  if (p->n_loops > p->piece_loop_off[p->n]) p->piece_loop_off[++p->n] = p->n_loops;
  return LITHE_OK;
}

/// Offsets exist from the first loop on.
static LitheStatus begin(LitheCtx *ctx, LthPieces *p) {
  LTH_RESERVE(ctx, p->loop_off, p->cap_loops, p->n_loops + 1);
  LTH_RESERVE(ctx, p->piece_loop_off, p->cap_pieces, p->n + 1);
  return LITHE_OK;
}

static const double *corner(const LthFaceView *face, LitheIndex k) {
  return face->points + 3 * (LitheCount)face->loop_point[k];
}

static LitheStatus copy_loop(LitheCtx *ctx, const LthFaceView *face, LitheIndex loop,
                             LthPieces *p) {
  for (LitheIndex k = face->loop_off[loop]; k < face->loop_off[loop + 1]; k++)
    LITHE_TRY(add_point(ctx, p, corner(face, k)));
  return end_loop(ctx, p, 3);
}

LitheStatus lth_pieces_add(LitheCtx *ctx, LthPieces *pieces, const LthFaceView *face) {
  LITHE_TRY(begin(ctx, pieces));
  for (LitheIndex l = 0; l < face->n_loops; l++) LITHE_TRY(copy_loop(ctx, face, l, pieces));
  return end_piece(ctx, pieces);
}

static double height_above(const LthPlane *plane, const double x[3], double tolerance) {
  double d[3];
  lth_v3_sub(x, plane->point, d);
  double h = lth_v3_dot(d, plane->normal);
  return fabs(h) <= tolerance ? 0 : h;
}

bool lth_plane_crosses(const LthPlane *plane, const LthFaceView *face, double tolerance) {
  bool above = false, below = false;
  for (LitheIndex k = face->loop_off[0]; k < face->loop_off[face->n_loops]; k++) {
    double h = height_above(plane, corner(face, k), tolerance);
    above |= h > 0;
    below |= h < 0;
  }
  return above && below;
}

void lth_cut_scratch_free(LitheCtx *ctx, LthCutScratch *s) {
  lth_free(ctx, s->height);
  for (int i = 0; i < 2; i++) {
    lth_free(ctx, s->along[i]);
    lth_free(ctx, s->chain[i]);
  }
  lth_free(ctx, s->next);
  lth_pieces_free(ctx, &s->chains);
  *s = (LthCutScratch){0};
}

/// Where the edge a -> b meets the plane; the same bits for both sides.
static LitheStatus add_crossing(LitheCtx *ctx, LthPieces *p, const double *a, const double *b,
                                double ha, double hb) {
  double x[3], w = ha / (ha - hb);
  for (int i = 0; i < 3; i++) x[i] = a[i] + w * (b[i] - a[i]);
  return add_point(ctx, p, x);
}

/// Append the chains of a loop that lie above the plane. `height` is that of the loop's points, signed by the
/// side.
static LitheStatus collect_chains(LitheCtx *ctx, const LthFaceView *face, LitheIndex loop,
                                  const double *height, LthPieces *chains) {
  LitheIndex base = face->loop_off[loop], n = face->loop_off[loop + 1] - base;
  for (LitheIndex a = 0; a < n; a++) {
    LitheIndex b = (a + 1) % n;
    if (height[a] > 0 || !(height[b] > 0)) continue;
    // a start: from the line, if not from a point on it, up to b
    const double *xa = corner(face, base + a);
    if (height[a] < 0)
      LITHE_TRY(add_crossing(ctx, chains, xa, corner(face, base + b), height[a], height[b]));
    else
      LITHE_TRY(add_point(ctx, chains, xa));
    // along the loop and back down to the line
    LitheIndex last;
    do {
      last = b;
      LITHE_TRY(add_point(ctx, chains, corner(face, base + last)));
      b = (b + 1) % n;
    } while (height[b] > 0);
    const double *xb = corner(face, base + b);
    if (height[b] < 0)
      LITHE_TRY(add_crossing(ctx, chains, corner(face, base + last), xb, height[last], height[b]));
    else
      LITHE_TRY(add_point(ctx, chains, xb));
    LITHE_TRY(end_loop(ctx, chains, 0));
  }
  return LITHE_OK;
}

/// Insertion sort: a cut line has few chains, and they come nearly in order.
static void sort_along(LitheIndex n, double *along, LitheIndex *chain) {
  for (LitheIndex i = 1; i < n; i++)
    for (LitheIndex j = i; j > 0 && along[j] < along[j - 1]; j--) {
      double t = along[j];
      LitheIndex c = chain[j];
      along[j] = along[j - 1], along[j - 1] = t;
      chain[j] = chain[j - 1], chain[j - 1] = c;
    }
}

/// next[c]: the chain whose start follows the end of chain c on the cut line.
static LitheStatus pair_chains(LitheCtx *ctx, const double direction[3], LthCutScratch *s) {
  const LthPieces *c = &s->chains;
  for (int end = 0; end < 2; end++) {
    LTH_RESERVE(ctx, s->along[end], s->caps[1 + end], c->n_loops);
    LTH_RESERVE(ctx, s->chain[end], s->caps[3 + end], c->n_loops);
    for (LitheIndex i = 0; i < c->n_loops; i++) {
      LitheIndex point = end ? c->loop_off[i + 1] - 1 : c->loop_off[i];
      double d[3];
      lth_v3_sub(c->points + 3 * (LitheCount)point, c->points, d);
      s->along[end][i] = lth_v3_dot(d, direction);
      s->chain[end][i] = i;
    }
    sort_along(c->n_loops, s->along[end], s->chain[end]);
  }
  LTH_RESERVE(ctx, s->next, s->caps[5], c->n_loops);
  for (LitheIndex i = 0; i < c->n_loops; i++) s->next[s->chain[1][i]] = s->chain[0][i];
  return LITHE_OK;
}

/// Close the chains to loops. Used chains are marked by next = -1.
static LitheStatus join_chains(LitheCtx *ctx, LthCutScratch *s, LthPieces *out) {
  const LthPieces *c = &s->chains;
  for (LitheIndex i = 0; i < c->n_loops; i++) {
    LitheIndex at = i;
    while (s->next[at] >= 0) {
      for (LitheIndex k = c->loop_off[at]; k < c->loop_off[at + 1]; k++) {
        const double *x = c->points + 3 * (LitheCount)k;
        bool repeats =
            out->n_points > out->loop_off[out->n_loops] &&
            memcmp(x, out->points + 3 * ((LitheCount)out->n_points - 1), 3 * sizeof *x) == 0;
        if (!repeats) LITHE_TRY(add_point(ctx, out, x));
      }
      LitheIndex next = s->next[at];
      s->next[at] = -1;
      at = next;
    }
    if (out->n_points > out->loop_off[out->n_loops]) LITHE_TRY(end_loop(ctx, out, 3));
  }
  return LITHE_OK;
}

LitheStatus lth_pieces_cut(LitheCtx *ctx, const LthFaceView *face, const LthPlane *plane,
                           double side, double tolerance, LthCutScratch *s, LthPieces *out) {
  LITHE_TRY(begin(ctx, out));
  lth_pieces_clear(&s->chains);
  LITHE_TRY(begin(ctx, &s->chains));
  LitheIndex first = face->loop_off[0], end = face->loop_off[face->n_loops];
  LTH_RESERVE(ctx, s->height, s->caps[0], end - first);
  for (LitheIndex k = first; k < end; k++)
    s->height[k - first] = side * height_above(plane, corner(face, k), tolerance);
  for (LitheIndex l = 0; l < face->n_loops; l++) {
    bool above = false, below = false;
    for (LitheIndex k = face->loop_off[l] - first; k < face->loop_off[l + 1] - first; k++) {
      above |= s->height[k] > 0;
      below |= s->height[k] < 0;
    }
    const double *height = s->height + (face->loop_off[l] - first);
    if (above && !below)
      LITHE_TRY(copy_loop(ctx, face, l, out));
    else if (above)
      LITHE_TRY(collect_chains(ctx, face, l, height, &s->chains));
  }
  if (s->chains.n_loops > 0) {
    // in the face, with the kept side on the left
    double direction[3];
    lth_v3_cross(plane->normal, face->normal, direction);
    lth_v3_scale(side, direction);
    LITHE_TRY(pair_chains(ctx, direction, s));
    LITHE_TRY(join_chains(ctx, s, out));
  }
  return end_piece(ctx, out);
}

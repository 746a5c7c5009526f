/// Where planar boundary pieces of two bodies coincide: one cut by the convex parts of the other.
#include "base/tensor.h"
#include "couple/tie_priv.h"

#define PLANE_TOLERANCE 1e-6 ///< of a piece's size: planes this close are one
#define CUT_TOLERANCE 1e-9   ///< of a piece's size: points this close to a cut are on it
#define AREA_TOLERANCE 1e-12 ///< of the smaller piece: parts below are none
#define ROUNDS_MAX 1000      ///< of a decomposition; each leaves fewer lines that cross

void lth_overlap_free(LitheCtx *ctx, LthOverlap *overlap) {
  lth_pieces_free(ctx, &overlap->pieces);
  lth_free(ctx, overlap->patch);
  *overlap = (LthOverlap){0};
}

/// The plane through edge k of a loop, its normal pointing into the face; false for an edge without length.
static bool edge_plane(const LthFaceView *face, LitheIndex loop, LitheIndex k, double tolerance,
                       LthPlane *plane) {
  LitheIndex next = k + 1 < face->loop_off[loop + 1] ? k + 1 : face->loop_off[loop];
  const double *a = face->points + 3 * (size_t)face->loop_point[k];
  double along[3];
  lth_v3_sub(face->points + 3 * (size_t)face->loop_point[next], a, along);
  if (!(lth_v3_norm(along) > tolerance)) return false;
  lth_v3_copy(a, plane->point);
  lth_v3_cross(face->normal, along, plane->normal);
  lth_v3_normalize(plane->normal);
  return true;
}

/// The line of an edge that has points of the face on both sides.
static bool find_crossing(const LthFaceView *face, double tolerance, LthPlane *plane) {
  for (LitheIndex l = 0; l < face->n_loops; l++)
    for (LitheIndex k = face->loop_off[l]; k < face->loop_off[l + 1]; k++)
      if (edge_plane(face, l, k, tolerance, plane) && lth_plane_crosses(plane, face, tolerance))
        return true;
  return false;
}

LitheStatus lth_convex_parts(LitheCtx *ctx, const LthFaceView *face, double tolerance,
                             LthPieces *out) {
  LitheStatus status = LITHE_OK;
  LthPieces list[2] = {{0}, {0}};
  LthCutScratch scratch = {0};
  LITHE_TRY_OR(done, lth_pieces_add(ctx, &list[0], face));
  for (int round = 0; list[round % 2].n > 0; round++) {
    const LthPieces *from = &list[round % 2];
    LthPieces *to = &list[1 - round % 2];
    lth_pieces_clear(to);
    for (LitheIndex i = 0; i < from->n; i++) {
      LthFaceView part = lth_pieces_view(from, i, face->normal);
      LthPlane plane;
      if (round == ROUNDS_MAX || !find_crossing(&part, tolerance, &plane)) {
        LITHE_TRY_OR(done, lth_pieces_add(ctx, out, &part));
        continue;
      }
      for (int side = -1; side <= 1; side += 2)
        LITHE_TRY_OR(done, lth_pieces_cut(ctx, &part, &plane, side, tolerance, &scratch, to));
    }
  }
done:
  lth_pieces_free(ctx, &list[0]);
  lth_pieces_free(ctx, &list[1]);
  lth_cut_scratch_free(ctx, &scratch);
  return status;
}

static void piece_box(const LthPatches *patches, LitheIndex i, double box[6]) {
  for (int a = 0; a < 3; a++) box[a] = INFINITY, box[3 + a] = -INFINITY;
  LitheIndex first = patches->loop_off[patches->loop_off_of[i]];
  LitheIndex last = patches->loop_off[patches->loop_off_of[i + 1]];
  for (LitheIndex k = first; k < last; k++)
    for (int a = 0; a < 3; a++) {
      double x = patches->points[3 * (size_t)patches->loop_point[k] + (size_t)a];
      box[a] = fmin(box[a], x);
      box[3 + a] = fmax(box[3 + a], x);
    }
}

LitheStatus lth_patches_tree(LitheCtx *ctx, const LthPatches *patches, LthBvh **tree) {
  double *boxes = NULL;
  LTH_NEW(ctx, boxes, 6 * (LitheCount)patches->n);
  for (LitheIndex i = 0; i < patches->n; i++) piece_box(patches, i, boxes + 6 * (size_t)i);
  LitheStatus status = lth_bvh_create_boxes(ctx, patches->n, boxes, tree);
  lth_free(ctx, boxes);
  return status;
}

/// A search for all that coincides with one piece of the first body.
typedef struct Search {
  LitheCtx *ctx;
  const LthTieDef *def;
  LthOverlap *overlap;
  uint8_t *const *tied;
  LitheIndex piece;
  LthFaceView face;
  double size;
  LthPieces parts, work[2]; ///< kept from piece to piece
  LthCutScratch scratch;
  LitheStatus status;
} Search;

static bool is_coplanar(const Search *s, const LthFaceView *other) {
  double sum[3];
  const double *at = s->face.points + 3 * (size_t)s->face.loop_point[s->face.loop_off[0]];
  lth_v3_add(s->face.normal, other->normal, sum);
  if (lth_v3_norm(sum) > PLANE_TOLERANCE) return false;
  for (LitheIndex k = other->loop_off[0]; k < other->loop_off[other->n_loops]; k++) {
    double d[3];
    lth_v3_sub(other->points + 3 * (size_t)other->loop_point[k], at, d);
    if (fabs(lth_v3_dot(d, s->face.normal)) > PLANE_TOLERANCE * s->size) return false;
  }
  return true;
}

/// Cut the face by all edges of a convex part; what remains ends in work[0].
static LitheStatus cut_by(Search *s, const LthFaceView *part) {
  const double tolerance = CUT_TOLERANCE * s->size;
  lth_pieces_clear(&s->work[0]);
  LITHE_TRY(lth_pieces_add(s->ctx, &s->work[0], &s->face));
  for (LitheIndex k = part->loop_off[0]; k < part->loop_off[1] && s->work[0].n > 0; k++) {
    LthPlane plane;
    if (!edge_plane(part, 0, k, tolerance, &plane)) continue;
    LthFaceView view = lth_pieces_view(&s->work[0], 0, s->face.normal);
    lth_pieces_clear(&s->work[1]);
    LITHE_TRY(lth_pieces_cut(s->ctx, &view, &plane, 1, tolerance, &s->scratch, &s->work[1]));
    LthPieces swap = s->work[0];
    s->work[0] = s->work[1], s->work[1] = swap;
  }
  return LITHE_OK;
}

static LitheStatus add_common(Search *s, LitheIndex other, const LthFaceView *view) {
  double centroid[3];
  const LthTieSide *side = s->def->side;
  LthOverlap *o = s->overlap;
  s->parts.n = s->parts.n_loops = s->parts.n_points = 0;
  LITHE_TRY(lth_convex_parts(s->ctx, view, CUT_TOLERANCE * s->size, &s->parts));
  for (LitheIndex i = 0; i < s->parts.n; i++) {
    LthFaceView part = lth_pieces_view(&s->parts, i, view->normal);
    LITHE_TRY(cut_by(s, &part));
    if (s->work[0].n == 0) continue;
    LthFaceView common = lth_pieces_view(&s->work[0], 0, s->face.normal);
    double least = fmin(side[0].patches->area[s->piece], side[1].patches->area[other]);
    if (!(lth_face_area_centroid(&common, centroid) > AREA_TOLERANCE * least)) continue;
    LITHE_TRY(lth_pieces_add(s->ctx, &o->pieces, &common));
    LTH_RESERVE(s->ctx, o->patch, o->patch_cap, 2 * (LitheCount)o->pieces.n);
    o->patch[2 * o->pieces.n - 2] = s->piece;
    o->patch[2 * o->pieces.n - 1] = other;
    s->tied[0][s->piece] = s->tied[1][other] = 1;
  }
  return LITHE_OK;
}

static bool visit(void *self, LitheIndex other) {
  Search *s = self;
  const LthTieSide *side = &s->def->side[1];
  LthFaceView view = lth_patches_view(side->disc->mesh, side->patches, other);
  if (is_coplanar(s, &view)) s->status = add_common(s, other, &view);
  return s->status == LITHE_OK;
}

LitheStatus lth_overlap_find(LitheCtx *ctx, const LthTieDef *def, LthOverlap *overlap,
                             uint8_t *const tied[2]) {
  LthBvh *tree = NULL;
  Search s = {.ctx = ctx, .def = def, .overlap = overlap, .tied = tied};
  const LthTieSide *a = &def->side[0];
  LITHE_TRY(lth_patches_tree(ctx, def->side[1].patches, &tree));
  for (s.piece = 0; s.piece < a->patches->n && s.status == LITHE_OK; s.piece++) {
    double box[6], middle[3];
    piece_box(a->patches, s.piece, box);
    for (int i = 0; i < 3; i++) middle[i] = 0.5 * (box[i] + box[3 + i]);
    double radius = lth_v3_distance(box, middle);
    s.size = 2 * radius;
    s.face = lth_patches_view(a->disc->mesh, a->patches, s.piece);
    lth_bvh_visit(tree, middle, radius, visit, &s);
  }
  lth_pieces_free(ctx, &s.parts);
  lth_pieces_free(ctx, &s.work[0]);
  lth_pieces_free(ctx, &s.work[1]);
  lth_cut_scratch_free(ctx, &s.scratch);
  lth_bvh_destroy(ctx, &tree);
  return s.status;
}

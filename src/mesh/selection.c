/// Boundary pieces and cells that a `where` selects, and quadrature over pieces.
///
/// A face is divided by every plane of the tree that crosses it. Each part then lies on one side of all
/// planes, so that its centroid decides for all of it, whatever and, or and not do.
#include "mesh/selection.h"

#include "base/tensor.h"
#include "geometry/quadrature.h"
#include "mesh/topology.h"
#include "mesh/where.h"

void lth_patches_destroy(LitheCtx *ctx, LthPatches **patches) {
  if (!*patches) return;
  lth_free(ctx, (*patches)->face);
  lth_free(ctx, (*patches)->loop_off_of);
  lth_free(ctx, (*patches)->loop_off);
  lth_free(ctx, (*patches)->loop_point);
  lth_free(ctx, (*patches)->points);
  lth_free(ctx, (*patches)->area);
  lth_free(ctx, (*patches)->centroid);
  lth_free(ctx, *patches);
  *patches = NULL;
}

LthFaceView lth_patches_view(const LthMesh *mesh, const LthPatches *patches, LitheIndex i) {
  LitheIndex first = patches->loop_off_of[i];
  return (LthFaceView){.points = patches->points,
                       .loop_off = patches->loop_off + first,
                       .loop_point = patches->loop_point,
                       .n_loops = patches->loop_off_of[i + 1] - first,
                       .normal = mesh->face_normal + 3 * (LitheCount)patches->face[i]};
}

/// What a selection collects, and its scratch.
typedef struct Collector {
  LthWhereReady ready;
  LthPieces chosen;        // result
  LitheIndex *chosen_face; // face of each chosen piece
  LitheCount cap_faces;
  LthPieces parts, cut; // parts of the face at hand, before and after a cut
  LthCutScratch scratch;
} Collector;

static void collector_free(LitheCtx *ctx, Collector *c) {
  lth_where_ready_free(ctx, &c->ready);
  lth_pieces_free(ctx, &c->chosen);
  lth_free(ctx, c->chosen_face);
  lth_pieces_free(ctx, &c->parts);
  lth_pieces_free(ctx, &c->cut);
  lth_cut_scratch_free(ctx, &c->scratch);
}

static LitheStatus choose(LitheCtx *ctx, Collector *c, LitheIndex f, const LthFaceView *piece) {
  LitheIndex before = c->chosen.n;
  LTH_RESERVE(ctx, c->chosen_face, c->cap_faces, before + 1);
  LITHE_TRY(lth_pieces_add(ctx, &c->chosen, piece));
  if (c->chosen.n > before) c->chosen_face[before] = f;
  return LITHE_OK;
}

/// Divide all parts by a plane.
static LitheStatus divide(LitheCtx *ctx, Collector *c, const double *normal,
                          const LthPlane *plane) {
  lth_pieces_clear(&c->cut);
  for (LitheIndex i = 0; i < c->parts.n; i++) {
    LthFaceView part = lth_pieces_view(&c->parts, i, normal);
    if (!lth_plane_crosses(plane, &part, c->ready.tolerance)) {
      LITHE_TRY(lth_pieces_add(ctx, &c->cut, &part));
      continue;
    }
    for (int side = -1; side <= 1; side += 2)
      LITHE_TRY(lth_pieces_cut(ctx, &part, plane, side, c->ready.tolerance, &c->scratch, &c->cut));
  }
  LthPieces swap = c->parts;
  c->parts = c->cut;
  c->cut = swap;
  return LITHE_OK;
}

static LitheStatus select_face(LitheCtx *ctx, Collector *c, LitheIndex f) {
  LthFaceView face = lth_mesh_face(c->ready.mesh, f);
  lth_pieces_clear(&c->parts);
  LITHE_TRY(lth_pieces_add(ctx, &c->parts, &face));
  for (LitheIndex p = 0; p < c->ready.n_planes; p++)
    if (lth_plane_crosses(&c->ready.planes[p], &face, c->ready.tolerance))
      LITHE_TRY(divide(ctx, c, face.normal, &c->ready.planes[p]));
  // a face that is chosen as a whole stays whole
  LitheIndex n_chosen = 0;
  double centroid[3];
  for (LitheIndex i = 0; i < c->parts.n; i++) {
    LthFaceView part = lth_pieces_view(&c->parts, i, face.normal);
    lth_face_area_centroid(&part, centroid);
    n_chosen += lth_where_contains(&c->ready, centroid, f);
  }
  if (n_chosen == c->parts.n) return choose(ctx, c, f, &face);
  for (LitheIndex i = 0; n_chosen > 0 && i < c->parts.n; i++) {
    LthFaceView part = lth_pieces_view(&c->parts, i, face.normal);
    lth_face_area_centroid(&part, centroid);
    if (lth_where_contains(&c->ready, centroid, f)) LITHE_TRY(choose(ctx, c, f, &part));
  }
  return LITHE_OK;
}

/// Hand the chosen pieces over.
static LitheStatus make_patches(LitheCtx *ctx, Collector *c, LthPatches **patches) {
  LitheStatus status = LITHE_OK;
  LthPatches *p = NULL;
  LTH_NEW_OR(done, ctx, p, 1);
  LTH_NEW_OR(done, ctx, p->area, c->chosen.n);
  LTH_NEW_OR(done, ctx, p->centroid, 3 * (LitheCount)c->chosen.n);
  // offsets exist even where nothing was chosen
  LTH_RESERVE_OR(done, ctx, c->chosen.piece_loop_off, c->chosen.cap_pieces, 1);
  LTH_RESERVE_OR(done, ctx, c->chosen.loop_off, c->chosen.cap_loops, 1);
  p->n = c->chosen.n;
  p->n_points = c->chosen.n_points;
  p->face = c->chosen_face;
  p->loop_off_of = c->chosen.piece_loop_off;
  p->loop_off = c->chosen.loop_off;
  p->loop_point = c->chosen.loop_point;
  p->points = c->chosen.points;
  c->chosen = (LthPieces){0};
  c->chosen_face = NULL;
  for (LitheIndex i = 0; i < p->n; i++) {
    LthFaceView view = lth_patches_view(c->ready.mesh, p, i);
    p->area[i] = lth_face_area_centroid(&view, p->centroid + 3 * (LitheCount)i);
  }
  *patches = p;
  p = NULL;
done:
  lth_patches_destroy(ctx, &p);
  return status;
}

LitheStatus lth_select_boundary(LitheCtx *ctx, const LthMesh *mesh, const LthWhere *where,
                                LthPatches **patches) {
  LitheStatus status = LITHE_OK;
  Collector c = {0};
  *patches = NULL;
  LITHE_TRY_OR(done, lth_where_prepare(ctx, mesh, where, &c.ready));
  for (LitheIndex f = 0; f < mesh->n_faces; f++)
    if (mesh->face_cell[2 * f + 1] < 0 && mesh->face_tag[f] > LTH_TAG_CUT)
      LITHE_TRY_OR(done, select_face(ctx, &c, f));
  LITHE_TRY_OR(done, make_patches(ctx, &c, patches));
done:
  collector_free(ctx, &c);
  return status;
}

void lth_patches_cells(const LthMesh *mesh, const LthPatches *patches, uint8_t *chosen) {
  memset(chosen, 0, (size_t)mesh->n_cells);
  for (LitheIndex i = 0; i < patches->n; i++) chosen[mesh->face_cell[2 * patches->face[i]]] = 1;
}

LitheStatus lth_select_cells(LitheCtx *ctx, const LthMesh *mesh, const LthWhere *where,
                             uint8_t *chosen) {
  LitheStatus status = LITHE_OK;
  LthPatches *patches = NULL;
  LthWhereReady ready = {0};
  LITHE_TRY_OR(done, lth_select_boundary(ctx, mesh, where, &patches));
  LITHE_TRY_OR(done, lth_where_prepare(ctx, mesh, where, &ready));
  lth_patches_cells(mesh, patches, chosen);
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    if (lth_where_contains_cell(&ready, c)) chosen[c] = 1;
done:
  lth_where_ready_free(ctx, &ready);
  lth_patches_destroy(ctx, &patches);
  return status;
}

/// Points and weights of the triangle x0, a, b; returns their number.
static LitheIndex triangle_points(const LthSimplexRule *rule, const double *x0, const double *a,
                                  const double *b, const double *normal, double *points,
                                  double *weights) {
  double u[3], v[3], w[3];
  lth_v3_sub(a, x0, u);
  lth_v3_sub(b, x0, v);
  lth_v3_cross(u, v, w);
  double area = 0.5 * lth_v3_dot(w, normal);
  int n = lth_simplex_rule_points(rule);
  for (int g = 0; g < n; g++) {
    double bary[3];
    weights[g] = area * lth_simplex_rule_point(rule, g, bary);
    lth_v3_copy(x0, points + 3 * g);
    lth_v3_axpy(bary[1], u, points + 3 * g);
    lth_v3_axpy(bary[2], v, points + 3 * g);
  }
  return n;
}

LitheStatus lth_patch_quadrature(LitheCtx *ctx, const LthFaceView *piece, int degree, LitheIndex *n,
                                 double **points, double **weights) {
  LitheStatus status = LITHE_OK;
  LthSimplexRule rule;
  *n = 0;
  *points = *weights = NULL;
  LITHE_TRY(lth_simplex_rule(ctx, 2, degree, &rule));
  LitheCount size = piece->loop_off[piece->n_loops] - piece->loop_off[0];
  size *= lth_simplex_rule_points(&rule);
  LTH_NEW_OR(done, ctx, *points, 3 * size);
  LTH_NEW_OR(done, ctx, *weights, size);
  LitheIndex t[3];
  for (LthFan fan = lth_fan(piece); lth_fan_next(&fan, t);)
    *n +=
        triangle_points(&rule, piece->points + 3 * (LitheCount)t[0],
                        piece->points + 3 * (LitheCount)t[1], piece->points + 3 * (LitheCount)t[2],
                        piece->normal, *points + 3 * (LitheCount)*n, *weights + *n);
done:
  if (status != LITHE_OK) {
    lth_free(ctx, *points);
    lth_free(ctx, *weights);
    *points = *weights = NULL;
  }
  return status;
}

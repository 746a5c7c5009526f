/// Bodies in space as they are in the end, drawn with a buffer of depths.
#include "study/view.h"

#include "base/tensor.h"
#include "embed/embedding.h"
#include "scene/body.h"
#include "scene/world.h"
#include "study/draw.h"

#include <string.h>

#define WIDTH 330 ///< of a view [px]
#define HEIGHT_MAX 300
#define GAP 14       ///< between views [px]
#define LINE 0.75    ///< half the width of a side's line [px]
#define MARGIN 0.03  ///< around all bodies, of their size
#define DARKEST 0.42 ///< of faces seen from the side

static LitheStatus fail_memory(const LthView *view) {
  LITHE_FAIL(view->run->ctx, LITHE_NO_MEMORY, "out of memory in a study");
}

/// Twice the room; what was there is left to the arena.
static LitheStatus reserve(LthView *view) {
  if (view->n < view->cap) return LITHE_OK;
  int cap = view->cap ? 2 * view->cap : 256;
  double *corner = lth_arena_take(&view->run->arena, sizeof *corner * 9 * (size_t)cap);
  uint8_t *edges = lth_arena_take(&view->run->arena, (size_t)cap);
  if (!corner || !edges) return fail_memory(view);
  if (view->n > 0) {
    memcpy(corner, view->corner, sizeof *corner * 9 * (size_t)view->n);
    memcpy(edges, view->edges, (size_t)view->n);
  }
  view->corner = corner, view->edges = edges, view->cap = cap;
  return LITHE_OK;
}

static LitheStatus add(LthView *view, const double *a, const double *b, const double *c,
                       int edges) {
  LITHE_TRY(reserve(view));
  double *to = view->corner + 9 * (size_t)view->n;
  lth_v3_copy(a, to);
  lth_v3_copy(b, to + 3);
  lth_v3_copy(c, to + 6);
  view->edges[view->n++] = (uint8_t)edges;
  return LITHE_OK;
}

static void move(const LthView *view, const LthBody *body, const double *coef, LitheIndex cell,
                 const double *rest, double now[3]) {
  double u[3];
  lth_disc_sample(body->disc, cell, coef, rest, u);
  lth_v3_copy(rest, now);
  lth_v3_axpy(view->times > 0 ? view->times : 1, u, now);
}

/// A triangle of a face in four, so that curved faces are seen as such. `edges` as of a triangle.
static LitheStatus add_moved(LthView *view, const LthBody *body, const double *coef,
                             LitheIndex cell, const double *const rest[3], int edges) {
  double now[6][3];
  for (int k = 0; k < 3; k++) {
    double middle[3] = {0};
    lth_v3_axpy(0.5, rest[k], middle);
    lth_v3_axpy(0.5, rest[(k + 1) % 3], middle);
    move(view, body, coef, cell, rest[k], now[k]);
    move(view, body, coef, cell, middle, now[3 + k]);
  }
  for (int k = 0; k < 3; k++) // corner k with the middles behind and before it
    LITHE_TRY(add(view, now[k], now[3 + k], now[3 + (k + 2) % 3],
                  (edges >> k & 1) | (edges >> (k + 2) % 3 & 1) << 2));
  return add(view, now[3], now[4], now[5], 0);
}

/// A face as one of its cells has it. Faces are convex or nearly so: a fan about the first corner.
static LitheStatus add_face(LthView *view, const LthBody *body, const double *coef, LitheIndex f,
                            LitheIndex cell) {
  LthFaceView face = lth_mesh_face(body->mesh, f);
  const LitheIndex *loop = face.loop_point + face.loop_off[0];
  LitheIndex n = face.loop_off[1] - face.loop_off[0];
  for (LitheIndex k = 1; k + 1 < n; k++) {
    const double *const rest[3] = {face.points + 3 * (size_t)loop[0],
                                   face.points + 3 * (size_t)loop[k],
                                   face.points + 3 * (size_t)loop[k + 1]};
    int edges = 2 | (k == 1 ? 1 : 0) | (k + 2 == n ? 4 : 0);
    LITHE_TRY(add_moved(view, body, coef, cell, rest, edges));
  }
  return LITHE_OK;
}

/// Inner faces are seen where elements part: each element has its own.
static LitheStatus add_elements(LthView *view, const LthBody *body) {
  const double *coef = lth_body_displacement(body);
  for (LitheIndex f = 0; f < body->mesh->n_faces; f++)
    for (int s = 0; s < 2; s++) {
      LitheIndex cell = body->mesh->face_cell[2 * f + s];
      if (cell >= 0) LITHE_TRY(add_face(view, body, coef, f, cell));
    }
  return LITHE_OK;
}

static LitheStatus add_surface(LthView *view, LitheCtx *ctx, const LthBody *body) {
  LitheStatus status = LITHE_OK;
  const LthSoup *soup = body->soup;
  double *now = NULL;
  if (!body->embedding) return LITHE_OK;
  LTH_NEW(ctx, now, 3 * (LitheCount)body->embedding->n_points);
  lth_embedding_apply(body->embedding, lth_threads(ctx), lth_body_displacement(body), now);
  const double *rest = body->embedding->rest, times = view->times > 0 ? view->times : 1;
  for (LitheCount k = 0; k < 3 * (LitheCount)body->embedding->n_points; k++)
    now[k] = rest[k] + times * (now[k] - rest[k]);
  for (LitheIndex p = 0; p < soup->n_polys && status == LITHE_OK; p++)
    for (LitheIndex k = soup->poly_off[p] + 1; k + 1 < soup->poly_off[p + 1]; k++) {
      const LitheIndex *point = soup->poly_point;
      status = add(view, now + 3 * (size_t)point[soup->poly_off[p]], now + 3 * (size_t)point[k],
                   now + 3 * (size_t)point[k + 1], 0);
      if (status != LITHE_OK) break;
    }
  lth_free(ctx, now);
  return status;
}

LitheStatus lth_view_look(void *user, LitheCtx *ctx, const LthWorld *world, LitheIndex frame) {
  LthView *view = user;
  (void)frame;
  view->n = 0;
  return view->of_surface ? add_surface(view, ctx, world->bodies[0])
                          : add_elements(view, world->bodies[0]);
}

LitheStatus lth_view_add_grid(LthView *view, int m, int n, const double *places, int step) {
  for (int j = 0; j + 1 < n; j++)
    for (int i = 0; i + 1 < m; i++) {
      const double *a = places + 3 * (size_t)(i + m * j), *b = a + 3, *d = a + 3 * (size_t)m;
      int low = j % step == 0, left = i % step == 0;
      int high = (j + 1) % step == 0, right = (i + 1) % step == 0;
      LITHE_TRY(add(view, a, b, b + 3 * (size_t)m, low | right << 1));
      LITHE_TRY(add(view, a, b + 3 * (size_t)m, d, high << 1 | left << 2));
    }
  return LITHE_OK;
}

// --- pixels ---

/// Axes of the page: rightwards, upwards, towards the eye; and what of it is seen.
typedef struct Page {
  double axis[3][3], low[2], high[2]; ///< [m]
  int w, h;
  double *depth;
  uint8_t *rgb;
} Page;

static void set_axes(Page *page, const double eye[3], const double up[3]) {
  lth_v3_copy(eye, page->axis[2]);
  lth_v3_normalize(page->axis[2]);
  lth_v3_cross(up, page->axis[2], page->axis[0]);
  lth_v3_normalize(page->axis[0]);
  lth_v3_cross(page->axis[2], page->axis[0], page->axis[1]);
}

static void widen(Page *page, const LthView *view) {
  for (int i = 0; i < 3 * view->n; i++)
    for (int a = 0; a < 2; a++) {
      double at = lth_v3_dot(page->axis[a], view->corner + 3 * (size_t)i);
      page->low[a] = fmin(page->low[a], at);
      page->high[a] = fmax(page->high[a], at);
    }
}

/// Place of the page in pixels, row 0 on top, and depth.
static void project(const Page *page, const double x[3], double at[3]) {
  double scale = page->w / (page->high[0] - page->low[0]);
  at[0] = (lth_v3_dot(page->axis[0], x) - page->low[0]) * scale;
  at[1] = (page->high[1] - lth_v3_dot(page->axis[1], x)) * scale;
  at[2] = lth_v3_dot(page->axis[2], x) * scale;
}

static void put_pixel(const Page *page, int i, int j, double depth, double light, bool is_line) {
  size_t k = (size_t)i + (size_t)page->w * (size_t)j;
  if (depth <= page->depth[k]) return;
  page->depth[k] = depth;
  static const double colour[3] = {170, 200, 235};
  for (int c = 0; c < 3; c++)
    page->rgb[3 * k + (size_t)c] = (uint8_t)(is_line ? 20 : light * colour[c]);
}

static void put_triangle(const Page *page, const double *corner, int edges) {
  double p[3][3], u[3], v[3], normal[3];
  for (int k = 0; k < 3; k++) project(page, corner + 3 * k, p[k]);
  lth_v3_sub(p[1], p[0], u);
  lth_v3_sub(p[2], p[0], v);
  lth_v3_cross(u, v, normal);
  double area = normal[2], length = lth_v3_norm(normal);
  if (!(length > 0) || fabs(area) < 1e-9) return;
  double light = DARKEST + (1 - DARKEST) * fabs(area) / length;
  int i0 = (int)fmax(0, floor(fmin(p[0][0], fmin(p[1][0], p[2][0])) - 0.5));
  int j0 = (int)fmax(0, floor(fmin(p[0][1], fmin(p[1][1], p[2][1])) - 0.5));
  int i1 = (int)fmin(page->w - 1, ceil(fmax(p[0][0], fmax(p[1][0], p[2][0]))));
  int j1 = (int)fmin(page->h - 1, ceil(fmax(p[0][1], fmax(p[1][1], p[2][1]))));
  for (int j = j0; j <= j1; j++)
    for (int i = i0; i <= i1; i++) {
      double depth = 0, x = i + 0.5, y = j + 0.5;
      bool inside = true, is_line = false;
      for (int k = 0; k < 3; k++) { // share of corner k, and distance from the side across it
        const double *a = p[(k + 1) % 3], *b = p[(k + 2) % 3];
        double share = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
        double away = share * fabs(area) / hypot(b[0] - a[0], b[1] - a[1]);
        inside = inside && share >= -1e-9;
        is_line = is_line || (edges >> (k + 1) % 3 & 1 && away < LINE);
        depth += share * p[k][2];
      }
      // lines of faces beside each other are at one depth: none is hidden by its neighbour
      if (inside) put_pixel(page, i, j, depth + (is_line ? 0.05 : 0), light, is_line);
    }
}

static void paint(const Page *page, const LthView *view) {
  for (int k = 0; k < page->w * page->h; k++) page->depth[k] = -INFINITY;
  memset(page->rgb, 255, 3 * (size_t)page->w * (size_t)page->h);
  for (int k = 0; k < view->n; k++)
    put_triangle(page, view->corner + 9 * (size_t)k, view->edges[k]);
}

static LitheStatus draw(LthStudyRun *run, Page *page, int n, const LthView *views, const char *name,
                        const char *caption) {
  LthDrawing d = {.ctx = run->ctx};
  const double box[4] = {0, 0, page->w, page->h};
  lth_draw_begin(&d, n * (page->w + GAP) + GAP, page->h + 40);
  for (int k = 0; k < n; k++) {
    double left = GAP + k * (page->w + GAP);
    lth_draw_words(&d, left, 18, views[k].label);
    lth_draw_panel(&d, box, left, 28, page->w);
    paint(page, views + k);
    lth_draw_pixels(&d, page->w, page->h, page->rgb);
  }
  const char *svg = lth_draw_end(&d, &run->arena);
  if (svg) lth_study_picture(&run->report, name, caption, svg);
  return svg ? LITHE_OK : fail_memory(views);
}

LitheStatus lth_views_draw(LthStudyRun *run, int n, const LthView *views, const double eye[3],
                           const double up[3], const char *name, const char *caption) {
  LitheStatus status = LITHE_OK;
  Page page = {.low = {INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY}, .w = WIDTH};
  set_axes(&page, eye, up);
  for (int k = 0; k < n; k++) widen(&page, views + k);
  double size = fmax(page.high[0] - page.low[0], page.high[1] - page.low[1]);
  if (!(size > 0) || !isfinite(size)) return LITHE_OK; // nothing was kept
  for (int a = 0; a < 2; a++) page.low[a] -= MARGIN * size, page.high[a] += MARGIN * size;
  double shape = (page.high[1] - page.low[1]) / (page.high[0] - page.low[0]);
  if (page.w * shape > HEIGHT_MAX) page.w = (int)(HEIGHT_MAX / shape);
  page.h = (int)ceil(page.w * shape);
  LTH_NEW_OR(done, run->ctx, page.depth, page.w * page.h);
  LTH_NEW_OR(done, run->ctx, page.rgb, 3 * page.w * page.h);
  status = draw(run, &page, n, views, name, caption);
done:
  lth_free(run->ctx, page.depth);
  lth_free(run->ctx, page.rgb);
  return status;
}

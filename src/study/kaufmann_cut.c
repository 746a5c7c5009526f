/// Figures 7 and 10 and section 9.6: one element that is sharpened, a bunny that is sliced, and what merging slivers does.
#include "study/kaufmann_studies.h"

#include "base/tensor.h"
#include "disc/dg/dg_operator.h"
#include "io/surface_file.h"
#include "mesh/topology.h"
#include "study/draw.h"

#include <string.h>
#include <unistd.h>

/// Largest eigenvalue of the stiffness of a free body over the smallest that is not that of a rigid motion.
static LitheStatus condition_of(LitheCtx *ctx, const LthMesh *mesh, double *condition) {
  LitheStatus status = LITHE_OK;
  LthDgSpace *space = NULL;
  LthDgOperator *op = NULL;
  LthBlockMatrix *K = NULL;
  double *constants = NULL, *f0 = NULL;
  LTH_NEW_OR(done, ctx, constants, 2 * (LitheCount)mesh->n_cells);
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    constants[c] = 1, constants[mesh->n_cells + c] = 0.3;
  LITHE_TRY_OR(done, lth_dg_space_create(ctx, mesh, 1, NULL, &space));
  LthDgOperatorDef def = {.space = space,
                          .young = constants,
                          .poisson = constants + mesh->n_cells,
                          .penalty = LTH_PENALTY_AUTO,
                          .eta = 1};
  LITHE_TRY_OR(done, lth_dg_operator_create(ctx, &def, &op));
  LITHE_TRY_OR(done, lth_dg_matrix_create(ctx, op, &K));
  LTH_NEW_OR(done, ctx, f0, K->n);
  lth_dg_assemble(op, 0, K, f0);
  LITHE_TRY_OR(done, lth_block_matrix_condition_beyond(ctx, K, 6, condition));
done:
  lth_free(ctx, constants);
  lth_free(ctx, f0);
  lth_block_matrix_destroy(ctx, &K);
  lth_dg_operator_destroy(ctx, &op);
  lth_dg_space_destroy(ctx, &space);
  return status;
}

// --- Figure 10, left ---

#define LENGTH 6.0 ///< of the pencil, which is 1 wide [m]
#define SLOPE 0.25 ///< half width of the tip over the distance from its point
#define PLANES 16
#define SAMPLES 40000 ///< of the exact volume's integral along the axis

/// Cut plane k goes through the point of the pencil; in this order four planes make a pyramid, eight an octagonal one.
static double angle_of(int k) {
  static const int order[PLANES] = {0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};
  return 2 * M_PI * order[k] / PLANES;
}

/// Area of the square of the pencil's section that is within w of the axis in the directions of the first n planes.
static double section(int n, double w) {
  double poly[2][2 * (PLANES + 5)] = {{-.5, -.5, .5, -.5, .5, .5, -.5, .5}}, area = 0;
  int count = 4, now = 0;
  for (int k = 0; k < n; k++) {
    const double c = cos(angle_of(k)), s = sin(angle_of(k)), *p = poly[now];
    double *q = poly[1 - now];
    int m = 0;
    for (int i = 0; i < count; i++) {
      const double *a = p + 2 * i, *b = p + 2 * ((i + 1) % count);
      double ha = c * a[0] + s * a[1] - w, hb = c * b[0] + s * b[1] - w;
      if (ha <= 0) q[2 * m] = a[0], q[2 * m + 1] = a[1], m++;
      if ((ha < 0) == (hb < 0) || ha == 0 || hb == 0) continue;
      double t = ha / (ha - hb);
      q[2 * m] = a[0] + t * (b[0] - a[0]), q[2 * m + 1] = a[1] + t * (b[1] - a[1]), m++;
    }
    count = m, now = 1 - now;
  }
  for (int i = 0; i < count; i++) {
    const double *a = poly[now] + 2 * i, *b = poly[now] + 2 * ((i + 1) % count);
    area += (a[0] * b[1] - a[1] * b[0]) / 2;
  }
  return area;
}

/// Simpson's rule: the section is quadratic but at some heights.
static double exact_volume(int n) {
  double sum = 0;
  for (int i = 0; i <= SAMPLES; i++) {
    double z = LENGTH * i / SAMPLES;
    sum += (i == 0 || i == SAMPLES ? 1 : i % 2 ? 4 : 2) * section(n, (LENGTH - z) * SLOPE);
  }
  return sum * LENGTH / SAMPLES / 3;
}

/// The faces that look towards the reader.
static void draw_pencil(LthDrawing *drawing, const LthMesh *m) {
  const double view[3] = {0.36, 0.48, 0.8}, across[3] = {0, 0, 1}, up[3] = {-0.8, 0.6, 0};
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    LthFaceView face = lth_mesh_face(m, f);
    double xy[64];
    int n = face.loop_off[1] - face.loop_off[0];
    double facing = lth_v3_dot(m->face_normal + 3 * (size_t)f, (double[]){view[0], view[1], 0.1});
    if (facing <= 0 || n > 32) continue;
    for (int i = 0; i < n; i++) {
      const double *x = face.points + 3 * (size_t)face.loop_point[face.loop_off[0] + i];
      xy[2 * i] = lth_v3_dot(across, x), xy[2 * i + 1] = lth_v3_dot(up, x);
    }
    char colour[LTH_COLOUR_MAX];
    lth_draw_area_begin(drawing, lth_colour(0.35 + 0.6 * facing / 0.62, colour));
    lth_draw_area_add(drawing, n, xy);
    lth_draw_area_end(drawing);
    for (int i = 0; i < n; i++)
      lth_draw_line(drawing, xy + (size_t)2 * i, xy + (size_t)2 * ((i + 1) % n), 0.7, "#333");
  }
}

/// Sharpen by plane k; the chip is left to itself. *cell is the pencil.
static LitheStatus sharpen(LitheCtx *ctx, LthTopology *t, int k, LitheIndex *cell) {
  const double norm = sqrt(1 + SLOPE * SLOPE);
  LthPlane plane = {.point = {0, 0, LENGTH},
                    .normal = {cos(angle_of(k)) / norm, sin(angle_of(k)) / norm, SLOPE / norm}};
  LthSplit split;
  LITHE_TRY(lth_topology_split(ctx, t, *cell, &plane, LTH_TAG_CUT - k, &split));
  if (split.n > 0) *cell = t->log.births[split.first].cell;
  return lth_topology_forget(ctx, t);
}

typedef struct Pencil {
  LthTopology *topology;
  LthMesh *whole, *mesh;
  LthDrawing drawing;
} Pencil;

static LitheStatus sharpen_all(LthStudyRun *run, Pencil *p, LthTable *t) {
  LitheCtx *ctx = run->ctx;
  LthGrid grid = {.min = {-.5, -.5, 0}, .max = {.5, .5, LENGTH}, .cells = {1, 1, 1}};
  LitheIndex cell = 0;
  LITHE_TRY(lth_mesh_hexahedra(ctx, &grid, &p->whole));
  LITHE_TRY(lth_topology_create(ctx, p->whole, &p->topology));
  for (int k = 0; k <= PLANES; k++) {
    double condition = NAN;
    if (k > 0) LITHE_TRY(sharpen(ctx, p->topology, k - 1, &cell));
    lth_mesh_destroy(ctx, &p->mesh);
    LITHE_TRY(lth_topology_mesh(ctx, p->topology, 1, &cell, &p->mesh, NULL, NULL));
    LITHE_TRY(condition_of(ctx, p->mesh, &condition));
    LthMeshQuality quality;
    LITHE_TRY(lth_mesh_quality(ctx, p->mesh, &quality));
    const double volume = p->mesh->cell_volume[0], exact = exact_volume(k);
    lth_table_row(t, NULL,
                  (double[]){k, p->mesh->n_faces, volume, fabs(volume / exact - 1), quality.max_gap,
                             condition});
    if (k != 0 && k != 4 && k != 8 && k != 16) continue;
    const double box[4] = {-0.2, -0.8, LENGTH + 0.2, 0.8};
    lth_draw_panel(&p->drawing, box, 20,
                   20 + 110 * (k == 0   ? 0
                               : k == 4 ? 1
                               : k == 8 ? 2
                                        : 3),
                   420);
    draw_pencil(&p->drawing, p->mesh);
  }
  return lth_topology_check(ctx, p->topology, 0, NULL);
}

LitheStatus lth_study_pencil(LthStudyRun *run) {
  enum { CUTS, FACES, VOLUME, MISS, GAP, CONDITION };
  LthStudyReport *r = &run->report;
  Pencil p = {.drawing = {.ctx = run->ctx}};
  double miss = 0, gap = 0;
  LthTable *t =
      lth_study_table(r, "pencil", "One element sharpened by plane cuts (Fig. 10, left)", NULL);
  lth_table_column(t, "cuts", "", 0);
  lth_table_column(t, "faces", "", 0);
  lth_table_column(t, "volume", "m^3", 8);
  lth_table_column(t, "off the exact volume, relative", "", 2);
  lth_table_column(t, "gap over area", "", 2);
  lth_table_column(t, "condition number, linear", "", 4);
  lth_draw_begin(&p.drawing, 460, 460);
  LitheStatus status = sharpen_all(run, &p, t);
  const char *svg = lth_draw_end(&p.drawing, &run->arena);
  lth_mesh_destroy(run->ctx, &p.mesh);
  lth_mesh_destroy(run->ctx, &p.whole);
  lth_topology_destroy(run->ctx, &p.topology);
  LITHE_TRY(status);
  if (svg) lth_study_picture(r, "pencil-drawn", "The element after 0, 4, 8 and 16 cuts", svg);
  for (int i = 0; i < t->n_rows; i++) {
    miss = fmax(miss, lth_table_at(t, i, MISS));
    gap = fmax(gap, lth_table_at(t, i, GAP));
  }
  lth_study_at_most(
      r, "volume: largest distance from the exact one, relative", miss, 1e-12,
      "that of the integral of the section over the height, by Simpson's rule with 40000 parts");
  lth_study_at_most(r, "gap of the element over its area", gap, 1e-14,
                    "it is closed but for rounding");
  lth_study_at_most(r, "condition number after 16 cuts over that of the whole bar",
                    lth_table_at(t, PLANES, CONDITION) / lth_table_at(t, 0, CONDITION), 3,
                    "the element stays one: its functions see a somewhat shorter body");
  lth_study_at_least(r, "faces of the element in the end", lth_table_at(t, PLANES, FACES), 20,
                     "sixteen of the tip, four sides and the end: an element of any shape");
  return LITHE_OK;
}

// --- Figure 7: slices ---

static const char bunny_file[] = "/usr/share/glmark2/models/bunny.obj";

typedef struct Slices {
  LthSoup *soup;
  LthSurface *surface;
  LthMesh *mesh;
  LthTopology *topology;
  LitheIndex *cells;
} Slices;

/// Area of the faces of a cut, summed with the side that they bound: nothing is left where both sides fit.
static void fit(const LthMesh *m, int n_cuts, const double (*normal)[3], double *misfit) {
  *misfit = 0;
  for (int k = 0; k < n_cuts; k++) {
    double sum = 0, area = 0;
    for (LitheIndex f = 0; f < m->n_faces; f++) {
      if (m->face_tag[f] != LTH_TAG_CUT - k) continue;
      area += m->face_area[f];
      sum += m->face_area[f] * (lth_v3_dot(m->face_normal + 3 * (size_t)f, normal[k]) > 0 ? 1 : -1);
    }
    if (area > 0) *misfit = fmax(*misfit, fabs(sum) / area);
  }
}

#define SLICES_MAX 32
#define SLIVER 1e-5 ///< of a cell: what the grid cuts off smaller than that is merged

static LitheStatus count_sliced(LitheCtx *ctx, const LthSurface *surface, const LthGrid *grid,
                                double sliver, LitheIndex *count) {
  LthMesh *mesh = NULL;
  LITHE_TRY(lth_mesh_slice(ctx, surface, grid, sliver, &mesh));
  *count = mesh->n_cells;
  lth_mesh_destroy(ctx, &mesh);
  return LITHE_OK;
}

/// The bunny as one element, cut by the planes of a grid of `cells` along its longest side.
static LitheStatus slice(LthStudyRun *run, int cells, Slices *s, LthTable *t) {
  LitheCtx *ctx = run->ctx;
  double normal[SLICES_MAX][3], min[3], max[3], longest = 0, misfit, start = lth_now();
  int n_cuts = 0;
  lth_surface_bounds(s->surface, min, max);
  LthGrid grid = {.cells = {1, 1, 1}};
  for (int a = 0; a < 3; a++) {
    grid.min[a] = min[a], grid.max[a] = max[a];
    longest = fmax(longest, max[a] - min[a]);
  }
  LthGrid sliced = grid;
  LITHE_TRY(lth_mesh_slice(ctx, s->surface, &grid, 0, &s->mesh));
  LITHE_TRY(lth_topology_create(ctx, s->mesh, &s->topology));
  const double volume = s->topology->volume;
  for (int a = 0; a < 3; a++) {
    const int n = (int)lround((max[a] - min[a]) / longest * cells); // next to cubes
    sliced.cells[a] = n;
    for (int i = 1; i < n && n_cuts < SLICES_MAX; i++, n_cuts++) {
      LthPlane plane = {.point = {min[0], min[1], min[2]}};
      LthCut cut;
      LitheIndex count = 0;
      memset(normal[n_cuts], 0, sizeof normal[0]);
      normal[n_cuts][a] = plane.normal[a] = 1;
      plane.point[a] += (max[a] - min[a]) * i / n;
      lth_free(ctx, s->cells);
      LTH_NEW(ctx, s->cells, s->topology->n_cells);
      for (LitheIndex c = 0; c < s->topology->n_cells; c++)
        if (s->topology->cells[c].is_live) s->cells[count++] = c;
      LITHE_TRY(lth_topology_cut(ctx, s->topology, count, s->cells, 1, &plane, LTH_TAG_CUT - n_cuts,
                                 &cut));
      LITHE_TRY(lth_topology_forget(ctx, s->topology));
    }
  }
  LthMeshQuality quality;
  double seconds = lth_now() - start;
  LITHE_TRY(lth_topology_check(ctx, s->topology, 0, NULL));
  lth_mesh_destroy(ctx, &s->mesh);
  LITHE_TRY(lth_topology_mesh(ctx, s->topology, 0, NULL, &s->mesh, NULL, NULL));
  LITHE_TRY(lth_mesh_quality(ctx, s->mesh, &quality));
  fit(s->mesh, n_cuts, (const double(*)[3])normal, &misfit);
  LitheIndex count[2];
  for (int k = 0; k < 2; k++)
    LITHE_TRY(count_sliced(ctx, s->surface, &sliced, k * SLIVER, &count[k]));
  lth_table_row(t, NULL,
                (double[]){cells, n_cuts, s->mesh->n_cells, count[0], count[1],
                           fabs(quality.volume / volume - 1), misfit, quality.max_gap, seconds});
  return LITHE_OK;
}

LitheStatus lth_study_slices(LthStudyRun *run) {
  enum { CELLS, CUTS, ELEMENTS, SLICED, MERGED, VOLUME, MISFIT, GAP };
  static const int cells[] = {3, 4, 5, 6};
  LthStudyReport *r = &run->report;
  if (access(bunny_file, R_OK) != 0) {
    lth_study_say(r, "Left out: %s is not there (Debian: glmark2-data). Nothing was run.",
                  bunny_file);
    return LITHE_OK;
  }
  LthTable *t = lth_study_table(
      r, "slices",
      "The bunny as one element of 70 000 faces, parted by the planes of a grid (Fig. 7)", NULL);
  lth_table_column(t, "cells along the longest side", "", 0);
  lth_table_column(t, "cuts", "", 0);
  lth_table_column(t, "elements", "", 0);
  lth_table_column(t, "sliced by the grid at once", "", 0);
  lth_table_column(t, "and slivers below 1e-5 of a cell merged", "", 0);
  lth_table_column(t, "volume lost, relative", "", 2);
  lth_table_column(t, "misfit of the two sides' areas", "", 2);
  lth_table_column(t, "largest gap over area", "", 2);
  lth_table_column(t, "time", "s", 2);
  double volume = 0, misfit = 0, gap = 0, differ = 0, nearest = INFINITY;
  for (int i = 0; i < 4; i++) {
    Slices s = {0};
    if (run->quick && cells[i] != 4) continue;
    LitheStatus status = lth_soup_read(run->ctx, bunny_file, &s.soup);
    if (status == LITHE_OK)
      status = lth_surface_from_soup(run->ctx, s.soup, "bunny", NULL, &s.surface);
    if (status == LITHE_OK) status = slice(run, cells[i], &s, t);
    lth_free(run->ctx, s.cells);
    lth_topology_destroy(run->ctx, &s.topology);
    lth_mesh_destroy(run->ctx, &s.mesh);
    lth_surface_destroy(run->ctx, &s.surface);
    lth_soup_destroy(run->ctx, &s.soup);
    LITHE_TRY(status);
    const int row = t->n_rows - 1;
    volume = fmax(volume, lth_table_at(t, row, VOLUME));
    misfit = fmax(misfit, lth_table_at(t, row, MISFIT));
    gap = fmax(gap, lth_table_at(t, row, GAP));
    differ = fmax(differ, fabs(lth_table_at(t, row, ELEMENTS) - lth_table_at(t, row, SLICED)));
    nearest = fmin(nearest, fabs(lth_table_at(t, row, MERGED) - 41));
  }
  lth_study_at_most(r, "volume lost or gained, relative", volume, 1e-12,
                    "the pieces fill the bunny");
  lth_study_at_most(r, "areas of the two sides of a cut: difference over sum", misfit, 1e-12,
                    "halves fit");
  lth_study_at_most(r, "gap of any element over its area", gap, 1e-12, "each is closed");
  lth_study_at_most(r, "elements by cuts less those by slicing", differ, 0,
                    "both are pieces of the bunny in cells of the grid");
  lth_study_at_most(
      r, "distance of the nearest count from the figure's 41 elements", nearest, 0,
      "of the grids whose cells are next to cubes, that of 4 x 4 x 3 leaves 42 pieces, "
      "one of them 2e-6 of a cell: the paper merges such slivers");
  return LITHE_OK;
}

// --- section 9.6 ---

static LitheStatus cut_off(LthStudyRun *run, double thin, Slices *s, LthTable *t) {
  LitheCtx *ctx = run->ctx;
  LthGrid grid = {.max = {1, 1, 1}, .cells = {3, 3, 3}};
  LthPlane plane = {.point = {0, 0, (1 + thin) / 3}, .normal = {0, 0, 1}};
  LthCut cut;
  LitheIndex n_merged;
  double condition[2] = {NAN, NAN};
  LITHE_TRY(lth_mesh_hexahedra(ctx, &grid, &s->mesh));
  LITHE_TRY(lth_topology_create(ctx, s->mesh, &s->topology));
  LTH_NEW(ctx, s->cells, 27);
  for (LitheIndex c = 0; c < 27; c++) s->cells[c] = c;
  LITHE_TRY(lth_topology_cut(ctx, s->topology, 27, s->cells, 1, &plane, -1, &cut));
  for (int k = 0; k < 2; k++) {
    lth_mesh_destroy(ctx, &s->mesh);
    LITHE_TRY(lth_topology_mesh(ctx, s->topology, 0, NULL, &s->mesh, NULL, NULL));
    LITHE_TRY(condition_of(ctx, s->mesh, &condition[k]));
    if (k == 0)
      LITHE_TRY(lth_topology_merge_slivers(ctx, s->topology, 0, NULL, 0.2 / 27, &n_merged));
  }
  lth_table_row(t, NULL, (double[]){thin, condition[0], condition[1], s->mesh->n_cells});
  return LITHE_OK;
}

LitheStatus lth_study_slivers(LthStudyRun *run) {
  static const double thin[] = {0.1, 1e-2, 1e-3, 1e-4};
  LthStudyReport *r = &run->report;
  LthTable *t = lth_study_table(
      r, "slivers", "A layer of nine elements cut off a cube of 27, before and after merging",
      NULL);
  lth_table_column(t, "thickness of the layer, in elements", "", 2);
  lth_table_column(t, "condition number with slivers", "", 4);
  lth_table_column(t, "after merging", "", 4);
  lth_table_column(t, "elements after merging", "", 0);
  double after = 0, elements = 0;
  for (int i = 0; i < 4; i++) {
    Slices s = {0};
    LitheStatus status = cut_off(run, thin[i], &s, t);
    lth_free(run->ctx, s.cells);
    lth_topology_destroy(run->ctx, &s.topology);
    lth_mesh_destroy(run->ctx, &s.mesh);
    LITHE_TRY(status);
    after = fmax(after, lth_table_at(t, i, 2) / lth_table_at(t, 0, 2));
    elements = fmax(elements, lth_table_at(t, i, 3));
  }
  LthPlot *plot = lth_study_plot(r, "plot-slivers", "Condition number and slivers (section 9.6)",
                                 "thickness of the layer [elements]", "condition number [-]");
  plot->log_x = plot->log_y = true;
  lth_plot_series(plot, "with slivers", t, 0, 1);
  lth_plot_series(plot, "after merging", t, 0, 2);
  lth_study_at_least(r, "growth with slivers from 0.1 to 1e-4",
                     lth_table_at(t, 3, 1) / lth_table_at(t, 0, 1), 10,
                     "\"those elements can effectively be avoided by simply merging them\"");
  lth_study_at_most(r, "growth after merging", after, 1.01,
                    "the same 27 elements, whatever was cut off");
  lth_study_at_most(r, "elements after merging", elements, 27, "every sliver found its neighbour");
  return LITHE_OK;
}

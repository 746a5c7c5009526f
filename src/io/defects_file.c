/// Defects of a surface as a PLY that every viewer shows: coloured edges, and thin bars around them.
#include "base/tensor.h"
#include "geometry/moments.h"
#include "io/file.h"
#include "io/surface_file.h"
#include "io/text.h"

#include <stdio.h>

#define BAR_RADIUS 0.002 // of the surface's size
#define BAR_POINTS 8     // two ends of the segment, then three corners around each
#define BAR_FACES 8

static const struct {
  const char *name;
  int rgb[3];
} colors[LTH_DEFECT_KINDS] = {
    [LTH_DEFECT_OPEN_EDGE] = {"red", {230, 30, 30}},
    [LTH_DEFECT_NON_MANIFOLD] = {"orange", {255, 140, 0}},
    [LTH_DEFECT_CROSSING] = {"magenta", {220, 0, 220}},
    [LTH_DEFECT_UNORIENTABLE] = {"blue", {30, 60, 230}},
    [LTH_DEFECT_NESTING] = {"green", {0, 160, 60}},
};

static void write_header(FILE *out, const LthDefects *defects) {
  fprintf(out, "ply\nformat ascii 1.0\ncomment defects of a surface, written by Lithe %s\n",
          lithe_version());
  for (int k = 0; k < LTH_DEFECT_KINDS; k++)
    if (defects->count[k] > 0)
      fprintf(out, "comment %s: %s, %d found\n", colors[k].name, lth_defect_text((LthDefectKind)k),
              defects->count[k]);
  fprintf(out,
          "element vertex %lld\nproperty double x\nproperty double y\nproperty double z\n"
          "property uchar red\nproperty uchar green\nproperty uchar blue\n"
          "element face %lld\nproperty list uchar int vertex_indices\n"
          "element edge %d\nproperty int vertex1\nproperty int vertex2\n"
          "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
          (long long)BAR_POINTS * defects->n, (long long)BAR_FACES * defects->n, defects->n);
}

static void write_point(FILE *out, const double x[3], const int rgb[3]) {
  fprintf(out, "%.10g %.10g %.10g %d %d %d\n", x[0], x[1], x[2], rgb[0], rgb[1], rgb[2]);
}

/// The ends of a segment and a three-sided bar around it that reaches a little beyond both.
static void write_bar_points(FILE *out, const double segment[6], double radius, const int rgb[3]) {
  double along[3], u[3], v[3];
  lth_v3_sub(segment + 3, segment, along);
  if (!(lth_v3_normalize(along) > 0)) along[0] = 1;
  lth_face_frame(along, u, v);
  write_point(out, segment, rgb);
  write_point(out, segment + 3, rgb);
  for (int end = 0; end < 2; end++)
    for (int i = 0; i < 3; i++) {
      double x[3], angle = 2 * M_PI * i / 3;
      for (int k = 0; k < 3; k++)
        x[k] = segment[3 * end + k] +
               radius * ((end ? 1 : -1) * along[k] + cos(angle) * u[k] + sin(angle) * v[k]);
      write_point(out, x, rgb);
    }
}

static void write_bar_faces(FILE *out, LitheIndex first) {
  for (LitheIndex i = 0; i < 3; i++) {
    LitheIndex j = (i + 1) % 3;
    fprintf(out, "3 %d %d %d\n", first + 2 + i, first + 2 + j, first + 5 + j);
    fprintf(out, "3 %d %d %d\n", first + 2 + i, first + 5 + j, first + 5 + i);
  }
  fprintf(out, "3 %d %d %d\n3 %d %d %d\n", first + 2, first + 4, first + 3, first + 5, first + 6,
          first + 7);
}

static void write_defects(FILE *out, const LthDefects *defects) {
  write_header(out, defects);
  for (LitheIndex i = 0; i < defects->n; i++)
    write_bar_points(out, defects->segment + 6 * (size_t)i, BAR_RADIUS * defects->size,
                     colors[defects->kind[i]].rgb);
  for (LitheIndex i = 0; i < defects->n; i++) write_bar_faces(out, BAR_POINTS * i);
  for (LitheIndex i = 0; i < defects->n; i++) {
    const int *rgb = colors[defects->kind[i]].rgb;
    fprintf(out, "%d %d %d %d %d\n", BAR_POINTS * i, BAR_POINTS * i + 1, rgb[0], rgb[1], rgb[2]);
  }
}

LitheStatus lth_defects_write_ply(LitheCtx *ctx, const char *path, const LthDefects *defects) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  LthTextLocale before = lth_text_locale_begin();
  write_defects(writer.stream, defects);
  lth_text_locale_end(before);
  return lth_file_commit(ctx, &writer);
}

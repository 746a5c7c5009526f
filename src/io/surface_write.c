/// Writing polygon files: OBJ as text, PLY and STL in binary with float coordinates.
#include "base/tensor.h"
#include "io/bytes.h"
#include "io/file.h"
#include "io/surface_file.h"
#include "io/text.h"

#include <stdio.h>

static const double *point_of(const double *points, LitheIndex p) { return points + 3 * (size_t)p; }

// ------------------------------------------------------------------ OBJ

static void write_obj_corner(FILE *out, const LthSoup *soup, LitheIndex corner) {
  LitheIndex uv = soup->poly_uv ? soup->poly_uv[corner] : -1;
  fprintf(out, " %d", soup->poly_point[corner] + 1);
  if (uv >= 0) fprintf(out, "/%d", uv + 1);
}

static void write_obj(FILE *out, const LthSoup *soup, const double *points) {
  LitheIndex group = -1;
  fprintf(out, "# written by Lithe %s\n", lithe_version());
  for (LitheIndex p = 0; p < soup->n_points; p++) {
    const double *x = point_of(points, p);
    fprintf(out, "v %.10g %.10g %.10g\n", x[0], x[1], x[2]);
  }
  for (LitheIndex i = 0; i < soup->n_uvs; i++)
    fprintf(out, "vt %.10g %.10g\n", soup->uvs[2 * (size_t)i], soup->uvs[2 * (size_t)i + 1]);
  for (LitheIndex p = 0; p < soup->n_polys; p++) {
    if (soup->poly_group && soup->poly_group[p] != group) {
      group = soup->poly_group[p];
      fprintf(out, "g %s\n", soup->group_names[group]);
    }
    putc('f', out);
    for (LitheIndex i = soup->poly_off[p]; i < soup->poly_off[p + 1]; i++)
      write_obj_corner(out, soup, i);
    putc('\n', out);
  }
}

LitheStatus lth_soup_write_obj(LitheCtx *ctx, const char *path, const LthSoup *soup,
                               const double *points) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  LthTextLocale before = lth_text_locale_begin();
  write_obj(writer.stream, soup, points ? points : soup->points);
  lth_text_locale_end(before);
  return lth_file_commit(ctx, &writer);
}

// ------------------------------------------------------------------ PLY

static void put_u32(FILE *out, uint32_t value) {
  char bytes[4];
  lth_bytes_put_u32(value, bytes);
  fwrite(bytes, 1, sizeof bytes, out);
}

static void put_point(FILE *out, const double x[3]) {
  char bytes[12];
  for (int i = 0; i < 3; i++) lth_bytes_put_f32((float)x[i], bytes + 4 * i);
  fwrite(bytes, 1, sizeof bytes, out);
}

static LitheIndex most_corners(const LthSoup *soup) {
  LitheIndex most = 0;
  for (LitheIndex p = 0; p < soup->n_polys; p++) {
    LitheIndex n = soup->poly_off[p + 1] - soup->poly_off[p];
    if (n > most) most = n;
  }
  return most;
}

static void write_ply(FILE *out, const LthSoup *soup, const double *points) {
  // the usual one byte for a polygon's size unless one has more corners
  bool is_wide = most_corners(soup) > 255;
  fprintf(out,
          "ply\nformat binary_little_endian 1.0\ncomment written by Lithe %s\n"
          "element vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
          "element face %d\nproperty list %s int vertex_indices\nend_header\n",
          lithe_version(), soup->n_points, soup->n_polys, is_wide ? "uint" : "uchar");
  for (LitheIndex p = 0; p < soup->n_points; p++) put_point(out, point_of(points, p));
  for (LitheIndex p = 0; p < soup->n_polys; p++) {
    LitheIndex n = soup->poly_off[p + 1] - soup->poly_off[p];
    if (is_wide)
      put_u32(out, (uint32_t)n);
    else
      putc(n, out);
    for (LitheIndex i = soup->poly_off[p]; i < soup->poly_off[p + 1]; i++)
      put_u32(out, (uint32_t)soup->poly_point[i]);
  }
}

LitheStatus lth_soup_write_ply(LitheCtx *ctx, const char *path, const LthSoup *soup,
                               const double *points) {
  LthFileWriter writer;
  LITHE_TRY(lth_file_open(ctx, path, &writer));
  write_ply(writer.stream, soup, points ? points : soup->points);
  return lth_file_commit(ctx, &writer);
}

// ------------------------------------------------------------------ STL

static void put_triangle(FILE *out, const double *points, const LitheIndex t[3]) {
  const double *a = point_of(points, t[0]), *b = point_of(points, t[1]),
               *c = point_of(points, t[2]);
  double e[3], f[3], normal[3];
  lth_v3_sub(b, a, e);
  lth_v3_sub(c, a, f);
  lth_v3_cross(e, f, normal);
  lth_v3_normalize(normal);
  put_point(out, normal);
  put_point(out, a);
  put_point(out, b);
  put_point(out, c);
  putc(0, out);
  putc(0, out);
}

/// The soup's own points decide how polygons are cut, so that all frames of a motion are cut alike.
LitheStatus lth_soup_write_stl(LitheCtx *ctx, const char *path, const LthSoup *soup,
                               const double *points) {
  LitheStatus status = LITHE_OK;
  LthFileWriter writer;
  LitheIndex n = 0, *tris = NULL, *tri_poly = NULL;
  char header[81] = {0};
  LITHE_TRY(lth_soup_triangulate(ctx, soup, &n, &tris, &tri_poly));
  LITHE_TRY_OR(done, lth_file_open(ctx, path, &writer));
  snprintf(header, sizeof header, "binary STL written by Lithe %s", lithe_version());
  fwrite(header, 1, 80, writer.stream);
  put_u32(writer.stream, (uint32_t)n);
  for (LitheIndex t = 0; t < n; t++)
    put_triangle(writer.stream, points ? points : soup->points, tris + 3 * (size_t)t);
  status = lth_file_commit(ctx, &writer);
done:
  lth_free(ctx, tris);
  lth_free(ctx, tri_poly);
  return status;
}

/// Surface files: every format and variant reads as the same polygons; bad files are told with place.
#include "check.h"
#include "failing_memory.h"
#include "io/surface_file.h"
#include "scratch_folder.h"

#include <locale.h>
#include <string.h>
#include <unistd.h>

static const char *bunny = "/usr/share/glmark2/models/bunny.obj";

/// Parse 0-terminated text and fail the test if it is refused.
static LthSoup *parse(LitheCtx *ctx, const char *format, const char *text) {
  LthSoup *soup = NULL;
  CHECK_OK(ctx, lth_soup_parse(ctx, "file", format, text, strlen(text), &soup));
  return soup;
}

/// Parsing must fail with a message that holds `expected`.
static void refuse(const char *format, const void *data, size_t size, const char *expected) {
  LitheCtx *ctx = test_ctx();
  LthSoup *soup = NULL;
  assert_int_equal(lth_soup_parse(ctx, "file", format, data, size, &soup), LITHE_BAD_INPUT);
  assert_null(soup);
  if (!strstr(lithe_ctx_message(ctx), expected))
    fail_msg("message '%s' does not hold '%s'", lithe_ctx_message(ctx), expected);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void refuse_text(const char *format, const char *text, const char *expected) {
  refuse(format, text, strlen(text), expected);
}

static void finish(LitheCtx *ctx, LthSoup *soup) {
  lth_soup_destroy(ctx, &soup);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void obj_reads_polygons_of_every_corner_form(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s =
      parse(ctx, "obj",
            "\xef\xbb\xbf# a comment\nmtllib x.mtl\nv 0 0 0\nv 1 0 0 1.0\nv 1 1e0 0 0.5 0.5 0.5\n"
            "v 0\t+1. .0\r\nvn 0 0 1\nvt 0.25 0.5 0\nvt 1\n\n"
            "f 1 2 3 4\nf -4//1 -3//1 -2//1\nf 1/1 2/2 3/-1\n"
            "  f 1/1/1 2/2/1 \\\n 3/2/1 4/1/1 # quad\nl 1 2\nf 1 2 3");
  assert_int_equal(s->n_points, 4);
  assert_int_equal(s->n_polys, 5);
  assert_int_equal(s->n_uvs, 2);
  static const LitheIndex off[] = {0, 4, 7, 10, 14, 17};
  static const LitheIndex point[] = {0, 1, 2, 3, 0, 1, 2, 0, 1, 2, 0, 1, 2, 3, 0, 1, 2};
  static const LitheIndex uv[] = {-1, -1, -1, -1, -1, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1, -1, -1};
  assert_memory_equal(s->poly_off, off, sizeof off);
  assert_memory_equal(s->poly_point, point, sizeof point);
  assert_memory_equal(s->poly_uv, uv, sizeof uv);
  CHECK_NEAR(s->points[9 + 1], 1, 0);
  CHECK_NEAR(s->uvs[0], 0.25, 0);
  CHECK_NEAR(s->uvs[2], 1, 0);
  assert_null(s->poly_group);
  finish(ctx, s);
}

static void obj_keeps_groups_by_name(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = parse(ctx, "obj",
                     "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ng left arm\nf 1 2 3\ng empty\no head\n"
                     "f 1 2 3\ng left arm  \nf 1 2 3\ng\nf 1 2 3\n");
  assert_int_equal(s->n_groups, 4);
  static const LitheIndex group[] = {0, 1, 3, 1, 0};
  assert_memory_equal(s->poly_group, group, sizeof group);
  static const char *names[] = {"default", "left arm", "empty", "head"};
  for (int i = 0; i < 4; i++) assert_string_equal(s->group_names[i], names[i]);
  finish(ctx, s);
}

static void obj_keeps_many_groups(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  char text[20000] = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", *at = text + strlen(text);
  for (int i = 0; i < 1000; i++) at += sprintf(at, "g n%d\nf 1 2 3\n", i % 500);
  LthSoup *s = parse(ctx, "obj", text);
  assert_int_equal(s->n_groups, 500);
  for (int i = 0; i < 1000; i++) assert_int_equal(s->poly_group[i], i % 500);
  finish(ctx, s);
}

static void obj_errors_name_the_line(void **state) {
  (void)state;
  refuse_text("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n",
              "file:4: vertex index 99 is out of range, the file has 3 so far");
  refuse_text("obj", "v 0 0 0\nf 0 1 1\n", "file:2: vertex index 0");
  refuse_text("obj", "v 0 0 0\nf -2 1 1\n", "file:2: vertex index -2");
  refuse_text("obj", "v 0 0 0\nf 1/1 1/1 1/1\n", "texture coordinate index 1 is out of range");
  refuse_text("obj", "v 0 0\n", "file:1: vertex coordinate is missing");
  refuse_text("obj", "v 0 0 1,5\n", "file:1: vertex coordinate is '1,5', expected a number");
  refuse_text("obj", "v 0 0 nan\n", "expected a finite number");
  refuse_text("obj", "v 0 1e999 0\n", "expected a finite number");
  refuse_text("obj", "v 0 0 0\n\\\nf 1 1\n", "file:3: face has 2 corners");
  refuse_text("obj", "v 0 0 0\nf 1 1 x\n", "face corner is 'x'");
  refuse_text("obj", "v 0 0 0\nf 1 1 1/1/1/1\n", "face corner is '1/1/1/1'");
  refuse_text("obj", "v 0 0 0\nf 1 1 99999999999999999999\n", "face corner");
  refuse_text("obj", "v 0 0 0\n", "no polygons");
  refuse_text("obj", "", "empty");
  refuse_text("xyz", "v 0 0 0\n", "expected .obj, .stl, .ply or .off");
}

static const char *text_stl = "solid part one\n facet normal nan 0 0\n  outer loop\n"
                              "   vertex 0 0 0\n   VERTEX 1 0 0\n   vertex 0 1.5 0\n"
                              "  endloop\n endfacet\nendsolid part one\n"
                              "solid\nendsolid\n";

static void check_stl_triangle(const LthSoup *s) {
  assert_int_equal(s->n_points, 3);
  assert_int_equal(s->n_polys, 1);
  static const double points[] = {0, 0, 0, 1, 0, 0, 0, 1.5, 0};
  assert_memory_equal(s->points, points, sizeof points);
}

static void stl_text_reads_solids_as_groups(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = parse(ctx, "stl", text_stl);
  check_stl_triangle(s);
  assert_string_equal(s->group_names[s->poly_group[0]], "part one");
  finish(ctx, s);
}

/// A binary STL of one triangle under the given header text; `extra` bytes follow.
static size_t binary_stl(char data[256], const char *header, size_t extra) {
  static const float values[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1.5f, 0};
  memset(data, 0, 256);
  memcpy(data, header, strlen(header));
  data[80] = 1;
  memcpy(data + 84, values, sizeof values);
  return 84 + 50 + extra;
}

static void stl_binary_is_known_whatever_its_header_says(void **state) {
  (void)state;
  static const char *headers[] = {"", "solid exported", "solid a\nfacet normal 0 0 1\n"};
  for (int i = 0; i < 3; i++) {
    LitheCtx *ctx = test_ctx();
    LthSoup *s = NULL;
    char data[256];
    size_t size = binary_stl(data, headers[i], 0);
    CHECK_OK(ctx, lth_soup_parse(ctx, "file", "STL", data, size, &s));
    check_stl_triangle(s);
    finish(ctx, s);
  }
}

static void stl_binary_with_a_tail_is_read_with_a_warning(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = NULL;
  char data[256];
  size_t size = binary_stl(data, "solid exported", 7);
  CHECK_OK(ctx, lth_soup_parse(ctx, "file", "stl", data, size, &s));
  check_stl_triangle(s);
  assert_int_equal(lithe_ctx_warning_count(ctx), 1);
  finish(ctx, s);
}

static void stl_errors_name_line_or_byte(void **state) {
  (void)state;
  char data[256];
  size_t size = binary_stl(data, "", 0);
  refuse("stl", data, size - 1,
         "byte 80: the header announces 1 triangles but the file ends after 0");
  refuse("stl", data, 20, "has 20 bytes, expected STL");
  memset(data + 80, 0xff, 4);
  refuse("stl", data, size, "announces 4294967295 triangles");
  size = binary_stl(data, "", 0);
  memset(data + 84 + 12, 0xff, 4);
  refuse("stl", data, size, "file: byte 96: coordinate of triangle 0");
  refuse_text("stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n",
              "file:4: vertex coordinate is 'zero'");
  refuse_text("stl", "solid x\nfacet normal 0 0 1\nouter loop\nendloop\n",
              "file:4: found 'endloop', expected 'vertex'");
  refuse_text("stl", "solid x\nfacet normal 0 0 1\n", "found 'the end of the file'");
  refuse_text("stl", "solid x\nendsolid x\n", "no polygons");
  refuse_text("stl",
              "solid x\nfacet normal 0 0 1 outer loop vertex 0 0 0\nvertex 0 0 1\n"
              "vertex 1 0 0\nendloop endfacet\n",
              "cut short");
}

static const char *ply_text =
    "ply\nformat ascii 1.0\ncomment hello\nobj_info x\nelement extra 1\nproperty list uchar int q\n"
    "element vertex 4\nproperty uchar red\nproperty double z\nproperty float x\nproperty int y\n"
    "property list char short tags\n"
    "element face 3\nproperty uchar flag\nproperty list uchar uint vertex_indices\n"
    "element edge 1\nproperty int a\nend_header\n"
    "2 7 8\n255 0.5 0 0 0\n1 0.5 1 0 2 1 1\n1 0.5 1 1 0\n1 0.5 0 1 1 -3\n"
    "0 4 0 1 2 3\n1 2 0 1\n9 3 0 2 3\n5\n";

static void check_ply(const LthSoup *s) {
  static const double points[] = {0, 0, .5, 1, 0, .5, 1, 1, .5, 0, 1, .5};
  static const LitheIndex off[] = {0, 4, 7}, point[] = {0, 1, 2, 3, 0, 2, 3};
  assert_int_equal(s->n_points, 4);
  assert_int_equal(s->n_polys, 2); // the face of two points is a line
  assert_memory_equal(s->points, points, sizeof points);
  assert_memory_equal(s->poly_off, off, sizeof off);
  assert_memory_equal(s->poly_point, point, sizeof point);
}

static void ply_text_skips_what_it_does_not_need(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = parse(ctx, "ply", ply_text);
  check_ply(s);
  finish(ctx, s);
}

/// A growing block of bytes of one byte order.
typedef struct Bytes {
  char at[2048];
  size_t n;
  bool big;
} Bytes;

static void put(Bytes *b, const void *value, size_t size) {
  const char *from = value;
  for (size_t i = 0; i < size; i++) b->at[b->n++] = from[b->big ? size - 1 - i : i];
}
static void put_u8(Bytes *b, int v) { put(b, &(uint8_t){(uint8_t)v}, 1); }
static void put_i16(Bytes *b, int v) { put(b, &(int16_t){(int16_t)v}, 2); }
static void put_i32(Bytes *b, int v) { put(b, &(int32_t){v}, 4); }
static void put_f32(Bytes *b, double v) { put(b, &(float){(float)v}, 4); }
static void put_f64(Bytes *b, double v) { put(b, &v, 8); }

/// The file of ply_text in binary.
static void make_binary_ply(Bytes *b, bool big, const char *line_end) {
  static const double points[4][3] = {{0, 0, .5}, {1, 0, .5}, {1, 1, .5}, {0, 1, .5}};
  static const int n_tags[] = {0, 2, 0, 1};
  *b = (Bytes){.big = big};
  const char *end = strstr(ply_text, "end_header\n") + strlen("end_header\n");
  for (const char *at = ply_text; at < end; at++) {
    if (*at == '\n')
      b->n += (size_t)sprintf(b->at + b->n, "%s", line_end);
    else if (strncmp(at, "ascii", 5) == 0) {
      b->n += (size_t)sprintf(b->at + b->n, "binary_%s_endian", big ? "big" : "little");
      at += 4;
    } else
      b->at[b->n++] = *at;
  }
  put_u8(b, 2), put_i32(b, 7), put_i32(b, 8);
  for (int i = 0; i < 4; i++) {
    put_u8(b, 255), put_f64(b, points[i][2]), put_f32(b, points[i][0]);
    put_i32(b, (int)points[i][1]), put_u8(b, n_tags[i]);
    for (int k = 0; k < n_tags[i]; k++) put_i16(b, -3);
  }
  put_u8(b, 0), put_u8(b, 4);
  for (int k = 0; k < 4; k++) put_i32(b, k);
  put_u8(b, 1), put_u8(b, 2), put_i32(b, 0), put_i32(b, 1);
  put_u8(b, 9), put_u8(b, 3), put_i32(b, 0), put_i32(b, 2), put_i32(b, 3);
  put_i32(b, 5);
}

static void ply_binary_reads_both_byte_orders(void **state) {
  (void)state;
  for (int variant = 0; variant < 4; variant++) {
    LitheCtx *ctx = test_ctx();
    Bytes bytes;
    LthSoup *s = NULL;
    make_binary_ply(&bytes, variant & 1, variant & 2 ? "\r\n" : "\n");
    CHECK_OK(ctx, lth_soup_parse(ctx, "file", "ply", bytes.at, bytes.n, &s));
    check_ply(s);
    finish(ctx, s);
  }
}

static void no_cut_short_ply_is_read(void **state) {
  (void)state;
  Bytes bytes;
  make_binary_ply(&bytes, false, "\n");
  for (size_t n = 0; n < bytes.n; n++) {
    // from a block of just that size, so that a read behind the end is seen by ASan
    char *data = malloc(n + 1);
    memcpy(data, bytes.at, n);
    refuse("ply", data, n, "file");
    free(data);
  }
}

static void ply_errors_name_line_or_byte(void **state) {
  (void)state;
  const char *head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                     "property float z\nelement face 1\nproperty list uchar int vertex_index\n"
                     "end_header\n0 0 0\n1 0 0\n0 1 0\n";
  static const char *cases[][2] = {
      {"3 0 1 3\n", "file:13: vertex index 3 is out of range, expected 0 to 2"},
      {"3 0 1 -1\n", "vertex index -1 is out of range"},
      {"3 0 1 0.5\n", "vertex index 0.5 is out of range"},
      {"-3 0 1 2\n", "length of the list vertex_index is -3"},
      {"3 0 1 x\n", "a vertex index is 'x'"},
      {"3 0 1\n", "the file ends before a vertex index"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    char text[1024];
    snprintf(text, sizeof text, "%s%s", head, cases[i][0]);
    refuse_text("ply", text, cases[i][1]);
  }
  refuse_text("ply", "PLY\n", "does not begin with 'ply'");
  refuse_text("ply", "ply\nformat ascii 2.0\n", "file:2: version");
  refuse_text("ply", "ply\nformat ascii 1.0\nproperty float x\n", "before the first element");
  refuse_text("ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty half x\n", "'half'");
  refuse_text("ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
              "0 properties 'y'");
  refuse_text(
      "ply",
      "ply\nformat ascii 1.0\nelement vertex 2000000000\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n0\n",
      "do not fit into the 2 bytes left");
}

static void off_reads_its_relatives(void **state) {
  (void)state;
  static const char *texts[] = {
      "OFF\n# comment\n4 2 0\n0 0 .5\n1 0 .5\n1 1 .5\n0 1 .5\n4 0 1 2 3\n3 0 2 3\n",
      "OFF 4 2 0\n0 0 .5\n\n1 0 .5 # x\n1 1 .5\n0 1 .5\n4 0 1 2 3 255 0 0\n3 0 2 3 7\n",
      "COFF\n4 3 0\n0 0 .5 1 0 0 1\n1 0 .5 1 0 0 1\n1 1 .5 1 0 0 1\n0 1 .5 1 0 0 1\n4 0 1 2 3\n"
      "2 0 1\n3 0 2 3\n",
      "STCNOFF\r\n4 2\r\n0 0 .5 0 0 1\r\n1 0 .5 0 0 1\r\n1 1 .5 0 0 1\r\n0 1 .5 0 0 1\r\n"
      "4 0 1 2 3\r\n3 0 2 3",
      "4 2 0\n0 0 .5\n1 0 .5\n1 1 .5\n0 1 .5\n4 0 1 2 3\n3 0 2 3\n"};
  for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
    LitheCtx *ctx = test_ctx();
    LthSoup *s = parse(ctx, "off", texts[i]);
    check_ply(s);
    finish(ctx, s);
  }
}

static void off_errors_name_the_line(void **state) {
  (void)state;
  refuse_text("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
              "file:6: vertex index 3 is out of range, expected 0 to 2");
  refuse_text("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n", "before its last face");
  refuse_text("off", "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n",
              "file:4: vertex coordinate is missing");
  refuse_text("off", "OFF\n1000000000 1 0\n0 0 0\n", "do not fit");
  refuse_text("off", "OFF\n-3 1 0\n0 0 0\n", "do not fit");
  refuse_text("off", "OFF BINARY\n", "binary OFF is not supported");
  refuse_text("off", "4OFF\n3 1 0\n", "expected OFF, COFF");
  refuse_text("off", "  \n", "empty");
}

static void numbers_are_rounded_correctly_in_any_locale(void **state) {
  (void)state;
  setlocale(LC_ALL, "de_DE.UTF-8");
  LitheCtx *ctx = test_ctx();
  uint64_t seed = 7;
  for (int i = 0; i < 2000; i++) {
    double x[3], scale = pow(10, 40 * test_random(&seed) - 20);
    for (int j = 0; j < 3; j++) x[j] = (test_random(&seed) - 0.5) * scale;
    char text[512];
    setlocale(LC_ALL, "C");
    snprintf(text, sizeof text, "v %.17g %.17g %.17g\nf 1 1 1\n", x[0], x[1], x[2]);
    setlocale(LC_ALL, "de_DE.UTF-8");
    LthSoup *s = parse(ctx, "obj", text);
    assert_memory_equal(s->points, x, sizeof x);
    lth_soup_destroy(ctx, &s);
  }
  setlocale(LC_ALL, "C");
  lithe_ctx_destroy(&ctx);
}

static void reads_the_bunny(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = NULL;
  CHECK_OK(ctx, lth_soup_read(ctx, bunny, &s));
  assert_int_equal(s->n_points, 34835);
  assert_int_equal(s->n_polys, 69666);
  finish(ctx, s);
}

static void the_bunny_is_one_closed_shell(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *soup = NULL;
  LthSurface *s = NULL;
  CHECK_OK(ctx, lth_soup_read(ctx, bunny, &soup));
  CHECK_OK(ctx, lth_surface_from_soup(ctx, soup, bunny, NULL, &s));
  assert_int_equal(s->n_shells, 1);
  assert_int_equal(s->n_tris, 69666);
  assert_int_equal(s->n_points, 34835);
  // the file's own volume, summed exactly; mending one fold of its base moves it in the ninth digit
  CHECK_NEAR(lth_surface_volume(s), 1.5998146124631423, 2e-8);
  lth_surface_destroy(ctx, &s);
  finish(ctx, soup);
}

// ------------------------------------------------------------------ writing

/// A path in the test's folder; valid until the next call.
static const char *in_folder(const char *name) {
  static char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return path;
}

static const char *grouped_obj =
    "v 0 0 0\nv 1.23456789 0 0\nv 1 1 -0.1\nv 0 1 0\nv 5 5 5\nvt 0 0.25\nvt 1 0.125\n"
    "g left\nf 1/1 2/2 3/1 4/2\ng right arm\nf 1 2 3\nf 3/2 2/1 1/1\ng left\nf 4 3 1\n";

static void check_same_polygons(const LthSoup *s, const LthSoup *t) {
  assert_int_equal(s->n_polys, t->n_polys);
  assert_memory_equal(s->poly_off, t->poly_off, sizeof(LitheIndex) * (size_t)(s->n_polys + 1));
  assert_memory_equal(s->poly_point, t->poly_point,
                      sizeof(LitheIndex) * (size_t)s->poly_off[s->n_polys]);
}

static void obj_comes_back_with_groups_and_texture_coordinates(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = parse(ctx, "obj", grouped_obj), *t = NULL;
  CHECK_OK(ctx, lth_soup_write_obj(ctx, in_folder("a.obj"), s, NULL));
  CHECK_OK(ctx, lth_soup_read(ctx, in_folder("a.obj"), &t));
  check_same_polygons(s, t);
  assert_int_equal(t->n_points, 5); // also the one that no polygon uses
  assert_memory_equal(s->points, t->points, 15 * sizeof(double));
  assert_int_equal(t->n_uvs, 2);
  assert_memory_equal(s->uvs, t->uvs, 4 * sizeof(double));
  assert_memory_equal(s->poly_uv, t->poly_uv, 13 * sizeof(LitheIndex));
  assert_int_equal(t->n_groups, 2);
  assert_memory_equal(s->poly_group, t->poly_group, 4 * sizeof(LitheIndex));
  assert_string_equal(t->group_names[1], "right arm");
  lth_soup_destroy(ctx, &t);
  finish(ctx, s);
}

static void ply_comes_back_with_other_points(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = parse(ctx, "obj", grouped_obj), *t = NULL;
  double moved[15];
  for (int i = 0; i < 15; i++) moved[i] = 0.5 * i;
  CHECK_OK(ctx, lth_soup_write_ply(ctx, in_folder("a.ply"), s, moved));
  CHECK_OK(ctx, lth_soup_read(ctx, in_folder("a.ply"), &t));
  check_same_polygons(s, t);
  assert_memory_equal(moved, t->points, sizeof moved);
  lth_soup_destroy(ctx, &t);
  finish(ctx, s);
}

static void ply_has_room_for_large_polygons(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  char text[20000], *at = text;
  for (int i = 0; i < 300; i++) at += sprintf(at, "v %d %d 0\n", i, i * i);
  at += sprintf(at, "f");
  for (int i = 0; i < 300; i++) at += sprintf(at, " %d", i + 1);
  LthSoup *s = parse(ctx, "obj", text), *t = NULL;
  CHECK_OK(ctx, lth_soup_write_ply(ctx, in_folder("b.ply"), s, NULL));
  CHECK_OK(ctx, lth_soup_read(ctx, in_folder("b.ply"), &t));
  check_same_polygons(s, t);
  lth_soup_destroy(ctx, &t);
  finish(ctx, s);
}

static void stl_comes_back_as_triangles(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = parse(ctx, "obj", grouped_obj), *t = NULL;
  CHECK_OK(ctx, lth_soup_write_stl(ctx, in_folder("a.stl"), s, NULL));
  CHECK_OK(ctx, lth_soup_read(ctx, in_folder("a.stl"), &t));
  assert_int_equal(t->n_polys, 5); // a quad and three triangles
  assert_int_equal(t->n_points, 15);
  for (int i = 0; i < 3; i++) // the last polygon: points 4, 3, 1 of the file
    for (int k = 0; k < 3; k++)
      CHECK_NEAR(t->points[36 + 3 * i + k], s->points[3 * (i == 0 ? 3 : i == 1 ? 2 : 0) + k], 1e-7);
  assert_int_equal(lithe_ctx_warning_count(ctx), 0);
  lth_soup_destroy(ctx, &t);
  finish(ctx, s);
}

static void a_full_disk_is_told_and_leaves_nothing(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = parse(ctx, "obj", grouped_obj);
  assert_int_equal(lth_soup_write_obj(ctx, "/dev/full", s, NULL), LITHE_NO_SPACE);
  assert_int_equal(lth_soup_write_ply(ctx, "/dev/full", s, NULL), LITHE_NO_SPACE);
  assert_int_equal(lth_soup_write_stl(ctx, "/dev/full", s, NULL), LITHE_NO_SPACE);
  assert_int_equal(lth_soup_write_stl(ctx, in_folder("no/such/a.stl"), s, NULL), LITHE_NO_SPACE);
  finish(ctx, s);
}

static void defects_are_written_as_edges_and_bars(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthSoup *s = parse(ctx, "obj", grouped_obj), *t = NULL;
  LthSurface *surface = NULL;
  LthDefects defects;
  assert_int_equal(lth_surface_from_soup(ctx, s, "a", &defects, &surface), LITHE_BAD_INPUT);
  assert_true(defects.n > 0);
  CHECK_OK(ctx, lth_defects_write_ply(ctx, in_folder("defects.ply"), &defects));
  CHECK_OK(ctx, lth_soup_read(ctx, in_folder("defects.ply"), &t));
  assert_int_equal(t->n_points, 8 * defects.n);
  assert_int_equal(t->n_polys, 8 * defects.n);
  for (LitheIndex i = 0; i < defects.n; i++)
    for (int k = 0; k < 6; k++) CHECK_NEAR(t->points[24 * i + k], defects.segment[6 * i + k], 1e-9);
  // each bar is a solid of its own
  LthSoup *bar = t;
  bar->n_polys = 8;
  CHECK_OK(ctx, lth_surface_from_soup(ctx, bar, "bar", NULL, &surface));
  assert_int_equal(surface->n_shells, 1);
  assert_int_equal(surface->n_tris, 8);
  lth_surface_destroy(ctx, &surface);
  lth_defects_free(ctx, &defects);
  lth_soup_destroy(ctx, &t);
  finish(ctx, s);
}

// ------------------------------------------------------------------ memory

static void running_out_of_memory_leaks_nothing(void **state) {
  (void)state;
  Bytes binary;
  make_binary_ply(&binary, true, "\n");
  const struct {
    const char *format, *data;
    size_t size;
  } files[] = {{"obj", grouped_obj, strlen(grouped_obj)},
               {"stl", text_stl, strlen(text_stl)},
               {"ply", ply_text, strlen(ply_text)},
               {"ply", binary.at, binary.n},
               {"off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", 37}};
  for (size_t f = 0; f < sizeof files / sizeof files[0]; f++) {
    LitheStatus status = LITHE_NO_MEMORY;
    int n = 0;
    for (; status == LITHE_NO_MEMORY; n++) {
      int left = n;
      LitheCtxDef def = lithe_ctx_def_default();
      def.allocate = test_failing_allocate;
      def.memory_user = &left;
      LitheCtx *ctx = lithe_ctx_create(&def);
      LthSoup *s = NULL;
      status = lth_soup_parse(ctx, "file", files[f].format, files[f].data, files[f].size, &s);
      if (status == LITHE_OK) status = lth_soup_write_stl(ctx, in_folder("m.stl"), s, NULL);
      lth_soup_destroy(ctx, &s);
      assert_int_equal(lth_alloc_bytes(ctx), 0);
      lithe_ctx_destroy(&ctx);
    }
    assert_int_equal(status, LITHE_OK);
    assert_true(n > 5);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(obj_reads_polygons_of_every_corner_form),
      cmocka_unit_test(obj_keeps_groups_by_name),
      cmocka_unit_test(obj_keeps_many_groups),
      cmocka_unit_test(obj_errors_name_the_line),
      cmocka_unit_test(stl_text_reads_solids_as_groups),
      cmocka_unit_test(stl_binary_is_known_whatever_its_header_says),
      cmocka_unit_test(stl_binary_with_a_tail_is_read_with_a_warning),
      cmocka_unit_test(stl_errors_name_line_or_byte),
      cmocka_unit_test(ply_text_skips_what_it_does_not_need),
      cmocka_unit_test(ply_binary_reads_both_byte_orders),
      cmocka_unit_test(no_cut_short_ply_is_read),
      cmocka_unit_test(ply_errors_name_line_or_byte),
      cmocka_unit_test(off_reads_its_relatives),
      cmocka_unit_test(off_errors_name_the_line),
      cmocka_unit_test(numbers_are_rounded_correctly_in_any_locale),
      cmocka_unit_test(reads_the_bunny),
      cmocka_unit_test(the_bunny_is_one_closed_shell),
      cmocka_unit_test(obj_comes_back_with_groups_and_texture_coordinates),
      cmocka_unit_test(ply_comes_back_with_other_points),
      cmocka_unit_test(ply_has_room_for_large_polygons),
      cmocka_unit_test(stl_comes_back_as_triangles),
      cmocka_unit_test(a_full_disk_is_told_and_leaves_nothing),
      cmocka_unit_test(defects_are_written_as_edges_and_bars),
      cmocka_unit_test(running_out_of_memory_leaks_nothing),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}

/// VTU files of polyhedra and the PVD list. golden/check_vtu.py opens them with VTK's own reader.
#include "check.h"
#include "io/json.h"
#include "io/vtu.h"

#include <string.h>

/// Points of a square frame with a plug in its hole: a 3 x 3 x 1 box of two cells.
static void frame_points(double *points) {
  static const double corner[8][2] = {{0, 0}, {3, 0}, {3, 3}, {0, 3},
                                      {1, 1}, {2, 1}, {2, 2}, {1, 2}};
  for (int i = 0; i < 16; i++) {
    points[3 * i] = corner[i % 8][0];
    points[3 * i + 1] = corner[i % 8][1];
    points[3 * i + 2] = i / 8;
  }
}

/// Cell 0 is the frame, whose top and bottom have a hole; cell 1 the plug.
static LthMesh *make_frame(LitheCtx *ctx) {
  double points[48];
  frame_points(points);
  const LitheIndex face_loop_off[13] = {0, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
  const LitheIndex loop_point[] = {
      8,  9,  10, 11, 12, 15, 14, 13,                               // top with hole
      0,  3,  2,  1,  4,  5,  6,  7,                                // bottom with hole
      0,  1,  9,  8,  1,  2,  10, 9,  2, 3,  11, 10, 3, 0,  8,  11, // outside
      4,  12, 13, 5,  5,  13, 14, 6,  6, 14, 15, 7,  7, 15, 12, 4,  // frame to plug
      12, 13, 14, 15, 4,  7,  6,  5};                               // top and bottom of the plug
  LitheIndex loop_off[15];
  for (int i = 0; i < 15; i++) loop_off[i] = 4 * i;
  const LitheIndex face_cell[24] = {0, -1, 0, -1, 0, -1, 0, -1, 0, -1, 0, -1,
                                    0, 1,  0, 1,  0, 1,  0, 1,  1, -1, 1, -1};
  LthMeshDef def = {.n_points = 16,
                    .n_faces = 12,
                    .n_cells = 2,
                    .points = points,
                    .face_loop_off = face_loop_off,
                    .loop_off = loop_off,
                    .loop_point = loop_point,
                    .face_cell = face_cell,
                    .cell_size = 1};
  LthMesh *mesh = NULL;
  CHECK_OK(ctx, lth_mesh_create(ctx, &def, &mesh));
  return mesh;
}

/// What the checker expects of one file.
static void tell(LthJson *json, const char *file, const LthVtu *vtu) {
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "file", file);
  lth_json_number(json, "time", vtu->time);
  lth_json_integer(json, "points", vtu->n_points);
  lth_json_begin_array(json, "volumes");
  for (LitheIndex c = 0; c < vtu->mesh->n_cells; c++)
    lth_json_number(json, NULL, vtu->mesh->cell_volume[c]);
  lth_json_end_array(json);
  lth_json_begin_object(json, "point_arrays");
  for (int i = 0; i < vtu->n_point_arrays; i++)
    lth_json_vector(json, vtu->point_arrays[i].name, vtu->point_arrays[i].components,
                    vtu->point_arrays[i].data);
  lth_json_end_object(json);
  lth_json_begin_object(json, "cell_arrays");
  for (int i = 0; i < vtu->n_cell_arrays; i++)
    lth_json_vector(json, vtu->cell_arrays[i].name, vtu->cell_arrays[i].components,
                    vtu->cell_arrays[i].data);
  lth_json_end_object(json);
  lth_json_end_object(json);
}

/// Write a mesh with each cell moved by a multiple of 0.1, so that neighbours come apart.
static void write_mesh(LitheCtx *ctx, LthJson *json, const char *file, const LthMesh *mesh,
                       double time, const LthVtuTopology *topology) {
  LitheCount *off;
  LitheIndex *mesh_point;
  CHECK_OK(ctx, lth_vtu_cell_points(ctx, mesh, &off, &mesh_point));
  LitheIndex n = (LitheIndex)off[mesh->n_cells];
  double *points = lth_alloc(ctx, 3 * (LitheCount)n, sizeof *points);
  double *moved = lth_alloc(ctx, 3 * (LitheCount)n, sizeof *moved);
  double *stress = lth_alloc(ctx, 6 * (LitheCount)mesh->n_cells, sizeof *stress);
  for (LitheIndex c = 0; c < mesh->n_cells; c++)
    for (LitheCount i = off[c]; i < off[c + 1]; i++)
      for (int a = 0; a < 3; a++) {
        moved[3 * i + a] = a == 2 ? 0.1 * (c % 7) : 0;
        points[3 * i + a] = mesh->points[3 * mesh_point[i] + a] + moved[3 * i + a];
      }
  for (int i = 0; i < 6; i++) stress[i] = i + 1;
  LthVtuArray point_array = lth_vtk_array("displacement", 3, moved);
  LthVtuArray cell_arrays[2] = {lth_vtk_array("stress", 6, stress),
                                lth_vtk_array("volume <m^3>", 1, mesh->cell_volume)};
  LthVtu vtu = {.mesh = mesh,
                .n_points = n,
                .points = points,
                .cell_point_off = off,
                .cell_mesh_point = mesh_point,
                .point_arrays = &point_array,
                .cell_arrays = cell_arrays,
                .n_point_arrays = 1,
                .n_cell_arrays = 2,
                .time = time,
                .topology = topology};
  LthVtuTopology *own = NULL;
  if (time > 0) CHECK_OK(ctx, lth_vtu_topology_create(ctx, &vtu, &own));
  if (own) vtu.topology = own;
  CHECK_OK(ctx, lth_vtu_write(ctx, file, &vtu));
  tell(json, file, &vtu);
  lth_vtu_topology_destroy(ctx, &own);
  lth_free(ctx, off);
  lth_free(ctx, mesh_point);
  lth_free(ctx, points);
  lth_free(ctx, moved);
  lth_free(ctx, stress);
}

static void writes_files_for_vtk_to_check(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthJson *json;
  const char *text;
  LthMesh *mesh;
  LthGrid grid = {.min = {0, 0, 0}, .max = {2, 1, 1}, .cells = {20, 10, 10}};
  CHECK_OK(ctx, lth_json_create(ctx, &json));
  lth_json_begin_array(json, NULL);

  mesh = make_frame(ctx);
  write_mesh(ctx, json, "test_frame.vtu", mesh, 0, NULL);
  lth_mesh_destroy(ctx, &mesh);
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &mesh));
  write_mesh(ctx, json, "test_hexahedra.vtu", mesh, 0.25, NULL);
  lth_mesh_destroy(ctx, &mesh);
  CHECK_OK(ctx, lth_mesh_tetrahedra(ctx, &grid, &mesh));
  write_mesh(ctx, json, "test_tetrahedra.vtu", mesh, 1. / 3, NULL);
  lth_mesh_destroy(ctx, &mesh);

  lth_json_end_array(json);
  CHECK_OK(ctx, lth_json_text(json, &text));
  FILE *expected = fopen("vtu_expected.json", "w");
  fputs(text, expected);
  fclose(expected);
  const char *const files[3] = {"test_frame.vtu", "test_hexahedra.vtu", "test_tetrahedra.vtu"};
  CHECK_OK(ctx, lth_pvd_write(ctx, "test_vtu.pvd", 3, (const double[]){0, 0.25, 1. / 3}, files));
  lth_json_destroy(ctx, &json);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void gives_each_cell_its_own_points(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = make_frame(ctx);
  LitheCount *off;
  LitheIndex *mesh_point;
  CHECK_OK(ctx, lth_vtu_cell_points(ctx, mesh, &off, &mesh_point));
  assert_int_equal(off[1], 16);
  assert_int_equal(off[2], 24);
  lth_free(ctx, off);
  lth_free(ctx, mesh_point);
  lth_mesh_destroy(ctx, &mesh);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void a_failed_write_leaves_no_file(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthMesh *mesh = make_frame(ctx);
  LitheCount *off;
  LitheIndex *mesh_point;
  CHECK_OK(ctx, lth_vtu_cell_points(ctx, mesh, &off, &mesh_point));
  double points[72] = {0};
  LthVtu vtu = {.mesh = mesh,
                .n_points = 24,
                .points = points,
                .cell_point_off = off,
                .cell_mesh_point = mesh_point};
  assert_int_equal(lth_vtu_write(ctx, "no/such/folder/x.vtu", &vtu), LITHE_NO_SPACE);
  assert_non_null(strstr(lithe_ctx_message(ctx), "no/such/folder/x.vtu"));
  lth_free(ctx, off);
  lth_free(ctx, mesh_point);
  lth_mesh_destroy(ctx, &mesh);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(writes_files_for_vtk_to_check),
      cmocka_unit_test(gives_each_cell_its_own_points),
      cmocka_unit_test(a_failed_write_leaves_no_file),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

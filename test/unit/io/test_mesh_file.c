/// Mesh files that are wrong are refused with file, line and element; what is odd but sound is read.
#include "check.h"
#include "io/mesh_file.h"

#include <string.h>

static LitheStatus parse(LitheCtx *ctx, const char *format, const char *text,
                         LthElementMesh **mesh) {
  char name[16];
  snprintf(name, sizeof name, "p.%s", format);
  return lth_mesh_file_parse(ctx, name, format, text, strlen(text), 1, mesh);
}

/// Parse, expect a refusal whose message holds `part`, and nothing left behind.
static void check_refused(const char *format, const char *text, const char *part) {
  LitheCtx *ctx = test_ctx();
  LthElementMesh *mesh = NULL;
  LitheStatus status = parse(ctx, format, text, &mesh);
  if (status != LITHE_BAD_INPUT || !strstr(lithe_ctx_message(ctx), part))
    fail_msg("'%s': %s: '%s', expected '%s'", text, lithe_status_text(status),
             lithe_ctx_message(ctx), part);
  assert_null(mesh);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

/// Two tetrahedra at the face 1 2 3, and a node that none uses.
#define NODES "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,0,0,-1\n9,7,7,7\n"
#define TETS NODES "*ELEMENT,TYPE=C3D4,ELSET=E\n11,1,2,3,4\n12,1,3,2,5\n"

static void decks_that_are_wrong_are_refused(void **state) {
  (void)state;
  static const char *const cases[][2] = {
      {"", "it has no volume elements"},
      {NODES, "it has no volume elements"},
      {"*NODE\n1,0,0,x\n", "p.inp:2: a coordinate is 'x', expected a number"},
      {"*NODE\n1,0,0,nan\n", "p.inp:2: a coordinate is 'nan', expected a finite number"},
      {"*NODE,NSET=\n1\n", "p.inp:1: *NODE: NSET has no name behind it"},
      {"*NODE,SYSTEM=C\n1\n", "p.inp:1: *NODE: SYSTEM is not read"},
      {NODES "*ELEMENT\n1,1,2,3,4\n", "p.inp:8: *ELEMENT: names no type"},
      {NODES "*ELEMENT,TYPE=C3D4\n1,1,2,3,8\n",
       "p.inp:9: element 1 (tet4) names node 8, which the file does not have"},
      {NODES "*ELEMENT,TYPE=C3D4\n1,1,2,3,99999999999\n", "names node 99999999999"},
      {NODES "*ELEMENT,TYPE=C3D4\n1,1,2,3\n", "p.inp:9: the last element has 3 nodes, expected 4"},
      {NODES "*ELEMENT,TYPE=C3D4\n1,1,2,3,4,5\n", "p.inp:9: an element has 5 or more nodes"},
      {NODES "*ELEMENT,TYPE=C3D4\n1,1,3,2,4\n",
       "p.inp:9: element 1 (tet4) near (0, 0, 0) is turned inside out: its volume is -0.166667"},
      {NODES "*ELEMENT,TYPE=C3D4\n1,1,2,3,3\n", "p.inp:9: element 1 (tet4) near (0, 0, 0) is flat"},
      {TETS "12,1,2,3,4\n", "p.inp:11: element 12 is there twice"},
      {TETS "13,1,2,3,4\n",
       "p.inp:11: element 13 (tet4) and p.inp:9: element 11 (tet4): both lie on the same side"},
      {TETS "*NODE\n6,1,1,-1\n*ELEMENT,TYPE=C3D4\n13,1,3,2,6\n",
       "p.inp:14: element 13 (tet4) and p.inp:9: element 11 (tet4): a third element lies at"},
      {TETS "*NSET\n1\n", "p.inp:11: *NSET: has no name, expected NSET=name"},
      {TETS "*NSET,NSET=N\n1,other\n", "p.inp:12: 'other' is neither a number nor a set of nodes"},
      {TETS "*ELSET,ELSET=A,GENERATE\n5,1\n", "p.inp:12: a range from 5 to 1 in steps of 1"},
      {TETS "*SURFACE,NAME=S\n11,S5\n", "p.inp:12: element 11 (tet4) has no face S5"},
      {TETS "*SURFACE,NAME=S\n11,P1\n", "p.inp:12: 'P1' is no face of a solid"},
      {TETS "*SURFACE,NAME=S\nF,S1\n", "p.inp:12: 'F' is neither an element nor a set"},
      {TETS "*SURFACE,NAME=S,TYPE=CUTTING\n", "p.inp:11: *SURFACE: TYPE is 'CUTTING'"},
      {TETS "*NGEN\n1,2\n", "p.inp:11: *NGEN: is not read"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
    check_refused("inp", cases[i][0], cases[i][1]);
}

static void decks_name_sets_in_any_case(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthElementMesh *m = NULL;
  const LthElementGroup *g;
  CHECK_OK(ctx, parse(ctx, "inp",
                      TETS "*NSET,NSET=Base,GENERATE\n1,3\n*NSET,NSET=more\nbase,5,9\n"
                           "*ELSET,ELSET=far,GENERATE\n1,2000000000,1\n"
                           "*SURFACE,NAME=Side\nE,S1\n12,S4\n*SURFACE,NAME=N,TYPE=NODE\nBASE,1.5\n",
                      &m));
  assert_int_equal(m->n_nodes, 5);
  assert_int_equal(m->n_elements, 2);
  assert_int_equal(m->element_id[1], 12);
  assert_int_equal(m->line[1], 10);
  g = lth_element_group(m, LTH_GROUP_NODES, "MORE");
  assert_non_null(g);
  assert_int_equal(g->n, 4); // node 9 is not part of the solid
  assert_int_equal(g->member[3], 4);
  assert_int_equal(lth_element_group(m, LTH_GROUP_NODES, "n")->n, 3);
  assert_int_equal(lth_element_group(m, LTH_GROUP_ELEMENTS, "FAR")->n, 2);
  assert_string_equal(lth_element_group(m, LTH_GROUP_ELEMENTS, "e")->name, "E");
  // S1 of a tetrahedron is its face 1 2 3, S4 is 3 4 1: here the last and the third
  g = lth_element_group(m, LTH_GROUP_FACES, "SIDE");
  assert_int_equal(g->n, 3);
  assert_int_equal(g->member[0], 3);
  assert_int_equal(g->member[1], 8 + 2);
  assert_int_equal(g->member[2], 8 + 3);
  lth_element_mesh_destroy(ctx, &m);

  // coordinates scaled, nodes defined anew, the reduced rule
  CHECK_OK(ctx, lth_mesh_file_parse(ctx, "p.inp", "INP", TETS "*NODE\n5,0,0,-4\n",
                                    strlen(TETS "*NODE\n5,0,0,-4\n"), 1e-3, &m));
  CHECK_NEAR(m->nodes[3 * 4 + 2], -4e-3, 1e-18);
  assert_null(m->reduced);
  lth_element_mesh_destroy(ctx, &m);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

#define MSH2 "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
#define POINTS2 "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n7 0 0 -1\n$EndNodes\n"
#define MSH4 "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"

static void gmsh_files_that_are_wrong_are_refused(void **state) {
  (void)state;
  static const char *const cases[][2] = {
      {"", "p.msh:1: the file is empty, expected $MeshFormat"},
      {"solid cube\n", "p.msh:1: 'solid' where a section was expected"},
      {"$Nodes\n0\n$EndNodes\n", "has to begin with $MeshFormat"},
      {"$MeshFormat\n4 0 8\n$EndMeshFormat\n", "the version is 4, expected 2.2 or 4.1"},
      {"$MeshFormat\n2.2 0", "the file ends in $MeshFormat before the data size: it is cut short"},
      {"$MeshFormat\n2.2 1 8\nabcd\n", "the byte order cannot be told"},
      {MSH2 MSH2, "has to begin with $MeshFormat, once"},
      {MSH2, "it has no volume elements"},
      {MSH2 "$Nodes\n2\n1 0 0 0\n2 1 0", "p.msh:7: the file ends in $Nodes before a coordinate"},
      {MSH2 "$Nodes\n1\n1 0 0 z\n", "p.msh:6: a coordinate is 'z' in $Nodes, expected a number"},
      {MSH2 "$Nodes\n1\n1 0 0 0\n2 0 0 0\n", "p.msh:7: '2' where $EndNodes was expected"},
      {MSH2 "$Nodes\n2\n1 0 0 0\n1 1 0 0\n$EndNodes\n", "p.msh: node 1 is there twice"},
      {MSH2 POINTS2 "$Elements\n1\n1 4 2 0 1 1 2 3\n$EndElements\n",
       "a node of an element is '$End"},
      {MSH2 POINTS2 "$Elements\n1\n1 4 2 0 1 1 2 3 4 7\n$EndElements\n",
       "p.msh:14: element 1 of type 4 has more than 4 nodes"},
      {MSH2 POINTS2 "$Elements\n1\n1 29 2 0 1 1 2 3 4\n$EndElements\n",
       "p.msh:14: element type 29 is not known here"},
      {MSH2 POINTS2 "$Elements\n1\n1 4 2 0 1 1 2 3 5\n$EndElements\n",
       "p.msh:14: element 1 (tet4) names node 5"},
      {MSH2 POINTS2 "$Elements\n1\n1 4 2 0 1 1 3 2 4\n$EndElements\n",
       "p.msh:14: element 1 (tet4) near (0, 0, 0) is turned inside out"},
      {MSH2 "$PhysicalNames\n1\n2 1 top\n", "p.msh:6: the name of a physical group is top"},
      {MSH2 "$Unknown\n1 2 3\n", "the section $Unknown has no end"},
      {MSH4 "$Nodes\n1 1 1 1\n0 1 0 1\n1\n0 0", "p.msh:8: the file ends in $Nodes before a coor"},
      {MSH4 "$Nodes\n1 1 1 1\n0 1 0 99999999999\n", "the file ends in $Nodes before the number of"},
      {MSH4 "$Nodes\n1 1 1 1\n9 1 0 1\n1\n", "a block of nodes has dimension 9"},
      {MSH4 "$Elements\n1 1 1 1\n3 1 4 -1\n", "the number of elements of a block is -1"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
    check_refused("msh", cases[i][0], cases[i][1]);
}

/// A grid of `points`, and cells by their arrays, all as text.
#define VTU(points, n, cells)                                                                      \
  "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" "              \
  "NumberOfCells=\"" n "\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "          \
  "format=\"ascii\">" points "</DataArray></Points><Cells>" cells "</Cells></Piece>"               \
  "</UnstructuredGrid></VTKFile>"
#define ARRAY(name, values)                                                                        \
  "<DataArray type=\"Int64\" Name=\"" name "\" format=\"ascii\">" values "</DataArray>"
#define CELL(nodes, offset, type)                                                                  \
  ARRAY("connectivity", nodes) ARRAY("offsets", offset) ARRAY("types", type)
#define CORNERS "0 0 0 1 0 0 0 1 0 0 0 1"
#define FACES(values) CELL("0 1 2 3", "4", "42") ARRAY("faces", values) ARRAY("faceoffsets", "17")

static void grids_that_are_wrong_are_refused(void **state) {
  (void)state;
  static const char *const cases[][2] = {
      {"", "the file has no tag VTKFile"},
      {"<VTKFile type=\"PolyData\">", "p.vtu:1: the file holds a PolyData"},
      {"<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkLZ4DataCompressor\">",
       "compressed by vtkLZ4DataCompressor"},
      {"<VTKFile type=\"UnstructuredGrid\"><Piece NumberOfPoints=\"-1\">", "NumberOfPoints of the"},
      {"<VTKFile type=\"UnstructuredGrid\"/>", "it has no array Points"},
      {VTU("0 0 0", "1", CELL("0 1 2 3", "4", "10")), "it has 3 values, expected 12"},
      {VTU(CORNERS " inf", "1", ""), "it has 13 values, expected 12"},
      {VTU("0 0 0 1 0 0 0 1 0 0 0 nan", "1", ""), "a coordinate of point 3 is nan"},
      {VTU(CORNERS, "1", ""), "it has no array connectivity"},
      {VTU(CORNERS, "1", CELL("0 1 2 4", "4", "10")), "the connectivity names point 4 of 4"},
      {VTU(CORNERS, "1", CELL("0 1 2 3", "5", "10")), "cell 0 ends in the connectivity at 5"},
      {VTU(CORNERS, "1", CELL("0 1 2 3", "3", "10")), "its number of points, 3"},
      {VTU(CORNERS, "1", CELL("0 1 2 3", "4", "71")),
       "cell 0 is of a type that is not read here: 71"},
      {VTU(CORNERS, "1", CELL("0 2 1 3", "4", "10")), "p.vtu: element 0 (tet4) near"},
      {VTU(CORNERS, "1", CELL("0 1 2 3", "4", "9")), "it has no volume elements"},
      {VTU(CORNERS, "1", CELL("0 1 2 3", "4", "42")), "it has no array faces"},
      {VTU(CORNERS, "1", FACES("4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 4")), "names point 4"},
      {VTU(CORNERS, "1", FACES("4 3 0 2 1 3 0 1 3 3 1 2 3 4 2 0 3")), "number of points is 4"},
      {VTU(CORNERS, "1", FACES("3 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3")), "number of faces is 3"},
      {VTU(CORNERS, "1", FACES("4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 1 3")),
       "element 0 (polyhedron) is not closed: an edge from (0, 0, 0) to"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
    check_refused("vtu", cases[i][0], cases[i][1]);
}

static void polyhedra_are_turned_outward(void **state) {
  (void)state;
  static const char *const cases[] = {
      VTU(CORNERS, "1", FACES("4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3")),
      VTU(CORNERS, "1", FACES("4 3 0 1 2 3 0 1 3 3 1 2 3 3 2 0 3")),
      VTU(CORNERS, "1", FACES("4 3 0 1 2 3 0 3 1 3 1 3 2 3 2 3 0"))};
  for (int i = 0; i < 3; i++) {
    LitheCtx *ctx = test_ctx();
    LthElementMesh *e = NULL;
    LthMesh *m = NULL;
    CHECK_OK(ctx, parse(ctx, "vtu", cases[i], &e));
    CHECK_OK(ctx, lth_mesh_from_elements(ctx, e, "p.vtu", &m));
    CHECK_NEAR(m->cell_volume[0], 1.0 / 6, 1e-16);
    lth_mesh_destroy(ctx, &m);
    lth_element_mesh_destroy(ctx, &e);
    assert_int_equal(lth_alloc_bytes(ctx), 0);
    lithe_ctx_destroy(&ctx);
  }
}

static void an_unknown_ending_is_refused(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthElementMesh *m = NULL;
  assert_int_equal(lth_mesh_file_read(ctx, "a.b/part", 1, &m), LITHE_BAD_INPUT);
  assert_non_null(strstr(lithe_ctx_message(ctx), "expected .msh (Gmsh), .vtu or .inp"));
  assert_int_equal(lth_mesh_file_read(ctx, "nowhere.msh", 1, &m), LITHE_BAD_INPUT);
  assert_true(lth_mesh_file_has_ending("a.b/part.MSH"));
  assert_false(lth_mesh_file_has_ending("part.obj"));
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(decks_that_are_wrong_are_refused),
      cmocka_unit_test(decks_name_sets_in_any_case),
      cmocka_unit_test(gmsh_files_that_are_wrong_are_refused),
      cmocka_unit_test(grids_that_are_wrong_are_refused),
      cmocka_unit_test(polyhedra_are_turned_outward),
      cmocka_unit_test(an_unknown_ending_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

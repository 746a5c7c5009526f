/// Nodes by `where`: shapes with their boundary, labels of every sort, complements, what only faces can say.
#include "check.h"

#include "mesh/node_selection.h"

#include <string.h>

/// Two hexahedra of second degree side by side along x, 45 nodes, with groups.
typedef struct Pair {
  LthMesh *mesh;
  LthElementMesh *elements;
  uint8_t chosen[45];
} Pair;

static void name(LitheCtx *ctx, LthElementGroup *group, LthGroupOf of, LitheIndex member) {
  *group = (LthElementGroup){.tag = -1, .of = of, .n = 1};
  CHECK_OK(ctx, lth_copy_text(ctx, "a", &group->name));
  CHECK_OK(ctx, lth_new_(ctx, (void **)&group->member, 1, sizeof member));
  group->member[0] = member;
}

static Pair make(LitheCtx *ctx, int n_groups, const LthGroupOf *of, const LitheIndex *member) {
  LthGrid grid = {{0, 0, 0}, {2, 1, 1}, {2, 1, 1}};
  Pair p = {0};
  CHECK_OK(ctx, lth_mesh_hexahedra(ctx, &grid, &p.mesh));
  CHECK_OK(ctx, lth_element_mesh_grid(ctx, &grid, 2, false, false, NULL, &p.elements));
  assert_int_equal(p.elements->n_nodes, 45);
  CHECK_OK(ctx, lth_new_(ctx, (void **)&p.elements->groups, n_groups, sizeof(LthElementGroup)));
  for (int i = 0; i < n_groups; i++) name(ctx, &p.elements->groups[i], of[i], member[i]);
  p.elements->n_groups = n_groups;
  return p;
}

static void unmake(LitheCtx *ctx, Pair *p) {
  lth_mesh_destroy(ctx, &p->mesh);
  lth_element_mesh_destroy(ctx, &p->elements);
}

static int count(LitheCtx *ctx, Pair *p, bool by_elements, LthWhere where) {
  LitheIndex n = by_elements ? p->elements->n_nodes : p->mesh->n_points;
  int sum = 0;
  CHECK_OK(ctx,
           lth_select_nodes(ctx, p->mesh, by_elements ? p->elements : NULL, &where, p->chosen));
  for (LitheIndex i = 0; i < n; i++) sum += p->chosen[i];
  return sum;
}

static LthWhere half_space(double x) {
  return (LthWhere){.kind = LTH_WHERE_PLANE, .point = {x, 0, 0}, .normal = {1, 0, 0}};
}

static void half_spaces_hold_their_plane(void **state) {
  LitheCtx *ctx = test_ctx();
  (void)state;
  Pair p = make(ctx, 0, NULL, NULL);
  assert_int_equal(count(ctx, &p, true, half_space(1)), 27);
  assert_int_equal(count(ctx, &p, false, half_space(1)), 8);
  unmake(ctx, &p);
  lithe_ctx_destroy(&ctx);
}

static void complements_and_intersections_add_up(void **state) {
  LitheCtx *ctx = test_ctx();
  (void)state;
  Pair p = make(ctx, 0, NULL, NULL);
  LthWhere right = half_space(1),
           left = {.kind = LTH_WHERE_NOT, .children = &right, .n_children = 1};
  LthWhere both[2] = {half_space(0.5), left};
  LthWhere band = {.kind = LTH_WHERE_AND, .children = both, .n_children = 2};
  assert_int_equal(count(ctx, &p, true, left), 18);
  assert_int_equal(count(ctx, &p, true, band), 9); // x = 0.5
  unmake(ctx, &p);
  lithe_ctx_destroy(&ctx);
}

static void what_only_faces_know_selects_no_node(void **state) {
  LitheCtx *ctx = test_ctx();
  (void)state;
  Pair p = make(ctx, 0, NULL, NULL);
  LthWhere up = {.kind = LTH_WHERE_NORMAL, .normal = {0, 0, 1}, .angle = 0.1};
  LthWhere other = {.kind = LTH_WHERE_NOT, .children = &up, .n_children = 1};
  assert_int_equal(count(ctx, &p, true, up), 0);
  assert_int_equal(count(ctx, &p, true, other), 0);
  unmake(ctx, &p);
  lithe_ctx_destroy(&ctx);
}

static void labels_mean_nodes_before_faces_before_elements(void **state) {
  LitheCtx *ctx = test_ctx();
  (void)state;
  const LthGroupOf of[3] = {LTH_GROUP_ELEMENTS, LTH_GROUP_FACES, LTH_GROUP_NODES};
  const LitheIndex member[3] = {1, 8 * 1 + 0, 7};
  const int nodes[3] = {27, 9, 1};
  LthWhere label = {.kind = LTH_WHERE_LABEL, .label = (char *)"a"};
  for (int n = 1; n <= 3; n++) {
    Pair p = make(ctx, n, of, member);
    assert_int_equal(count(ctx, &p, true, label), nodes[n - 1]);
    unmake(ctx, &p);
  }
  lithe_ctx_destroy(&ctx);
}

static void unknown_labels_are_named(void **state) {
  LitheCtx *ctx = test_ctx();
  (void)state;
  const LthGroupOf of[1] = {LTH_GROUP_NODES};
  const LitheIndex member[1] = {1};
  LthWhere label = {.kind = LTH_WHERE_LABEL, .label = (char *)"top"};
  const char *wanted[2] = {"label top: this mesh has no labels",
                           "label top: the mesh file has no set of this name; it has a"};
  for (int n = 0; n < 2; n++) {
    Pair p = make(ctx, n, of, member);
    assert_int_equal(lth_select_nodes(ctx, p.mesh, p.elements, &label, p.chosen), LITHE_BAD_INPUT);
    assert_non_null(strstr(lithe_ctx_message(ctx), wanted[n]));
    unmake(ctx, &p);
  }
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(half_spaces_hold_their_plane),
      cmocka_unit_test(complements_and_intersections_add_up),
      cmocka_unit_test(what_only_faces_know_selects_no_node),
      cmocka_unit_test(labels_mean_nodes_before_faces_before_elements),
      cmocka_unit_test(unknown_labels_are_named),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/// Running out of memory anywhere in tessellating, embedding and contact: told, and nothing is lost.
#include "check.h"

#include "embed/contact.h"
#include "failing_memory.h"
#include "geometry/shape.h"
#include "solids.h"

#include <string.h>

/// Memory fails from the n-th allocation on.
static int allocations_left;

static LitheCtx *failing_ctx(int n) {
  LitheCtxDef def = lithe_ctx_def_default();
  def.allocate = test_failing_allocate;
  def.memory_user = &allocations_left;
  allocations_left = n;
  return lithe_ctx_create(&def);
}

static void end(LitheCtx *ctx) {
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

static void tessellating_survives(void **state) {
  (void)state;
  LthShape parts[2] = {{.kind = LTH_SHAPE_CYLINDER, .b = {0, 1, 0}, .radius = 0.4},
                       {.kind = LTH_SHAPE_SPHERE, .radius = 0.5}};
  LthShape both = {.kind = LTH_SHAPE_UNION, .children = parts, .n_children = 2};
  const LthShape *shapes[3] = {&parts[0], &parts[1], &both};
  for (int k = 0; k < 3; k++)
    for (int n = 0, done = 0; !done; n++) {
      LitheCtx *ctx = failing_ctx(n);
      LthSurface *s = NULL;
      LitheStatus status = lth_shape_tessellate(ctx, shapes[k], 0.3, &s);
      done = status == LITHE_OK;
      assert_true(done || (status == LITHE_NO_MEMORY && !s));
      lth_surface_destroy(ctx, &s);
      end(ctx);
    }
}

/// What both tests below stand on, with memory of its own.
typedef struct World {
  LitheCtx *ctx;
  LthSurface *ball;
  LthMesh *mesh;
  LthDgSpace *space;
} World;

static void make_world(World *w) {
  LthGrid g = {.min = {0, 0, 0}, .max = {1, 1, 1}, .cells = {2, 2, 2}};
  w->ctx = test_ctx();
  w->ball = solid_sphere(w->ctx, 2);
  CHECK_OK(w->ctx, lth_mesh_hexahedra(w->ctx, &g, &w->mesh));
  CHECK_OK(w->ctx, lth_dg_space_create(w->ctx, w->mesh, 1, NULL, &w->space));
}

static void free_world(World *w) {
  lth_dg_space_destroy(w->ctx, &w->space);
  lth_mesh_destroy(w->ctx, &w->mesh);
  solid_free(w->ctx, &w->ball);
  end(w->ctx);
}

static void embedding_survives(void **state) {
  (void)state;
  World w = {0};
  make_world(&w);
  for (int how = LTH_EMBED_MLS; how <= LTH_EMBED_STITCHED; how++)
    for (int n = 0, done = 0; !done; n++) {
      LitheCtx *ctx = failing_ctx(n);
      LthEmbedding *e = NULL;
      LitheStatus status = lth_embedding_create(ctx, w.space, w.ball->n_points, w.ball->points,
                                                NULL, (LthInterpolation)how, LTH_SAMPLE_EDGES, &e);
      done = status == LITHE_OK;
      assert_true(done || (status == LITHE_NO_MEMORY && !e));
      lth_embedding_destroy(ctx, &e);
      end(ctx);
    }
  free_world(&w);
}

static void contact_survives(void **state) {
  (void)state;
  World w = {0};
  make_world(&w);
  LthEmbedding *e = NULL;
  CHECK_OK(w.ctx, lth_embedding_create(w.ctx, w.space, w.mesh->n_points, w.mesh->points, NULL,
                                       LTH_EMBED_MLS, LTH_SAMPLE_NODES, &e));
  LthCollider mesh = {.kind = LTH_COLLIDER_MESH,
                      .shape = {.kind = LTH_SHAPE_MESH, .surface = w.ball}};
  LthContactDef def = {.points = e,
                       .colliders = &mesh,
                       .n_colliders = 1,
                       .stiffness = 1,
                       .friction = 1,
                       .cell_size = 0.5,
                       .body_size = 1};
  double *zero = calloc((size_t)w.space->n_dofs, sizeof *zero);
  for (int n = 0, done = 0; !done; n++) {
    LitheCtx *ctx = failing_ctx(n);
    LthContact *contact = NULL;
    LitheIndex n_active = 0;
    LitheStatus status = lth_contact_create(ctx, &def, &contact);
    if (status == LITHE_OK)
      status = lth_contact_detect(ctx, contact, 0, 0.1, zero, zero, &n_active);
    done = status == LITHE_OK;
    assert_true(done || status == LITHE_NO_MEMORY);
    if (done) assert_true(n_active > 0); // the ball about the origin holds a corner of the cube
    lth_contact_destroy(ctx, &contact);
    end(ctx);
  }
  free(zero);
  lth_embedding_destroy(w.ctx, &e);
  free_world(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tessellating_survives),
      cmocka_unit_test(embedding_survives),
      cmocka_unit_test(contact_survives),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

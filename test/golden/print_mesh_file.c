/// Reads mesh files and prints what they hold as JSON, one line a file; test/golden/check_mesh_file.py compares it.
#include "io/mesh_file.h"

#include "base/ctx.h"

#include <stdio.h>
#include <string.h>

static const char *const of_text[] = {"elements", "nodes", "faces"};

static void print_groups(const LthElementMesh *e, const LthMesh *m) {
  printf(", \"groups\": {");
  for (LitheIndex g = 0; g < e->n_groups; g++)
    printf("%s\"%s %s\": %d", g ? ", " : "", of_text[e->groups[g].of], e->groups[g].name,
           e->groups[g].n);
  printf("}, \"areas\": {");
  for (LitheIndex g = 0, n = 0; g < m->n_groups; g++) {
    double area = 0;
    if (m->groups[g].of_cells) continue;
    for (LitheIndex i = 0; i < m->groups[g].n; i++) area += m->face_area[m->groups[g].member[i]];
    printf("%s\"%s\": %.17g", n++ ? ", " : "", m->groups[g].name, area);
  }
  printf("}");
}

/// Sum over all nodes of all elements, weighted by their place in the element: any wrong order changes it.
static double order_sum(const LthElementMesh *m) {
  double sum = 0;
  for (LitheIndex e = 0; e < m->n_elements; e++) {
    if (m->kind[e] == LTH_POLYHEDRON) continue;
    for (LitheIndex i = m->element_off[e]; i < m->element_off[e + 1]; i++) {
      const double *x = m->nodes + 3 * (LitheCount)m->element_node[i];
      sum += (i - m->element_off[e] + 1) * (x[0] + 2 * x[1] + 3 * x[2]);
    }
  }
  return sum;
}

static LitheStatus print_file(LitheCtx *ctx, const char *path) {
  LthElementMesh *e = NULL;
  LthMesh *m = NULL;
  LthMeshQuality q;
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, lth_mesh_file_read(ctx, path, 1, &e));
  LITHE_TRY_OR(done, lth_mesh_from_elements(ctx, e, path, &m));
  LITHE_TRY_OR(done, lth_mesh_quality(ctx, m, &q));
  printf("{\"nodes\": %d, \"elements\": %d, \"volume\": %.17g, \"area\": %.17g, \"inner\": %d, "
         "\"boundary\": %d, \"parts\": %d, \"order\": %.17g",
         e->n_nodes, e->n_elements, q.volume, q.surface_area, q.n_inner_faces, q.n_boundary_faces,
         q.n_components, order_sum(e));
  print_groups(e, m);
  printf("}\n");
done:
  if (status != LITHE_OK) printf("{\"error\": \"%s\"}\n", lithe_ctx_message(ctx));
  lth_mesh_destroy(ctx, &m);
  lth_element_mesh_destroy(ctx, &e);
  return status;
}

int main(int argc, char **argv) {
  int n_failed = 0;
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = 1;
  LitheCtx *ctx = lithe_ctx_create(&def);
  for (int i = 1; i < argc; i++) n_failed += print_file(ctx, argv[i]) != LITHE_OK;
  if (lth_alloc_bytes(ctx) != 0)
    fprintf(stderr, "memory is left: %lld\n", (long long)lth_alloc_bytes(ctx));
  lithe_ctx_destroy(&ctx);
  return n_failed ? 2 : 0;
}

/// What the mesh fuzz targets share: parse, check, make polyhedra, free; nothing may leak.
#pragma once

#include "io/mesh_file.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

/// libFuzzer's entry; each target defines it.
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/// Larger meshes would only make the fuzzer slow.
#define FUZZ_ELEMENTS_MAX 2000

static inline void fuzz_check(bool condition) {
  if (!condition) abort();
}

/// Every index is one, groups ascend, and the polyhedra have volume.
static inline void fuzz_check_mesh(LitheCtx *ctx, const LthElementMesh *m) {
  LthMesh *mesh = NULL;
  fuzz_check(m->n_elements > 0 && m->n_nodes >= 4 && m->element_off[0] == 0);
  for (LitheIndex k = 0; k < m->element_off[m->n_elements]; k++)
    fuzz_check(m->element_node[k] >= 0 && m->element_node[k] < m->n_nodes);
  for (LitheIndex g = 0; g < m->n_groups; g++) {
    const LthElementGroup *group = &m->groups[g];
    LitheIndex end = group->of == LTH_GROUP_NODES   ? m->n_nodes
                     : group->of == LTH_GROUP_FACES ? 8 * m->n_elements
                                                    : m->n_elements;
    for (LitheIndex i = 0; i < group->n; i++)
      fuzz_check(group->member[i] >= (i ? group->member[i - 1] + 1 : 0) && group->member[i] < end);
  }
  if (lth_mesh_from_elements(ctx, m, "fuzz", &mesh) == LITHE_OK) {
    fuzz_check(mesh->n_cells == m->n_elements);
    for (LitheIndex c = 0; c < mesh->n_cells; c++) fuzz_check(mesh->cell_volume[c] > 0);
  } else {
    fuzz_check(lithe_ctx_message(ctx)[0] != 0);
  }
  lth_mesh_destroy(ctx, &mesh);
}

static inline int fuzz_mesh(const char *format, const uint8_t *data, size_t size) {
  LitheCtxDef def = lithe_ctx_def_default();
  def.threads = 1;
  LitheCtx *ctx = lithe_ctx_create(&def);
  LthElementMesh *mesh = NULL;
  LitheStatus status = lth_mesh_file_parse(ctx, "fuzz", format, data, size, 1, &mesh);
  if (status != LITHE_OK) fuzz_check(!mesh && lithe_ctx_message(ctx)[0] != 0);
  if (status == LITHE_OK && mesh->n_elements <= FUZZ_ELEMENTS_MAX) fuzz_check_mesh(ctx, mesh);
  lth_element_mesh_destroy(ctx, &mesh);
  fuzz_check(lth_alloc_bytes(ctx) == 0);
  lithe_ctx_destroy(&ctx);
  return 0;
}

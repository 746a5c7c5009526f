/// Edges between points of cut faces, by faces.
#include "mesh/cut_edges.h"

#include "mesh/topology.h"

#include <stdlib.h>

bool lth_is_cut_face(const LthMesh *m, LitheIndex face) {
  return m->face_cell[2 * (size_t)face + 1] < 0 && m->face_tag[face] <= LTH_TAG_CUT;
}

static int compare_edges(const void *a, const void *b) {
  const LthCutEdge *p = a, *q = b;
  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  return (p->face > q->face) - (p->face < q->face);
}

/// Points of cut faces; false where there are none.
static bool mark_points(const LthMesh *m, bool *is_at_cut) {
  bool any = false;
  for (LitheIndex f = 0; f < m->n_faces; f++) {
    if (!lth_is_cut_face(m, f)) continue;
    any = true;
    LthFaceView v = lth_mesh_face(m, f);
    for (LitheIndex k = v.loop_off[0]; k < v.loop_off[v.n_loops]; k++)
      is_at_cut[v.loop_point[k]] = true;
  }
  return any;
}

static LitheStatus add_edges(LitheCtx *ctx, const LthMesh *m, LitheIndex face,
                             const bool *is_at_cut, LthCutEdge **edges, LitheCount *n,
                             LitheCount *cap) {
  LthFaceView v = lth_mesh_face(m, face);
  for (LitheIndex l = 0; l < v.n_loops; l++)
    for (LitheIndex k = v.loop_off[l]; k < v.loop_off[l + 1]; k++) {
      LitheIndex p = v.loop_point[k],
                 q = v.loop_point[k + 1 < v.loop_off[l + 1] ? k + 1 : v.loop_off[l]];
      if (!is_at_cut[p] || !is_at_cut[q]) continue;
      LTH_RESERVE(ctx, *edges, *cap, *n + 1);
      (*edges)[(*n)++] = (LthCutEdge){p < q ? p : q, p < q ? q : p, face};
    }
  return LITHE_OK;
}

LitheStatus lth_list_cut_edges(LitheCtx *ctx, const LthMesh *m, bool of_boundary,
                               LthCutEdge **edges, LitheCount *n) {
  LitheStatus status = LITHE_OK;
  LitheCount cap = 0;
  bool *is_at_cut = NULL;
  LTH_NEW_OR(done, ctx, is_at_cut, m->n_points);
  if (!mark_points(m, is_at_cut)) goto done;
  for (LitheIndex f = 0; f < m->n_faces; f++)
    if (!of_boundary || m->face_cell[2 * (size_t)f + 1] < 0)
      LITHE_TRY_OR(done, add_edges(ctx, m, f, is_at_cut, edges, n, &cap));
  if (*n > 0) qsort(*edges, (size_t)*n, sizeof **edges, compare_edges);
done:
  lth_free(ctx, is_at_cut);
  return status;
}

LitheCount lth_cut_edge_end(const LthCutEdge *edges, LitheCount first, LitheCount n) {
  LitheCount end = first + 1;
  while (end < n && edges[end].low == edges[first].low && edges[end].high == edges[first].high)
    end++;
  return end;
}

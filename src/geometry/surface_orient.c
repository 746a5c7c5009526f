/// Making triangles agree in orientation by flooding over edges, and finding shells.
#include "geometry/surface_clean.h"

typedef struct Flood {
  LthCleaner *c;
  bool *is_turned;    ///< against the file                     (n_tris)
  LitheIndex *stack;  ///< triangles still to visit             (n_tris)
  LitheIndex *member; ///< triangles of the present shell       (n_tris)
  LitheIndex n_stack, n_member, n_turned;
  LitheIndex bad_edge; ///< where the present shell contradicts itself, -1 nowhere
} Flood;

static void visit(Flood *f, LitheIndex tri, bool is_turned) {
  f->c->tri_shell[tri] = f->c->n_shells;
  f->is_turned[tri] = is_turned;
  f->n_turned += is_turned;
  f->member[f->n_member++] = tri;
  f->stack[f->n_stack++] = tri;
}

/// Two triangles agree where they run through their common edge in opposite directions.
static void cross_edge(Flood *f, LitheIndex tri, LitheIndex half) {
  LthCleaner *c = f->c;
  LitheIndex edge = c->half_edge[half], first = c->edge_off[edge];
  if (c->edge_off[edge + 1] - first != 2) return;
  LitheIndex other = c->edge_half[first] == half ? c->edge_half[first + 1] : c->edge_half[first];
  LitheIndex next = other / 3;
  bool agree = lth_clean_from(c, half) == lth_clean_to(c, other);
  bool is_turned = f->is_turned[tri] == agree;
  if (c->tri_shell[next] < 0)
    visit(f, next, is_turned);
  else if (f->is_turned[next] != is_turned && f->bad_edge < 0)
    f->bad_edge = edge;
}

/// Flood one shell from a triangle; the orientation of most of its triangles stands.
static LitheStatus flood_shell(Flood *f, LitheIndex seed, LitheIndex *n_turned_all) {
  LthCleaner *c = f->c;
  f->n_stack = f->n_member = f->n_turned = 0;
  f->bad_edge = -1;
  visit(f, seed, false);
  while (f->n_stack > 0) {
    LitheIndex tri = f->stack[--f->n_stack];
    for (LitheIndex k = 0; k < 3; k++) cross_edge(f, tri, 3 * tri + k);
  }
  c->n_shells++;

  bool turn_others = f->n_turned > f->n_member / 2;
  *n_turned_all += turn_others ? f->n_member - f->n_turned : f->n_turned;
  for (LitheIndex i = 0; i < f->n_member; i++) {
    LitheIndex t = f->member[i];
    if (f->n_turned > 0) c->tri_is_mixed[t] = true;
    f->is_turned[t] = f->is_turned[t] != turn_others;
  }
  if (f->bad_edge < 0) return LITHE_OK;
  LitheIndex half = c->edge_half[c->edge_off[f->bad_edge]];
  return lth_defects_add(c->ctx, c->defects, LTH_DEFECT_UNORIENTABLE,
                         lth_clean_point(c, lth_clean_from(c, half)),
                         lth_clean_point(c, lth_clean_to(c, half)));
}

/// Turning a triangle moves its half-edges, so the edges are found again.
static LitheStatus apply_turns(LthCleaner *c, const bool *is_turned, LitheIndex n_turned) {
  if (n_turned == 0) return LITHE_OK;
  for (LitheIndex t = 0; t < c->n_tris; t++) {
    if (!is_turned[t]) continue;
    LitheIndex *p = c->tris + 3 * (size_t)t, keep = p[1];
    p[1] = p[2];
    p[2] = keep;
  }
  return lth_clean_edges(c);
}

LitheStatus lth_clean_orient(LthCleaner *c) {
  LitheStatus status = LITHE_OK;
  Flood flood = {.c = c};
  LitheIndex n_turned = 0;
  LTH_NEW_OR(done, c->ctx, flood.is_turned, c->n_tris);
  LTH_NEW_OR(done, c->ctx, flood.stack, c->n_tris);
  LTH_NEW_OR(done, c->ctx, flood.member, c->n_tris);
  for (LitheIndex t = 0; t < c->n_tris; t++) c->tri_shell[t] = -1;
  c->n_shells = 0;
  for (LitheIndex t = 0; t < c->n_tris; t++)
    if (c->tri_shell[t] < 0) LITHE_TRY_OR(done, flood_shell(&flood, t, &n_turned));
  if (n_turned)
    lth_warn(c->ctx, "%s: %d triangles turned over to agree with their neighbours", c->name,
             n_turned);
  LITHE_TRY_OR(done, apply_turns(c, flood.is_turned, n_turned));
done:
  lth_free(c->ctx, flood.is_turned);
  lth_free(c->ctx, flood.stack);
  lth_free(c->ctx, flood.member);
  return status;
}

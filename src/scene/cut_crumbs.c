/// Crumbs: pieces that cuts leave behind, so small or thin that arithmetic cannot carry them. Thin elements are merged, with
/// any `sliver`; what has nothing to merge with is taken away.
#include "scene/cut_priv.h"

#include <math.h>

/// A piece is what hangs together by faces across which it may be merged. It is a crumb below LTH_CRUMB_VOLUME, or where all its elements are thinner (volume over area) than
/// this share of its size: their corners are off by rounding, and integrals over them need its fourth power.
#define CRUMB_THICKNESS 1e-9

/// Or thinner than this share of the way of a wave in a time step, for degree 1 (gradients grow with k (k + 1)): the inertia of
/// the piece is rounding of its stiffness over the step then, and no method finds the matrix definite.
#define CRUMB_WAVE 1e-8
/// That is no reason to take away what is thicker than this share of the body.
#define CRUMB_WAVE_THICKNESS 1e-5

enum { UNSEEN, HERE, STAYS, GOES };

/// A search for crumbs in one body.
typedef struct Sweep {
  const LthBody *body;
  const LthTopology *t;
  uint8_t *seen;            ///< by record                               (n_cells)
  LitheIndex *piece, *gone; ///< cells of the piece in hand, and of crumbs (n_cells)
  LitheIndex n_piece, n_gone;
  double volume; ///< of the piece in hand
  bool is_thin;
} Sweep;

/// Largest speed of a wave that the body's materials have at a place [m/s].
static double wave_speed(const LthBody *body, const double at[3]) {
  double most = 0;
  for (LitheIndex i = 0; i < body->def->n_materials; i++) {
    const LthMaterial *m = &body->def->materials[i].material;
    double E = lth_value_at(&m->young, at, 0), nu = lth_value_at(&m->poisson, at, 0);
    double c2 = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / lth_value_at(&m->density, at, 0);
    if (c2 > 0 && isfinite(c2)) most = fmax(most, sqrt(c2));
  }
  return most;
}

/// Records that are new have the degree of what they were parts of.
static int degree_of(const LthBody *body, LitheIndex cell) {
  LitheIndex before = lth_topology_before(body->change->topology, cell);
  return before >= 0 && body->change->degree[before] > 0 ? body->change->degree[before]
                                                         : LTH_DG_MAX_DEGREE;
}

static bool is_thin(const LthBody *body, LitheIndex cell) {
  const LthTopology *t = body->change->topology;
  const LthTopologyCell *c = t->cells + cell;
  const LthScene *scene = body->scene;
  double size = cbrt(t->volume), least = CRUMB_THICKNESS * size;
  if (!(c->volume < CRUMB_WAVE_THICKNESS * size * c->area)) return false;
  if (scene->time_kind == LTH_TIME_DYNAMIC) {
    int k = degree_of(body, cell);
    double way = scene->step * wave_speed(body, c->centroid);
    least = fmax(least, fmin(CRUMB_WAVE * k * (k + 1) / 2 * way, CRUMB_WAVE_THICKNESS * size));
  }
  return c->volume < least * c->area;
}

/// The cell beyond face k of a cell, -1: none.
static LitheIndex across_of(const LthTopology *t, LitheIndex cell, LitheIndex k) {
  const LthTopologyFace *f = t->faces + lth_topology_cell_faces(t, cell)[k];
  return f->cell[f->cell[0] == cell];
}

/// Add a cell to the piece in hand; false where that is no crumb for it.
static bool add(Sweep *s, LitheIndex cell) {
  if (s->seen[cell] == STAYS) return false;
  if (s->seen[cell] == HERE) return true;
  s->seen[cell] = HERE;
  s->piece[s->n_piece++] = cell;
  s->volume += s->t->cells[cell].volume;
  s->is_thin = s->is_thin && is_thin(s->body, cell);
  return s->is_thin || s->volume < LTH_CRUMB_VOLUME * s->t->volume;
}

static bool is_crumb(Sweep *s, LitheIndex first) {
  s->n_piece = 0;
  s->volume = 0;
  s->is_thin = true;
  if (!add(s, first)) return false;
  for (LitheIndex i = 0; i < s->n_piece; i++) {
    LitheIndex cell = s->piece[i];
    for (LitheIndex k = 0; k < s->t->cells[cell].n_faces; k++) {
      LitheIndex across = across_of(s->t, cell, k);
      bool joins = across >= 0 && s->seen[across] != HERE;
      if (joins && lth_topology_may_merge(s->t, cell, across) && !add(s, across)) return false;
    }
  }
  return true;
}

/// Pieces of which something is new.
static void find_crumbs(Sweep *s) {
  const LthTopologyLog *log = &s->t->log;
  for (LitheIndex i = 0; i < log->n_births; i++) {
    LitheIndex cell = log->births[i].cell;
    if (!s->t->cells[cell].is_live || s->seen[cell] != UNSEEN) continue;
    bool goes = is_crumb(s, cell);
    for (LitheIndex k = 0; k < s->n_piece; k++) {
      s->seen[s->piece[k]] = goes ? GOES : STAYS;
      if (goes) s->gone[s->n_gone++] = s->piece[k];
    }
  }
}

/// Crumbs may still share faces with what stays, where a cut ends beside them.
static LitheStatus part_crumbs(LitheCtx *ctx, LthTopology *t, const Sweep *s, LitheIndex tag) {
  for (LitheIndex i = 0; i < s->n_gone; i++)
    for (LitheIndex k = 0; k < t->cells[s->gone[i]].n_faces;) {
      LitheIndex across = across_of(t, s->gone[i], k);
      if (across >= 0 && s->seen[across] != GOES)
        LITHE_TRY(lth_topology_separate(ctx, t, lth_topology_cell_faces(t, s->gone[i])[k], tag,
                                        NULL)); // another takes its place
      else
        k++;
    }
  return LITHE_OK;
}

/// Merge thin elements once; two that became one may be thin still.
static LitheStatus merge_round(LitheCtx *ctx, LthBody *body, LitheIndex *n_merged) {
  LthTopology *t = body->change->topology;
  LitheIndex *thin = NULL, n = 0;
  double most = 0;
  *n_merged = 0;
  LTH_NEW(ctx, thin, t->log.n_births);
  for (LitheIndex i = 0; i < t->log.n_births; i++) {
    LitheIndex cell = t->log.births[i].cell;
    if (!t->cells[cell].is_live || !is_thin(body, cell)) continue;
    thin[n++] = cell;
    most = fmax(most, t->cells[cell].volume);
  }
  LitheStatus status = LITHE_OK;
  if (n > 0 && !body->change->atoms) status = lth_body_change_hold(ctx, body);
  if (n > 0 && status == LITHE_OK)
    status = lth_topology_merge_slivers(ctx, t, n, thin, nextafter(most, INFINITY), n_merged);
  lth_free(ctx, thin);
  return status;
}

static LitheStatus sweep(LitheCtx *ctx, LthBody *body, LitheIndex *n_removed) {
  LthTopology *t = body->change->topology;
  Sweep s = {.body = body, .t = t};
  LitheStatus status = LITHE_OK;
  LTH_NEW_OR(done, ctx, s.seen, t->n_cells);
  LTH_NEW_OR(done, ctx, s.piece, t->n_cells);
  LTH_NEW_OR(done, ctx, s.gone, t->n_cells);
  find_crumbs(&s);
  if (s.n_gone == 0 || s.n_gone == t->n_live_cells) goto done;
  LITHE_TRY_OR(done, part_crumbs(ctx, t, &s, LTH_TAG_CUT - (body->change->n_cuts - 1)));
  LITHE_TRY_OR(done, lth_topology_remove(ctx, t, s.n_gone, s.gone));
  *n_removed += s.n_gone;
done:
  lth_free(ctx, s.seen);
  lth_free(ctx, s.piece);
  lth_free(ctx, s.gone);
  return status;
}

// What was merged may keep others from being merged with it, for it has both sides of a cut then.
LitheStatus lth_cut_clear_crumbs(LitheCtx *ctx, LthBody *body, LitheIndex *n_merged,
                                 LitheIndex *n_removed) {
  LitheIndex n;
  LITHE_TRY(sweep(ctx, body, n_removed));
  do {
    LITHE_TRY(merge_round(ctx, body, &n));
    *n_merged += n;
  } while (n > 0);
  return sweep(ctx, body, n_removed);
}

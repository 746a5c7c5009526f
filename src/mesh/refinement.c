/// Dividing, merging back, and following what others do to the cells.
#include "mesh/refinement.h"

#include "base/tensor.h"

void lth_refinement_free(LitheCtx *ctx, LthRefinement *r) {
  lth_free(ctx, r->families);
  lth_free(ctx, r->family_of);
  *r = (LthRefinement){0};
}

/// Room for all records; new ones belong to no family.
static LitheStatus make_room(LitheCtx *ctx, LthRefinement *r, LitheIndex n) {
  LTH_RESERVE(ctx, r->family_of, r->cap_family_of, n);
  for (; r->n_records < n; r->n_records++) r->family_of[r->n_records] = -1;
  return LITHE_OK;
}

static LitheStatus add_family(LitheCtx *ctx, LthRefinement *r, const LthFamily *from,
                              LitheIndex *family) {
  LitheIndex f = r->free_family > 0 ? r->free_family - 1 : r->n_families;
  LTH_RESERVE(ctx, r->families, r->cap_families, f + 1);
  if (f == r->n_families)
    r->n_families++;
  else
    r->free_family = r->families[f].parent;
  r->families[f] = *from;
  if (from->parent >= 0) r->families[from->parent].n_within++;
  *family = f;
  return LITHE_OK;
}

/// Numbers of families that no cell and no other family knows are free again.
static void release(LthRefinement *r, LitheIndex f) {
  while (f >= 0 && r->families[f].n_alive == 0 && r->families[f].n_within == 0) {
    LitheIndex parent = r->families[f].parent;
    r->families[f] = (LthFamily){.parent = r->free_family};
    r->free_family = f + 1;
    if (parent >= 0) r->families[parent].n_within--;
    f = parent;
  }
}

static void leave(LthRefinement *r, LitheIndex record) {
  LitheIndex f = lth_refinement_family(r, record);
  if (f < 0) return;
  r->family_of[record] = -1;
  r->families[f].n_alive--;
  release(r, f);
}

static void join(LthRefinement *r, LitheIndex record, LitheIndex f) {
  r->family_of[record] = f;
  if (f >= 0) r->families[f].n_alive++;
}

LitheStatus lth_refinement_divide(LitheCtx *ctx, LthRefinement *r, LthTopology *t, LitheIndex cell,
                                  uint8_t level, LthDivision division, const double normal[3],
                                  LthSplit *split) {
  if (division == LTH_DIVIDE_EIGHT)
    LITHE_TRY(lth_topology_split_eight(ctx, t, cell, split));
  else
    LITHE_TRY(lth_topology_split_two(ctx, t, cell, normal, split));
  if (split->n == 0) return LITHE_OK;
  LITHE_TRY(make_room(ctx, r, t->n_cells));
  LthFamily from = {
      .volume = t->cells[cell].volume, .parent = lth_refinement_family(r, cell), .level = level};
  LitheIndex family;
  LITHE_TRY(add_family(ctx, r, &from, &family));
  for (LitheIndex i = split->first; i < t->log.n_births; i++) {
    LitheIndex part = t->log.births[i].cell;
    if (!t->cells[part].is_live) continue;
    join(r, part, family);
    r->families[family].n++;
  }
  leave(r, cell);
  return LITHE_OK;
}

/// The sibling that a cell shares most of its surface with, -1: none.
static LitheIndex nearest_sibling(const LthRefinement *r, const LthTopology *t, LitheIndex cell) {
  LitheIndex best = -1, family = lth_refinement_family(r, cell);
  double most = 0;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    const LthTopologyFace *f = t->faces + lth_topology_cell_faces(t, cell)[i];
    LitheIndex across = f->cell[f->cell[0] == cell];
    if (across < 0 || f->is_line || lth_refinement_family(r, across) != family) continue;
    double common = 0;
    for (LitheIndex k = 0; k < t->cells[cell].n_faces; k++) {
      const LthTopologyFace *g = t->faces + lth_topology_cell_faces(t, cell)[k];
      if (!g->is_line && g->cell[g->cell[0] == cell] == across) common += g->area;
    }
    if (common > most && lth_topology_may_merge(t, cell, across)) most = common, best = across;
  }
  return best;
}

/// Two parts of a family become one of its parts.
static LitheStatus unite(LitheCtx *ctx, LthRefinement *r, LthTopology *t, LitheIndex a,
                         LitheIndex b, LitheIndex *merged) {
  LitheIndex family = lth_refinement_family(r, a);
  LITHE_TRY(lth_topology_merge(ctx, t, a, b, merged));
  LITHE_TRY(make_room(ctx, r, t->n_cells));
  join(r, *merged, family);
  leave(r, a);
  leave(r, b);
  r->families[family].n--;
  return LITHE_OK;
}

LitheStatus lth_refinement_merge_slivers(LitheCtx *ctx, LthRefinement *r, LthTopology *t,
                                         LitheIndex first, LthDivision division, double share,
                                         LitheIndex *n_merged) {
  LitheIndex last = t->log.n_births;
  double even = division == LTH_DIVIDE_EIGHT ? 0.125 : 0.5;
  *n_merged = 0;
  for (LitheIndex i = first; i < last; i++) {
    LitheIndex cell = t->log.births[i].cell, merged = -1;
    LitheIndex family = lth_refinement_family(r, cell);
    if (family < 0 || !t->cells[cell].is_live || r->families[family].n < 3 ||
        t->cells[cell].volume >= share * even * r->families[family].volume)
      continue;
    LitheIndex sibling = nearest_sibling(r, t, cell);
    if (sibling < 0) continue;
    LITHE_TRY(unite(ctx, r, t, cell, sibling, &merged));
    ++*n_merged;
  }
  return LITHE_OK;
}

/// Two cells have a common face.
static bool touches(const LthTopology *t, LitheIndex a, LitheIndex b) {
  for (LitheIndex i = 0; i < t->cells[a].n_faces; i++) {
    const LthTopologyFace *f = t->faces + lth_topology_cell_faces(t, a)[i];
    if (!f->is_line && f->cell[f->cell[0] == a] == b) return true;
  }
  return false;
}

LitheStatus lth_refinement_may_merge(LitheCtx *ctx, const LthRefinement *r, const LthTopology *t,
                                     const LitheIndex *cells, LitheIndex n, bool *may) {
  LitheIndex family = n > 0 ? lth_refinement_family(r, cells[0]) : -1, n_reached = 1;
  LitheIndex *reached = NULL;
  *may = family >= 0 && r->families[family].n_alive == n && r->families[family].n == n && n > 1;
  for (LitheIndex i = 0; *may && i < n; i++)
    for (LitheIndex j = 0; *may && j < i; j++)
      *may = !touches(t, cells[i], cells[j]) || lth_topology_may_merge(t, cells[i], cells[j]);
  if (!*may) return LITHE_OK;

  // all of them hang together through common faces
  LTH_NEW(ctx, reached, n);
  reached[0] = 1;
  for (LitheIndex round = 0; round < n; round++)
    for (LitheIndex i = 0; i < n; i++)
      for (LitheIndex j = 0; j < n && !reached[i]; j++)
        if (reached[j] && touches(t, cells[i], cells[j])) reached[i] = 1, n_reached++;
  lth_free(ctx, reached);
  *may = n_reached == n;
  return LITHE_OK;
}

LitheStatus lth_refinement_merge(LitheCtx *ctx, LthRefinement *r, LthTopology *t, LitheIndex family,
                                 const LitheIndex *cells, LitheIndex *merged) {
  LitheIndex n = r->families[family].n, parent = r->families[family].parent;
  *merged = cells[0];
  for (LitheIndex left = n - 1; left > 0; left--) {
    LitheIndex next = -1;
    for (LitheIndex i = 1; i < n && next < 0; i++)
      if (t->cells[cells[i]].is_live && cells[i] != *merged &&
          lth_topology_may_merge(t, *merged, cells[i]))
        next = cells[i];
    if (next < 0) return LITHE_OK; // a cut keeps the rest apart: what is merged stays a part
    LITHE_TRY(unite(ctx, r, t, *merged, next, merged));
  }

  // the parent is kept while it has no member yet
  if (parent >= 0) r->families[parent].n_within++;
  leave(r, *merged);
  if (parent >= 0) r->families[parent].n_within--;
  if (parent >= 0) join(r, *merged, parent);
  return LITHE_OK;
}

LitheStatus lth_refinement_follow(LitheCtx *ctx, LthRefinement *r, const LthTopology *t) {
  LITHE_TRY(make_room(ctx, r, t->n_cells));
  for (LitheIndex i = 0; i < t->log.n_dead_cells; i++) leave(r, t->log.dead_cells[i]);
  return LITHE_OK;
}

LitheStatus lth_refinement_list(LitheCtx *ctx, const LthRefinement *r, const LthTopology *t,
                                LitheIndex **off, LitheIndex **list) {
  *off = *list = NULL;
  LTH_NEW(ctx, *off, (LitheCount)r->n_families + 2);
  LTH_NEW(ctx, *list, r->n_records);
  for (LitheIndex c = 0; c < r->n_records; c++) {
    LitheIndex f = r->family_of[c];
    if (f >= 0 && t->cells[c].is_live && r->families[f].n_alive == r->families[f].n)
      (*off)[f + 2]++;
  }
  for (LitheIndex f = 0; f < r->n_families; f++) (*off)[f + 2] += (*off)[f + 1];
  for (LitheIndex c = 0; c < r->n_records; c++) {
    LitheIndex f = r->family_of[c];
    if (f >= 0 && t->cells[c].is_live && r->families[f].n_alive == r->families[f].n)
      (*list)[(*off)[f + 1]++] = c;
  }
  return LITHE_OK;
}

static LitheStatus take_lengths(LitheCtx *ctx, LthRefinement *r, LitheCount n, LitheCount m) {
  LTH_RESERVE(ctx, r->families, r->cap_families, n);
  LTH_RESERVE(ctx, r->family_of, r->cap_family_of, m);
  r->n_families = (LitheIndex)n, r->n_records = (LitheIndex)m;
  return LITHE_OK;
}

void lth_refinement_archive(LitheCtx *ctx, LthRefinement *r, LthArchive *archive) {
  LitheCount n = r->n_families, m = r->n_records;
  lth_archive_mark(archive, "refinement");
  lth_archive_count(archive, &n);
  lth_archive_count(archive, &m);
  if (archive->status == LITHE_OK && archive->is_reading)
    archive->status = take_lengths(ctx, r, n, m);
  if (archive->status != LITHE_OK) return;
  LTH_ARCHIVE(archive, r->free_family);
  LTH_ARCHIVE_ARRAY(archive, r->families, n);
  LTH_ARCHIVE_ARRAY(archive, r->family_of, m);
}

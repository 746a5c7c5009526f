/// Following a change: the touched elements and their neighbours as a mesh of their own, what is new in it integrated, and the
/// rows of the touched ones written in place.
#include "disc/dg/dg_live_priv.h"

#include "base/order.h"

#include <stdlib.h>

struct LthDgLive {
  LthDgLiveDef def;
  LthDgStore *store;
  LthDgLiveRows matrix;
  LthBlockMatrix *lent;
  uint64_t lent_revision;
  // elements by record: 2 stamp where they are in the patch in hand, 2 stamp + 1 where they are touched
  uint32_t stamp, *mark;
  LitheCount mark_cap;
  LitheIndex *list; ///< records of the patch
  LitheCount list_cap;
  LitheIndex n_list;
};

/// The elements in hand.
typedef struct Patch {
  LthMesh *mesh;
  LitheIndex *cell, *face; ///< records
  bool *is_rim;
  uint8_t *degree;
  double *young, *poisson;
  LthDgSpace *space;
  LthDgOperator *op;
  LthDgRecords records;
} Patch;

static void free_patch(LitheCtx *ctx, Patch *p) {
  lth_dg_operator_destroy(ctx, &p->op);
  lth_dg_space_destroy(ctx, &p->space);
  lth_mesh_destroy(ctx, &p->mesh);
  void *blocks[] = {p->cell, p->face, p->is_rim, p->degree, p->young, p->poisson};
  for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) lth_free(ctx, blocks[i]);
}

// --- which elements ---

static LitheStatus begin_list(LitheCtx *ctx, LthDgLive *live) {
  LTH_RESERVE(ctx, live->mark, live->mark_cap, live->def.topology->n_cells);
  live->stamp++;
  live->n_list = 0;
  return LITHE_OK;
}

/// Put an element on the list, once.
static LitheStatus list_cell(LitheCtx *ctx, LthDgLive *live, LitheIndex cell, bool is_touched) {
  const LthTopology *t = live->def.topology;
  if (cell < 0 || !t->cells[cell].is_live || live->mark[cell] >= 2 * live->stamp) return LITHE_OK;
  live->mark[cell] = 2 * live->stamp + is_touched;
  LTH_RESERVE(ctx, live->list, live->list_cap, (LitheCount)live->n_list + 1);
  live->list[live->n_list++] = cell;
  return LITHE_OK;
}

static LitheStatus list_neighbours(LitheCtx *ctx, LthDgLive *live, LitheIndex cell,
                                   bool is_touched) {
  const LthTopology *t = live->def.topology;
  for (LitheIndex i = 0; i < t->cells[cell].n_faces; i++) {
    const LthTopologyFace *f = t->faces + lth_topology_cell_faces(t, cell)[i];
    if (!f->is_line) LITHE_TRY(list_cell(ctx, live, f->cell[f->cell[0] == cell], is_touched));
  }
  return LITHE_OK;
}

/// Births, changed elements and neighbours of births, then the neighbours of all these; by record.
static LitheStatus list_touched(LitheCtx *ctx, LthDgLive *live, LthDgLiveReport *report) {
  const LthTopologyLog *log = &live->def.topology->log;
  LITHE_TRY(begin_list(ctx, live));
  for (LitheIndex i = 0; i < log->n_births; i++)
    LITHE_TRY(list_cell(ctx, live, log->births[i].cell, true));
  report->n_births = live->n_list;
  for (LitheIndex i = 0; i < log->n_changed_cells; i++)
    LITHE_TRY(list_cell(ctx, live, log->changed_cells[i], true));
  for (LitheIndex i = 0; i < report->n_births; i++)
    LITHE_TRY(list_neighbours(ctx, live, live->list[i], true));
  report->n_touched = live->n_list;
  for (LitheIndex i = 0; i < report->n_touched; i++)
    LITHE_TRY(list_neighbours(ctx, live, live->list[i], false));
  report->n_rim = live->n_list - report->n_touched;
  qsort(live->list, (size_t)live->n_list, sizeof *live->list, lth_compare_index);
  return LITHE_OK;
}

static LitheStatus list_all(LitheCtx *ctx, LthDgLive *live, LthDgLiveReport *report) {
  LITHE_TRY(begin_list(ctx, live));
  for (LitheIndex c = 0; c < live->def.topology->n_cells; c++)
    LITHE_TRY(list_cell(ctx, live, c, true));
  report->n_births = report->n_touched = live->n_list;
  return LITHE_OK;
}

// --- integration ---

static LitheStatus set_constants(LitheCtx *ctx, const LthDgLive *live, Patch *p) {
  const LthDgLiveDef *def = &live->def;
  LTH_NEW(ctx, p->is_rim, p->mesh->n_cells);
  LTH_NEW(ctx, p->degree, p->mesh->n_cells);
  LTH_NEW(ctx, p->young, p->mesh->n_cells);
  LTH_NEW(ctx, p->poisson, p->mesh->n_cells);
  for (LitheIndex c = 0; c < p->mesh->n_cells; c++) {
    LitheIndex source = def->topology->cells[p->cell[c]].source;
    p->is_rim[c] = live->mark[p->cell[c]] == 2 * live->stamp;
    p->degree[c] = def->cell_degree ? def->cell_degree[source] : (uint8_t)def->degree;
    p->young[c] = def->young[source];
    p->poisson[c] = def->poisson[source];
  }
  return LITHE_OK;
}

static LitheStatus integrate(LitheCtx *ctx, const LthDgLive *live, Patch *p) {
  const LthDgLiveDef *def = &live->def;
  LITHE_TRY(set_constants(ctx, live, p));
  p->records = (LthDgRecords){live->store, p->cell, p->face, p->is_rim};
  LITHE_TRY(lth_dg_space_create_kept(ctx, p->mesh, 0, p->degree, &p->records, &p->space));
  LthDgOperatorDef op = {.space = p->space,
                         .young = p->young,
                         .poisson = p->poisson,
                         .flux = def->flux,
                         .penalty = def->penalty,
                         .eta = def->eta,
                         .records = &p->records};
  if (def->constrain)
    LITHE_TRY(def->constrain(ctx, def->constrain_self, p->mesh, p->face, &op.weak, &op.n_weak));
  return lth_dg_operator_create(ctx, &op, &p->op);
}

// --- assembly ---

/// The pattern: rows of the dead go, those of the touched become what their faces say.
static LitheStatus place_rows(LitheCtx *ctx, LthDgLive *live, const Patch *p) {
  LthDgLiveRows *m = &live->matrix;
  const LthTopologyLog *log = &live->def.topology->log;
  for (LitheIndex i = 0; i < log->n_dead_cells; i++)
    LITHE_TRY(lth_dg_live_rows_close(ctx, m, log->dead_cells[i]));
  for (LitheIndex c = 0; c < p->mesh->n_cells; c++)
    if (!p->is_rim[c])
      LITHE_TRY(lth_dg_live_rows_open(ctx, m, p->cell[c], lth_dg_funcs(p->space, c)));
  for (LitheIndex f = 0; f < p->op->n_faces; f = lth_dg_next_pair(p->op, f))
    if (!p->is_rim[p->op->faces[f].cell[0]] || !p->is_rim[p->op->faces[f].cell[1]])
      LITHE_TRY(lth_dg_live_rows_place(ctx, m, &p->records, p->op, f, live->stamp));
  for (LitheIndex c = 0; c < p->mesh->n_cells; c++)
    if (!p->is_rim[c]) LITHE_TRY(lth_dg_live_rows_drop(ctx, m, p->cell[c], live->stamp));
  return lth_dg_live_rows_grow(ctx, m);
}

/// The diagonal block and the load of a touched cell.
static LitheCount write_cell(LthDgLive *live, const Patch *p, LitheIndex c, double t) {
  LthDgLiveRows *m = &live->matrix;
  LitheIndex record = p->cell[c];
  LthDgLiveBlock *block = lth_dg_live_rows_find(m, record, record);
  uint64_t made_of = live->store->cells[record].made_of; // of its matrix, and so of the block
  lth_dg_assemble_cell_load(p->op, c, t, m->load + 3 * (LitheCount)m->rows[record].func);
  if (!block->is_stale && block->made_of == made_of) return 0;
  lth_dg_assemble_diagonal(p->op, c, m->values + block->at);
  block->made_of = made_of;
  block->is_stale = false;
  return 1;
}

static LitheCount write_pair(LthDgLive *live, const Patch *p, LitheIndex f) {
  LthDgLiveRows *m = &live->matrix;
  const LthDgFace *face = p->op->faces + f;
  LitheIndex a = p->cell[face->cell[0]], b = p->cell[face->cell[1]];
  LthDgLiveBlock *block = lth_dg_live_rows_find(m, a, b), *mirror = lth_dg_live_rows_find(m, b, a);
  if (!block || !block->is_stale) return 0;
  lth_dg_assemble_pair(p->op, f, m->values + block->at, m->values + mirror->at);
  block->is_stale = mirror->is_stale = false;
  return 2;
}

/// Rows of the touched; `*n` counts the blocks that are written.
static LitheStatus assemble(LitheCtx *ctx, LthDgLive *live, const Patch *p, double t,
                            LitheCount *n) {
  LITHE_TRY(place_rows(ctx, live, p));
  LitheCount written = 0;
#pragma omp parallel for schedule(static) num_threads(lth_threads(ctx)) reduction(+ : written)
  for (LitheIndex c = 0; c < p->mesh->n_cells; c++) {
    if (!p->is_rim[c]) written += write_cell(live, p, c, t);
    LitheIndex end = p->op->own_face_off[c + 1];
    for (LitheIndex f = p->op->own_face_off[c]; f < end; f = lth_dg_next_pair(p->op, f))
      written += write_pair(live, p, f);
  }
  *n = written;
  return LITHE_OK;
}

/// Do the elements on the list.
static LitheStatus renew(LitheCtx *ctx, LthDgLive *live, double t, LthDgLiveReport *report) {
  LitheStatus status = LITHE_OK;
  Patch p = {0};
  LthDgStoreCount before = live->store->count;
  double start = lth_now();
  LITHE_TRY_OR(done, lth_topology_mesh(ctx, live->def.topology, live->n_list, live->list, &p.mesh,
                                       &p.cell, &p.face));
  double meshed = lth_now();
  LITHE_TRY_OR(done, integrate(ctx, live, &p));
  double integrated = lth_now();
  LITHE_TRY_OR(done, assemble(ctx, live, &p, t, &report->n_blocks));
  LITHE_TRY_OR(done, lth_dg_store_forget(ctx, live->store, live->def.topology));
  LITHE_TRY_OR(done, lth_dg_store_settle(ctx, live->store));
  report->n_bases = live->store->count.bases - before.bases;
  report->n_faces = live->store->count.faces - before.faces;
  report->n_matrices = live->store->count.matrices - before.matrices;
  report->patch += meshed - start;
  report->integration = integrated - meshed;
  report->assembly = lth_now() - integrated;
done:
  free_patch(ctx, &p);
  return status;
}

LitheStatus lth_dg_live_create(LitheCtx *ctx, const LthDgLiveDef *def, double t, LthDgLive **out) {
  LitheStatus status = LITHE_OK;
  LthDgLive *live = NULL;
  LthDgLiveReport report = {0};
  *out = NULL;
  LTH_NEW_OR(done, ctx, live, 1);
  live->def = *def;
  LITHE_TRY_OR(done, lth_dg_store_create(ctx, &live->store));
  LITHE_TRY_OR(done, list_all(ctx, live, &report));
  LITHE_TRY_OR(done, renew(ctx, live, t, &report));
  *out = live;
  live = NULL;
done:
  lth_dg_live_destroy(ctx, &live);
  return status;
}

void lth_dg_live_destroy(LitheCtx *ctx, LthDgLive **out) {
  LthDgLive *live = *out;
  if (!live) return;
  lth_block_matrix_destroy(ctx, &live->lent);
  lth_dg_live_rows_free(ctx, &live->matrix);
  lth_dg_store_destroy(ctx, &live->store);
  lth_free(ctx, live->mark);
  lth_free(ctx, live->list);
  lth_free(ctx, live);
  *out = NULL;
}

LitheStatus lth_dg_live_follow(LitheCtx *ctx, LthDgLive *live, double t, LthDgLiveReport *report) {
  LthDgLiveReport own = {0};
  double start = lth_now();
  LITHE_TRY(list_touched(ctx, live, &own));
  own.patch = lth_now() - start;
  LITHE_TRY(renew(ctx, live, t, &own));
  if (report) *report = own;
  return LITHE_OK;
}

LitheIndex lth_dg_live_func(const LthDgLive *live, LitheIndex record) {
  return live->matrix.rows[record].func;
}

LitheIndex lth_dg_live_n_funcs(const LthDgLive *live) {
  return (LitheIndex)live->matrix.func_rooms.end;
}

const double *lth_dg_live_block(const LthDgLive *live, LitheIndex row, LitheIndex col) {
  const LthDgLiveBlock *block = lth_dg_live_rows_find(&live->matrix, row, col);
  return block ? live->matrix.values + block->at : NULL;
}

const double *lth_dg_live_load(const LthDgLive *live) { return live->matrix.load; }

const LthDgStore *lth_dg_live_store(const LthDgLive *live) { return live->store; }

LitheStatus lth_dg_live_matrix(LitheCtx *ctx, LthDgLive *live, const LthBlockMatrix **matrix) {
  if (!live->lent || live->lent_revision != live->matrix.revision) {
    lth_block_matrix_destroy(ctx, &live->lent);
    LITHE_TRY(lth_dg_live_rows_matrix(ctx, &live->matrix, &live->lent));
    live->lent_revision = live->matrix.revision;
  }
  *matrix = live->lent;
  return LITHE_OK;
}

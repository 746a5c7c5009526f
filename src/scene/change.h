/// Bodies whose elements change while they are simulated: what their mesh has to do with the topology, and the renewal
/// of all that is built upon elements (docs/develop/topology.md, section 6).
///
/// A change goes one way: operations on the topology of one or more bodies, splits first, then, where something is to be
/// merged, lth_body_change_hold() and the merges, then lth_world_renew(), then the observers (lth_output_renew()).
#pragma once

#include "disc/dg/dg_kept.h"
#include "mesh/refinement.h"
#include "scene/world.h"

typedef struct LthCutSurface LthCutSurface; // cut_surface.h

/// A constraint, load or tie of whose boundary (nodes, elements) a change in the middle of a run left nothing.
typedef struct LthLoss {
  LitheIndex kind;  ///< 0: constraint, 1: load of the body, 2: tie of the scene
  LitheIndex index; ///< in that list
  double t;         ///< [s]
} LthLoss;

/// What a body with `cuts` or `adapt` has besides its mesh. Records are those of the topology; arrays by record
/// are as long as lth_body_change_inherit() made them.
struct LthBodyChange {
  LthTopology *topology;
  LthMesh
      *first; ///< the mesh that it began with: groups and sources; the body's mesh until a change
  LitheIndex n_cuts; ///< numbers of cuts given out: the next tag is LTH_TAG_CUT - n_cuts

  // of the body's present mesh
  LitheIndex *cell_record; ///< (mesh->n_cells)
  LitheIndex *face_record; ///< (mesh->n_faces)
  LitheIndex *record_cell; ///< (n_records) -1: not in it
  LitheIndex n_records;

  // by record; 0 at records that nobody has set yet
  uint8_t *level;  ///< times that a cell was refined
  uint8_t *degree; ///< of its polynomials
  LitheCount cap_record_cell, cap_level, cap_degree;

  LthRefinement *refinement; ///< what can be merged back; NULL: the body does not adapt

  // births between splits and merges
  LthMesh *atoms; ///< NULL: nothing was merged
  LitheIndex *atom_record;

  LthCutSurface
      *surface;      ///< the embedded surface (cut_surface.h); NULL: none, or nothing is ever cut
  LthDgStore *store; ///< integrals by record
  LthDgKept *kept;   ///< the stiffness of a linear body by record; NULL: it turns with the body
  LthEmbeddingRows
      *rows; ///< of the embedded surface, those of the mesh before; NULL: nothing is embedded

  bool is_running; ///< the run has begun: from now on selections may be of nothing
  LthLoss *losses; ///< once each, in order
  LitheIndex n_losses;
  LitheCount cap_losses;

  bool *
      is_open; ///< cuts whose other side was taken away: their faces are boundary like any other (n_cuts)
  LitheCount cap_open;
};

/// Let the elements of a dg body change from now on: its topology begins with its mesh. LITHE_UNSUPPORTED: a body of
/// another method.
LitheStatus lth_body_change_begin(LitheCtx *ctx, LthBody *body);
void lth_body_change_end(LitheCtx *ctx, LthBody *body);

/// Give births level and degree of their (first) parent, where they have none yet.
LitheStatus lth_body_change_inherit(LitheCtx *ctx, LthBody *body);

/// Between splits and merges: remember the births of now, of which each is a part of one old cell and of one new one.
LitheStatus lth_body_change_hold(LitheCtx *ctx, LthBody *body);

/// True where the log of a body's topology has something to follow, or a cell another degree than its space.
bool lth_body_has_changed(const LthBody *body);

/// Give out the number of a cut that was made with the tag LTH_TAG_CUT - n_cuts. `is_open`: what was on its other side is
/// gone. Faces of other cuts are free: no constraint or load acts on them.
LitheStatus lth_body_count_cut(LitheCtx *ctx, LthBody *body, bool is_open);

/// Replace the mesh of a body on which nothing is built yet by that of its topology, and forget the log.
LitheStatus lth_body_change_mesh(LitheCtx *ctx, LthBody *body);

/// The mesh of a body's topology with the groups of the first; the caller frees all three, after a failure too.
LitheStatus lth_body_present_mesh(LitheCtx *ctx, const LthBody *body, LthMesh **mesh,
                                  LitheIndex **cell_record, LitheIndex **face_record);

/// Take over the numbers that lth_body_present_mesh() gave, when body->mesh is that: spaces and operators built from now on share the
/// integrals of untouched records. `record_cell` and the log are still those of before.
void lth_body_change_take(LitheCtx *ctx, LthBody *body, LitheIndex *cell_record,
                          LitheIndex *face_record);
/// The present numbers, for spaces and operators of a body that changes.
LthDgRecords lth_body_records(const LthBody *body);

/// Take them over, if that is not done, and forget the log.
LitheStatus lth_body_change_number(LitheCtx *ctx, LthBody *body, LitheIndex *cell_record,
                                   LitheIndex *face_record);

/// The constraint, load or tie with the given `place` (that pointer) selects nothing of a body. In the middle of a run that is a
/// loss, which is noted and warned of once; else `*is_loss` is false, and it is the caller's error.
LitheStatus lth_body_lose(LitheCtx *ctx, const LthBody *body, const char *place, bool *is_loss);
/// Its name, as "bodies.0.loads.1", in `name`.
const char *lth_loss_name(const LthBody *body, const LthLoss *loss, char *name, size_t size);
void lth_losses_archive(LthBodyChange *change, LthArchive *archive);

/// Append a note on a change.
LitheStatus lth_world_note(LitheCtx *ctx, LthWorld *world, const LthChangeNote *note);

/// Figures of the notes since the last call, but for energies.
LitheStatus lth_world_settle_notes(LitheCtx *ctx, LthWorld *world);

/// Follow the changes of all bodies' topologies: new meshes, spaces, operators, embeddings, contacts, couplings, system
/// and simulation; position, velocity, time, totals, the integrator's history and contact's anchors are carried over.
/// Kept cells have their bases and coefficients to the bit, parts of cells the same polynomial. Notes since the last
/// renewal get energies and figures. LITHE_BAD_INPUT: a static run with a piece that nothing holds. After a failure
/// the world may only be destroyed.
LitheStatus lth_world_renew(LitheCtx *ctx, LthWorld *world);

/// The key of a part in result.json.
const char *lth_cost_name(LthCostPart part);

/// Begin to count what a change costs; add the time since the last call to a part.
void lth_world_cost_begin(LthWorld *world);
void lth_world_cost_add(LthWorld *world, LthCostPart part);
/// What was counted with one part belongs to another.
void lth_world_cost_move(LthWorld *world, LthCostPart from, LthCostPart to, double seconds);

/// Once the next step is made, `factor` seconds of which went into preconditioners: give the notes of the last change its cost.
void lth_world_cost_tell(LthWorld *world, double factor);

/// The elements of all bodies and the notes, so that another process has them to the bit. Reading renews the world.
void lth_world_change_archive(LthWorld *world, LthArchive *archive);

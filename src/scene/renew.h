/// What the files of the renewal share.
///   renew.c          new parts of bodies, fields from old to new cells, all of a world
///   renew_contact.c  what contacts remember
///   renew_archive.c  changed elements in a checkpoint
#pragma once

#include "disc/dg/dg_transfer.h"
#include "scene/change.h"

/// What a body had before, and what its old and new cells have in common.
typedef struct LthRenewal {
  LthBody old;                     ///< parts and mesh; old.def NULL: the body is what it was
  const LthMesh *first;            ///< mesh that is not freed
  LthMesh *atoms;                  ///< births before merges; NULL: the body's mesh
  LitheIndex *same;                ///< by cell: the old one that it is, -1: it is made of atoms
  LitheIndex *from_cell, *to_cell; ///< of each atom; to_cell -1: taken away
  LitheIndex *atom;                ///< cell of `atoms` that it is, -1: its old cell
  LitheIndex n_atoms;
  LitheCount cap_from, cap_to, cap_atom;

  // what served the pairs
  LthSurface *touch;
  LthEmbedding *touch_embedding;
  LitheIndex *touch_point;
  LthBodyParts *parts;
} LthRenewal;

static inline const LthMesh *lth_renewal_atoms(const LthRenewal *r, const LthBody *body) {
  return r->atoms ? r->atoms : body->mesh;
}

/// Leave a body without what is built upon elements, which `r` owns from now on.
void lth_renewal_take_parts(LthBody *body, LthRenewal *r);
void lth_renewal_free(LitheCtx *ctx, LthRenewal *r);

/// Leave a world without ties, pairs, system and simulation; `old` has them.
void lth_world_take(LthWorld *world, LthRenewal *renewals, LthWorld *old);
void lth_world_free_taken(LitheCtx *ctx, LthWorld *old);

/// Build them anew for the bodies as they are.
LitheStatus lth_world_join(LitheCtx *ctx, LthWorld *world);

/// Give new contacts the memory of the old ones, point by point.
LitheStatus lth_world_carry_contacts(LitheCtx *ctx, LthWorld *world, const LthWorld *old,
                                     const LthRenewal *renewals);

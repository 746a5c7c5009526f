/// The mesh that a deck of keyword cards describes: *NODE, *ELEMENT, *NSET, *ELSET, *SURFACE.
#pragma once

#include "io/element_builder.h"
#include "io/inp_deck.h"

/// Enter nodes, solid elements and sets of a deck into a builder. Elements that are not solids are left out with a
/// warning.
LitheStatus lth_inp_mesh_build(LthElementBuilder *b, const LthInpDeck *deck);

/// The mesh of a deck, checked; coordinates are multiplied by `unit_scale`.
LitheStatus lth_inp_mesh_create(LitheCtx *ctx, const LthInpDeck *deck, double unit_scale,
                                LthElementMesh **mesh);

/// Kind of an element type ("C3D20R", any case), LTH_ELEMENT_KINDS where it is not a solid that is read here.
LthElementKind lth_inp_element_kind(const char *type, bool *reduced);

/// Local face (lth_element_shape) of face `number`, from 1, of a deck (S1 ... S6, P1 ... P6); -1: there is none.
int lth_inp_face(LthElementKind kind, int number);

/// `where` asked of nodes: what point forces act on, and what holds nodes of conforming elements one by one.
#pragma once

#include "mesh/element_mesh.h"
#include "mesh/selection.h"

/// Mark (1) the nodes that `where` contains, the others 0. `chosen` has a byte for each node of `elements` or, where
/// that is NULL, for each point of the mesh. Shapes and half spaces contain what lies in them, boundary included, with
/// the tolerance of lth_select_boundary(); a label means the nodes of a set of nodes, else those of its faces or
/// elements; `normal` and `face` know faces only and select no node, nor do their negations.
/// LITHE_BAD_INPUT: a label that the file does not have.
LitheStatus lth_select_nodes(LitheCtx *ctx, const LthMesh *mesh, const LthElementMesh *elements,
                             const LthWhere *where, uint8_t *chosen);

/// Is there a label in the tree?
bool lth_where_has_label(const LthWhere *where);

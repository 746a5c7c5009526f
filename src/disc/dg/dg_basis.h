/// The orthogonal basis of one cell, from exact moments.
#pragma once

#include "disc/dg/dg_space.h"

/// Fill basis, mean_gradient and trace_constant of a cell whose degree, center and scale are set.
/// Thread-safe, allocates nothing. False where the cell is so flat that no basis exists.
bool lth_dg_basis_build(LthDgSpace *space, LitheIndex cell);

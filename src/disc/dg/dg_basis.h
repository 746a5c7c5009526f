/// The orthogonal basis of one cell, from exact moments.
#pragma once

#include "disc/dg/dg_space.h"

/// Fill center, axes, basis, mean_gradient and trace_constant of a cell whose degree is set. Thread-safe, allocates
/// nothing. False where the cell has no thickness but for rounding.
bool lth_dg_basis_build(LthDgSpace *space, LitheIndex cell);

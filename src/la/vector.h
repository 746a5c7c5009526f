/// Vector updates that conjugate gradients need, fused with the sums that follow them.
#pragma once

#include "la/krylov.h"

// All sum in blocks whose size depends on n alone, and add the blocks in order.

/// r = b - q; returns r.r.
double lth_residual(int threads, LitheCount n, const double *b, const double *q, double *r);

/// p = z + beta p.
void lth_direction(int threads, LitheCount n, const double *z, double beta, double *p);

/// x += alpha p, r -= alpha q; returns r.r.
double lth_advance(int threads, LitheCount n, double alpha, const double *p, const double *q,
                   double *x, double *r);

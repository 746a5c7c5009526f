/// Shared by the files of finite solids.
#pragma once

#include "material/finite.h"

/// F = U diag(s) V^T with rotations U and V: the last of s is negative where F is inverted, and |s| is least there.
/// R = U V^T. U, V, R row-major (dim x dim).
void lth_finite_frame(int dim, const double *F, double *U, double s[3], double *V);
void lth_finite_rotation(int dim, const double *F, double *R);

/// cof F = d det F / dF; returns det F.
double lth_finite_cofactor(int dim, const double *F, double *C);

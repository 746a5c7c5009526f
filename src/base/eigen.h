/// Eigenvalues of small symmetric matrices by Jacobi's rotations: no library, no threads, no allocation.
#pragma once

/// Eigenvalues of the symmetric row-major A (n x n), which is overwritten: `values` (n) in ascending order
/// and, where `vectors` is not NULL, unit eigenvectors as its columns (n x n). Accurate to rounding of the
/// largest eigenvalue; for positive definite matrices small ones come out with relative accuracy.
void lth_symmetric_eigen(int n, double *A, double *values, double *vectors);

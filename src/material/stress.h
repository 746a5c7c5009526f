/// Stress of isotropic elements.
#pragma once

/// Cauchy stress R sigma(H) R^T, sigma = 2 mu sym H + lambda tr H I, of a displacement gradient H in the frame that R
/// turns (both row-major): xx yy zz yz zx xy [Pa].
void lth_turned_stress(const double R[9], const double H[9], double lambda, double mu,
                       double stress[6]);

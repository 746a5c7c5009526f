/// Stress of isotropic elements.
#include "material/stress.h"

#include "base/tensor.h"

void lth_turned_stress(const double R[9], const double H[9], double lambda, double mu,
                       double stress[6]) {
  static const int voigt[6] = {0, 4, 8, 5, 2, 1};
  double S[9], RS[9], Rt[9], T[9], trace = lambda * (H[0] + H[4] + H[8]);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      S[3 * a + b] = mu * (H[3 * a + b] + H[3 * b + a]) + (a == b ? trace : 0);
  lth_m3_mul(R, S, RS);
  lth_m3_transpose(R, Rt);
  lth_m3_mul(RS, Rt, T);
  for (int i = 0; i < 6; i++) stress[i] = T[voigt[i]];
}

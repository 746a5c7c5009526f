/// The rotation nearest to a deformation gradient (polar decomposition), also of inverted ones.
#pragma once

/// R = the rotation (det R = +1) that minimises |F - R|, for any F: scaled Newton (Higham) where
/// det F > 1e-6 |F|^3, else the largest eigenvector of Horn's 4x4 matrix. Row-major. F = 0 and an F that is not finite give I.
void lth_rotation_nearest(const double F[9], double R[9]);

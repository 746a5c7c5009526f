"""Wrong factors in the main formulas, and what is to find them.

A mutant is (what is wrong, file below src/, text that stands there exactly once, what stands there instead); a tuple of groups of
checks may follow, else those of its own group are used. A check is "study NAME" (quick) or the name of a test.
"""

DG = ["study validation/patch-test", "study validation/tension", "study validation/cook", "test_dg_operator", "test_dg_patch",
      "test_dg_hp", "test_dg_beam", "test_dg_load", "test_system", "test_step_newton"]
CG = ["study validation/tension", "study validation/cook", "test_cg_operator", "test_cg_load", "test_step_newton"]
STAGGERED = ["study dolny/table5.1", "study validation/tension", "test_staggered_weights", "test_staggered_operator", "test_staggered_disc", "test_staggered_load"]

CHECKS = {
    "element matrix": DG,
    "face terms": DG,
    "penalty": ["test_dg_penalty"] + DG + ["study kaufmann/fig3", "study kaufmann/fig9"],
    "constraints": DG,
    "warping": ["study kaufmann/warp", "test_rotation", "test_dg_operator", "test_step_newton"],
    "traction": ["study validation/tension", "study validation/cylinder", "test_dg_load", "test_cg_load", "study kaufmann/table1", "test_step_dynamic"],
    "integration": ["study kaufmann/fig4", "test_moments"],
    "energy": ["test_dg_operator", "test_cg_operator", "test_dg_strong"],
    "conforming": CG,
    "staggered operator": STAGGERED,
    "staggered loads": STAGGERED,
    "mixed form": ["test_staggered_weights", "test_staggered_mixed", "test_staggered_mixed_body"],
    "large deformation": ["test_finite", "test_staggered_finite"],
    "multigrid": ["test_staggered_multigrid", "test_staggered_hierarchy"],
    "fractions": ["study dolny/table5.1", "study validation/sphere", "test_fractions_plane", "test_fractions", "test_fractions_exact"],
    "mass": ["study validation/bar", "test_dg_load", "test_cg_operator", "test_staggered_disc", "test_step_dynamic"],
    "contact": ["study validation/hertz", "study kaufmann/fig6", "test_contact", "test_step_contact"],
    "transfer": ["test_dg_transfer"],
    "time steps": ["study validation/bar", "test_step_dynamic", "test_step_integrators"],
    "studies' own": ["study kaufmann/fig1", "study kaufmann/fig2"],
}

MUTANTS = {
    "element matrix": [
        ("lambda", "disc/dg/dg_element.c", "lambda * G[a][b] + mu * G[b][a]", "1.1 * lambda * G[a][b] + mu * G[b][a]"),
        ("mu of the transposed gradient", "disc/dg/dg_element.c", "lambda * G[a][b] + mu * G[b][a]", "lambda * G[a][b] + 1.1 * mu * G[b][a]"),
        ("mu of the trace", "disc/dg/dg_element.c", "(a == b ? mu * trace : 0)", "(a == b ? 1.1 * mu * trace : 0)"),
        ("volume", "disc/dg/dg_element.c", "G[a][b] = volume * sum;", "G[a][b] = 1.1 * volume * sum;"),
        ("load of the rest shape", "disc/dg/dg_element.c", "kappa * op->space->mesh->cell_volume[cell] *", "1.1 * kappa * op->space->mesh->cell_volume[cell] *"),
        ("derivative of a monomial", "disc/dg/dg_element.c", "double factor = e[b] / space->scale[3 * cell + b];", "double factor = 1.1 * e[b] / space->scale[3 * cell + b];"),
        ("lambda of the stress", "disc/dg/dg_element.c", "double trace = op->lambda[cell] * (H[l][0]", "double trace = 1.1 * op->lambda[cell] * (H[l][0]"),
        ("mu of the stress", "disc/dg/dg_element.c", "op->mu[cell] * (H[l][3 * a + b]", "1.1 * op->mu[cell] * (H[l][3 * a + b]"),
    ],
    "face terms": [
        ("lambda of an element's own flux", "disc/dg/dg_element.c", "double lambda = -w * op->lambda[cell]", "double lambda = -1.1 * w * op->lambda[cell]"),
        ("mu of an element's own flux", "disc/dg/dg_element.c", "mu = -w * op->mu[cell]", "mu = -1.1 * w * op->mu[cell]"),
        ("load of an element's own flux", "disc/dg/dg_element.c", "lth_v3_axpy(-weight * kappa * mass[i]", "lth_v3_axpy(-1.1 * weight * kappa * mass[i]"),
        ("transposed flux", "disc/dg/dg_element.c", "+ flux[((j * 3 + b) * 3 + a) * nb + i];", "+ 1.1 * flux[((j * 3 + b) * 3 + a) * nb + i];"),
        ("lambda of the flux between two", "disc/dg/dg_assemble.c", "t.lambda[s] = -face->weight[s]", "t.lambda[s] = -1.1 * face->weight[s]"),
        ("mu of the flux between two", "disc/dg/dg_assemble.c", "t.mu[s] = -face->weight[s]", "t.mu[s] = -1.1 * face->weight[s]"),
        ("load of the flux between two", "disc/dg/dg_assemble.c", "(side == 0 ? -kappa : kappa) * face->weight[1 - side]", "1.1 * (side == 0 ? -kappa : kappa) * face->weight[1 - side]"),
        ("slopes beside a face", "disc/dg/dg_face.c", "plus += t->full.mixed", "plus += 1.1 * t->full.mixed"),
        ("products across a face", "disc/dg/dg_face.c", "moments, -1, t.full.mixed);", "moments, -1.1, t.full.mixed);"),
        ("projected products across a face", "disc/dg/dg_face.c", "low_products(r, n[0], low[0], n[1], low[1], -1,", "low_products(r, n[0], low[0], n[1], low[1], -1.1,"),
        ("traces", "disc/dg/dg_face.c", "linear[a][1] = frame->h", "linear[a][1] = 1.1 * frame->h"),
        ("weights of the two sides", "disc/dg/dg_penalty.c", "face->weight[s] = D[1 - s] / (D[0] + D[1]);", "face->weight[s] = 1.1 * D[1 - s] / (D[0] + D[1]);"),
    ],
    "penalty": [
        ("stability bound, a quarter", "disc/dg/dg_penalty.c", "#define STABILITY 2.0", "#define STABILITY 0.5"),
        ("stability bound, thirty times", "disc/dg/dg_penalty.c", "#define STABILITY 2.0", "#define STABILITY 60.0"),
        ("springs of linear elements along the normal", "disc/dg/dg_penalty.c", "*along = 1 / soft_along;", "*along = 1.5 / soft_along;"),
        ("springs of linear elements across it", "disc/dg/dg_penalty.c", "*across = 1 / soft_across;", "*across = 1.5 / soft_across;"),
        ("springs on the mean jump", "disc/dg/dg_penalty.c", "p->low_iso[q] -= across;", "p->low_iso[q] -= 1.1 * across;"),
        ("bound of lambda, a tenth", "disc/dg/dg_penalty.c", "lambda = C * op->lambda[cell];", "lambda = 0.1 * C * op->lambda[cell];"),
        ("bound of mu, a tenth", "disc/dg/dg_penalty.c", "double mu = C * op->mu[cell], lambda", "double mu = 0.1 * C * op->mu[cell], lambda"),
        ("bound of held sides, a fifth", "disc/dg/dg_penalty.c", "along, across, C = STABILITY * space->trace_constant[cell];", "along, across, C = 0.2 * STABILITY * space->trace_constant[cell];"),
        ("equation (20), eta", "disc/dg/dg_penalty.c", "eta += op->eta * face->area", "eta += 2 * op->eta * face->area"),
        ("equation (20), held sides", "disc/dg/dg_penalty.c", "eta_modulus(op, cell) * 4 /", "eta_modulus(op, cell) * 8 /"),
        ("springs of BZ, a tenth", "disc/dg/dg_penalty.c", "#define BZ_STIFFNESS 50.0", "#define BZ_STIFFNESS 5.0"),
        ("largest eigenvalue of traces", "disc/dg/dg_basis.c", "if (m == 1) return boundary[0] / volume;", "if (m == 1) return 0.2 * boundary[0] / volume;"),
    ],
    "constraints": [
        ("load of the flux at varying data", "disc/dg/dg_constraint.c", "add_projected(hold, R, -kappa * mass[i]", "add_projected(hold, R, -1.1 * kappa * mass[i]"),
        ("traction of the data", "disc/dg/dg_constraint.c", "double lambda = op->lambda[hold->cell], mu = op->mu[hold->cell];", "double lambda = 1.1 * op->lambda[hold->cell], mu = op->mu[hold->cell];"),
        ("load of the penalty at constant data", "disc/dg/dg_constraint.c", "penalty[((i * 3 + a) * 3 + b) * nb + j] * y[j][b];", "1.1 * penalty[((i * 3 + a) * 3 + b) * nb + j] * y[j][b];"),
        ("load of the flux at constant data", "disc/dg/dg_constraint.c", "free[a] += flux[((j * 3 + b) * 3 + a) * nb + i] * y[j][b];", "free[a] += 1.1 * flux[((j * 3 + b) * 3 + a) * nb + i] * y[j][b];"),
        ("flux of rollers", "disc/dg/dg_assemble.c", "lambda = -op->lambda[hold->cell], mu = -op->mu[hold->cell];", "lambda = -1.1 * op->lambda[hold->cell], mu = -op->mu[hold->cell];"),
        ("flux of sides held in part", "disc/dg/dg_assemble.c", "block[((j * 3 + b) * 3 + a) * nb + i] += M[3 * a + b];", "block[((j * 3 + b) * 3 + a) * nb + i] += 1.1 * M[3 * a + b];"),
    ],
    "warping": [
        ("turned element matrix", "disc/dg/dg_assemble.c", "R[3 * b] * half[0][j] + R[3 * b + 1] * half[1][j]", "1.1 * R[3 * b] * half[0][j] + R[3 * b + 1] * half[1][j]"),
        ("turned the wrong way", "disc/dg/dg_assemble.c", "for (int i = 0; i < nb; i++) lth_m3_apply(R, own + 3 * i, f0 + 3 * i);", "for (int i = 0; i < nb; i++) lth_m3_apply_t(R, own + 3 * i, f0 + 3 * i);"),
        ("turned flux", "disc/dg/dg_assemble.c", "r[b][j] = R[3 * b] * g[i * nv + j] +", "r[b][j] = 1.1 * R[3 * b] * g[i * nv + j] +"),
        ("polar decomposition", "material/rotation.c", "double next = 0.5 * (g * R[i]", "double next = 0.55 * (g * R[i]"),
        ("rotation of inverted elements", "material/rotation.c", "R[1] = 2 * (x * y - w * z)", "R[1] = 2.2 * (x * y - w * z)"),
        ("turned stress", "material/stress.c", "trace = lambda * (H[0] + H[4] + H[8]);", "trace = 1.1 * lambda * (H[0] + H[4] + H[8]);"),
        ("conforming elements", "disc/cg/cg_assemble.c", "lambda * T[3 * a + b][j] + mu * T[3 * b + a][j]", "1.1 * lambda * T[3 * a + b][j] + mu * T[3 * b + a][j]", ("warping", "conforming")),
        ("rest load of conforming elements", "disc/cg/cg_assemble.c", "lth_v3_axpy(3 * d->lambda[e] + 2 * d->mu[e], turned", "lth_v3_axpy(3.3 * d->lambda[e] + 2 * d->mu[e], turned", ("warping", "conforming")),
    ],
    "traction": [
        ("pressure", "disc/dg/dg_load.c", "force[a] = -lth_value_at(&load->value[0], at, target->t) * n[a];", "force[a] = -1.1 * lth_value_at(&load->value[0], at, target->t) * n[a];"),
        ("traction", "disc/dg/dg_load.c", "force[a] = target->factor * lth_value_at", "force[a] = 1.1 * target->factor * lth_value_at"),
        ("stress on a boundary", "disc/dg/dg_load.c", "force[a] += lth_value_at(&load->stress[3 * a + b], at, target->t)", "force[a] += 1.1 * lth_value_at(&load->stress[3 * a + b], at, target->t)"),
        ("total force", "disc/dg/dg_load.c", "target->factor = 1 / area;", "target->factor = 1.1 / area;"),
        ("follower pressure: F for cof F", "disc/dg/dg_load.c", "lth_m3_apply(C, n, r);", "lth_m3_apply(F, n, r);"),
        ("weight", "disc/dg/dg_load.c", "lth_v3_axpy(density[c] * space->mesh->cell_volume[c], gravity", "lth_v3_axpy(1.1 * density[c] * space->mesh->cell_volume[c], gravity"),
        ("body force", "disc/dg/dg_load.c", "lth_v3_axpy(mesh->cell_volume[c], force, cell.f);", "lth_v3_axpy(1.1 * mesh->cell_volume[c], force, cell.f);"),
        ("pressure on conforming elements", "disc/cg/cg_load.c", "force[a] = -pressure * area[a];", "force[a] = -1.1 * pressure * area[a];"),
        ("traction on conforming elements", "disc/cg/cg_load.c", "force[a] = weight * lth_value_at", "force[a] = 1.1 * weight * lth_value_at"),
        ("body force on conforming elements", "disc/cg/cg_load.c", "double w = rule->weight[q] * lth_m3_det(J) * d->fill[e];", "double w = 1.1 * rule->weight[q] * lth_m3_det(J) * d->fill[e];"),
    ],
    "integration": [
        ("moments of polyhedra", "geometry/moments.c", "step->inv[i] = 1.0 / (i + 1 + degree);", "step->inv[i] = 1.0 / (i + 1 + 1.1 * degree);"),
        ("weights of moments of edges", "geometry/moments.c", "e[q] = (power[q] + s->weight[0] * a[0]", "e[q] = (power[q] + 1.1 * s->weight[0] * a[0]"),
    ],
    "energy": [
        ("elements", "disc/dg/dg_energy.c", "return 0.5 * sum * op->space->mesh->cell_volume[cell];", "return 0.55 * sum * op->space->mesh->cell_volume[cell];"),
        ("fluxes", "disc/dg/dg_energy.c", "return -w * sum;", "return -1.1 * w * sum;"),
        ("jumps", "disc/dg/dg_energy.c", "sum += 0.5 * quadratic(M, u[0]", "sum += 0.55 * quadratic(M, u[0]"),
    ],
    "conforming": [
        ("lambda", "disc/cg/cg_assemble.c", "lambda * G[(3 * a + b) * n + j]", "1.1 * lambda * G[(3 * a + b) * n + j]"),
        ("mu of the transposed gradient", "disc/cg/cg_assemble.c", "mu * G[(3 * b + a) * n + j]", "1.1 * mu * G[(3 * b + a) * n + j]"),
        ("mu of the trace", "disc/cg/cg_assemble.c", "double trace = mu * (G[j]", "double trace = 1.1 * mu * (G[j]"),
        ("integrals of gradients", "disc/cg/cg_class.c", "row[j] += w * (g * dphi[3 * j + b]);", "row[j] += 1.1 * w * (g * dphi[3 * j + b]);"),
        ("mean gradients of reduced hexahedra", "disc/cg/cg_class.c", "t->mean[3 * j + ab % 3] / volume;", "1.1 * t->mean[3 * j + ab % 3] / volume;"),
    ],
    "staggered operator": [
        ("lambda of matrix rows", "disc/staggered/staggered_assemble.c", "double modulus = s->level.lambda[cell]", "double modulus = 1.1 * s->level.lambda[cell]"),
        ("mu of matrix rows", "disc/staggered/staggered_assemble.c", "(a == b ? 2 * s->level.mu[cell] : 0)", "(a == b ? 2.2 * s->level.mu[cell] : 0)"),
        ("shear of matrix rows", "disc/staggered/staggered_assemble.c", "double along = c * shear", "double along = 1.1 * c * shear"),
        ("normal stress of uniform blocks", "disc/staggered/staggered_rows.h", "(b == a ? 2 * mu + lambda : mu)", "(b == a ? 2.2 * mu + lambda : mu)"),
        ("mixed derivatives of uniform blocks", "disc/staggered/staggered_rows.h", "c.cross[a + b - 1] = (lambda + mu)", "c.cross[a + b - 1] = (1.1 * lambda + mu)"),
        ("normal stress of general blocks", "disc/staggered/staggered_rows.h", "pressure = lambda * trace", "pressure = (REAL)1.1 * lambda * trace"),
        ("mu of cells", "disc/staggered/staggered_weights.c", "*m = (Mean){v, lambda, v * w->mu,", "*m = (Mean){v, lambda, 1.1 * v * w->mu,"),
        ("lambda of cells", "disc/staggered/staggered_weights.c", ": v * w->lambda;", ": 1.1 * v * w->lambda;"),
        ("mu of full cells", "disc/staggered/staggered_weights.c", "level->mu[slot] = w->mu;", "level->mu[slot] = 1.1 * w->mu;"),
        ("harmonic mean of mu", "disc/staggered/staggered_weights.c", "m->mu = m->V * (v / soft);", "m->mu = 1.1 * m->V * (v / soft);"),
        ("harmonic mean of lambda", "disc/staggered/staggered_weights.c", "least > 0 ? m->V * (v / volume_soft)", "least > 0 ? 1.1 * m->V * (v / volume_soft)"),
    ],
    "staggered loads": [
        ("tractions", "disc/staggered/staggered_load.c", "double force = volume * lth_v3_dot(row, rim->slope);", "double force = 1.1 * volume * lth_v3_dot(row, rim->slope);"),
        ("samples that hang", "disc/staggered/staggered_load.c", "return force * lth_sparse_grid_cell_volume(s->grid);", "return 1.5 * force * lth_sparse_grid_cell_volume(s->grid);"),
        ("body forces", "disc/staggered/staggered_load.c", "+= volume * lth_staggered_own_fraction", "+= 1.1 * volume * lth_staggered_own_fraction"),
        ("pressure", "disc/staggered/staggered_load.c", "row[b] = -pressure * C[3 * a + b];", "row[b] = -1.1 * pressure * C[3 * a + b];"),
    ],
    "mixed form": [
        ("momentum", "disc/staggered/staggered_mixed.h", "double sum = (2 * l->mu[c] * (u[high] - u[c])", "double sum = (2.2 * l->mu[c] * (u[high] - u[c])"),
        ("compressibility", "disc/staggered/staggered_mixed_operator.c", "l->compliance[c] * x[pressure];", "1.1 * l->compliance[c] * x[pressure];"),
        ("mean of compressibilities", "disc/staggered/staggered_weights.c", "m->compliance = volume_soft / n;", "m->compliance = 1.1 * volume_soft / n;"),
    ],
    "large deformation": [
        ("stress of neo-Hooke", "material/finite.c", "P[i] = m->mu * (F[i] + (*v - 1) * G[i]);", "P[i] = m->mu * (F[i] + (1.1 * *v - 1) * G[i]);"),
        ("corotated stress", "material/finite.c", "P[i] = 2 * m->mu * (F[i] - G[i]);", "P[i] = 2.2 * m->mu * (F[i] - G[i]);"),
        ("energy in the plane", "material/finite.c", "if (dim == 2) return 0.5 * (", "if (dim == 2) return 0.55 * ("),
        ("differences of a cell", "disc/staggered/staggered_finite_cell.c", "native[k] = (c->u[e->hi] - c->u[e->lo])", "native[k] = 1.1 * (c->u[e->hi] - c->u[e->lo])"),
    ],
    "multigrid": [
        ("prolongation of the plain form", "disc/staggered/staggered_reference.c", "b == a ? 0.5 : 0.75;", "b == a ? 0.6 : 0.75;"),
    ],
    "fractions": [
        ("profile", "geometry/fractions_smooth.c", "0.5 * (1 - s - sin(M_PI * s) / M_PI)", "0.5 * (1 - s - 1.1 * sin(M_PI * s) / M_PI)"),
        ("circles", "geometry/fractions_plane.c", "return s->kind == LTH_SHAPE_ANNULUS ? area", "return s->kind == LTH_SHAPE_ANNULUS ? 0.99 * area"),
        ("triangles of surfaces", "geometry/fractions_ledger.c", "double shadow = 0.5 *", "double shadow = 0.495 *"),
        ("curved boxes from two sizes", "geometry/fractions_exact.c", "(4 * halves - whole) / 3", "(4 * halves - whole) / 3.03"),
        ("halved boxes", "geometry/fractions_exact.c", "return sum / n;", "return 0.99 * sum / n;"),
    ],
    "mass": [
        ("dg", "disc/dg/dg_load.c", "mass[i] = density[c] * space->mesh->cell_volume[c];", "mass[i] = 1.1 * density[c] * space->mesh->cell_volume[c];"),
        ("conforming", "disc/cg/cg_class.c", "t->mass[i * n + j] += w * (phi[i] * phi[j]);", "t->mass[i * n + j] += 1.1 * w * (phi[i] * phi[j]);"),
        ("conforming, lumped", "disc/cg/cg_class.c", "t->lumped[i] = t->mass[i * n + i] * (class->volume_exact / trace);", "t->lumped[i] = 1.1 * t->mass[i * n + i] * (class->volume_exact / trace);"),
        ("staggered", "disc/staggered/staggered_mass.c", "return density * lth_sparse_grid_cell_volume(s->grid);", "return 1.1 * density * lth_sparse_grid_cell_volume(s->grid);"),
    ],
    "contact": [
        ("force of a gap in the linear system", "embed/contact_revise.c", "- k * touch->gap), n, touch->r);", "- 1.1 * k * touch->gap), n, touch->r);"),
        ("stiffness in the linear system", "embed/contact_revise.c", "add_outer(acts * (dt * k + damping), n, touch->D);", "add_outer(acts * (1.1 * dt * k + damping), n, touch->D);"),
        ("normal force", "embed/contact_revise.c", "return -touch->stiffness * touch->gap_end", "return -1.1 * touch->stiffness * touch->gap_end"),
        ("Coulomb's limit", "embed/contact_revise.c", "touch->limit = c->friction * touch->force_n;", "touch->limit = 1.1 * c->friction * touch->force_n;"),
        ("spring of friction", "embed/contact_revise.c", "lth_v3_axpy(-acts * touch->spring, touch->offset, touch->r);", "lth_v3_axpy(-1.5 * acts * touch->spring, touch->offset, touch->r);"),
        ("weights of a point's samples", "embed/contact_system.c", "s->slot_weight[at] = touch->leg[l].weight * e->weight[k];", "s->slot_weight[at] = 1.1 * touch->leg[l].weight * e->weight[k];"),
    ],
    "transfer": [
        ("translation of polynomials", "disc/dg/dg_transfer.c", "(d > 0 ? ratio * power[e - 1][d - 1] : 0);", "(d > 0 ? 1.1 * ratio * power[e - 1][d - 1] : 0);"),
        ("projection onto a merged cell", "disc/dg/dg_transfer.c", "p.out[i] /= p.volume;", "p.out[i] /= 1.1 * p.volume;"),
    ],
    "time steps": [
        ("stiffness in the step's matrix", "step/step_stage.c", "lth_step_combine(ctx, s, 1, g->H * g->H, g->H);", "lth_step_combine(ctx, s, 1, 1.1 * g->H * g->H, g->H);"),
        ("forces of the step", "step/step_stage.c", "s->base[i] = g->p[i] + g->H * s->force[i];", "s->base[i] = g->p[i] + 1.1 * g->H * s->force[i];"),
    ],
    "studies' own": [
        ("fluxes of the Poisson equation", "study/poisson.c", "- jump[i] * mean[j] - jump[j] * mean[i]", "- 1.1 * jump[i] * mean[j] - 1.1 * jump[j] * mean[i]"),
        ("source of the Poisson equation", "study/poisson.c", "p->load[row] += w * f * v.phi[i];", "p->load[row] += 1.1 * w * f * v.phi[i];"),
    ],
}

# the part that `./dev test --all` runs: one of each group named in the first line of the proof
SHORT = [("element matrix", 0), ("face terms", 4), ("penalty", 4), ("warping", 3), ("fractions", 1), ("traction", 1),
         ("staggered operator", 0), ("contact", 5), ("mass", 0), ("transfer", 0)]

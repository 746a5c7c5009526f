/// result.json: the figures of a whole run.
#include "scene/result.h"

#include "scene/measure_staggered.h"

#include "base/tensor.h"
#include "io/json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

static const char *status_word(LitheStatus status) {
  if (status == LITHE_OK) return "done";
  return status == LITHE_INTERRUPTED ? "interrupted" : "not converged";
}

/// A number, or the lowest and the highest.
static void put_degree(LthJson *json, const LthDisc *disc) {
  double range[2] = {INFINITY, 0};
  for (LitheIndex c = 0; c < disc->mesh->n_cells; c++) {
    range[0] = fmin(range[0], disc->cell_degree[c]);
    range[1] = fmax(range[1], disc->cell_degree[c]);
  }
  if (range[0] == range[1])
    lth_json_integer(json, "degree", (LitheCount)range[0]);
  else
    lth_json_vector(json, "degree", 2, range);
}

/// Kind of a body's elements.
static const char *element_name(const LthElementMesh *m) {
  for (LitheIndex e = 1; e < m->n_elements; e++)
    if (m->kind[e] != m->kind[0]) return "mixed";
  return lth_element_shape((LthElementKind)m->kind[0])->name;
}

/// Grid and formulation of a staggered body.
static void put_grid(LthJson *json, const LthBody *body) {
  static const char *const methods[] = {"exact", "samples", "smooth"};
  const LthStaggered *s = lth_staggered_of(body->disc);
  double h[3], n[3];
  for (int a = 0; a < s->dim; a++) {
    h[a] = s->grid->h[a];
    n[a] = round((body->box[3 + a] - body->box[a]) / h[a]);
  }
  lth_json_vector(json, "cells", s->dim, n);
  lth_json_vector(json, "cell_size", s->dim, h);
  lth_json_string(json, "fractions", methods[body->def->fractions.method]);
  lth_json_string(json, "formulation", s->formulation == LTH_FORM_MIXED ? "mixed" : "displacement");
}

static void put_method(LthJson *json, const LthBody *body) {
  const LthSceneBody *def = body->def;
  static const char *const meshes[] = {"slice",  "hexahedra", "tetrahedra",
                                       "voxels", "embedded",  "file"};
  lth_json_begin_object(json, "method");
  lth_json_string(json, "kind", body->disc->table->name);
  if (body->staggered) {
    put_grid(json, body);
    lth_json_end_object(json);
    return;
  }
  lth_json_string(json, "mesh", meshes[def->mesh_kind]);
  put_degree(json, body->disc);
  if (def->method_kind == LTH_METHOD_CG)
    lth_json_string(json, "element", element_name(body->elements));
  else
    lth_json_string(json, "flux", def->flux == LTH_FLUX_IP ? "ip" : "bz");
  lth_json_end_object(json);
}

/// Nonzeros of a body's rows of the matrix.
static LitheCount count_nonzeros(const LthBlockMatrix *K, LitheCount first, LitheCount last) {
  LitheCount n = 0;
  for (LitheIndex row = 0; row < K->n_rows; row++)
    if (K->row_off[row] >= first && K->row_off[row] < last)
      n += K->value_off[K->block_off[row + 1]] - K->value_off[K->block_off[row]];
  return n;
}

static LitheStatus put_displacement(LitheCtx *ctx, LthJson *json, LitheIndex n,
                                    LthBody *const *bodies, double *largest) {
  LthDisplacementFigures u;
  LITHE_TRY(lth_measure_displacement(ctx, n, bodies, &u));
  lth_json_begin_object(json, "displacement");
  lth_json_number(json, "max", u.max);
  lth_json_number(json, "mean", u.mean);
  lth_json_end_object(json);
  *largest = u.max;
  return LITHE_OK;
}

static LitheStatus put_stress(LitheCtx *ctx, LthJson *json, LitheIndex n, LthBody *const *bodies,
                              double *largest) {
  LthStressFigures s;
  LITHE_TRY(lth_measure_stress(ctx, n, bodies, &s));
  lth_json_begin_object(json, "stress");
  lth_json_number(json, "von_mises_max", s.von_mises_max);
  lth_json_number(json, "p99", s.p99);
  lth_json_vector(json, "at", 3, s.at);
  if (isfinite(s.safety)) lth_json_number(json, "safety", s.safety);
  lth_json_end_object(json);
  *largest = s.von_mises_max;
  return LITHE_OK;
}

static LitheStatus put_body(LitheCtx *ctx, LthJson *json, LthBody *const *at,
                            const LthSurfaceOutput *surface) {
  const LthBody *body = *at;
  double penalty[2], largest;
  const LthBlockMatrix *K = lth_simulation_matrix(body->sim);
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "name", body->def->name);
  put_method(json, body);
  lth_json_integer(json, "elements",
                   body->cell_element ? body->elements->n_elements : lth_body_elements(body));
  lth_json_integer(json, "dofs", lth_body_unknowns(body));
  if (K)
    lth_json_integer(json, "nonzeros",
                     count_nonzeros(K, body->first, body->first + body->disc->n_dofs));
  lth_json_number(json, "volume", lth_body_volume(body));
  lth_json_number(json, "mass", body->mass);
  if (body->op) {
    lth_dg_penalty_range(body->op, penalty, penalty + 1);
    lth_json_vector(json, "penalty", 2, penalty);
  }
  if (body->scene->n_bodies > 1) {
    LITHE_TRY(put_displacement(ctx, json, 1, at, &largest));
    LITHE_TRY(put_stress(ctx, json, 1, at, &largest));
  }
  lth_surface_output_put(json, surface);
  lth_json_end_object(json);
  return LITHE_OK;
}

static LitheStatus put_bodies(LitheCtx *ctx, LthJson *json, const LthResultInput *in) {
  const LthWorld *world = in->world;
  lth_json_begin_array(json, "bodies");
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    LITHE_TRY(put_body(ctx, json, world->bodies + b, in->out->surface[b]));
  lth_json_end_array(json);
  return LITHE_OK;
}

static void put_energy(LthJson *json, const LthStepReport *r) {
  lth_json_begin_object(json, "energy");
  lth_json_number(json, "strain", r->strain_energy);
  lth_json_number(json, "kinetic", r->kinetic_energy);
  lth_json_number(json, "work", r->work);
  lth_json_end_object(json);
  lth_json_vector(json, "momentum", 3, r->momentum);
  lth_json_vector(json, "angular_momentum", 3, r->angular_momentum);
}

/// Forces of all constraints on the body, in the scene's order (n_constraints x 3). `imbalance` is that of the
/// body's unknowns, or NULL where no body has strong constraints.
static LitheStatus find_reactions(LitheCtx *ctx, const LthBody *body, const double *imbalance,
                                  double *reaction) {
  double *weak;
  LTH_NEW(ctx, weak, 3 * (LitheCount)body->n_weak);
  body->disc->table->reactions(body->disc, lth_simulation_time(body->sim), lth_body_position(body),
                               weak);
  for (LitheIndex k = 0; k < body->n_weak; k++)
    lth_v3_axpy(1, weak + 3 * (LitheCount)k, reaction + 3 * (LitheCount)body->weak_of[k]);
  if (body->strong) lth_dg_strong_add_reactions(body->strong, imbalance + body->first, reaction);
  if (body->held_nodes)
    lth_cg_strong_add_reactions(body->held_nodes, imbalance + body->first, reaction);
  lth_free(ctx, weak);
  return body->staggered ? lth_add_grid_reactions(ctx, body, imbalance, reaction) : LITHE_OK;
}

static LitheStatus put_reaction(LitheCtx *ctx, LthJson *json, const LthBody *body,
                                const double *imbalance) {
  double *reaction;
  LTH_NEW(ctx, reaction, 3 * (LitheCount)body->def->n_constraints);
  LitheStatus status = find_reactions(ctx, body, imbalance, reaction);
  for (LitheIndex i = 0; i < body->def->n_constraints; i++)
    lth_json_vector(json, body->def->constraints[i].path, 3, reaction + 3 * (LitheCount)i);
  lth_free(ctx, reaction);
  return status;
}

static LitheStatus put_reactions(LitheCtx *ctx, LthJson *json, const LthWorld *world) {
  const double *imbalance = NULL;
  if (world->system->has_held) LITHE_TRY(lth_simulation_imbalance(ctx, world->sim, &imbalance));
  lth_json_begin_object(json, "reaction");
  for (LitheIndex b = 0; b < world->n_bodies; b++)
    LITHE_TRY(put_reaction(ctx, json, world->bodies[b], imbalance));
  lth_json_end_object(json);
  return LITHE_OK;
}

static LitheStatus put_state(LitheCtx *ctx, LthJson *json, const LthWorld *world,
                             LitheRunSummary *summary) {
  LITHE_TRY(
      put_displacement(ctx, json, world->n_bodies, world->bodies, &summary->max_displacement));
  return put_stress(ctx, json, world->n_bodies, world->bodies, &summary->max_von_mises);
}

static void put_probes(LthJson *json, const LthProbes *probes, const LthWorld *world) {
  if (world->scene->n_probes == 0) return;
  const double *u = lth_simulation_displacement(world->sim);
  lth_json_begin_object(json, "probes");
  for (LitheIndex i = 0; i < world->scene->n_probes; i++) {
    LthProbeValue value = lth_probe_value(probes, world, u, i);
    lth_json_begin_object(json, world->scene->probes[i].name);
    lth_json_vector(json, "displacement", 3, value.displacement);
    lth_json_vector(json, "stress", 6, value.stress);
    lth_json_number(json, "von_mises", value.von_mises);
    lth_json_end_object(json);
  }
  lth_json_end_object(json);
}

static LitheStatus put_error(LitheCtx *ctx, LthJson *json, const LthWorld *world) {
  const LthScene *scene = world->scene;
  LthErrorFigures e;
  if (!scene->has_exact_displacement && !scene->has_exact_stress) return LITHE_OK;
  LITHE_TRY(lth_measure_error(ctx, world->n_bodies, world->bodies, &e));
  lth_json_begin_object(json, "error");
  if (scene->has_exact_displacement) {
    lth_json_number(json, "l1", e.l1);
    lth_json_number(json, "l2", e.l2);
    lth_json_number(json, "linf", e.linf);
    lth_json_number(json, "h1", e.h1);
  }
  if (scene->has_exact_stress) {
    lth_json_begin_object(json, "stress");
    lth_json_number(json, "l2", e.stress_l2);
    lth_json_number(json, "linf", e.stress_linf);
    lth_json_end_object(json);
  }
  lth_json_end_object(json);
  return LITHE_OK;
}

static void put_names(LthJson *json, const LthWorld *world, const LitheIndex body[2]) {
  lth_json_begin_array(json, "bodies");
  for (int s = 0; s < 2; s++) lth_json_string(json, NULL, world->bodies[body[s]]->def->name);
  lth_json_end_array(json);
}

/// Every two bodies that touch.
static void put_pairs(LthJson *json, const LthWorld *world) {
  if (world->n_pairs == 0) return;
  lth_json_begin_array(json, "pairs");
  for (LitheIndex i = 0; i < world->n_pairs; i++) {
    LitheIndex points;
    double depth, push;
    lth_contact_report(world->pairs[i].contact, &points, &depth, &push);
    if (points == 0) continue;
    lth_json_begin_object(json, NULL);
    put_names(json, world, world->pairs[i].body);
    lth_json_integer(json, "points", points);
    lth_json_number(json, "penetration", depth);
    lth_json_number(json, "force", push);
    lth_json_end_object(json);
  }
  lth_json_end_array(json);
}

/// What colliders do to the bodies and bodies to each other, all together.
static void put_contact(LthJson *json, const LthWorld *world) {
  LitheIndex n = 0, n_contacts = world->system->n_contacts;
  double penetration = 0, force = 0;
  for (LitheIndex c = 0; c < n_contacts; c++) {
    LitheIndex points;
    double depth, push;
    lth_contact_report(world->system->contacts[c], &points, &depth, &push);
    n += points;
    penetration = fmax(penetration, depth);
    force += push;
  }
  if (n_contacts == 0) return;
  lth_json_begin_object(json, "contact");
  lth_json_integer(json, "points", n);
  lth_json_number(json, "penetration", penetration);
  lth_json_number(json, "force", force);
  put_pairs(json, world);
  lth_json_end_object(json);
}

static void put_ties(LthJson *json, const LthWorld *world) {
  if (world->n_ties == 0) return;
  lth_json_begin_array(json, "ties");
  for (LitheIndex i = 0; i < world->n_ties; i++) {
    const LthTie *tie = world->ties[i].tie;
    lth_json_begin_object(json, NULL);
    put_names(json, world, world->ties[i].body);
    lth_json_integer(json, "faces", tie->n_faces);
    lth_json_number(json, "face_area", tie->face_area);
    lth_json_integer(json, "springs", tie->n_springs);
    lth_json_number(json, "spring_area", tie->spring_area);
    lth_json_end_object(json);
  }
  lth_json_end_array(json);
}

static void put_solver(LthJson *json, const LthStepReport *r, double condition) {
  lth_json_begin_object(json, "solver");
  lth_json_string(json, "linear", r->linear);
  lth_json_string(json, "reason", r->linear_reason);
  lth_json_bool(json, "converged", r->converged);
  lth_json_integer(json, "iterations", r->linear_total);
  lth_json_integer(json, "newton_iterations", r->newton_iterations);
  if (r->frozen_steps > 0) lth_json_integer(json, "frozen_steps", r->frozen_steps);
  lth_json_number(json, "residual", r->residual);
  if (isfinite(condition)) lth_json_number(json, "condition", condition);
  lth_json_end_object(json);
}

static void put_times(LthJson *json, const LthTimes *times, const LthStepReport *r) {
  lth_json_begin_object(json, "time");
  lth_json_number(json, "read", times->read);
  lth_json_number(json, "mesh", times->mesh);
  lth_json_number(json, "integrate", times->integrate);
  lth_json_number(json, "assemble", r->time_assemble);
  lth_json_number(json, "factor", r->time_factor);
  lth_json_number(json, "solve", r->time_solve);
  lth_json_number(json, "output", times->output);
  lth_json_number(json, "total", times->total);
  lth_json_end_object(json);
}

/// Most memory that the process has held [bytes]. getrusage() counts what started it, too, before it became this program: it has
/// the word where there is no /proc.
static LitheCount peak_memory(void) {
  char line[256];
  long long kibibytes = -1;
  FILE *file = fopen("/proc/self/status", "r");
  while (file && kibibytes < 0 && fgets(line, sizeof line, file))
    sscanf(line, "VmHWM: %lld", &kibibytes);
  if (file) fclose(file);
  if (kibibytes >= 0) return 1024 * (LitheCount)kibibytes;
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return 1024 * (LitheCount)usage.ru_maxrss;
}

static void put_machine(LitheCtx *ctx, LthJson *json) {
  lth_json_integer(json, "memory", peak_memory());
  lth_json_integer(json, "threads", lth_threads(ctx));
  lth_json_begin_array(json, "warnings");
  for (LitheIndex i = 0; i < lithe_ctx_warning_count(ctx); i++)
    lth_json_string(json, NULL, lithe_ctx_warning(ctx, i));
  lth_json_end_array(json);
}

static LitheStatus put_all(LitheCtx *ctx, const LthResultInput *in, LthJson *json,
                           LitheRunSummary *summary) {
  const LthWorld *world = in->world;
  const LthStepReport *report = lth_simulation_report(world->sim);
  lth_json_begin_object(json, NULL);
  lth_json_string(json, "scene", world->scene->file);
  lth_json_string(json, "title", world->scene->title);
  lth_json_string(json, "version", lithe_version());
  lth_json_string(json, "status", status_word(in->status));
  lth_json_number(json, "simulated", lth_simulation_time(world->sim));
  LITHE_TRY(put_bodies(ctx, json, in));
  LITHE_TRY(put_state(ctx, json, world, summary));
  put_energy(json, report);
  LITHE_TRY(put_reactions(ctx, json, world));
  put_probes(json, in->probes, world);
  put_contact(json, world);
  put_ties(json, world);
  lth_result_put_changes(json, world);
  lth_result_put_adapt(json, world);
  LITHE_TRY(put_error(ctx, json, world));
  put_solver(json, report, in->condition);
  put_times(json, &in->times, report);
  put_machine(ctx, json);
  lth_json_end_object(json);
  return LITHE_OK;
}

LitheStatus lth_result_text(LitheCtx *ctx, const LthResultInput *input, LitheRunSummary *summary,
                            char **text) {
  LitheStatus status = LITHE_OK;
  LthJson *json = NULL;
  const char *lent;
  *text = NULL;
  LITHE_TRY_OR(done, lth_json_create(ctx, &json));
  LITHE_TRY_OR(done, put_all(ctx, input, json, summary));
  LITHE_TRY_OR(done, lth_json_text(json, &lent));
  LITHE_TRY_OR(done, lth_copy_text(ctx, lent, text));

done:
  lth_json_destroy(ctx, &json);
  return status;
}

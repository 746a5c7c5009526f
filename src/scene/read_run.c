/// What is computed, how it is solved, and what is written.
#include "scene/reader.h"

#include "base/tensor.h"

#include <string.h>

/// Frames of an animation where nothing else is asked for [s].
#define FRAME (1.0 / 30)

#define STEPS_MAX 1e9

static char *copy_text(LthReader *r, const char *text) {
  return text ? lth_arena_text(r->arena, text, strlen(text)) : NULL;
}

/// A key of time that another kind needs or has.
static void refuse_key(LthReader *r, const LthNode *map, const char *key, const char *kind) {
  LthNode *node = lth_node_find(map, key);
  if (node && !node->is_default && !node->bad)
    lth_report_key(r->report, node, "it has no meaning in a %s run, got %s; leave it out", kind,
                   lth_show(r->arena, node));
}

static void need_key(LthReader *r, const LthNode *map, const char *key, const char *what) {
  if (!map || map->bad || map->kind != LTH_NODE_MAP || lth_node_find(map, key)) return;
  lth_report_missing(r->report, map, key, "missing; expected %s", what);
}

/// A run of more steps than a life is long: a unit is wrong.
static void check_steps(LthReader *r, const LthNode *map) {
  double n = r->scene->duration / r->scene->step;
  if (r->scene->step > 0 && n > STEPS_MAX)
    lth_report(r->report, lth_node_find(map, "step"),
               "too many steps, got %.3g in %g s; expected at most %g: a longer step or a shorter "
               "duration",
               n, r->scene->duration, STEPS_MAX);
}

static void read_kind(LthReader *r, const LthNode *map, LthTimeKind kind) {
  static const char *const names[] = {"static", "quasistatic", "dynamic"};
  static const char *const integrators[] = {"implicit-euler", "newton-euler", "bdf2", "newmark",
                                            NULL};
  LthScene *scene = r->scene;
  scene->time_kind = kind;
  scene->duration = lth_read_number(map, "duration", kind == LTH_TIME_QUASISTATIC ? 1 : 0);
  scene->step = lth_read_number(map, "step", 0);
  scene->steps = lth_read_integer(map, "steps", 0);
  scene->integrator = (LthIntegrator)lth_read_word(map, "integrator", integrators);
  if (kind == LTH_TIME_DYNAMIC) {
    need_key(r, map, "duration", "a number > 0 [s]");
    need_key(r, map, "step", "a number > 0 [s]");
    check_steps(r, map);
  } else {
    refuse_key(r, map, "step", names[kind]);
    refuse_key(r, map, "integrator", names[kind]);
  }
  if (kind == LTH_TIME_QUASISTATIC)
    need_key(r, map, "steps", "an integer >= 1");
  else
    refuse_key(r, map, "steps", names[kind]);
  if (kind == LTH_TIME_STATIC) refuse_key(r, map, "duration", names[kind]);
}

/// A word alone where the kind needs more than its name.
static void refuse_word(LthReader *r, LthNode *time, LthTimeKind kind) {
  const char *example = kind == LTH_TIME_DYNAMIC ? "{kind: dynamic, duration: 2, step: 1/120}"
                                                 : "{kind: quasistatic, steps: 10}";
  r->scene->time_kind = kind;
  if (kind != LTH_TIME_STATIC)
    lth_report(r->report, time, "incomplete, got %s alone; expected a mapping such as %s",
               lth_show(r->arena, time), example);
}

void lth_read_time(LthReader *r) {
  static const char *const kinds[] = {"static", "quasistatic", "dynamic", NULL};
  LthNode *time = lth_node_find(r->root, "time");
  if (!time || time->bad) return;
  if (time->kind == LTH_NODE_SCALAR) {
    refuse_word(r, time, (LthTimeKind)lth_read_word(r->root, "time", kinds));
  } else if (lth_node_find(time, "dynamic")) {
    read_kind(r, lth_node_get(time, "dynamic"), LTH_TIME_DYNAMIC);
  } else if (lth_node_find(time, "quasistatic")) {
    read_kind(r, lth_node_get(time, "quasistatic"), LTH_TIME_QUASISTATIC);
  } else {
    need_key(r, time, "kind", "static, quasistatic or dynamic");
    if (lth_node_get(time, "kind"))
      read_kind(r, time, (LthTimeKind)lth_read_word(time, "kind", kinds));
  }
}

void lth_read_solver(LthReader *r) {
  static const char *const linear[] = {"auto", "cholesky", "pcg", "multigrid", NULL};
  const LthNode *solver = lth_node_get(r->root, "solver"), *newton = lth_node_get(solver, "newton");
  LthScene *scene = r->scene;
  scene->linear = (LthLinearChoice)lth_read_word(solver, "linear", linear);
  scene->tolerance = lth_read_number(solver, "tolerance", 1e-8);
  scene->threads = lth_read_integer(solver, "threads", 0);
  scene->newton_tolerance = lth_read_number(newton, "tolerance", 1e-8);
  scene->newton_iterations = lth_read_integer(newton, "iterations", 100);
  scene->condition = lth_read_flag(solver, "condition");
  scene->export_path = copy_text(r, lth_read_text(solver, "export"));
}

void lth_read_contact(LthReader *r) {
  static const char *const points[] = {"auto", "surface", "nodes", NULL};
  const LthNode *contact = lth_node_get(r->root, "contact");
  LthScene *scene = r->scene;
  scene->contact_stiffness = lth_read_number(contact, "stiffness", 0);
  scene->contact_friction = lth_read_number(contact, "friction", 0);
  scene->contact_damping = lth_read_number(contact, "damping", 0);
  scene->contact_bodies = lth_read_flag(contact, "bodies");
  int which = lth_read_word(contact, "points", points);
  bool has_embed = false;
  for (LitheIndex b = 0; b < scene->n_bodies; b++) has_embed |= scene->bodies[b].has_embed;
  scene->contact_points = (LthContactPoints)which;
  if (which == LTH_POINTS_SURFACE && !has_embed)
    lth_report(r->report, lth_node_find(contact, "points"),
               "no surface is embedded, got \"surface\"; expected "
               "nodes, or embed in the body");
}

void lth_read_probes(LthReader *r) {
  const LthNode *list = lth_node_get(r->root, "probes");
  LthScene *scene = r->scene;
  scene->probes = lth_read_array(r, list, sizeof *scene->probes);
  if (!scene->probes) return;
  for (const LthNode *node = list ? list->first : NULL; node; node = node->next) {
    LthSceneProbe *probe = &scene->probes[scene->n_probes++];
    const char *name = lth_read_text(node, "name");
    probe->name = copy_text(r, name ? name : "");
    lth_read_vector(node, "point", probe->point);
    for (LitheIndex i = 0; name && probe->name && i + 1 < scene->n_probes; i++) {
      if (!scene->probes[i].name || strcmp(scene->probes[i].name, name) != 0) continue;
      lth_report(r->report, lth_node_find(node, "name"),
                 "the name is taken, got %s twice; expected names that differ",
                 lth_show_text(r->arena, name));
      break;
    }
  }
}

void lth_read_exact(LthReader *r) {
  const LthNode *exact = lth_node_get(r->root, "exact");
  LthScene *scene = r->scene;
  scene->exact_is_position = lth_node_find(exact, "position") != NULL;
  scene->has_exact_displacement =
      lth_read_values(exact, scene->exact_is_position ? "position" : "displacement", scene->exact);
  scene->has_exact_stress = lth_read_tensor(exact, "stress", scene->exact_stress);
}

/// Does a word, or a list of words, name this format?
static bool names_format(const LthNode *node, const char *format) {
  if (!node) return false;
  if (node->kind == LTH_NODE_SCALAR) return lth_node_is_text(node, format);
  for (const LthNode *item = node->first; item; item = item->next)
    if (lth_node_is_text(item, format)) return true;
  return false;
}

static void check_none(LthReader *r, LthNode *node) {
  if (!node || node->kind != LTH_NODE_LIST || node->n_children < 2 || !names_format(node, "none"))
    return;
  lth_report(r->report, node, "none stands beside formats, got %s; expected one or the other",
             lth_show(r->arena, node));
}

/// Formats that no body of the scene has.
static void check_fields(LthReader *r, LthNode *fields) {
  bool any_grid = false, any_scan = false;
  for (LitheIndex b = 0; b < r->scene->n_bodies; b++) {
    const LthSceneBody *body = &r->scene->bodies[b];
    bool is_grid = body->method_kind == LTH_METHOD_STAGGERED;
    any_grid = any_grid || is_grid;
    any_scan = any_scan || (is_grid && body->shape.kind == LTH_SHAPE_IMAGE);
  }
  if (r->scene->fields_vti && !any_grid)
    lth_report(r->report, fields,
               "vti holds fields on a grid, got no body of `kind: staggered`; expected vtu");
  if (r->scene->fields_nifti && !any_scan)
    lth_report(r->report, fields,
               "nifti holds fields on the voxels of a scan, got no body of `kind: staggered` made "
               "from an image; expected vti or vtu");
}

void lth_read_output(LthReader *r) {
  static const char *const spaces[] = {"scene", "file", NULL};
  const LthNode *output = lth_node_get(r->root, "output"), *every = lth_node_get(output, "every");
  LthScene *scene = r->scene;
  scene->output_every = scene->time_kind == LTH_TIME_DYNAMIC ? FRAME : 0;
  if (every) scene->output_every = lth_node_is_text(every, "last") ? -1 : every->value.constant;
  scene->checkpoint_period = lth_read_number(output, "checkpoint", -1);
  const LthNode *fields = lth_node_get(output, "fields"),
                *surface = lth_node_get(output, "surface");
  check_none(r, lth_node_find(output, "fields"));
  check_none(r, lth_node_find(output, "surface"));
  scene->fields_vtu = names_format(fields, "vtu");
  scene->fields_unsaid = fields && fields->is_default;
  scene->fields_vti = names_format(fields, "vti");
  scene->fields_nifti = names_format(fields, "nifti");
  if (fields) check_fields(r, lth_node_find(output, "fields"));
  scene->surface_pc2 = names_format(surface, "pc2");
  scene->surface_obj = names_format(surface, "obj");
  scene->surface_ply = names_format(surface, "ply");
  scene->surface_stl = names_format(surface, "stl");
  scene->output_in_file_space = lth_read_word(output, "space", spaces) == 1;
  bool has_embed = false;
  for (LitheIndex b = 0; b < scene->n_bodies; b++) has_embed |= scene->bodies[b].has_embed;
  if (surface && !surface->is_default && !has_embed && !names_format(surface, "none") &&
      surface->n_children)
    lth_warn(
        r->ctx,
        "output.surface: no body has embed, so no surface is written; add `embed: {}` to the body");
}

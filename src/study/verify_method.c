/// What each method needs in a scene that was written for another one.
#include "study/verify.h"

#include <math.h>
#include <string.h>

static bool is_axis_box(const LthSceneBody *body) {
  return body->has_shape && body->shape.kind == LTH_SHAPE_BOX;
}

bool lth_verify_allows(const LthScene *scene, LthMethodKind kind, const char **why) {
  for (LitheIndex b = 0; b < scene->n_bodies; b++) {
    const LthSceneBody *body = scene->bodies + b;
    *why = NULL;
    if (scene->dimension == 2 && kind != LTH_METHOD_STAGGERED)
      *why = "it needs three dimensions";
    else if (!body->has_shape && kind == LTH_METHOD_STAGGERED)
      *why = "it needs a shape, not a mesh file";
    for (LitheIndex i = 0; i < body->n_materials && kind != LTH_METHOD_STAGGERED; i++)
      if (body->materials[i].material.model == LTH_MATERIAL_NEO_HOOKEAN)
        *why = "it has no neo-Hookean material";
    if (*why) return false;
  }
  return true;
}

double lth_verify_cells(const LthSceneBody *body) {
  const LthResolution *r = &body->resolution;
  double min[3], max[3], longest = 0, cells = 0;
  if (r->has_grid) {
    for (int a = 0; a < 3; a++) cells = fmax(cells, r->grid.cells[a]);
    return cells;
  }
  for (int a = 0; a < 3; a++) cells = fmax(cells, r->cells[a]);
  if (cells > 0) return cells;
  lth_shape_bounds(&body->shape, min, max);
  for (int a = 0; a < 3; a++) longest = fmax(longest, max[a] - min[a]);
  return r->cell_size > 0 ? ceil(longest / r->cell_size) : 16;
}

/// "cells: 12", "cells: [4, 12, 4]" or "grid: ...": as the scene has it, finer by a factor.
static const char *resolution(LthStudyRun *run, const LthSceneBody *body, double factor) {
  const LthResolution *r = &body->resolution;
  LitheIndex n[3];
  for (int a = 0; a < 3; a++)
    n[a] = (LitheIndex)fmax(1, round(factor * (r->has_grid ? r->grid.cells[a] : r->cells[a])));
  if (r->has_grid)
    return lth_study_print(
        run, "grid: {min: [%.17g, %.17g, %.17g], max: [%.17g, %.17g, %.17g], cells: [%d, %d, %d]}",
        r->grid.min[0], r->grid.min[1], r->grid.min[2], r->grid.max[0], r->grid.max[1],
        r->grid.max[2], n[0], n[1], n[2]);
  if (r->cells[1] > 0) return lth_study_print(run, "cells: [%d, %d, %d]", n[0], n[1], n[2]);
  return lth_study_print(run, "cells: %d", (int)fmax(1, round(factor * lth_verify_cells(body))));
}

/// Settings of a kind that the body is not of.
static const char *settings(const LthSceneBody *body, LthMethodKind kind) {
  if (kind == LTH_METHOD_DG) return "kind: dg, degree: 2";
  if (kind == LTH_METHOD_STAGGERED) return "kind: staggered";
  return is_axis_box(body) ? "kind: cg, mesh: hexahedra, degree: 2" : "kind: cg";
}

/// The body's own method, finer by a factor.
static const char *refined(LthStudyRun *run, const LthSceneBody *body, LitheIndex b,
                           double factor) {
  const LthResolution *r = &body->resolution;
  if (r->cell_size > 0)
    return lth_study_print(run, "bodies.%d.method.cell_size=%.17g", b, r->cell_size / factor);
  const char *text = resolution(run, body, factor), *value = strchr(text, ':') + 2;
  return lth_study_print(run, "bodies.%d.method.%s=%s", b, r->has_grid ? "grid" : "cells", value);
}

const char *lth_verify_override(LthStudyRun *run, const LthScene *scene, LitheIndex b,
                                const LthVerifyMethod *method, int level) {
  const LthSceneBody *body = scene->bodies + b;
  const LthMethodKind kind = method->kind;
  const double factor = method->cells[level] / lth_verify_cells(scene->bodies);
  if (b == 0 && method->file[level])
    return lth_study_print(run, "bodies.0.method={kind: cg, mesh: {file: \"%s\"}}",
                           method->file[level]);
  if (!body->has_shape) // elements of a file stay as they are
    return lth_study_print(run, "bodies.%d.method.kind=%s", b, kind == LTH_METHOD_CG ? "cg" : "dg");
  if (!method->settings && body->method_kind == kind) return refined(run, body, b, factor);
  return lth_study_print(run, "bodies.%d.method={%s, %s}", b,
                         method->settings ? method->settings : settings(body, kind),
                         resolution(run, body, factor));
}

/// The list of what is wrong with a surface, and the message that tells it.
#include "base/tensor.h"
#include "geometry/surface_clean.h"

#include <stdio.h>
#include <string.h>

static const struct {
  const char *one, *many, *remedy;
} kinds[LTH_DEFECT_KINDS] = {
    [LTH_DEFECT_OPEN_EDGE] = {"open edge", "open edges",
                              "close the holes (Blender: Mesh > Clean Up > Fill Holes)"},
    [LTH_DEFECT_NON_MANIFOLD] =
        {"edge with more than two triangles", "edges with more than two triangles",
         "remove doubled and inner faces (Blender: Select > All by Trait > Non "
         "Manifold shows them)"},
    [LTH_DEFECT_CROSSING] =
        {"pair of triangles that cross or overlap", "pairs of triangles that cross or overlap",
         "unite the parts (Blender: Boolean modifier, Union, Self Intersection)"},
    [LTH_DEFECT_UNORIENTABLE] = {"shell without an outside", "shells without an outside",
                                 "a one-sided surface encloses nothing; model it with a thickness"},
    [LTH_DEFECT_NESTING] =
        {"shell that faces the same way as the shell around it",
         "shells that face the same way as the shells around them",
         "turn the inner shell's normals over if it is a cavity, delete it if it "
         "lies within the solid"},
};

const char *lth_defect_text(LthDefectKind kind) { return kinds[kind].one; }

void lth_defects_free(LitheCtx *ctx, LthDefects *defects) {
  if (!defects) return;
  lth_free(ctx, defects->kind);
  lth_free(ctx, defects->segment);
  *defects = (LthDefects){0};
}

LitheStatus lth_defects_add(LitheCtx *ctx, LthDefects *defects, LthDefectKind kind,
                            const double a[3], const double b[3]) {
  if (defects->count[kind] < INT32_MAX) defects->count[kind]++;
  if (defects->count[kind] > LTH_DEFECTS_KEPT) return LITHE_OK;
  LTH_RESERVE(ctx, defects->kind, defects->cap, (LitheCount)defects->n + 1);
  LTH_RESERVE(ctx, defects->segment, defects->segment_cap, 6 * ((LitheCount)defects->n + 1));
  defects->kind[defects->n] = kind;
  lth_v3_copy(a, defects->segment + 6 * (size_t)defects->n);
  lth_v3_copy(b, defects->segment + 6 * (size_t)defects->n + 3);
  defects->n++;
  return LITHE_OK;
}

/// The first defect of a kind.
static const double *first_place(const LthDefects *defects, LthDefectKind kind) {
  for (LitheIndex i = 0; i < defects->n; i++)
    if (defects->kind[i] == kind) return defects->segment + 6 * (size_t)i;
  return NULL;
}

typedef struct Text {
  char at[2048];
  size_t n;
} Text;

__attribute__((format(printf, 2, 3))) static void append(Text *text, const char *format, ...) {
  va_list args;
  va_start(args, format);
  int n = vsnprintf(text->at + text->n, sizeof text->at - text->n, format, args);
  va_end(args);
  if (n > 0) text->n += (size_t)n;
  if (text->n >= sizeof text->at) text->n = sizeof text->at - 1;
}

LitheStatus lth_defects_check(LitheCtx *ctx, const LthDefects *defects, const char *name) {
  Text found = {.n = 0}, remedy = {.n = 0};
  if (defects->n == 0) return LITHE_OK;
  for (int k = 0; k < LTH_DEFECT_KINDS; k++) {
    LitheIndex n = defects->count[k];
    const double *s = first_place(defects, (LthDefectKind)k);
    if (n == 0 || !s) continue;
    append(&found, "%s%d %s (%sfrom (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g))", found.n ? ", " : "",
           n, n == 1 ? kinds[k].one : kinds[k].many, n == 1 ? "" : "the first ", s[0], s[1], s[2],
           s[3], s[4], s[5]);
    append(&remedy, "%s%s", remedy.n ? "; " : "", kinds[k].remedy);
  }
  LITHE_FAIL(
      ctx, LITHE_BAD_INPUT,
      "%s: the surface is not the boundary of a solid: %s. What helps: %s. Places are in the "
      "file's own coordinates",
      name, found.at, remedy.at);
}

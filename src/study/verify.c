/// `lithe verify`: a scene read once for every method and resolution, run, and compared.
#include "lithe/verify.h"

#include "io/file.h"
#include "io/text.h"
#include "scene/scene_public.h"
#include "study/study_book.h"
#include "study/verify.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define METHODS_MAX 3

LitheVerifyDef lithe_verify_def_default(void) { return (LitheVerifyDef){.tolerance = 0.01}; }

typedef struct Verify {
  LthStudy study;
  LthStudyRun *run;
  const LitheVerifyDef *def;
  const LthScene *scene; ///< as it stands in the file
  LthVerifyMethod method[METHODS_MAX];
  int n_methods;
} Verify;

static const struct {
  const char *name;
  LthMethodKind kind;
} kinds[] = {{"dg", LTH_METHOD_DG}, {"staggered", LTH_METHOD_STAGGERED}, {"cg", LTH_METHOD_CG}};

/// Is `name` an entry of a list of words behind commas?
static bool is_listed(const char *list, const char *name) {
  size_t length = strlen(name);
  for (const char *at = list; at; at = strchr(at, ','), at = at ? at + 1 : NULL)
    if (strncmp(at, name, length) == 0 && (at[length] == ',' || at[length] == 0)) return true;
  return false;
}

static LitheStatus check_names(LitheCtx *ctx, const char *list) {
  int n = list ? 1 : 0, known = 0;
  for (const char *at = list; at && *at; at++) n += *at == ',';
  for (size_t i = 0; list && i < sizeof kinds / sizeof kinds[0]; i++)
    known += is_listed(list, kinds[i].name);
  if (n == known) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT, "--methods %s: expected some of dg,staggered,cg", list);
}

/// In the plane there is one method only: two kinds of fractions are compared.
static void choose_plane(Verify *v) {
  static const char *const fractions[] = {"exact", "smooth"};
  for (int i = 0; i < 2; i++)
    v->method[v->n_methods++] = (LthVerifyMethod){
        .kind = LTH_METHOD_STAGGERED,
        .name = fractions[i],
        .settings = lth_study_print(v->run, "kind: staggered, fractions: %s", fractions[i])};
}

static LitheStatus choose_methods(Verify *v) {
  LitheCtx *ctx = v->run->ctx;
  const char *left_out = "";
  LITHE_TRY(check_names(ctx, v->def->methods));
  if (v->scene->dimension == 2) {
    choose_plane(v);
    return LITHE_OK;
  }
  for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
    const char *why;
    if (v->def->methods && !is_listed(v->def->methods, kinds[i].name)) continue;
    if (lth_verify_allows(v->scene, kinds[i].kind, &why)) {
      v->method[v->n_methods++] = (LthVerifyMethod){.kind = kinds[i].kind, .name = kinds[i].name};
      continue;
    }
    left_out = lth_study_print(v->run, "%s %s is left out: %s.", left_out, kinds[i].name, why);
  }
  if (*left_out) lth_study_say(&v->run->report, "%s", left_out + 1);
  if (v->n_methods >= 2) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT, "%s: fewer than two methods are left to compare.%s",
             v->def->scene, left_out);
}

/// Of "8,16,32" or "dg:8,16;staggered:16,32,64" the part for a method: that with its name, else the one without a name.
static LthWord cells_of(const char *list, const char *name) {
  LthWord found = {NULL, 0};
  for (const char *at = list; at; at = strchr(at, ';'), at = at ? at + 1 : NULL) {
    size_t length = strcspn(at, ";"), named = strcspn(at, ":;");
    bool has_name = at[named] == ':';
    if (has_name && (named != strlen(name) || strncmp(at, name, named) != 0)) continue;
    if (!has_name && found.at) continue;
    found = has_name ? (LthWord){at + named + 1, length - named - 1} : (LthWord){at, length};
    if (has_name) break;
  }
  return found;
}

static LitheStatus read_cells(Verify *v, LthWord list, LthVerifyMethod *m) {
  const char *end = list.at + list.length;
  for (const char *at = list.at; at;) {
    size_t length = strcspn(at, ",;");
    double value = 0;
    bool is_number = lth_word_number((LthWord){at, length}, &value);
    if (!is_number || !(value >= 1) || m->n_levels == LTH_VERIFY_LEVELS_MAX)
      LITHE_FAIL(v->run->ctx, LITHE_BAD_INPUT,
                 "--cells %s: expected 1 to %d rising numbers of cells, as in 8,16,32 or "
                 "\"dg:8,16,32;staggered:16,32,64\"",
                 v->def->cells, LTH_VERIFY_LEVELS_MAX);
    m->cells[m->n_levels++] = value;
    at = at + length < end ? at + length + 1 : NULL;
  }
  return LITHE_OK;
}

/// Every name in front of a part of the list is that of a method here.
static LitheStatus check_parts(Verify *v) {
  for (const char *at = v->def->cells; at; at = strchr(at, ';'), at = at ? at + 1 : NULL) {
    size_t named = strcspn(at, ":;");
    bool known = at[named] != ':';
    for (int m = 0; m < v->n_methods; m++)
      known |= named == strlen(v->method[m].name) && strncmp(at, v->method[m].name, named) == 0;
    if (!known)
      LITHE_FAIL(v->run->ctx, LITHE_BAD_INPUT,
                 "--cells %s: %.*s is none of the methods that are compared", v->def->cells,
                 (int)named, at);
  }
  return LITHE_OK;
}

/// Resolutions along the longest side: the same for all methods, unless the list tells them apart.
static LitheStatus choose_cells(Verify *v) {
  double own = lth_verify_cells(v->scene->bodies);
  LITHE_TRY(check_parts(v));
  for (int k = 0; k < v->n_methods; k++) {
    LthVerifyMethod *m = &v->method[k];
    LthWord list = cells_of(v->def->cells, m->name);
    m->n_levels = 0;
    if (list.at) LITHE_TRY(read_cells(v, list, m));
    for (int i = 0; !list.at && i < 3; i++)
      m->cells[m->n_levels++] = fmax(1, round(own * (1 << i) / 2));
  }
  return LITHE_OK;
}

/// Mesh files for cg, coarse to fine; their resolution is known once they have run.
static LitheStatus choose_files(Verify *v) {
  for (int m = 0; m < v->n_methods && v->def->meshes; m++) {
    LthVerifyMethod *method = v->method + m;
    int n = 0;
    if (method->kind != LTH_METHOD_CG) continue;
    for (const char *at = v->def->meshes; at;) {
      size_t length = strcspn(at, ",");
      if (length == 0 || n == LTH_VERIFY_LEVELS_MAX)
        LITHE_FAIL(v->run->ctx, LITHE_BAD_INPUT,
                   "--meshes %s: expected 1 to %d files, coarse to fine, as in a.msh,b.msh",
                   v->def->meshes, LTH_VERIFY_LEVELS_MAX);
      method->file[n++] = lth_study_print(v->run, "%.*s", (int)length, at);
      at = at[length] ? at + length + 1 : NULL;
    }
    method->n_levels = n;
  }
  return LITHE_OK;
}

static LitheStatus run_level(Verify *v, const LthVerifyMethod *m, int level,
                             LthStudyResult *result) {
  LthStudyRun *run = v->run;
  const LitheVerifyDef *def = v->def;
  LitheScene *scene = NULL;
  LitheResult *out = NULL;
  int n = def->n_overrides + v->scene->n_bodies;
  const char **sets = lth_arena_take(&run->arena, sizeof *sets * (size_t)n);
  if (!sets) LITHE_FAIL(run->ctx, LITHE_NO_MEMORY, "out of memory in a comparison");
  for (int i = 0; i < def->n_overrides; i++) sets[i] = def->overrides[i];
  for (LitheIndex b = 0; b < v->scene->n_bodies; b++)
    sets[def->n_overrides + b] = lth_verify_override(run, v->scene, b, m, level);
  LitheSceneDef scene_def = lithe_scene_def_default();
  scene_def.file = def->scene;
  scene_def.overrides = sets;
  scene_def.n_overrides = n;
  const char *folder = lth_study_print(run, "%s/%s-%d", run->folder, m->name,
                                       m->file[level] ? level + 1 : (int)m->cells[level]);
  LitheStatus status = lithe_scene_read(run->ctx, &scene_def, &scene);
  if (status == LITHE_OK) status = lithe_run(run->ctx, scene, folder, &out);
  if (status == LITHE_OK || status == LITHE_NOT_CONVERGED) {
    result->status = status;
    status = lth_study_parse(run, lithe_result_json(out), &result->json);
  }
  lithe_result_destroy(run->ctx, &out);
  lithe_scene_destroy(run->ctx, &scene);
  return status;
}

static LitheStatus run_all(Verify *v) {
  for (int m = 0; m < v->n_methods; m++) {
    LthVerifyMethod *method = v->method + m;
    LthStudyResult *result = lth_arena_take(&v->run->arena, sizeof *result * LTH_VERIFY_LEVELS_MAX);
    if (!result) LITHE_FAIL(v->run->ctx, LITHE_NO_MEMORY, "out of memory in a comparison");
    method->result = result;
    for (int i = 0; i < method->n_levels; i++) {
      lth_progress(v->run->ctx, lth_study_print(v->run, "%s, level %d", method->name, i + 1),
                   (m + (double)i / method->n_levels) / v->n_methods);
      LITHE_TRY(run_level(v, method, i, result + i));
      if (method->file[i]) // as many elements as a cube with so many along its side
        method->cells[i] = cbrt(lth_study_number(result + i, "bodies.0.elements"));
    }
  }
  return LITHE_OK;
}

static LitheStatus compare(Verify *v) {
  LITHE_TRY(choose_methods(v));
  LITHE_TRY(choose_cells(v));
  LITHE_TRY(choose_files(v));
  LITHE_TRY(run_all(v));
  lth_verify_report(v->run, v->n_methods, v->method, v->def->tolerance);
  return LITHE_OK;
}

/// As LthBookFill.
static LitheStatus verify_into(LthBook *book, void *self) {
  Verify *v = self;
  LitheScene *scene = NULL;
  LitheStudyDef teller = lithe_study_def_default();
  teller.tell = v->def->tell;
  teller.tell_user = v->def->tell_user;
  v->study = (LthStudy){
      .name = "verify", .title = v->def->scene, .question = "Do the methods agree, and on what?"};
  LITHE_TRY(lth_book_add(book, &v->study, "", &v->run));
  LitheSceneDef scene_def = lithe_scene_def_default();
  scene_def.file = v->def->scene;
  scene_def.overrides = v->def->overrides;
  scene_def.n_overrides = v->def->n_overrides;
  LitheStatus status = lithe_scene_read(book->ctx, &scene_def, &scene);
  if (status == LITHE_OK) {
    v->scene = scene->scene;
    status = compare(v);
  }
  lithe_scene_destroy(book->ctx, &scene);
  LITHE_TRY(status);
  return lth_book_finish(book, v->run, LITHE_OK, &teller);
}

LitheStatus lithe_verify(LitheCtx *ctx, const LitheVerifyDef *def, LitheStudyResult **result) {
  Verify v = {.def = def};
  char *folder, title[300], command[600];
  if (!(def->tolerance > 0))
    LITHE_FAIL(ctx, LITHE_BAD_INPUT, "--tolerance: expected a positive share, got %g",
               def->tolerance);
  snprintf(title, sizeof title, "Lithe: %s by several methods", def->scene);
  snprintf(command, sizeof command, "lithe verify %s", def->scene);
  LITHE_TRY(lth_book_folder(ctx, def->folder, def->scene, "verify", &folder));
  LitheStatus status = lth_book_make(ctx, folder, title, command, verify_into, &v, result);
  lth_free(ctx, folder);
  return status;
}

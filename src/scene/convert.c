/// Decks of CalculiX and Abaqus to scenes: which cards are translated, which are left aside, which refused.
#include "scene/convert.h"

#include "io/file.h"
#include "io/inp_mesh.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

LitheConvertDef lithe_convert_def_default(void) { return (LitheConvertDef){0}; }

typedef LitheStatus (*ReadCard)(LthConvert *c, const LthInpCard *card);

static LitheStatus read_step(LthConvert *c, const LthInpCard *card) {
  const char *nonlinear = lth_inp_parameter(card, "NLGEOM");
  if (nonlinear && !lth_word_is_any_case((LthWord){nonlinear, strlen(nonlinear)}, "NO"))
    LITHE_FAIL(
        c->ctx, LITHE_UNSUPPORTED,
        "%s:%d: *STEP: NLGEOM (large strains) cannot be translated, Lithe's corotated material "
        "is another one; without NLGEOM the deck can",
        card->file, card->line);
  c->step++;
  c->analysis = NULL;
  memset(c->renewed, 0, sizeof c->renewed);
  return LITHE_OK;
}

static LitheStatus read_static(LthConvert *c, const LthInpCard *card) {
  c->analysis = card;
  return LITHE_OK;
}

static LitheStatus read_end(LthConvert *c, const LthInpCard *card) {
  if (c->analysis) return LITHE_OK;
  return lth_inp_card_fail(c->ctx, card, "the step has no *STATIC, expected one");
}

static LitheStatus read_heading(LthConvert *c, const LthInpCard *card) {
  if (card->n_rows == 0 || c->title) return LITHE_OK;
  const LthInpLine *line = &c->deck->lines[card->first_row];
  LthText text = lth_text(c->ctx, "", line->at, (size_t)line->length);
  LthWord rest = lth_text_rest(&text);
  if (rest.length == 0) return LITHE_OK;
  LTH_NEW(c->ctx, c->title, (LitheCount)rest.length + 1);
  memcpy(c->title, rest.at, rest.length);
  return LITHE_OK;
}

/// Types of elements that cg computes as CalculiX does, but for how C3D8R holds its hourglasses.
static LitheStatus check_element(LthConvert *c, const LthInpCard *card) {
  static const char *const types[] = {"C3D4",  "C3D6",  "C3D8",  "C3D8R",
                                      "C3D10", "C3D15", "C3D20", "C3D20R"};
  const char *type = lth_inp_parameter(card, "TYPE");
  if (!type) return lth_inp_card_fail(c->ctx, card, "TYPE is missing");
  LthWord word = {type, strlen(type)};
  for (size_t i = 0; i < sizeof types / sizeof types[0]; i++)
    if (lth_word_is_any_case(word, types[i])) return LITHE_OK;
  LITHE_FAIL(
      c->ctx, LITHE_UNSUPPORTED,
      "%s:%d: *ELEMENT: TYPE=%s cannot be translated; C3D4, C3D6, C3D8, C3D8R, C3D10, C3D15, "
      "C3D20 and C3D20R can",
      card->file, card->line, type);
}

/// Cards that are translated; `parameters`: what they may have, NULL: anything, for the reader of meshes has
/// looked, or the card only asks for output.
static const struct {
  const char *keyword;
  ReadCard read;
  const char *parameters;
} known[] = {
    {"HEADING", read_heading, NULL},
    {"NODE", NULL, NULL},
    {"ELEMENT", NULL, NULL},
    {"NSET", NULL, NULL},
    {"ELSET", NULL, NULL},
    {"SURFACE", NULL, NULL},
    {"INCLUDE", NULL, NULL},
    {"MATERIAL", lth_convert_material, "NAME"},
    {"ELASTIC", lth_convert_elastic, "TYPE"},
    {"DENSITY", lth_convert_density, ""},
    {"SOLIDSECTION", lth_convert_section, "ELSET MATERIAL"},
    {"AMPLITUDE", lth_convert_amplitude, NULL},
    {"STEP", read_step, "INC NLGEOM AMPLITUDE NAME"},
    {"STATIC", read_static, "SOLVER DIRECT"},
    {"ENDSTEP", read_end, ""},
    {"BOUNDARY", lth_convert_boundary, "OP AMPLITUDE"},
    {"CLOAD", lth_convert_cload, "OP AMPLITUDE"},
    {"DLOAD", lth_convert_dload, "OP AMPLITUDE"},
    {"DSLOAD", lth_convert_dsload, "OP AMPLITUDE"},
    {"NODEPRINT", NULL, NULL},
    {"ELPRINT", NULL, NULL},
    {"NODEFILE", NULL, NULL},
    {"ELFILE", NULL, NULL},
    {"NODEOUTPUT", NULL, NULL},
    {"ELEMENTOUTPUT", NULL, NULL},
    {"OUTPUT", NULL, NULL},
    {"FILEFORMAT", NULL, NULL},
    {"PREPRINT", NULL, NULL},
};

/// Cards that are refused, and what they stand for.
static const struct {
  const char *keyword, *meaning;
} refused[] = {
    {"PLASTIC", "plasticity"},
    {"CYCLICHARDENING", "plasticity"},
    {"DEFORMATIONPLASTICITY", "plasticity"},
    {"CREEP", "creep"},
    {"VISCO", "creep"},
    {"HYPERELASTIC", "a hyperelastic material"},
    {"HYPERFOAM", "a hyperelastic material"},
    {"USERMATERIAL", "a user material"},
    {"CONTACTPAIR", "contact"},
    {"SURFACEINTERACTION", "contact"},
    {"TIE", "a tie of surfaces"},
    {"SHELLSECTION", "shells"},
    {"MEMBRANESECTION", "membranes"},
    {"BEAMSECTION", "beams"},
    {"BEAMGENERALSECTION", "beams"},
    {"FLUIDSECTION", "a flow"},
    {"GAP", "gaps"},
    {"SPRING", "springs"},
    {"DASHPOT", "dashpots"},
    {"MASS", "point masses"},
    {"EXPANSION", "thermal expansion"},
    {"TEMPERATURE", "temperatures"},
    {"CONDUCTIVITY", "heat conduction"},
    {"HEATTRANSFER", "heat conduction"},
    {"COUPLEDTEMPERATURE-DISPLACEMENT", "temperatures"},
    {"UNCOUPLEDTEMPERATURE-DISPLACEMENT", "temperatures"},
    {"INITIALCONDITIONS", "an initial state"},
    {"FREQUENCY", "eigenfrequencies"},
    {"COMPLEXFREQUENCY", "eigenfrequencies"},
    {"BUCKLE", "buckling"},
    {"DYNAMIC", "dynamics; *STATIC can be translated"},
    {"MODALDYNAMIC", "modal dynamics"},
    {"STEADYSTATEDYNAMICS", "steady-state dynamics"},
    {"SENSITIVITY", "sensitivities"},
    {"GREEN", "Green's functions"},
    {"ELECTROMAGNETICS", "electromagnetics"},
    {"EQUATION", "a linear equation between displacements"},
    {"MPC", "a constraint between displacements"},
    {"RIGIDBODY", "a rigid part"},
    {"COUPLING", "a coupling of nodes"},
    {"DISTRIBUTINGCOUPLING", "a coupling of nodes"},
    {"CYCLICSYMMETRYMODEL", "cyclic symmetry"},
    {"TRANSFORM", "supports and forces along axes of their own"},
    {"ORIENTATION", "materials along axes of their own"},
    {"SUBMODEL", "displacements from another run"},
    {"SUBSTRUCTUREGENERATE", "substructures"},
    {"PRE-TENSIONSECTION", "pre-tension"},
    {"MODELCHANGE", "parts that come and go"},
    {"CHANGEMATERIAL", "materials that change"},
    {"CHANGESOLIDSECTION", "sections that change"},
    {"NOANALYSIS", "a run that solves nothing"},
    {"RESTART", "the state of another run"},
};

static LitheStatus refuse(LthConvert *c, const LthInpCard *card) {
  for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++)
    if (lth_inp_is(card, refused[i].keyword))
      LITHE_FAIL(c->ctx, LITHE_UNSUPPORTED, "%s:%d: *%s: %s cannot be translated", card->file,
                 card->line, card->keyword, refused[i].meaning);
  LITHE_FAIL(c->ctx, LITHE_UNSUPPORTED,
             "%s:%d: *%s: this card cannot be translated; linear elastic static solids can",
             card->file, card->line, card->keyword);
}

static bool is_listed(const char *list, const char *word) {
  size_t length = strlen(word);
  for (const char *at = list; (at = strstr(at, word)) != NULL; at += length)
    if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == 0)) return true;
  return false;
}

static LitheStatus check_parameters(LthConvert *c, const LthInpCard *card, const char *list) {
  for (int i = 0; i < card->n_parameters && list; i++)
    if (!is_listed(list, card->parameters[i].name))
      LITHE_FAIL(c->ctx, LITHE_UNSUPPORTED, "%s:%d: *%s: %s cannot be translated", card->file,
                 card->line, card->keyword, card->parameters[i].name);
  return LITHE_OK;
}

static LitheStatus read_card(LthConvert *c, const LthInpCard *card) {
  for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
    if (!lth_inp_is(card, known[i].keyword)) continue;
    LITHE_TRY(check_parameters(c, card, known[i].parameters));
    return known[i].read ? known[i].read(c, card) : LITHE_OK;
  }
  if (lth_inp_is(card, "RESTART") && lth_inp_parameter(card, "WRITE")) return LITHE_OK;
  return refuse(c, card);
}

/// What a later step asks for may be out of reach where the first one is not.
static LitheStatus read_card_of_step(LthConvert *c, const LthInpCard *card) {
  int step = c->step + lth_inp_is(card, "STEP");
  LitheStatus status = read_card(c, card);
  if (status != LITHE_UNSUPPORTED || step < 2) return status;
  char message[1024];
  snprintf(message, sizeof message, "%s", lithe_ctx_message(c->ctx));
  LITHE_FAIL(c->ctx, status, "%s (step %d; --step %d translates what is before it)", message, step,
             step - 1);
}

/// All cards up to the end of the step that is wanted.
static LitheStatus read_cards(LthConvert *c) {
  bool done = false;
  for (LitheIndex i = 0; i < c->deck->n_cards && !done; i++) {
    const LthInpCard *card = &c->deck->cards[i];
    LITHE_TRY(read_card_of_step(c, card));
    done = c->def->step > 0 && c->step == c->def->step && lth_inp_is(card, "END STEP");
  }
  if (c->step == 0)
    LITHE_FAIL(c->ctx, LITHE_BAD_INPUT, "%s: there is no *STEP, expected at least one",
               c->def->deck);
  if (c->step < c->def->step)
    LITHE_FAIL(c->ctx, LITHE_BAD_INPUT, "%s: there is no step %d, the deck has %d", c->def->deck,
               c->def->step, c->step);
  return lth_convert_check(c);
}

static LitheStatus open_deck(LthConvert *c) {
  LitheIndex twice;
  LITHE_TRY(lth_inp_deck_read(c->ctx, c->def->deck, &c->deck));
  // before the reader of meshes leaves out what it does not know
  for (LitheIndex i = 0; i < c->deck->n_cards; i++)
    if (lth_inp_is(&c->deck->cards[i], "ELEMENT")) LITHE_TRY(check_element(c, &c->deck->cards[i]));
  LITHE_TRY(lth_inp_mesh_create(c->ctx, c->deck, 1, &c->mesh));
  LITHE_TRY(lth_id_map_create(c->ctx, c->mesh->node_id, c->mesh->n_nodes, &c->node_of, &twice));
  LITHE_TRY(
      lth_id_map_create(c->ctx, c->mesh->element_id, c->mesh->n_elements, &c->element_of, &twice));
  LitheCount n = 3 * (LitheCount)c->mesh->n_nodes,
             m = LTH_CONVERT_FACES * (LitheCount)c->mesh->n_elements;
  LTH_NEW(c->ctx, c->is_held, n);
  LTH_NEW(c->ctx, c->held, n);
  LTH_NEW(c->ctx, c->force, n);
  LTH_NEW(c->ctx, c->force_step, n);
  LTH_NEW(c->ctx, c->pressure, m);
  LTH_NEW(c->ctx, c->pressure_step, m);
  return LITHE_OK;
}

static void close_deck(LthConvert *c) {
  for (LitheIndex i = 0; i < c->n_materials; i++) lth_free(c->ctx, c->materials[i].name);
  lth_free(c->ctx, c->materials);
  lth_free(c->ctx, c->sections);
  lth_free(c->ctx, c->amplitudes);
  lth_free(c->ctx, c->body_forces);
  lth_free(c->ctx, c->title);
  lth_free(c->ctx, c->is_held);
  lth_free(c->ctx, c->held);
  lth_free(c->ctx, c->force);
  lth_free(c->ctx, c->force_step);
  lth_free(c->ctx, c->pressure);
  lth_free(c->ctx, c->pressure_step);
  lth_id_map_free(c->ctx, &c->node_of);
  lth_id_map_free(c->ctx, &c->element_of);
  lth_element_mesh_destroy(c->ctx, &c->mesh);
  lth_inp_deck_destroy(c->ctx, &c->deck);
}

/// Length of a path's folder with its slash.
static size_t folder_length(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? (size_t)(slash - path) + 1 : 0;
}

/// The deck as a file in the scene's folder names it: by its name where both are in one folder, else from the root.
static LitheStatus name_deck(LthConvert *c, char **name) {
  const char *deck = c->def->deck, *scene = c->def->scene;
  size_t length = folder_length(deck);
  if (length == folder_length(scene) && memcmp(deck, scene, length) == 0)
    return lth_copy_text(c->ctx, deck + length, name);
  char *whole = realpath(deck, NULL);
  if (!whole) LITHE_FAIL(c->ctx, LITHE_BAD_INPUT, "%s: cannot be read", deck);
  LitheStatus status = lth_copy_text(c->ctx, whole, name);
  free(whole);
  return status;
}

/// "folder/scene-sets.inp" from "folder/scene.yaml".
static LitheStatus name_sets_file(LthConvert *c, char **path) {
  static const char ending[] = "-sets.inp";
  const char *scene = c->def->scene, *name = scene + folder_length(scene);
  const char *dot = strrchr(name, '.');
  size_t length = dot && dot != name ? (size_t)(dot - scene) : strlen(scene);
  LTH_NEW(c->ctx, *path, (LitheCount)(length + sizeof ending));
  memcpy(*path, scene, length);
  memcpy(*path + length, ending, sizeof ending);
  return LITHE_OK;
}

/// Write both files; the scene last, so that it never names a mesh that is not there.
static LitheStatus write(LthConvert *c, LthConvertScene *scene) {
  LitheStatus status = LITHE_OK;
  char *deck = NULL, *sets = NULL;
  LITHE_TRY_OR(done, name_deck(c, &deck));
  if (scene->n_new > 0) {
    LITHE_TRY_OR(done, name_sets_file(c, &sets));
    LITHE_TRY_OR(done, lth_convert_write_sets(c, scene, sets, deck));
    LITHE_TRY_OR(done, lth_copy_text(c->ctx, sets + folder_length(sets), &scene->mesh));
  } else {
    scene->mesh = deck;
    deck = NULL;
  }
  status = lth_convert_write_scene(c, scene);
done:
  lth_free(c->ctx, deck);
  lth_free(c->ctx, sets);
  return status;
}

static LitheStatus gather(LthConvert *c, LthConvertScene *scene) {
  LITHE_TRY(lth_convert_holds(c, &scene->holds));
  LITHE_TRY(lth_convert_forces(c, &scene->forces));
  LITHE_TRY(lth_convert_pressures(c, &scene->pressures));
  LITHE_TRY(lth_convert_name_sets(c, "HELD", &scene->holds, &scene->n_new));
  LITHE_TRY(lth_convert_name_sets(c, "LOADED", &scene->forces, &scene->n_new));
  return lth_convert_name_sets(c, "PRESSED", &scene->pressures, &scene->n_new);
}

static void report(const LthConvert *c, const LthConvertScene *scene, LitheConversion *conversion) {
  LitheIndex n_loads = scene->forces.n + scene->pressures.n + c->n_body_forces;
  *conversion = (LitheConversion){.elements = c->mesh->n_elements,
                                  .nodes = c->mesh->n_nodes,
                                  .materials = c->n_materials,
                                  .constraints = scene->holds.n,
                                  .loads = n_loads,
                                  .sets = scene->n_new};
  snprintf(conversion->mesh, sizeof conversion->mesh, "%s", scene->mesh);
}

LitheStatus lithe_convert(LitheCtx *ctx, const LitheConvertDef *def, LitheConversion *conversion) {
  LthConvert c = {.ctx = ctx, .def = def};
  LthConvertScene scene = {0};
  LitheStatus status = LITHE_OK;
  *conversion = (LitheConversion){0};
  LITHE_TRY_OR(done, open_deck(&c));
  LITHE_TRY_OR(done, read_cards(&c));
  LITHE_TRY_OR(done, gather(&c, &scene));
  LITHE_TRY_OR(done, write(&c, &scene));
  report(&c, &scene, conversion);

done:
  lth_convert_sets_free(ctx, &scene.holds);
  lth_convert_sets_free(ctx, &scene.forces);
  lth_convert_sets_free(ctx, &scene.pressures);
  lth_free(ctx, scene.mesh);
  close_deck(&c);
  return status;
}

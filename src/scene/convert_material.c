/// Materials, sections and amplitudes of a deck.
#include "scene/convert.h"

#include <math.h>
#include <string.h>

LitheStatus lth_convert_material(LthConvert *c, const LthInpCard *card) {
  const char *name = lth_inp_parameter(card, "NAME");
  if (!name || !*name) return lth_inp_card_fail(c->ctx, card, "NAME is missing");
  LTH_RESERVE(c->ctx, c->materials, c->cap_materials, c->n_materials + 1);
  LthConvertMaterial *m = &c->materials[c->n_materials++];
  *m = (LthConvertMaterial){.card = card, .poisson = NAN};
  return lth_copy_text(c->ctx, name, &m->name);
}

/// The material that a card speaks of, and its one line.
static LitheStatus of_material(LthConvert *c, const LthInpCard *card, LthConvertMaterial **m,
                               LthInpRow *row) {
  if (c->n_materials == 0)
    return lth_inp_card_fail(c->ctx, card, "stands before any *MATERIAL, expected one");
  if (card->n_rows == 0) return lth_inp_card_fail(c->ctx, card, "has no line of values");
  if (card->n_rows > 1) {
    LITHE_TRY(lth_inp_row(c->ctx, c->deck, card->first_row + 1, row));
    return lth_fail(c->ctx, LITHE_UNSUPPORTED,
                    "%s:%d: *%s: more than one line, values that depend on temperature cannot be "
                    "translated; keep one line",
                    row->file, row->line, card->keyword);
  }
  *m = &c->materials[c->n_materials - 1];
  return lth_inp_row(c->ctx, c->deck, card->first_row, row);
}

static bool is_isotropic(const char *type) {
  LthWord word = {type, strlen(type)};
  return lth_word_is_any_case(word, "ISO") || lth_word_is_any_case(word, "ISOTROPIC");
}

LitheStatus lth_convert_elastic(LthConvert *c, const LthInpCard *card) {
  LthConvertMaterial *m = NULL;
  LthInpRow row;
  const char *type = lth_inp_parameter(card, "TYPE");
  if (type && !is_isotropic(type))
    LITHE_FAIL(c->ctx, LITHE_UNSUPPORTED,
               "%s:%d: *ELASTIC: TYPE=%s cannot be translated; only isotropic materials can",
               card->file, card->line, type);
  LITHE_TRY(of_material(c, card, &m, &row));
  LITHE_TRY(lth_inp_row_number(&row, 0, "Young's modulus", &m->young));
  LITHE_TRY(lth_inp_row_number(&row, 1, "Poisson's ratio", &m->poisson));
  if (!(m->young > 0))
    return lth_inp_row_fail(&row, "Young's modulus is %g, expected a number > 0", m->young);
  if (!(m->poisson > -1 && m->poisson < 0.5))
    return lth_inp_row_fail(&row, "Poisson's ratio is %g, expected a number > -1 and < 0.5",
                            m->poisson);
  return LITHE_OK;
}

LitheStatus lth_convert_density(LthConvert *c, const LthInpCard *card) {
  LthConvertMaterial *m = NULL;
  LthInpRow row;
  LITHE_TRY(of_material(c, card, &m, &row));
  LITHE_TRY(lth_inp_row_number(&row, 0, "density", &m->density));
  if (!(m->density > 0))
    return lth_inp_row_fail(&row, "density is %g, expected a number > 0", m->density);
  return LITHE_OK;
}

static LitheIndex find_material(const LthConvert *c, const char *name) {
  LthWord word = {name, strlen(name)};
  for (LitheIndex i = c->n_materials; i-- > 0;)
    if (lth_word_is_any_case(word, c->materials[i].name)) return i;
  return -1;
}

LitheStatus lth_convert_section(LthConvert *c, const LthInpCard *card) {
  const char *set = lth_inp_parameter(card, "ELSET");
  if (!set || !lth_inp_parameter(card, "MATERIAL"))
    return lth_inp_card_fail(c->ctx, card, "%s is missing", set ? "MATERIAL" : "ELSET");
  LthConvertSection section = {
      .card = card,
      .elements = lth_convert_group(c, LTH_GROUP_ELEMENTS, (LthWord){set, strlen(set)}),
      .material = -1};
  if (!section.elements)
    return lth_inp_card_fail(c->ctx, card, "there is no set of elements '%s'", set);
  LTH_RESERVE(c->ctx, c->sections, c->cap_sections, c->n_sections + 1);
  c->sections[c->n_sections++] = section;
  return LITHE_OK;
}

static LitheStatus find_materials(LthConvert *c) {
  for (LitheIndex s = 0; s < c->n_sections; s++) {
    const LthInpCard *card = c->sections[s].card;
    const char *name = lth_inp_parameter(card, "MATERIAL");
    c->sections[s].material = find_material(c, name);
    if (c->sections[s].material < 0)
      return lth_inp_card_fail(c->ctx, card, "there is no *MATERIAL '%s'", name);
  }
  return LITHE_OK;
}

LitheStatus lth_convert_element_materials(LthConvert *c, LitheIndex **material) {
  LTH_NEW(c->ctx, *material, c->mesh->n_elements);
  for (LitheIndex e = 0; e < c->mesh->n_elements; e++) (*material)[e] = -1;
  for (LitheIndex s = 0; s < c->n_sections; s++)
    for (LitheIndex i = 0; i < c->sections[s].elements->n; i++)
      (*material)[c->sections[s].elements->member[i]] = c->sections[s].material;
  return LITHE_OK;
}

/// Body forces need the densities of all elements, which are one number where the force spins.
static LitheStatus check_density(LthConvert *c, const LitheIndex *material) {
  for (LitheIndex i = 0; i < c->n_body_forces; i++) {
    const LthInpCard *card = c->body_forces[i].card;
    for (LitheIndex e = 0; e < c->mesh->n_elements; e++) {
      const LthConvertMaterial *m = &c->materials[material[e]], *first = &c->materials[material[0]];
      if (!(m->density > 0))
        return lth_inp_card_fail(c->ctx, card,
                                 "a body force acts, but *MATERIAL '%s' has no *DENSITY", m->name);
      if (c->body_forces[i].spins && m->density != first->density)
        LITHE_FAIL(c->ctx, LITHE_UNSUPPORTED,
                   "%s:%d: *%s: CENTRIF on materials of different densities cannot be translated",
                   card->file, card->line, card->keyword);
    }
  }
  return LITHE_OK;
}

LitheStatus lth_convert_check(LthConvert *c) {
  LitheIndex *material = NULL;
  char text[LTH_ELEMENT_TEXT_MAX];
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, find_materials(c));
  LITHE_TRY_OR(done, lth_convert_element_materials(c, &material));
  for (LitheIndex e = 0; e < c->mesh->n_elements; e++) {
    if (material[e] < 0) {
      status = lth_fail(c->ctx, LITHE_BAD_INPUT, "%s has no material, expected a *SOLID SECTION",
                        lth_element_text(c->mesh, c->def->deck, e, text));
      goto done;
    }
    const LthConvertMaterial *m = &c->materials[material[e]];
    if (m->young > 0) continue;
    status = lth_inp_card_fail(c->ctx, m->card, "'%s' has no *ELASTIC, expected one", m->name);
    goto done;
  }
  LITHE_TRY_OR(done, check_density(c, material));
done:
  lth_free(c->ctx, material);
  return status;
}

LitheStatus lth_convert_amplitude(LthConvert *c, const LthInpCard *card) {
  const char *name = lth_inp_parameter(card, "NAME");
  LthConvertAmplitude amplitude = {.card = card, .name = name, .is_constant = true, .value = NAN};
  LthInpRow row;
  if (!name) return lth_inp_card_fail(c->ctx, card, "NAME is missing");
  if (lth_inp_parameter(card, "USER")) amplitude.is_constant = false;
  for (LitheIndex r = 0; r < card->n_rows && amplitude.is_constant; r++) {
    LITHE_TRY(lth_inp_row(c->ctx, c->deck, card->first_row + r, &row));
    for (int i = 1; i < row.n_fields; i += 2) {
      double value;
      LITHE_TRY(lth_inp_row_number(&row, i, "amplitude", &value));
      if (isnan(amplitude.value)) amplitude.value = value;
      if (value != amplitude.value) amplitude.is_constant = false;
    }
  }
  if (isnan(amplitude.value)) amplitude.is_constant = false;
  LTH_RESERVE(c->ctx, c->amplitudes, c->cap_amplitudes, c->n_amplitudes + 1);
  c->amplitudes[c->n_amplitudes++] = amplitude;
  return LITHE_OK;
}

LitheStatus lth_convert_factor(LthConvert *c, const LthInpCard *card, double *factor) {
  const char *name = lth_inp_parameter(card, "AMPLITUDE");
  *factor = 1;
  if (!name) return LITHE_OK;
  LthWord word = {name, strlen(name)};
  for (LitheIndex i = c->n_amplitudes; i-- > 0;) {
    const LthConvertAmplitude *a = &c->amplitudes[i];
    if (!lth_word_is_any_case(word, a->name)) continue;
    if (!a->is_constant)
      LITHE_FAIL(c->ctx, LITHE_UNSUPPORTED,
                 "%s:%d: *%s: AMPLITUDE=%s varies (see line %d); only constant ones can be "
                 "translated",
                 card->file, card->line, card->keyword, name, a->card->line);
    *factor = a->value;
    return LITHE_OK;
  }
  return lth_inp_card_fail(c->ctx, card, "there is no *AMPLITUDE '%s' above", name);
}

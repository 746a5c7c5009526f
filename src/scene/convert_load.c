/// Supports and loads of a deck: values on nodes and faces, as they stand at the end of a step.
#include "scene/convert.h"

#include <math.h>
#include <string.h>

/// What OP=NEW clears, by kind.
enum { BOUNDARY, NODAL, DISTRIBUTED };

const LthElementGroup *lth_convert_group(const LthConvert *c, LthGroupOf of, LthWord name) {
  for (LitheIndex i = 0; i < c->mesh->n_groups; i++) {
    const LthElementGroup *group = &c->mesh->groups[i];
    if (group->of == of && lth_word_is_any_case(name, group->name)) return group;
  }
  return NULL;
}

LitheStatus lth_convert_target(LthConvert *c, const LthInpRow *row, LthGroupOf of, LitheIndex *one,
                               const LitheIndex **member, LitheIndex *n) {
  const char *what = of == LTH_GROUP_NODES ? "node" : "element";
  LitheCount id;
  if (lth_inp_row_is_blank(row, 0))
    return lth_inp_row_fail(row, "expected the number of a%s %s or the name of a set",
                            of == LTH_GROUP_NODES ? "" : "n", what);
  LthWord word = row->field[0];
  if (lth_word_integer(word, &id)) {
    *one = lth_id_map_find(of == LTH_GROUP_NODES ? &c->node_of : &c->element_of, id);
    *member = one;
    *n = 1;
    if (*one >= 0) return LITHE_OK;
    return lth_inp_row_fail(row, "there is no %s %lld%s", what, (long long)id,
                            of == LTH_GROUP_NODES ? " that belongs to an element" : "");
  }
  const LthElementGroup *group = lth_convert_group(c, of, word);
  if (!group)
    return lth_inp_row_fail(row, "there is no set of %ss '%.*s'", what,
                            word.length < 80 ? (int)word.length : 80, word.at);
  *member = group->member;
  *n = group->n;
  return LITHE_OK;
}

/// OP=NEW: the first card of a kind in a step forgets what earlier steps said.
static LitheStatus renew(LthConvert *c, const LthInpCard *card, int kind, bool *now) {
  const char *op = lth_inp_parameter(card, "OP");
  *now = false;
  if (!op) return LITHE_OK;
  LthWord word = {op, strlen(op)};
  bool is_new = lth_word_is_any_case(word, "NEW");
  if (!is_new && !lth_word_is_any_case(word, "MOD"))
    return lth_inp_card_fail(c->ctx, card, "OP=%s, expected NEW or MOD", op);
  *now = is_new && !c->renewed[kind];
  if (is_new) c->renewed[kind] = true;
  return LITHE_OK;
}

/// First and last degree of freedom of a support.
static LitheStatus read_range(const LthInpRow *row, LitheCount *first, LitheCount *last) {
  LITHE_TRY(lth_inp_row_integer(row, 1, "the first degree of freedom", first));
  *last = *first;
  if (!lth_inp_row_is_blank(row, 2))
    LITHE_TRY(lth_inp_row_integer(row, 2, "the last degree of freedom", last));
  if (*first < 1 || *last < *first)
    return lth_inp_row_fail(row, "degrees of freedom %lld to %lld, expected 1 <= first <= last",
                            (long long)*first, (long long)*last);
  if (*last <= 3) return LITHE_OK;
  return lth_fail(row->ctx, LITHE_UNSUPPORTED,
                  "%s:%d: degree of freedom %lld cannot be translated; solids have 1, 2 and 3",
                  row->file, row->line, (long long)*last);
}

LitheStatus lth_convert_boundary(LthConvert *c, const LthInpCard *card) {
  bool now;
  double factor;
  LITHE_TRY(renew(c, card, BOUNDARY, &now));
  LITHE_TRY(lth_convert_factor(c, card, &factor));
  if (now) memset(c->is_held, 0, 3 * (size_t)c->mesh->n_nodes);
  for (LitheIndex r = 0; r < card->n_rows; r++) {
    LthInpRow row;
    LitheIndex one, n;
    const LitheIndex *node;
    LitheCount first, last;
    double value = 0;
    LITHE_TRY(lth_inp_row(c->ctx, c->deck, card->first_row + r, &row));
    LITHE_TRY(lth_convert_target(c, &row, LTH_GROUP_NODES, &one, &node, &n));
    LITHE_TRY(read_range(&row, &first, &last));
    if (!lth_inp_row_is_blank(&row, 3))
      LITHE_TRY(lth_inp_row_number(&row, 3, "the displacement", &value));
    for (LitheIndex i = 0; i < n; i++)
      for (LitheCount a = first - 1; a < last; a++) {
        c->is_held[3 * (LitheCount)node[i] + a] = 1;
        c->held[3 * (LitheCount)node[i] + a] = factor * value;
      }
  }
  return LITHE_OK;
}

/// Loads of one step add up; those of a later one replace what was there.
static void add(double *sum, int *in_step, int step, double value) {
  *sum = *in_step == step ? *sum + value : value;
  *in_step = step;
}

LitheStatus lth_convert_cload(LthConvert *c, const LthInpCard *card) {
  bool now;
  double factor;
  LITHE_TRY(renew(c, card, NODAL, &now));
  LITHE_TRY(lth_convert_factor(c, card, &factor));
  if (now) memset(c->force, 0, sizeof *c->force * 3 * (size_t)c->mesh->n_nodes);
  for (LitheIndex r = 0; r < card->n_rows; r++) {
    LthInpRow row;
    LitheIndex one, n;
    const LitheIndex *node;
    LitheCount a, last;
    double value;
    LITHE_TRY(lth_inp_row(c->ctx, c->deck, card->first_row + r, &row));
    LITHE_TRY(lth_convert_target(c, &row, LTH_GROUP_NODES, &one, &node, &n));
    row.n_fields = row.n_fields < 4 ? row.n_fields : 4;
    LthInpRow dof = row; // the value stands where a support has its last degree of freedom
    dof.n_fields = dof.n_fields < 2 ? dof.n_fields : 2;
    LITHE_TRY(read_range(&dof, &a, &last));
    LITHE_TRY(lth_inp_row_number(&row, 2, "the force", &value));
    for (LitheIndex i = 0; i < n; i++) {
      LitheCount k = 3 * (LitheCount)node[i] + a - 1;
      add(&c->force[k], &c->force_step[k], c->step, factor * value);
    }
  }
  return LITHE_OK;
}

/// GRAV and CENTRIF: size, then point (CENTRIF) and direction.
static LitheStatus read_body_force(LthConvert *c, const LthInpCard *card, const LthInpRow *row,
                                   bool spins, double factor) {
  LthConvertBodyForce force = {.card = card, .spins = spins, .step = c->step};
  int at = 3;
  if (c->n_body_forces > 0 && c->body_forces[0].step != c->step)
    LITHE_FAIL(c->ctx, LITHE_UNSUPPORTED,
               "%s:%d: *%s: a body force beside those of an earlier step cannot be translated; "
               "write OP=NEW and all of them",
               row->file, row->line, card->keyword);
  LITHE_TRY(lth_inp_row_number(row, 2, spins ? "the angular velocity's square" : "the acceleration",
                               &force.size));
  force.size *= factor;
  for (int a = 0; a < 3 && spins; a++)
    LITHE_TRY(lth_inp_row_number(row, at++, "a point of the axis", &force.point[a]));
  for (int a = 0; a < 3; a++)
    LITHE_TRY(lth_inp_row_number(row, at++, "a direction", &force.axis[a]));
  double length = sqrt(force.axis[0] * force.axis[0] + force.axis[1] * force.axis[1] +
                       force.axis[2] * force.axis[2]);
  if (!(length > 0)) return lth_inp_row_fail(row, "the direction has no length");
  for (int a = 0; a < 3; a++) force.axis[a] /= length;
  LTH_RESERVE(c->ctx, c->body_forces, c->cap_body_forces, c->n_body_forces + 1);
  c->body_forces[c->n_body_forces++] = force;
  return LITHE_OK;
}

/// Face of an element for a label such as P3 or S3; -1 where it has none of that number.
static LitheIndex face_of(const LthConvert *c, LitheIndex element, LitheCount number) {
  int local = lth_inp_face((LthElementKind)c->mesh->kind[element], (int)number);
  return local < 0 ? -1 : LTH_CONVERT_FACES * element + local;
}

static LitheStatus add_pressure(LthConvert *c, const LthInpRow *row, LitheIndex element,
                                LitheCount number, double value) {
  LitheIndex face = face_of(c, element, number);
  if (face < 0)
    return lth_inp_row_fail(
        row, "element %lld (%s) has no face %lld", (long long)c->mesh->element_id[element],
        lth_element_shape((LthElementKind)c->mesh->kind[element])->name, (long long)number);
  add(&c->pressure[face], &c->pressure_step[face], c->step, value);
  return LITHE_OK;
}

static LitheStatus unsupported_label(const LthInpRow *row, LthWord label) {
  return lth_fail(row->ctx, LITHE_UNSUPPORTED,
                  "%s:%d: load '%.*s' cannot be translated; P1 to P6, GRAV and CENTRIF can",
                  row->file, row->line, label.length < 40 ? (int)label.length : 40, label.at);
}

/// A row of *DLOAD.
static LitheStatus read_dload(LthConvert *c, const LthInpCard *card, const LthInpRow *row,
                              double factor) {
  LitheIndex one, n;
  const LitheIndex *element;
  LitheCount number = 0;
  double value;
  if (lth_inp_row_is_blank(row, 1)) return lth_inp_row_fail(row, "expected a load, such as P1");
  LthWord label = row->field[1], digits = {label.at + 1, label.length - 1};
  bool pulls = lth_word_is_any_case(label, "GRAV"), spins = lth_word_is_any_case(label, "CENTRIF");
  if (pulls || spins) {
    if (!lth_inp_row_is_blank(row, 0))
      LITHE_TRY(lth_convert_target(c, row, LTH_GROUP_ELEMENTS, &one, &element, &n));
    else
      n = c->mesh->n_elements;
    if (n < c->mesh->n_elements)
      LITHE_FAIL(c->ctx, LITHE_UNSUPPORTED,
                 "%s:%d: *%s: %.*s on some elements only cannot be translated; it can on all",
                 row->file, row->line, card->keyword, (int)label.length, label.at);
    return read_body_force(c, card, row, spins, factor);
  }
  if ((label.at[0] != 'P' && label.at[0] != 'p') || !lth_word_integer(digits, &number))
    return unsupported_label(row, label);
  LITHE_TRY(lth_convert_target(c, row, LTH_GROUP_ELEMENTS, &one, &element, &n));
  LITHE_TRY(lth_inp_row_number(row, 2, "the pressure", &value));
  for (LitheIndex i = 0; i < n; i++)
    LITHE_TRY(add_pressure(c, row, element[i], number, factor * value));
  return LITHE_OK;
}

/// A row of *DSLOAD: a surface, P, the pressure.
static LitheStatus read_dsload(LthConvert *c, const LthInpRow *row, double factor) {
  double value;
  if (lth_inp_row_is_blank(row, 0) || lth_inp_row_is_blank(row, 1))
    return lth_inp_row_fail(row, "expected a surface, P and a pressure");
  LthWord name = row->field[0], label = row->field[1];
  const LthElementGroup *surface = lth_convert_group(c, LTH_GROUP_FACES, name);
  if (!surface)
    return lth_inp_row_fail(row, "there is no *SURFACE of element faces '%.*s'",
                            name.length < 80 ? (int)name.length : 80, name.at);
  if (!lth_word_is_any_case(label, "P")) return unsupported_label(row, label);
  LITHE_TRY(lth_inp_row_number(row, 2, "the pressure", &value));
  for (LitheIndex i = 0; i < surface->n; i++) {
    LitheIndex face = surface->member[i];
    add(&c->pressure[face], &c->pressure_step[face], c->step, factor * value);
  }
  return LITHE_OK;
}

static LitheStatus read_distributed(LthConvert *c, const LthInpCard *card, bool on_surface) {
  bool now;
  double factor;
  LITHE_TRY(renew(c, card, DISTRIBUTED, &now));
  LITHE_TRY(lth_convert_factor(c, card, &factor));
  if (now) {
    memset(c->pressure, 0, sizeof *c->pressure * LTH_CONVERT_FACES * (size_t)c->mesh->n_elements);
    c->n_body_forces = 0;
  }
  for (LitheIndex r = 0; r < card->n_rows; r++) {
    LthInpRow row;
    LITHE_TRY(lth_inp_row(c->ctx, c->deck, card->first_row + r, &row));
    LITHE_TRY(on_surface ? read_dsload(c, &row, factor) : read_dload(c, card, &row, factor));
  }
  return LITHE_OK;
}

LitheStatus lth_convert_dload(LthConvert *c, const LthInpCard *card) {
  return read_distributed(c, card, false);
}

LitheStatus lth_convert_dsload(LthConvert *c, const LthInpCard *card) {
  return read_distributed(c, card, true);
}

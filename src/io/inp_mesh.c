/// The mesh of a keyword deck.
///
/// Node orders of CalculiX and Abaqus are VTK's for all kinds here; faces S1, S2, ... are numbered otherwise.
#include "io/inp_mesh.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const struct {
  const char *type;
  LthElementKind kind;
  bool reduced;
} types[] = {
    {"C3D4", LTH_TET4, false},     {"C3D5", LTH_PYRAMID5, false}, {"C3D6", LTH_WEDGE6, true},
    {"C3D8", LTH_HEX8, false},     {"C3D8R", LTH_HEX8, true},     {"C3D8I", LTH_HEX8, false},
    {"C3D10", LTH_TET10, false},   {"C3D10T", LTH_TET10, false},  {"C3D10M", LTH_TET10, false},
    {"C3D15", LTH_WEDGE15, false}, {"C3D20", LTH_HEX20, false},   {"C3D20R", LTH_HEX20, true},
    {"C3D20RI", LTH_HEX20, true}};

LthElementKind lth_inp_element_kind(const char *type, bool *reduced) {
  *reduced = false;
  for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
    if (strcasecmp(type, types[i].type) != 0) continue;
    *reduced = types[i].reduced;
    return types[i].kind;
  }
  return LTH_ELEMENT_KINDS;
}

int lth_inp_face(LthElementKind kind, int number) {
  static const int8_t tet[4] = {3, 0, 1, 2}, hex[6] = {4, 5, 2, 1, 3, 0};
  const LthElementShape *shape = lth_element_shape(kind);
  if (number < 1 || number > shape->n_faces) return -1;
  if (shape->n_corners == 4) return tet[number - 1];
  return shape->n_corners == 8 ? hex[number - 1] : number - 1;
}

/// What a card is read with.
typedef struct InpReader {
  LthElementBuilder *b;
  const LthInpDeck *deck;
  const LthInpCard *card;
} InpReader;

static LthWord word_of(const char *text) { return (LthWord){text, strlen(text)}; }

/// The group that parameter `name` of the card calls; -1 where it has none.
static LitheStatus group_of_card(InpReader *r, const char *name, LthGroupOf of, LitheIndex *group) {
  const char *value = lth_inp_parameter(r->card, name);
  *group = -1;
  if (!value) return LITHE_OK;
  if (!*value) return lth_inp_card_fail(r->b->ctx, r->card, "%s has no name behind it", name);
  return lth_builder_group(r->b, of, word_of(value), -1, true, group);
}

/// A group that stands in a data line by its name, -1.
static LitheIndex find_group(const LthElementBuilder *b, LthGroupOf of, LthWord name) {
  for (LitheIndex g = 0; g < b->n_groups; g++)
    if (b->groups[g].of == of && lth_word_is_any_case(name, b->groups[g].name)) return g;
  return -1;
}

static LitheStatus read_nodes(InpReader *r) {
  LitheIndex group = -1;
  LITHE_TRY(group_of_card(r, "NSET", LTH_GROUP_NODES, &group));
  if (lth_inp_parameter(r->card, "SYSTEM"))
    return lth_inp_card_fail(r->b->ctx, r->card, "SYSTEM is not read; give Cartesian coordinates");
  for (LitheIndex i = 0; i < r->card->n_rows; i++) {
    LthInpRow row;
    LitheCount id = 0;
    double x[3] = {0, 0, 0};
    LITHE_TRY(lth_inp_row(r->b->ctx, r->deck, r->card->first_row + i, &row));
    LITHE_TRY(lth_inp_row_integer(&row, 0, "the node's number", &id));
    for (int a = 0; a < 3; a++)
      if (!lth_inp_row_is_blank(&row, 1 + a))
        LITHE_TRY(lth_inp_row_number(&row, 1 + a, "a coordinate", &x[a]));
    LITHE_TRY(lth_builder_node(r->b, id, x));
    if (group >= 0) LITHE_TRY(lth_builder_member(r->b, group, id));
  }
  return LITHE_OK;
}

/// One element, on as many lines as its nodes take; `*next` moves behind them.
static LitheStatus read_element(InpReader *r, LthElementKind kind, bool reduced, LitheIndex group,
                                LitheIndex *next) {
  LthInpRow row = {0};
  LitheCount value[1 + LTH_ELEMENT_MAX_NODES];
  int n = 0, n_all = 1 + lth_element_shape(kind)->n_nodes;
  LitheIndex line = r->deck->lines[r->card->first_row + *next].line;
  while (n < n_all) {
    if (*next == r->card->n_rows)
      return lth_inp_row_fail(&row, "the last element has %d nodes, expected %d", n - 1, n_all - 1);
    LITHE_TRY(lth_inp_row(r->b->ctx, r->deck, r->card->first_row + (*next)++, &row));
    // hexahedra with incompatible modes are sometimes listed with two or three nodes for these
    bool has_modes = kind == LTH_HEX8 && n == 0 && row.n_fields <= n_all + 3;
    if (n + row.n_fields > n_all && !has_modes)
      return lth_inp_row_fail(&row, "an element has %d or more nodes, expected %d",
                              n + row.n_fields - 1, n_all - 1);
    for (int i = 0; i < row.n_fields && n < n_all; i++, n++)
      LITHE_TRY(lth_inp_row_integer(&row, i, n == 0 ? "the element's number" : "a node's number",
                                    &value[n]));
  }
  LITHE_TRY(lth_builder_element(r->b, kind, reduced, value[0], line, value + 1));
  return group < 0 ? LITHE_OK : lth_builder_member(r->b, group, value[0]);
}

static LitheStatus read_elements(InpReader *r) {
  LitheIndex group = -1, next = 0;
  bool reduced = false;
  const char *type = lth_inp_parameter(r->card, "TYPE");
  if (!type || !*type)
    return lth_inp_card_fail(r->b->ctx, r->card, "names no type, expected TYPE=C3D8 or the like");
  LthElementKind kind = lth_inp_element_kind(type, &reduced);
  // the set is known by its name also where its elements are left out
  LITHE_TRY(group_of_card(r, "ELSET", LTH_GROUP_ELEMENTS, &group));
  if (kind == LTH_ELEMENT_KINDS) {
    lth_warn(r->b->ctx, "%s: elements of type %s are not solids that are read here; left out",
             r->b->file, type);
    return LITHE_OK;
  }
  while (next < r->card->n_rows) LITHE_TRY(read_element(r, kind, reduced, group, &next));
  return LITHE_OK;
}

/// Numbers from first to last in steps. A range far longer than the file is cut to the numbers it has by now.
static LitheStatus generate(InpReader *r, const LthInpRow *row, LitheIndex group) {
  const LthElementBuilder *b = r->b;
  LitheCount first = 0, last = 0, step = 1;
  LITHE_TRY(lth_inp_row_integer(row, 0, "the first number", &first));
  LITHE_TRY(lth_inp_row_integer(row, 1, "the last number", &last));
  if (!lth_inp_row_is_blank(row, 2)) LITHE_TRY(lth_inp_row_integer(row, 2, "the step", &step));
  if (step < 1 || last < first || first < 0)
    return lth_inp_row_fail(row,
                            "a range from %lld to %lld in steps of %lld, expected first <= last "
                            "and a step of 1 or more",
                            (long long)first, (long long)last, (long long)step);
  bool is_nodes = b->groups[group].of == LTH_GROUP_NODES;
  LitheIndex n_known = is_nodes ? b->n_nodes : b->n_elements;
  const int64_t *known = is_nodes ? b->node_id : b->element_id;
  if ((last - first) / step <= 16 * (LitheCount)n_known + 1000) {
    for (LitheCount id = first; id <= last; id += step)
      LITHE_TRY(lth_builder_member(r->b, group, id));
    return LITHE_OK;
  }
  for (LitheIndex i = 0; i < n_known; i++)
    if (known[i] >= first && known[i] <= last && (known[i] - first) % step == 0)
      LITHE_TRY(lth_builder_member(r->b, group, known[i]));
  return LITHE_OK;
}

/// A number, or the name of a set whose members are taken over.
static LitheStatus read_member(InpReader *r, const LthInpRow *row, int i, LitheIndex group) {
  LitheCount id = 0;
  LthWord word = row->field[i];
  LthGroupOf of = r->b->groups[group].of;
  if (lth_word_integer(word, &id)) return lth_builder_member(r->b, group, id);
  LitheIndex other = find_group(r->b, of, word);
  if (other < 0)
    return lth_inp_row_fail(row, "'%.*s' is neither a number nor a set of %s defined before",
                            word.length < 80 ? (int)word.length : 80, word.at,
                            of == LTH_GROUP_NODES ? "nodes" : "elements");
  for (LitheCount k = 0, n = other == group ? 0 : r->b->groups[other].n; k < n; k++)
    LITHE_TRY(lth_builder_member(r->b, group, r->b->groups[other].member[k]));
  return LITHE_OK;
}

static LitheStatus read_set(InpReader *r, const char *name, LthGroupOf of) {
  LitheIndex group = -1;
  bool is_range = lth_inp_parameter(r->card, "GENERATE") != NULL;
  LITHE_TRY(group_of_card(r, name, of, &group));
  if (group < 0)
    return lth_inp_card_fail(r->b->ctx, r->card, "has no name, expected %s=name", name);
  if (of == LTH_GROUP_NODES && lth_inp_parameter(r->card, "ELSET"))
    return lth_inp_card_fail(r->b->ctx, r->card, "ELSET is not read here; list the nodes");
  for (LitheIndex i = 0; i < r->card->n_rows; i++) {
    LthInpRow row;
    LITHE_TRY(lth_inp_row(r->b->ctx, r->deck, r->card->first_row + i, &row));
    if (is_range) {
      LITHE_TRY(generate(r, &row, group));
      continue;
    }
    for (int k = 0; k < row.n_fields; k++)
      if (row.field[k].length > 0) LITHE_TRY(read_member(r, &row, k, group));
  }
  return LITHE_OK;
}

/// Kind of an element by its number: the last element of that number, LTH_ELEMENT_KINDS where there is none yet.
static LthElementKind kind_of(const LthElementBuilder *b, const LthIdMap *map, int64_t id) {
  LitheIndex at = lth_id_map_find(map, id);
  return at < 0 ? LTH_ELEMENT_KINDS : (LthElementKind)b->kind[at];
}

static LitheStatus add_face(InpReader *r, const LthInpRow *row, const LthIdMap *map,
                            LitheIndex group, int64_t element, int number) {
  LthElementKind kind = kind_of(r->b, map, element);
  // an element that is no solid, or none at all, is told of with the set
  if (kind == LTH_ELEMENT_KINDS) return lth_builder_face(r->b, group, element, 0);
  int face = lth_inp_face(kind, number);
  if (face < 0)
    return lth_inp_row_fail(row, "element %lld (%s) has no face S%d", (long long)element,
                            lth_element_shape(kind)->name, number);
  return lth_builder_face(r->b, group, element, face);
}

/// "element or set, S3".
static LitheStatus read_surface_row(InpReader *r, const LthInpRow *row, const LthIdMap *map,
                                    LitheIndex group) {
  LitheCount element = 0, number = 0;
  if (lth_inp_row_is_blank(row, 0)) return lth_inp_row_fail(row, "an element or a set is missing");
  LthWord name = row->field[0], label = lth_inp_row_is_blank(row, 1) ? name : row->field[1];
  bool is_face = label.at != name.at && (label.at[0] == 'S' || label.at[0] == 's') &&
                 lth_word_integer((LthWord){label.at + 1, label.length - 1}, &number) &&
                 number > 0 && number < 100;
  if (lth_word_is_any_case(label, "SPOS") || lth_word_is_any_case(label, "SNEG")) {
    lth_warn(r->b->ctx, "%s: sides of shells in the surface %s are left out", r->b->file,
             r->b->groups[group].name);
    return LITHE_OK;
  }
  if (!is_face)
    return lth_inp_row_fail(row, "'%.*s' is no face of a solid, expected S1 to S6",
                            label.length < 40 ? (int)label.length : 40, label.at);
  if (lth_word_integer(name, &element)) return add_face(r, row, map, group, element, (int)number);
  LitheIndex set = find_group(r->b, LTH_GROUP_ELEMENTS, name);
  if (set < 0)
    return lth_inp_row_fail(row,
                            "'%.*s' is neither an element nor a set of elements defined before",
                            name.length < 80 ? (int)name.length : 80, name.at);
  for (LitheCount k = 0; k < r->b->groups[set].n; k++)
    LITHE_TRY(add_face(r, row, map, group, r->b->groups[set].member[k], (int)number));
  return LITHE_OK;
}

static LitheStatus read_element_surface(InpReader *r) {
  LitheStatus status = LITHE_OK;
  LitheIndex group = -1, twice = -1;
  LthIdMap map = {0};
  LITHE_TRY(group_of_card(r, "NAME", LTH_GROUP_FACES, &group));
  LITHE_TRY(lth_id_map_create(r->b->ctx, r->b->element_id, r->b->n_elements, &map, &twice));
  for (LitheIndex i = 0; i < r->card->n_rows; i++) {
    LthInpRow row;
    LITHE_TRY_OR(done, lth_inp_row(r->b->ctx, r->deck, r->card->first_row + i, &row));
    LITHE_TRY_OR(done, read_surface_row(r, &row, &map, group));
  }
done:
  lth_id_map_free(r->b->ctx, &map);
  return status;
}

/// Nodes of a surface; what else stands on its lines are areas.
static LitheStatus read_node_surface(InpReader *r) {
  LitheIndex group = -1;
  LITHE_TRY(group_of_card(r, "NAME", LTH_GROUP_NODES, &group));
  for (LitheIndex i = 0; i < r->card->n_rows; i++) {
    LthInpRow row;
    LITHE_TRY(lth_inp_row(r->b->ctx, r->deck, r->card->first_row + i, &row));
    if (!lth_inp_row_is_blank(&row, 0)) LITHE_TRY(read_member(r, &row, 0, group));
  }
  return LITHE_OK;
}

static LitheStatus read_surface(InpReader *r) {
  const char *type = lth_inp_parameter(r->card, "TYPE"), *name = lth_inp_parameter(r->card, "NAME");
  if (!name || !*name)
    return lth_inp_card_fail(r->b->ctx, r->card, "has no name, expected NAME=name");
  if (!type || strcasecmp(type, "ELEMENT") == 0) return read_element_surface(r);
  if (strcasecmp(type, "NODE") == 0) return read_node_surface(r);
  return lth_inp_card_fail(r->b->ctx, r->card, "TYPE is '%s', expected ELEMENT or NODE", type);
}

/// Cards that make nodes or elements in ways that are not read here: without them the mesh would not be whole.
static LitheStatus refuse_others(InpReader *r) {
  static const char *const others[] = {"NGEN",  "NFILL",  "NMAP",     "NCOPY",
                                       "ELGEN", "ELCOPY", "INSTANCE", "SUBMODEL PART"};
  for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
    if (lth_inp_is(r->card, others[i]))
      return lth_inp_card_fail(r->b->ctx, r->card,
                               "is not read; write the nodes and elements out as one part");
  return LITHE_OK;
}

static LitheStatus read_card(InpReader *r) {
  if (lth_inp_is(r->card, "NODE")) return read_nodes(r);
  if (lth_inp_is(r->card, "ELEMENT")) return read_elements(r);
  if (lth_inp_is(r->card, "NSET")) return read_set(r, "NSET", LTH_GROUP_NODES);
  if (lth_inp_is(r->card, "ELSET")) return read_set(r, "ELSET", LTH_GROUP_ELEMENTS);
  if (lth_inp_is(r->card, "SURFACE")) return read_surface(r);
  return refuse_others(r);
}

LitheStatus lth_inp_mesh_build(LthElementBuilder *b, const LthInpDeck *deck) {
  InpReader r = {.b = b, .deck = deck};
  b->keeps_last = true;
  for (LitheIndex c = 0; c < deck->n_cards; c++) {
    r.card = &deck->cards[c];
    LITHE_TRY(read_card(&r));
  }
  return LITHE_OK;
}

LitheStatus lth_inp_mesh_create(LitheCtx *ctx, const LthInpDeck *deck, double unit_scale,
                                LthElementMesh **mesh) {
  LthElementBuilder b = {.ctx = ctx, .file = deck->files[0].path};
  *mesh = NULL;
  LitheStatus status = lth_inp_mesh_build(&b, deck);
  if (status == LITHE_OK) status = lth_builder_take(&b, unit_scale, mesh);
  lth_element_builder_free(&b);
  return status;
}

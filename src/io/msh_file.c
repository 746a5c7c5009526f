/// Gmsh mesh files: sections $MeshFormat, $PhysicalNames, $Entities, $Nodes and $Elements; others are skipped.
///
/// Versions 2 to 2.2 and 4.1 as https://gmsh.info/doc/texinfo/gmsh.html lays them down.
#define _GNU_SOURCE // memmem
#include "io/msh_file.h"

#include "io/bytes.h"
#include "io/msh_reader.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/// The one after the head of a binary file tells its byte order.
static LitheStatus read_byte_order(LthMshReader *r) {
  lth_text_rest(&r->text);
  if (!lth_text_next_line(&r->text) || r->text.end - r->text.at < 4)
    return lth_msh_fail(r, "the file ends in $MeshFormat: it is cut short");
  if (lth_bytes_u32(r->text.at, false) != 1) {
    if (lth_bytes_u32(r->text.at, true) != 1)
      return lth_msh_fail(r, "the byte order cannot be told: expected the number 1 behind the line "
                             "of $MeshFormat");
    r->is_big = true;
  }
  r->text.at += 4;
  return LITHE_OK;
}

static LitheStatus read_format(LthMshReader *r) {
  double version = 0;
  LitheIndex is_binary = 0;
  LitheCount size_bytes = 0;
  LITHE_TRY(lth_msh_double(r, "the version", &version));
  LITHE_TRY(lth_msh_int(r, "the file type", &is_binary));
  LITHE_TRY(lth_msh_size(r, "the data size", &size_bytes));
  bool is_known = (version >= 2 && version < 3) || fabs(version - 4.1) < 1e-6;
  if (!is_known)
    return lth_msh_fail(r,
                        "the version is %g, expected 2.2 or 4.1: save the mesh with `gmsh -save "
                        "-format msh41`",
                        version);
  if (is_binary < 0 || is_binary > 1 || (size_bytes != 4 && size_bytes != 8))
    return lth_msh_fail(r, "file type %d and data size %lld, expected 0 (text) or 1 (binary) and 8",
                        is_binary, (long long)size_bytes);
  r->version = version < 3 ? 2 : 4;
  r->size_bytes = (int)size_bytes;
  if (is_binary) {
    LITHE_TRY(read_byte_order(r));
    r->is_binary = true;
  }
  return LITHE_OK;
}

/// Physical names are text in binary files too: `dimension tag "name"`.
static LitheStatus read_name(LthMshReader *r) {
  LitheIndex dimension = 0, tag = 0;
  LITHE_TRY(lth_msh_int(r, "the dimension of a physical group", &dimension));
  LITHE_TRY(lth_msh_int(r, "the number of a physical group", &tag));
  LthWord rest = lth_text_rest(&r->text);
  if (rest.length < 2 || rest.at[0] != '"' || rest.at[rest.length - 1] != '"')
    return lth_msh_fail(r, "the name of a physical group is %.*s, expected it in quotes",
                        rest.length < 40 ? (int)rest.length : 40, rest.at);
  if (dimension < 0 || dimension > 3)
    return lth_msh_fail(r, "a physical group has dimension %d, expected 0 to 3", dimension);
  return lth_msh_name(r, dimension, tag, (LthWord){rest.at + 1, rest.length - 2});
}

static LitheStatus read_names(LthMshReader *r) {
  LitheIndex n = 0;
  bool is_binary = r->is_binary;
  r->is_binary = false;
  LITHE_TRY(lth_msh_int(r, "the number of physical groups", &n));
  for (LitheIndex i = 0; i < n; i++) LITHE_TRY(read_name(r));
  r->is_binary = is_binary;
  return LITHE_OK;
}

/// An entity: number, its place or box, its physical groups, what it is bounded by.
static LitheStatus read_entity(LthMshReader *r, LitheIndex dimension) {
  LitheIndex tag = 0, group = 0, bound = 0;
  LitheCount n = 0;
  double x;
  LITHE_TRY(lth_msh_int(r, "the number of an entity", &tag));
  LITHE_TRY(lth_msh_entity(r, dimension, tag));
  for (int i = 0; i < (dimension == 0 ? 3 : 6); i++)
    LITHE_TRY(lth_msh_double(r, "the box of an entity", &x));
  LITHE_TRY(lth_msh_size(r, "the number of an entity's groups", &n));
  for (LitheCount i = 0; i < n; i++) {
    LITHE_TRY(lth_msh_int(r, "a group of an entity", &group));
    LITHE_TRY(lth_msh_entity_group(r, group));
  }
  if (dimension == 0) return LITHE_OK;
  LITHE_TRY(lth_msh_size(r, "the number of bounds of an entity", &n));
  for (LitheCount i = 0; i < n; i++) LITHE_TRY(lth_msh_int(r, "a bound of an entity", &bound));
  return LITHE_OK;
}

static LitheStatus read_entities(LthMshReader *r) {
  LitheCount n[4] = {0};
  for (int d = 0; d < 4; d++) LITHE_TRY(lth_msh_size(r, "the number of entities", &n[d]));
  for (int d = 0; d < 4; d++)
    for (LitheCount i = 0; i < n[d]; i++) LITHE_TRY(read_entity(r, d));
  return LITHE_OK;
}

static LitheStatus read_point(LthMshReader *r, int64_t id) {
  double x[3];
  for (int a = 0; a < 3; a++) LITHE_TRY(lth_msh_double(r, "a coordinate", &x[a]));
  return lth_builder_node(r->b, id, x);
}

/// The count in front of the nodes and elements of version 2 is text, also where binary values follow.
static LitheStatus read_count_2(LthMshReader *r, const char *what, LitheCount *n) {
  LthWord word;
  if (!lth_text_word_across(&r->text, &word) || !lth_word_integer(word, n) || *n < 0)
    return lth_msh_fail(r, "the number of %s is missing", what);
  if (r->is_binary) lth_text_next_line(&r->text);
  return LITHE_OK;
}

static LitheStatus read_nodes_2(LthMshReader *r) {
  LitheCount n = 0;
  LitheIndex id = 0;
  LITHE_TRY(read_count_2(r, "nodes", &n));
  for (LitheCount i = 0; i < n; i++) {
    LITHE_TRY(lth_msh_int(r, "the number of a node", &id));
    LITHE_TRY(read_point(r, id));
  }
  return LITHE_OK;
}

/// A block of nodes of one entity: all their numbers, then all their places.
static LitheStatus read_node_block(LthMshReader *r, int64_t **ids, LitheCount *cap) {
  LitheIndex dimension = 0, tag = 0, is_parametric = 0;
  LitheCount n = 0;
  double parameter;
  LITHE_TRY(lth_msh_int(r, "the dimension of a block of nodes", &dimension));
  LITHE_TRY(lth_msh_int(r, "the entity of a block of nodes", &tag));
  LITHE_TRY(lth_msh_int(r, "the mark of parametric nodes", &is_parametric));
  LITHE_TRY(lth_msh_size(r, "the number of nodes of a block", &n));
  if (dimension < 0 || dimension > 3)
    return lth_msh_fail(r, "a block of nodes has dimension %d, expected 0 to 3", dimension);
  for (LitheCount i = 0; i < n; i++) {
    LitheCount id = 0;
    LITHE_TRY(lth_msh_size(r, "the number of a node", &id));
    LTH_RESERVE(r->b->ctx, *ids, *cap, i + 1);
    (*ids)[i] = id;
  }
  for (LitheCount i = 0; i < n; i++) {
    LITHE_TRY(read_point(r, (*ids)[i]));
    for (int k = 0; is_parametric && k < dimension; k++)
      LITHE_TRY(lth_msh_double(r, "a parameter of a node", &parameter));
  }
  return LITHE_OK;
}

static LitheStatus read_nodes_4(LthMshReader *r) {
  LitheStatus status = LITHE_OK;
  LitheCount head[4], cap = 0;
  int64_t *ids = NULL;
  for (int i = 0; i < 4; i++) LITHE_TRY(lth_msh_size(r, "the head of $Nodes", &head[i]));
  for (LitheCount i = 0; i < head[0]; i++) LITHE_TRY_OR(done, read_node_block(r, &ids, &cap));
done:
  lth_free(r->b->ctx, ids);
  return status;
}

static LitheStatus find_type(const LthMshReader *r, LitheIndex number, const LthMshType **type) {
  *type = lth_msh_type(number);
  if (*type) return LITHE_OK;
  return lth_msh_fail(r,
                      "element type %d is not known here, expected elements of first or second "
                      "order",
                      number);
}

/// Tags and nodes of an element of version 2: the first tag is its physical group, 0 for none.
static LitheStatus read_element_2(LthMshReader *r, const LthMshType *type, LitheIndex id,
                                  LitheIndex line, LitheIndex n_tags) {
  int64_t node[LTH_ELEMENT_MAX_NODES];
  LitheIndex group = 0, value = 0;
  for (LitheIndex i = 0; i < n_tags; i++) {
    LITHE_TRY(lth_msh_int(r, "a tag of an element", &value));
    if (i == 0) group = value == INT32_MIN ? 0 : value < 0 ? -value : value;
  }
  for (int i = 0; i < type->n_nodes; i++) {
    LITHE_TRY(lth_msh_int(r, "a node of an element", &value));
    node[i] = value;
  }
  return lth_msh_element(r, type, id, line, node, group > 0, &group);
}

static LitheStatus read_text_element_2(LthMshReader *r) {
  LitheIndex id = 0, number = 0, n_tags = 0;
  const LthMshType *type = NULL;
  LITHE_TRY(lth_msh_int(r, "the number of an element", &id));
  LitheIndex line = (LitheIndex)r->text.line;
  LITHE_TRY(lth_msh_int(r, "the type of an element", &number));
  LITHE_TRY(find_type(r, number, &type));
  LITHE_TRY(lth_msh_int(r, "the number of tags of an element", &n_tags));
  LITHE_TRY(read_element_2(r, type, id, line, n_tags));
  LthWord more;
  if (lth_text_word(&r->text, &more))
    return lth_msh_fail(r, "element %d of type %d has more than %d nodes", id, number,
                        type->n_nodes);
  return LITHE_OK;
}

/// Elements of one type and number of tags; `*n` elements of all are left.
static LitheStatus read_element_block_2(LthMshReader *r, LitheCount *n) {
  LitheIndex number = 0, count = 0, n_tags = 0, id = 0;
  const LthMshType *type = NULL;
  LITHE_TRY(lth_msh_int(r, "the type of a block of elements", &number));
  LITHE_TRY(lth_msh_int(r, "the number of elements of a block", &count));
  LITHE_TRY(lth_msh_int(r, "the number of tags of a block", &n_tags));
  LITHE_TRY(find_type(r, number, &type));
  if (count < 1 || count > *n)
    return lth_msh_fail(r, "a block of %d elements where %lld are left", count, (long long)*n);
  for (LitheIndex i = 0; i < count; i++) {
    LITHE_TRY(lth_msh_int(r, "the number of an element", &id));
    LITHE_TRY(read_element_2(r, type, id, 0, n_tags));
  }
  *n -= count;
  return LITHE_OK;
}

static LitheStatus read_elements_2(LthMshReader *r) {
  LitheCount n = 0;
  LITHE_TRY(read_count_2(r, "elements", &n));
  while (r->is_binary && n > 0) LITHE_TRY(read_element_block_2(r, &n));
  for (LitheCount i = 0; i < n; i++) LITHE_TRY(read_text_element_2(r));
  return LITHE_OK;
}

static LitheStatus read_element_block_4(LthMshReader *r) {
  LitheIndex dimension = 0, tag = 0, number = 0;
  LitheCount n = 0, value = 0;
  const LthMshType *type = NULL;
  const LitheIndex *groups = NULL;
  int64_t node[LTH_ELEMENT_MAX_NODES];
  LITHE_TRY(lth_msh_int(r, "the dimension of a block of elements", &dimension));
  LITHE_TRY(lth_msh_int(r, "the entity of a block of elements", &tag));
  LITHE_TRY(lth_msh_int(r, "the type of a block of elements", &number));
  LITHE_TRY(lth_msh_size(r, "the number of elements of a block", &n));
  LITHE_TRY(find_type(r, number, &type));
  LitheIndex n_groups = lth_msh_groups_of(r, type->dimension, tag, &groups);
  for (LitheCount i = 0; i < n; i++) {
    LitheCount id = 0;
    LITHE_TRY(lth_msh_size(r, "the number of an element", &id));
    LitheIndex line = r->is_binary ? 0 : (LitheIndex)r->text.line;
    for (int k = 0; k < type->n_nodes; k++) {
      LITHE_TRY(lth_msh_size(r, "a node of an element", &value));
      node[k] = value;
    }
    LITHE_TRY(lth_msh_element(r, type, id, line, node, n_groups, groups));
  }
  return LITHE_OK;
}

static LitheStatus read_elements_4(LthMshReader *r) {
  LitheCount head[4];
  for (int i = 0; i < 4; i++) LITHE_TRY(lth_msh_size(r, "the head of $Elements", &head[i]));
  for (LitheCount i = 0; i < head[0]; i++) LITHE_TRY(read_element_block_4(r));
  return LITHE_OK;
}

/// Go behind `$End` and the section's name; whether anything may stand in front of it.
static LitheStatus end_section(LthMshReader *r, LthWord name, bool skips) {
  char end[64];
  LthWord word;
  int length = snprintf(end, sizeof end, "$End%.*s", (int)name.length, name.at);
  if (skips) {
    const char *found = memmem(r->text.at, (size_t)(r->text.end - r->text.at), end, (size_t)length);
    if (!found)
      return lth_msh_fail(r, "the section $%.*s has no end: the file is cut short",
                          (int)name.length, name.at);
    for (; r->text.at < found; r->text.at++) r->text.line += *r->text.at == '\n';
  }
  if (!lth_text_word_across(&r->text, &word))
    return lth_msh_fail(r, "the file ends before %s: it is cut short", end);
  if (!lth_word_is(word, end))
    return lth_msh_fail(r, "'%.*s' where %s was expected", word.length < 40 ? (int)word.length : 40,
                        word.at, end);
  return LITHE_OK;
}

static LitheStatus read_section(LthMshReader *r, LthWord name) {
  static const struct {
    const char *name;
    int version; ///< 0: of all
    LitheStatus (*read)(LthMshReader *);
  } sections[] = {{"MeshFormat", 0, read_format},  {"PhysicalNames", 0, read_names},
                  {"Entities", 4, read_entities},  {"Nodes", 2, read_nodes_2},
                  {"Nodes", 4, read_nodes_4},      {"Elements", 2, read_elements_2},
                  {"Elements", 4, read_elements_4}};
  for (size_t i = 0; i < sizeof sections / sizeof sections[0]; i++) {
    if (!lth_word_is(name, sections[i].name)) continue;
    bool is_format = sections[i].read == read_format;
    if (is_format != (r->version == 0))
      return lth_msh_fail(r, "the file has to begin with $MeshFormat, once: found $%s",
                          sections[i].name);
    if (sections[i].version && sections[i].version != r->version) continue;
    r->section = sections[i].name;
    // binary values begin right behind the line of the section's name
    if (r->is_binary) lth_text_next_line(&r->text);
    LITHE_TRY(sections[i].read(r));
    return end_section(r, name, false);
  }
  return end_section(r, name, true);
}

LitheStatus lth_msh_parse(LthElementBuilder *b, const char *data, size_t size) {
  LthMshReader r = {.b = b, .data = data, .text = lth_text(b->ctx, b->file, data, size)};
  LitheStatus status = LITHE_OK;
  LthWord word;
  r.section = "MeshFormat";
  r.size_bytes = 8;
  while (status == LITHE_OK && lth_text_word_across(&r.text, &word)) {
    if (word.at[0] != '$' || word.length < 2 || word.length > 40)
      status = lth_msh_fail(&r, "'%.*s' where a section was expected, which begins with $",
                            word.length < 40 ? (int)word.length : 40, word.at);
    else
      status = read_section(&r, (LthWord){word.at + 1, word.length - 1});
  }
  if (status == LITHE_OK && r.version == 0)
    status = lth_msh_fail(&r, "the file is empty, expected $MeshFormat");
  lth_msh_reader_free(&r);
  return status;
}

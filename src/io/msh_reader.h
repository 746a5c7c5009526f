/// Values and sections of a Gmsh file, whether text or binary of either byte order.
#pragma once

#include "io/element_builder.h"

/// Where a reader is.
typedef struct LthMshReader {
  LthElementBuilder *b;
  const char *data; ///< start of the file, for byte offsets
  LthText text;     ///< `at` is the next byte, also of binary data
  const char *section;
  bool is_binary, is_big;
  int version;    ///< 2 or 4
  int size_bytes; ///< of a size_t in the file

  // physical groups: names by dimension and number, numbers by entity
  LthHash name_of, entity_of;
  LthWord *names;
  LitheIndex *physical_off; ///< (n_entities + 1) into physical
  LitheIndex *physical;
  LitheIndex n_names, n_entities, n_physical;
  LitheCount cap_names, cap_off, cap_physical;
  LthHash volume_of; ///< version 2: elements by their nodes, as they are repeated for every group
} LthMshReader;

void lth_msh_reader_free(LthMshReader *r);

/// LITHE_BAD_INPUT with the line of a text file or the byte of a binary one in front.
LitheStatus lth_msh_fail(const LthMshReader *r, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/// The next value; `what` names it in messages. An int is 4 bytes in a binary file, a size what its head says.
LitheStatus lth_msh_int(LthMshReader *r, const char *what, LitheIndex *value);
LitheStatus lth_msh_size(LthMshReader *r, const char *what, LitheCount *value);
LitheStatus lth_msh_double(LthMshReader *r, const char *what, double *value);

/// Physical groups: remember a name, the groups of an entity; the list of an entity's groups (n = 0: none).
LitheStatus lth_msh_name(LthMshReader *r, LitheIndex dimension, LitheIndex tag, LthWord name);
LitheStatus lth_msh_entity(LthMshReader *r, LitheIndex dimension, LitheIndex tag);
LitheStatus lth_msh_entity_group(LthMshReader *r, LitheIndex group); ///< of the last entity
LitheIndex lth_msh_groups_of(const LthMshReader *r, LitheIndex dimension, LitheIndex tag,
                             const LitheIndex **groups);

/// What is known of an element type of Gmsh.
typedef struct LthMshType {
  int number, dimension, n_nodes, n_corners;
  LthElementKind kind; ///< of dimension 3
} LthMshType;

/// NULL where the type is not known.
const LthMshType *lth_msh_type(LitheIndex number);

/// Enter an element into the builder, and into the groups (physical tags) given.
LitheStatus lth_msh_element(LthMshReader *r, const LthMshType *type, int64_t id, LitheIndex line,
                            const int64_t *node, LitheIndex n_groups, const LitheIndex *groups);

/// The header of a PLY file: its elements and their properties.
#pragma once

#include "io/text.h"

#define LTH_PLY_NAME_MAX 64
#define LTH_PLY_ELEMENTS_MAX 32
#define LTH_PLY_PROPERTIES_MAX 512

typedef enum LthPlyFormat { LTH_PLY_TEXT, LTH_PLY_LITTLE, LTH_PLY_BIG } LthPlyFormat;

typedef enum LthPlyType {
  LTH_PLY_INT8,
  LTH_PLY_UINT8,
  LTH_PLY_INT16,
  LTH_PLY_UINT16,
  LTH_PLY_INT32,
  LTH_PLY_UINT32,
  LTH_PLY_FLOAT32,
  LTH_PLY_FLOAT64
} LthPlyType;

typedef struct LthPlyProperty {
  char name[LTH_PLY_NAME_MAX];
  bool is_list;
  LthPlyType count_type; ///< of the length of a list
  LthPlyType type;
} LthPlyProperty;

typedef struct LthPlyElement {
  char name[LTH_PLY_NAME_MAX];
  LitheCount count;
  int first_property, n_properties;
} LthPlyElement;

typedef struct LthPlyHeader {
  LthPlyFormat format;
  int n_elements, n_properties;
  LthPlyElement elements[LTH_PLY_ELEMENTS_MAX];
  LthPlyProperty properties[LTH_PLY_PROPERTIES_MAX];
} LthPlyHeader;

/// Bytes of a value in a binary file.
int lth_ply_type_size(LthPlyType type);

/// Read up to and with the line "end_header"; `text` is left at the first byte of the data.
LitheStatus lth_ply_header_parse(LthText *text, LthPlyHeader *header);

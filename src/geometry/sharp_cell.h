/// The surface of a solid in one tetrahedron, in which all its fields are linear: planar pieces that meet in sharp
/// edges and corners.
#pragma once

#include "geometry/solid.h"

#define LTH_CELL_FIELDS 24 ///< fields that may meet in one tetrahedron
#define LTH_CELL_VERTICES 1024
#define LTH_CELL_PIECES 512
#define LTH_CELL_SIDES 64 ///< of a piece

/// A point of a simplex (edge, face, whole tetrahedron) where one, two, three fields are zero.
typedef struct LthCellVertex {
  int simplex;       ///< bits of its corners
  int n, field[3];   ///< local numbers, rising
  double weight[4];  ///< of the corners; their sum is one
  uint32_t asked;    ///< bits of the fields whose sign is known here
  uint32_t negative; ///< and which of them are negative
} LthCellVertex;

/// What a side of a piece lies in: a face of the tetrahedron, or where another field is zero.
typedef struct LthCellLine {
  int simplex, field; ///< bits of three corners and -1, or 15 and the field
} LthCellLine;

/// Part of the plane where a field is zero; it faces where the field is positive unless `is_turned`.
typedef struct LthCellPiece {
  int field, n, vertex[LTH_CELL_SIDES];
  LthCellLine line[LTH_CELL_SIDES]; ///< of the side from a vertex to the next
  uint32_t negative;                ///< bits of the fields that are negative in it
  bool is_kept, is_turned;
} LthCellPiece;

/// Fill the first block, then call lth_cell_surface(). Corners are in an order that neighbours agree on.
typedef struct LthCell {
  const LthSolid *solid;
  LthFieldSide *side; ///< of all the solid's fields in this tetrahedron; changed (n_fields)
  int n;              ///< fields here
  LitheIndex field[LTH_CELL_FIELDS];
  double value[LTH_CELL_FIELDS][4];
  bool is_odd; ///< the corners are a left-handed frame

  LthCellVertex vertex[LTH_CELL_VERTICES];
  LthCellPiece piece[LTH_CELL_PIECES];
  int n_vertices, n_pieces;
} LthCell;

/// Find the pieces of the surface (is_kept). Sides in faces of the tetrahedron are the same for both neighbours. False where rounding
/// left what does not fit, or more than there is room for.
bool lth_cell_surface(LthCell *cell);

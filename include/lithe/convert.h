/// Scenes from decks of other programs.
#pragma once

#include "lithe/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What to translate. Start from lithe_convert_def_default() and set both files. Nothing is kept.
typedef struct LitheConvertDef {
  const char *deck;  ///< a deck of CalculiX or Abaqus (.inp)
  const char *scene; ///< the scene file to write
  LitheIndex step;   ///< the state at the end of which *STEP, from 1; 0: of the last
} LitheConvertDef;

LITHE_API LitheConvertDef lithe_convert_def_default(void);

/// What was translated.
typedef struct LitheConversion {
  LitheIndex elements, nodes, materials, constraints, loads;
  LitheIndex
      sets; ///< that the deck does not name and the mesh file beside the scene adds; 0: there is none
  char mesh[1024]; ///< the mesh file as the scene names it
} LitheConversion;

/// Translate a linear elastic static deck into a scene of conforming elements with the deck's own nodes. Where
/// loads or supports stand on nodes and faces without a name, SCENE-sets.inp is written beside the scene:
/// it includes the deck and names them.
/// @return LITHE_BAD_INPUT: the deck is wrong. LITHE_UNSUPPORTED: it holds what a scene cannot say; the message names
/// keyword and line. LITHE_NO_SPACE: cannot write. LITHE_NO_MEMORY.
LITHE_API LitheStatus lithe_convert(LitheCtx *ctx, const LitheConvertDef *def,
                                    LitheConversion *conversion);

#ifdef __cplusplus
}
#endif

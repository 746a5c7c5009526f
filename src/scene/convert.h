/// A deck on its way to a scene: what its cards say by the end of a step, resolved to nodes and faces.
#pragma once

#include "io/id_map.h"
#include "io/inp_mesh.h"
#include "lithe/convert.h"
#include "mesh/element_mesh.h"

#define LTH_CONVERT_FACES 8 ///< faces of an element are 8 * element + local face, as in groups

typedef struct LthConvertMaterial {
  const LthInpCard *card; ///< *MATERIAL
  char *name;
  double young, poisson, density; ///< 0: not given
} LthConvertMaterial;

typedef struct LthConvertSection {
  const LthInpCard *card;
  const LthElementGroup *elements;
  LitheIndex material; ///< -1 until lth_convert_check() finds it: it may stand below
} LthConvertSection;

typedef struct LthConvertAmplitude {
  const LthInpCard *card;
  const char *name; ///< borrowed from the card
  bool is_constant;
  double value;
} LthConvertAmplitude;

/// Gravity or a centrifugal force on all elements.
typedef struct LthConvertBodyForce {
  const LthInpCard *card;
  bool spins;
  int step;
  double size; ///< acceleration, or square of the angular velocity
  double point[3], axis[3];
} LthConvertBodyForce;

/// Everything that is known of the deck so far. Values hold for the end of the step that was read last.
typedef struct LthConvert {
  LitheCtx *ctx;
  const LitheConvertDef *def;
  LthInpDeck *deck;
  LthElementMesh *mesh;
  LthIdMap node_of, element_of;
  char *title;
  int step;                   ///< 0: before the first *STEP
  const LthInpCard *analysis; ///< *STATIC of this step
  bool renewed[3]; ///< OP=NEW of this step was heard: boundary, nodal forces, distributed loads

  LthConvertMaterial *materials;
  LitheIndex n_materials;
  LthConvertSection *sections;
  LitheIndex n_sections;
  LthConvertAmplitude *amplitudes;
  LitheIndex n_amplitudes;
  LthConvertBodyForce *body_forces;
  LitheIndex n_body_forces;
  LitheCount cap_materials, cap_sections, cap_amplitudes, cap_body_forces;

  uint8_t *is_held; ///< (n_nodes x 3)
  double *held;     ///< [m]                                       (n_nodes x 3)
  double *force;    ///< [N]                                       (n_nodes x 3)
  int *force_step;  ///< step in which a force was given last      (n_nodes x 3)
  double *pressure; ///< [Pa]                                      (8 n_elements)
  int *pressure_step;
} LthConvert;

/// Cards, each in a function; the caller has checked the parameters.
LitheStatus lth_convert_material(LthConvert *c, const LthInpCard *card);
LitheStatus lth_convert_elastic(LthConvert *c, const LthInpCard *card);
LitheStatus lth_convert_density(LthConvert *c, const LthInpCard *card);
LitheStatus lth_convert_section(LthConvert *c, const LthInpCard *card);
LitheStatus lth_convert_amplitude(LthConvert *c, const LthInpCard *card);
LitheStatus lth_convert_boundary(LthConvert *c, const LthInpCard *card);
LitheStatus lth_convert_cload(LthConvert *c, const LthInpCard *card);
LitheStatus lth_convert_dload(LthConvert *c, const LthInpCard *card);
LitheStatus lth_convert_dsload(LthConvert *c, const LthInpCard *card);

/// The factor that the card's AMPLITUDE stands for, 1 without one.
LitheStatus lth_convert_factor(LthConvert *c, const LthInpCard *card, double *factor);

/// A group called like a word, upper and lower case alike; NULL.
const LthElementGroup *lth_convert_group(const LthConvert *c, LthGroupOf of, LthWord name);

/// The nodes or elements that entry 0 of a row means: a number (put into *one) or the name of a set.
LitheStatus lth_convert_target(LthConvert *c, const LthInpRow *row, LthGroupOf of, LitheIndex *one,
                               const LitheIndex **member, LitheIndex *n);

/// Every element has a section; materials that count are complete.
LitheStatus lth_convert_check(LthConvert *c);
/// Material of each element (n_elements), the last section wins; caller frees.
LitheStatus lth_convert_element_materials(LthConvert *c, LitheIndex **material);

/// What one entry of the scene acts on: members, and three values of which some may be absent.
typedef struct LthConvertSet {
  LthGroupOf of;
  LitheIndex n, *member; ///< ascending, as in LthElementGroup
  bool has[3];
  double value[3];
  const char *label; ///< borrowed from the mesh, or `own`
  char own[32];      ///< name of a set that the deck does not have
} LthConvertSet;

typedef struct LthConvertSets {
  LthConvertSet *set;
  LitheIndex n;
  LitheCount cap;
} LthConvertSets;

void lth_convert_sets_free(LitheCtx *ctx, LthConvertSets *sets);

/// Supports: nodes of equal value a component; components of the same nodes are one entry.
LitheStatus lth_convert_holds(LthConvert *c, LthConvertSets *sets);
/// Nodal forces: nodes of the same force. Pressures (value[0]): faces of the same pressure.
LitheStatus lth_convert_forces(LthConvert *c, LthConvertSets *sets);
LitheStatus lth_convert_pressures(LthConvert *c, LthConvertSets *sets);
/// Give each set the deck's name for it, or a new one: `stem`-1, `stem`-2, ...; counts the new ones.
LitheStatus lth_convert_name_sets(LthConvert *c, const char *stem, LthConvertSets *sets,
                                  LitheIndex *n_new);

/// All that the scene says, in the order it is written.
typedef struct LthConvertScene {
  LthConvertSets holds, forces, pressures;
  LitheIndex n_new; ///< sets that the deck does not name
  char *mesh;       ///< file that the scene names
} LthConvertScene;

LitheStatus lth_convert_write_scene(LthConvert *c, const LthConvertScene *scene);
LitheStatus lth_convert_write_sets(LthConvert *c, const LthConvertScene *scene, const char *path,
                                   const char *deck);

/// A scene as typed values: what the reader makes of the file and everything else is built from.
#pragma once

#include "base/ctx.h"
#include "base/value.h"
#include "disc/dg/dg_operator.h"
#include "embed/embedding.h"
#include "geometry/fractions.h"
#include "geometry/shape.h"
#include "material/material.h"
#include "mesh/element_mesh.h"
#include "mesh/piece.h"
#include "mesh/refinement.h"
#include "mesh/selection.h"
#include "step/simulation.h"

typedef enum LthMethodKind { LTH_METHOD_DG, LTH_METHOD_CG, LTH_METHOD_STAGGERED } LthMethodKind;

/// Of staggered bodies. Auto: mixed where a Poisson's ratio is 0.45 or more.
typedef enum LthSceneFormulation {
  LTH_FORMULATION_AUTO,
  LTH_FORMULATION_DISPLACEMENT,
  LTH_FORMULATION_MIXED
} LthSceneFormulation;

typedef enum LthMeshKind {
  LTH_MESH_SLICE,
  LTH_MESH_HEXAHEDRA,
  LTH_MESH_TETRAHEDRA,
  LTH_MESH_VOXELS,   ///< of cg: grid cells at least half full
  LTH_MESH_EMBEDDED, ///< of cg: all grid cells that the body touches, weighted by what it fills
  LTH_MESH_FILE
} LthMeshKind;

/// Hexahedra of degree 2.
typedef enum LthHexahedron {
  LTH_HEXAHEDRON_27,
  LTH_HEXAHEDRON_20,
  LTH_HEXAHEDRON_20R
} LthHexahedron;

/// How a body's resolution is given; exactly one of the three.
typedef struct LthResolution {
  LitheIndex cells[3]; ///< over the bounding box; {n, 0, 0}: n along the longest side
  double cell_size;    ///< [m], 0: not given
  bool has_grid;
  LthGrid grid;
} LthResolution;

typedef struct LthSceneConstraint {
  char *path;        ///< "bodies.0.constraints.1", for `reaction`
  const char *place; ///< "scene.yaml:8:9: bodies.0.constraints.1", for messages
  LthWhere where;
  bool fixed[3], normal_only, is_position, strong, interior;
  LthValue value[3];
} LthSceneConstraint;

typedef struct LthSceneLoad {
  const char *place; ///< "scene.yaml:12:9: bodies.0.loads.0", for messages
  LthWhere where;
  LthLoadKind kind;
  LthValue value[3], stress[9];
  bool follower;
} LthSceneLoad;

/// A heterogeneous material's part: the first whose `where` contains a cell's centroid wins.
typedef struct LthSceneMaterial {
  bool has_where;
  LthWhere where;
  LthMaterial material;
} LthSceneMaterial;

typedef struct LthSceneBody {
  char *name, *path;
  const char *place;   ///< "scene.yaml:3:5: bodies.0", for messages
  LthShape shape;      ///< placed: scene axes, scale and place
  LthSoup *soup;       ///< of a mesh shape, placed, file order; NULL otherwise
  LthSurface *surface; ///< of a mesh shape, cleaned and placed; NULL otherwise, also of a wrapped
  double file_to_scene[12]; ///< row-major 3x4: scene = A file + b, for output.space: file
  double shape_resolution;  ///< [m], 0: a quarter of a cell
  LthSceneMaterial *materials;
  LitheIndex n_materials;
  LthMethodKind method_kind;
  LthMeshKind mesh_kind;
  bool has_shape;            ///< false: the mesh file is the shape
  LthElementMesh *elements;  ///< of a mesh file, placed; NULL otherwise
  const char *elements_file; ///< its path, for messages
  double elements_box[6];    ///< min, max [m]
  LthHexahedron hexahedron;
  LthResolution resolution;
  int degree;         ///< of every element; 0: `degree_at`
  LthValue degree_at; ///< an expression of x, y, z, taken at centroids and rounded
  LthFlux flux;
  LthPenaltyKind penalty;
  double eta;
  double sliver;
  LthFractionDef fractions;        ///< of staggered
  bool has_fractions;              ///< false: the user leaves `fractions` to us
  LthSceneFormulation formulation; ///< of staggered
  LthSceneConstraint *constraints;
  LitheIndex n_constraints;
  LthSceneLoad *loads;
  LitheIndex n_loads;
  double place_rotation[9]; ///< of `place`; grids stay along the scene's axes
  double place_translation[3];
  LthValue initial_velocity[3], initial_displacement[3]; ///< of x, y, z
  bool has_embed;
  LthSoup *embed_soup; ///< a mesh file's, placed as the body; NULL: the shape's own surface
  LthInterpolation interpolation;
  LthSamples samples;
} LthSceneBody;

/// Two bodies that are glued together.
typedef struct LthSceneTie {
  const char *place; ///< "scene.yaml:20:5: tie.0", for messages
  LitheIndex body[2];
  LthWhere where;
} LthSceneTie;

typedef enum LthCutKind { LTH_CUT_PLANE, LTH_CUT_BLADE, LTH_CUT_CARVE } LthCutKind;

/// Of carving.
typedef enum LthKeep { LTH_KEEP_INSIDE, LTH_KEEP_OUTSIDE, LTH_KEEP_BOTH } LthKeep;

/// A cut, as `cuts` has it.
typedef struct LthSceneCut {
  const char *place; ///< "scene.yaml:20:5: cuts.0", for messages
  double at;         ///< [s]
  LitheIndex body;   ///< -1: all
  bool at_rest;      ///< places are those at rest, else those of the moment
  LthCutKind kind;
  LthPlane plane;
  bool has_within;
  LthShape within;   ///< prepared
  LitheIndex n_path; ///< of a blade, two at least
  double (*path)[3], depth[3];
  LthShape carve;
  LthKeep keep;
} LthSceneCut;

/// What an element is judged by: the words of `criterion`, in their order.
typedef enum LthCriterion { LTH_BY_STRESS, LTH_BY_TURN, LTH_BY_ERROR } LthCriterion;

/// One half of `adapt`: division (h) or degree (p).
typedef struct LthSceneAdapt {
  bool is_on;
  LthCriterion criterion;
  double threshold;     ///< [Pa], [rad] or [1]
  double coarsen;       ///< share of it below which refinement is taken back
  LthDivision division; ///< of h
  LitheIndex limit;     ///< highest level, highest degree
  LitheIndex every;     ///< steps between two looks
} LthSceneAdapt;

typedef enum LthTimeKind { LTH_TIME_STATIC, LTH_TIME_QUASISTATIC, LTH_TIME_DYNAMIC } LthTimeKind;

/// What touches. Auto: see build_contact.c.
typedef enum LthContactPoints {
  LTH_POINTS_AUTO,
  LTH_POINTS_SURFACE,
  LTH_POINTS_NODES
} LthContactPoints;

typedef struct LthSceneProbe {
  char *name;
  double point[3];
} LthSceneProbe;

typedef struct LthScene {
  char *title, *file, *directory; ///< file as given; directory that paths are relative to
  char *name;                     ///< stem of the file: the default output folder's name
  int dimension;                  ///< 3, or 2: plane strain, where all places have z = 0
  LthSceneBody *bodies;           ///< one or more (n_bodies)
  LitheIndex n_bodies;
  double gravity[3]; ///< [m/s^2]
  LthCollider *colliders;
  LthSurface *
      *collider_surfaces; ///< of mesh colliders, owned                (n_colliders, may hold NULL)
  LitheIndex n_colliders;
  double contact_stiffness; ///< 0: auto
  double contact_friction, contact_damping;
  bool contact_bodies; ///< every two bodies collide
  LthContactPoints contact_points;
  LthSceneTie *ties;
  LitheIndex n_ties;
  LthSceneCut *cuts;
  LitheIndex n_cuts;
  LthSceneAdapt adapt_h, adapt_p;
  double adapt_blend;        ///< time in which what new functions release comes to act [s]
  LitheIndex adapt_elements; ///< nothing is divided beyond so many
  LthTimeKind time_kind;
  double duration, step; ///< [s]
  LitheIndex steps;      ///< quasistatic
  LthIntegrator integrator;
  LthLinearChoice linear;
  double tolerance;
  int threads;
  double newton_tolerance;
  LitheIndex newton_iterations;
  bool condition;
  char *export_path; ///< Matrix Market, relative to the output folder; NULL: none
  LthSceneProbe *probes;
  LitheIndex n_probes;
  bool has_exact_displacement, exact_is_position, has_exact_stress;
  LthValue exact[3], exact_stress[9];
  double output_every; ///< [s]; 0: every step; negative: `last`
  bool fields_vtu, fields_vti, fields_nifti;
  bool fields_unsaid; ///< the default: vtu, of staggered bodies vti
  bool surface_pc2, surface_obj, surface_ply, surface_stl;
  bool output_in_file_space;
  double checkpoint_period; ///< of wall clock [s]; negative: no checkpoints
  char **overrides;         ///< of the command line, as given                    (n_overrides)
  int n_overrides;
  uint64_t
      digest;  ///< of the file, of all files that it names, and of the overrides but for threads
  void *owned; ///< expressions and strings behind the values
} LthScene;

/// All that is wrong with a scene file, one line each: "file:line:col: path: what; what is expected".
typedef struct LthSceneErrors {
  LitheCtx *ctx; ///< whose memory the lines are
  char **lines;
  LitheIndex n;
} LthSceneErrors;

void lth_scene_errors_free(LthSceneErrors *errors);

/// Read and check a scene, with the surfaces it names. An override of the command line reads
/// "bodies.0.method.degree=2". On LITHE_BAD_INPUT `errors` (zero-initialised by the caller, freed by
/// lth_scene_errors_free()) holds every error of the file, and where a surface is defective its defects
/// have been written to `defects_path` ("defects.ply", NULL: not written).
LitheStatus lth_scene_read(LitheCtx *ctx, const char *file, const char *const *overrides,
                           int n_overrides, const char *defects_path, LthSceneErrors *errors,
                           LthScene **scene);

/// The same from text in memory (for tests and fuzzing); `name` stands for the file in messages and its
/// folder for what paths are relative to. NULL: text of unknown origin, no file that it names is opened.
LitheStatus lth_scene_read_text(LitheCtx *ctx, const char *name, const char *text, size_t length,
                                const char *const *overrides, int n_overrides,
                                LthSceneErrors *errors, LthScene **scene);

/// LITHE_BAD_INPUT where an expression of the scene has come out infinite or undefined by now; the message
/// names it, the place and the time.
LitheStatus lth_scene_check_values(LitheCtx *ctx, const LthScene *scene);

/// Let `file` be the name that results tell for this scene, wherever it was read from.
LitheStatus lth_scene_rename(LitheCtx *ctx, LthScene *scene, const char *file);

void lth_scene_destroy(LitheCtx *ctx, LthScene **scene);

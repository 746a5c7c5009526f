/// A body as it is simulated: everything that is built from a scene's description of it.
#pragma once

#include "disc/cg/cg_strong.h"
#include "disc/dg/dg_disc.h"
#include "disc/dg/dg_strong.h"
#include "scene/scene.h"
#include "step/simulation.h"

typedef struct LthStaggeredBody LthStaggeredBody; // staggered_body.h
typedef struct LthBodyChange LthBodyChange;       // change.h

/// Parts of a body that do not hang together, with closed surfaces at rest.
typedef struct LthBodyParts {
  LitheIndex n;
  LthSurface *surface;     ///< (n)
  LthCrackSides *cracks;   ///< (n) NULL: no cut ends inside a part
  LitheIndex *first_point; ///< embedded point of each surface's first        (n + 1)
  LthEmbedding *points;    ///< of all surfaces, one after the other
} LthBodyParts;

/// Built once, in the order of the fields; nothing turns back. Owned: all but `def` and `scene`. A staggered body has
/// fractions in the place of a mesh, and neither mesh nor surface nor constants per cell.
typedef struct LthBody {
  const LthScene *scene;
  const LthSceneBody *def;

  // shape -> mesh (build_mesh.c)
  LthSurface *surface; ///< closed surface in scene axes; NULL for plain boxes of cells
  LthMesh *mesh;
  LthBodyChange *change; ///< of bodies whose elements change; else NULL
  LthElementMesh
      *elements; ///< nodes and elements behind the mesh: of a file (then the scene's), or of cg
  LitheIndex *cell_element;    ///< element of each cell where they are not the same, or NULL
  double box[6];               ///< of the mesh: min, max [m]
  double size;                 ///< longest side of it [m]
  double cell_size;            ///< typical edge of a cell [m]
  LthStaggeredBody *staggered; ///< NULL: of another method (build_staggered.c)

  // space and material (build_material.c)
  LthDgSpace *space;
  LitheIndex *label; ///< entry of the material list                    (n_cells)
  double *young, *poisson, *density, *yield; ///< per cell; yield 0: not given  (n_cells)
  bool warped;
  double damping_mass, damping_stiffness;
  double mass; ///< [kg]

  // constraints and loads (build_constraint.c, build_load.c)
  LthPatches **patches; ///< of constraints and loads                     (n_patches)
  LitheCount n_patches, cap_patches;
  LthWeakConstraint *weak;
  LitheIndex *weak_of; ///< scene constraint behind each weak one          (n_weak)
  LitheIndex n_weak;
  LitheCount cap_weak, cap_weak_of;
  LthDgStrong *strong;     ///< NULL: none
  LthCgStrong *held_nodes; ///< of cg; NULL: none
  LthLoad *loads;          ///< parts of the scene's that differ in what is held
  LitheIndex n_loads;
  LitheCount cap_loads;
  LthPlaces **places; ///< of point forces, NULL for other loads          (def->n_loads)

  LthDgOperator *op;
  LitheIndex n_parts;  ///< that do not hang together; staggered bodies count as one
  LitheIndex n_fronts; ///< edges at which a cut ends inside a part
  LthDisc *disc;       ///< what all the rest sees of space and operator

  // what follows the body, and what it touches (build_embedding.c)
  LthSoup *own_soup;       ///< of the tessellated shape where no file gave one
  const LthSoup *soup;     ///< the embedded surface, or NULL
  LthEmbedding *embedding; ///< of soup's points, or NULL
  LthEmbedding *nodes;     ///< contact points where they are not the embedding's, or NULL
  LthContact *contact;     ///< with colliders, or NULL

  // what other bodies touch (build_touch.c), where there are any
  LthSurface *touch;             ///< closed, at rest
  LthEmbedding *touch_embedding; ///< of its points where that is not `embedding`, or NULL
  LitheIndex *touch_point;       ///< embedded point of each of its points
  LthBodyParts *parts; ///< by which they touch each other, where there are several, or NULL

  // among all bodies (world.c)
  LthSimulation *sim; ///< of all, borrowed
  LitheCount first;   ///< first unknown of this body in it
} LthBody;

/// Free all of a body.
void lth_body_destroy(LitheCtx *ctx, LthBody **body);

/// Free what is built upon elements: all but shape, mesh, what may change of it, and the surface that follows.
void lth_body_free_on_mesh(LitheCtx *ctx, LthBody *body);

/// Operator, contact and all else that follows from the mesh (and space and material where they are there).
LitheStatus lth_body_build_on_mesh(LitheCtx *ctx, LthBody *body);

/// A body with its mesh and nothing else; lth_body_build_on_mesh() goes on.
LitheStatus lth_body_create_mesh(LitheCtx *ctx, const LthScene *scene, const LthSceneBody *def,
                                 LthBody **body);

/// Basis functions of a dg body's cells.
LitheStatus lth_body_build_space(LitheCtx *ctx, LthBody *body);

/// What a check needs on top of the mesh: material, selections, operator.
LitheStatus lth_body_build_conditions(LitheCtx *ctx, LthBody *body);

/// Matrix entries of a linear body whose elements change, where its operator has others than before.
LitheStatus lth_body_keep_matrix(LitheCtx *ctx, LthBody *body);

/// The body as part of a system.
LthSystemBody lth_body_as_part(const LthBody *body);

/// Its own coefficients in the simulation: x - X0 (computed by each call, not for loops), position, velocity. (disc->n_dofs)
const double *lth_body_displacement(const LthBody *body);
double *lth_body_position(const LthBody *body);
double *lth_body_velocity(const LthBody *body); ///< NULL where nothing ever moves

/// Whether the embedded surface is that of the shape, point for point: not one of its own, and not the file that a
/// shape was wrapped around.
static inline bool lth_body_embeds_shape(const LthBody *body) {
  return !body->def->embed_soup && !(body->def->soup && !body->def->surface);
}

/// What follows the points of `touch`: lent.
const LthEmbedding *lth_body_touch_points(const LthBody *body);

/// Largest lambda + 2 mu [Pa].
double lth_body_modulus(const LthBody *body);
/// Weight that a spot of contact carries [N]. In the plane, where masses are those of a metre, that of a slice as deep as the
/// spot is wide: the spot is a strip across it.
double lth_body_weight(const LthBody *body);

/// Cells of the discretisation, its material's volume in one of them [m^3] and the middle of that [m].
double lth_body_cell_volume(const LthBody *body, LitheIndex cell);
void lth_body_cell_center(const LthBody *body, LitheIndex cell, double x[3]);
double lth_body_volume(const LthBody *body);       ///< at rest [m^3]
LitheIndex lth_body_elements(const LthBody *body); ///< cells with material
LitheCount
lth_body_unknowns(const LthBody *body); ///< without those of staggered grids that are missing

/// Entry of the material list that a cell has, and its yield strength [Pa], 0 where none is given.
LitheIndex lth_body_entry(const LthBody *body, LitheIndex cell);
double lth_body_yield(const LthBody *body, LitheIndex cell);

/// Young's modulus [Pa] and Poisson's ratio of a cell.
void lth_body_elastic(const LthBody *body, LitheIndex cell, double *young, double *poisson);

/// What is the same in all materials of a body; and constants in range at a place.
LitheStatus lth_check_materials(LitheCtx *ctx, const LthSceneBody *def);
LitheStatus lth_check_constants(LitheCtx *ctx, const LthBody *body, const double at[3],
                                double young, double poisson, double density);

/// The steps of lth_body_create(), in order.
LitheStatus lth_build_mesh(LitheCtx *ctx, LthBody *body);
LitheStatus lth_build_slices(LitheCtx *ctx, LthBody *body, const LthGrid *grid, double sliver,
                             LthMesh **mesh);
LitheStatus lth_build_elements(LitheCtx *ctx, LthBody *body, const LthGrid *grid, bool tetrahedra,
                               const uint8_t *keep);                               ///< of cg
LitheStatus lth_build_voxels(LitheCtx *ctx, LthBody *body, const LthGrid *grid);   ///< of cg
LitheStatus lth_build_covering(LitheCtx *ctx, LthBody *body, const LthGrid *grid); ///< of cg
/// Degree of each element of the mesh (n_cells). LITHE_BAD_INPUT: out of range somewhere.
LitheStatus lth_build_degrees(LitheCtx *ctx, const LthBody *body, uint8_t *degree);
LitheStatus lth_build_degrees_of(LitheCtx *ctx, const LthBody *body, const LthMesh *mesh,
                                 uint8_t *degree); ///< of another mesh of the body
LitheStatus lth_build_material(LitheCtx *ctx, LthBody *body);
LitheStatus lth_build_constraints(LitheCtx *ctx, LthBody *body);
LitheStatus lth_build_weak(LitheCtx *ctx, LthBody *body, LitheIndex constraint); ///< a part of it
LitheStatus lth_build_nodes(LitheCtx *ctx, LthBody *body); ///< constraints and discretisation of cg
LitheStatus lth_build_loads(LitheCtx *ctx, LthBody *body);
LitheStatus lth_build_embedding(LitheCtx *ctx, LthBody *body);
LitheStatus lth_build_contact(LitheCtx *ctx, LthBody *body);
/// Contact points of a staggered body: one on the boundary near each cell that it leaves, with its share of the area,
/// and those of `surface` (NULL: none) as in lth_embedding_create_nodes().
LitheStatus lth_build_grid_nodes(LitheCtx *ctx, const LthBody *body, const LthEmbedding *surface,
                                 LthEmbedding **nodes);
LitheStatus lth_build_touch(LitheCtx *ctx, LthBody *body); ///< later, among several bodies
void lth_body_free_touch(LitheCtx *ctx, LthBody *body);
LitheStatus lth_body_count_parts(LitheCtx *ctx, LthBody *body); ///< and the fronts of cuts
LitheStatus lth_build_parts(LitheCtx *ctx, LthBody *body); ///< body->parts, later, among bodies
void lth_body_parts_destroy(LitheCtx *ctx, LthBodyParts **parts);
LitheStatus lth_build_initial(LitheCtx *ctx, LthBody *body);

/// The embedded surface: the scene's file, the shape's file, the tessellated shape, or without a shape the
/// boundary of the mesh file. Nothing where the body has one.
LitheStatus lth_body_choose_soup(LitheCtx *ctx, LthBody *body);

/// Triangles as polygons. Free with lth_soup_destroy().
LitheStatus lth_surface_as_soup(LitheCtx *ctx, const LthSurface *surface, LthSoup **soup);

/// Tessellate the shape where the body has no surface yet.
LitheStatus lth_body_make_surface(LitheCtx *ctx, LthBody *body);

/// Points (n x 3) that follow the body as its embedded surface would. `cells` (n): -1 where not known.
LitheStatus lth_build_points(LitheCtx *ctx, const LthBody *body, LitheIndex n, const double *points,
                             const LitheIndex *cells, LthEmbedding **embedding);

/// The grid that a body's resolution asks for, over the box of its shape.
LitheStatus lth_build_grid(LitheCtx *ctx, const LthSceneBody *def, const double min[3],
                           const double max[3], LthGrid *grid);

/// Strong and interior constraints hold unknowns of elements, the others act on the boundary.
bool lth_is_strong(const LthSceneConstraint *constraint);

/// Some value varies with time.
bool lth_moves(const LthValue value[3]);

/// Take over patches, which live as long as the body; they are freed where that fails.
LitheStatus lth_body_own_patches(LitheCtx *ctx, LthBody *body, LthPatches *patches);

/// The nodes that a point force acts on; none is an error, or a loss (change.h) that leaves `*places` as it is.
LitheStatus lth_build_places(LitheCtx *ctx, const LthBody *body, const LthSceneLoad *load,
                             LthPlaces **places);

/// The patches that `where` selects; none is an error that names `place` and the body's box, or a loss (change.h).
LitheStatus lth_build_patches(LitheCtx *ctx, const LthBody *body, const char *place,
                              const LthWhere *where, LthPatches **patches);

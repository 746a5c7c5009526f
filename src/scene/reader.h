/// What all readers of parts of a scene share: where errors, memory and files go.
///
/// Readers run after the schema's check: types, units, ranges and defaults are settled. A node that is
/// missing or bad has been reported; readers then leave the zero that is there and go on, so that one
/// run finds all errors.
#pragma once

#include "scene/quantity.h"
#include "scene/report.h"

/// What a scene owns beyond its own arrays; behind LthScene.owned.
typedef struct LthSceneOwned {
  LthArena arena;
  LthExpressionList expressions;
  LthSurface **surfaces;
  LitheCount n_surfaces, cap_surfaces;
  LthSoup **soups;
  LitheCount n_soups, cap_soups;
  LthWrap **wraps;
  LitheCount n_wraps, cap_wraps;
  LthVolume **volumes;
  LitheCount n_volumes, cap_volumes;
  LthImage **images;
  LitheCount n_images, cap_images;
  LthLoops **loops;
  LitheCount n_loops, cap_loops;
} LthSceneOwned;

typedef struct LthReader {
  LitheCtx *ctx;
  LthReport *report;
  LthArena *arena;
  LthSceneOwned *owned;
  LthScene *scene;
  const char *defects_path; ///< or NULL
  bool opens_files;         ///< false: files of a text of unknown origin stay closed
  const LthNode *root;
  const LthImage *image;    ///< of the present body, or NULL
  bool image_is_missing;    ///< it has one, but that could not be read
  double mesh_to_scene[12]; ///< of the mesh shape that was read last
  /// Groups that a `where` may name: of the body at hand; UNKNOWN where its file could not be read.
  enum { LTH_LABELS_UNKNOWN, LTH_LABELS_NONE, LTH_LABELS_OF_FILE } labels;
  const LthElementMesh *elements;
} LthReader;

/// x_scene = R x + t.
typedef struct LthPlacement {
  double rotation[9], translation[3];
  bool rotates;
} LthPlacement;

/// --- values (read_value.c) ---

/// A checked number of a map; `otherwise` where it is missing, bad or varies.
double lth_read_number(const LthNode *map, const char *key, double otherwise);
LitheIndex lth_read_integer(const LthNode *map, const char *key, LitheIndex otherwise);
LthValue lth_read_value(const LthNode *map, const char *key); ///< constant 0 where it is missing
bool lth_read_flag(const LthNode *map, const char *key);
const char *lth_read_text(const LthNode *map, const char *key); ///< NULL where it is missing
/// Vectors and tensors, row by row; false (and zeros) where they are missing.
bool lth_read_vector(const LthNode *map, const char *key, double v[3]);
bool lth_read_values(const LthNode *map, const char *key, LthValue v[3]);
bool lth_read_tensor(const LthNode *map, const char *key, LthValue v[9]);
/// A direction of length 1; a zero vector is reported.
bool lth_read_direction(LthReader *r, const LthNode *map, const char *key, double v[3]);
/// Position of a word in a NULL-ended list, 0 where it is missing.
int lth_read_word(const LthNode *map, const char *key, const char *const *words);

/// An array for a list's entries, zeroed; NULL where memory is out (the arena then has failed).
void *lth_read_array(LthReader *r, const LthNode *list, size_t size);

/// Placement of a body or collider (`place` may be NULL).
void lth_read_placement(LthReader *r, const LthNode *place, LthPlacement *placement);
void lth_place_point(const LthPlacement *p, const double x[3], double placed[3]);

/// --- shapes (read_shape.c, read_implicit.c) ---

/// A shape from a map with one shape key, placed. Bodies must be bounded: `search` (min, max or NULL) is
/// where implicit parts without a box are looked for; with `may_be_unbounded` they need none.
LitheStatus lth_read_shape(LthReader *r, const LthNode *node, const LthPlacement *place,
                           const double *search, bool may_be_unbounded, LthShape *shape);

/// Shapes of plane scenes (read_plane.c): `node` is the value of the key. A disk stands in for a bad one.
void lth_read_disk(LthReader *r, const LthNode *node, const LthPlacement *place, LthShape *shape);
LitheStatus lth_read_polygon(LthReader *r, const LthNode *node, const LthPlacement *place,
                             LthShape *shape);
/// A box there: a turned one goes on as a polygon.
LitheStatus lth_read_plane_box(LthReader *r, const double min[3], const double max[3],
                               const LthPlacement *place, LthShape *shape);
/// What a plane scene's box is along z: endless.
void lth_open_box(const LthReader *r, double min[3], double max[3]);

/// The implicit shape, before its box is known. True if the map gives one.
LitheStatus lth_read_implicit(LthReader *r, const LthNode *node, const LthPlacement *place,
                              LthShape *shape);
/// Give boxes to implicit parts that have none.
void lth_bound_shape(LthReader *r, const LthNode *node, LthShape *shape, const double *search);

/// --- images (read_image.c) ---

/// The shape of the map with `file`; a ball where that could not be read, and it has been reported.
LitheStatus lth_read_image(LthReader *r, const LthNode *node, const LthPlacement *place,
                           LthShape *shape);
/// Islands of an image (read_islands.c): what they are is told, or all but the largest left out.
LitheStatus lth_settle_islands(LthReader *r, const LthNode *image, LthImage *m);
/// `islands: remove-free`, once the body's constraints are read: `shape` is the node behind body->shape, or NULL.
LitheStatus lth_read_islands(LthReader *r, const LthNode *shape, const LthSceneBody *body);
/// `where: {label: k}` in a body made from an image.
LitheStatus lth_read_image_label(LthReader *r, const LthNode *node, LthWhere *where);
/// Let `value` and `label` in an expression mean the present body's image; reported where it has none.
void lth_bind_image(LthReader *r, const LthNode *map, const char *key);

LitheStatus lth_own_volume(LthReader *r, LthVolume *volume); ///< also frees it where that fails
LitheStatus lth_own_image(LthReader *r, LthImage *image);

/// --- surface files (read_mesh.c) ---

typedef struct LthMeshFile {
  LthSoup *soup;       ///< owned by the scene
  LthSurface *surface; ///< owned by the scene; NULL where it was not asked for
  LthWrap *wrap;       ///< instead of it with `repair: wrap`, owned by the scene
  double resolution;   ///< of `wrap` [m], 0: not given
  double to_scene[12]; ///< row-major 3x4, file to scene
} LthMeshFile;

/// Read, scale, fit and place a surface file; `node` is the map with `file`. What is wrong with the file
/// is reported at its name, and `mesh->soup` stays NULL.
LitheStatus lth_read_mesh(LthReader *r, const LthNode *node, const LthPlacement *place,
                          bool needs_surface, LthMeshFile *mesh);

/// A surface file that goes through a transform that is already known.
LitheStatus lth_read_mesh_as(LthReader *r, const LthNode *file, const double to_scene[12],
                             LthMeshFile *mesh);

/// Factor of `unit` of a file's numbers, 1 where it is not given.
double lth_read_unit(LthReader *r, const LthNode *node);

/// --- volume meshes (read_elements.c) ---

/// Read and place the mesh file of a method; what is wrong with it is reported at its name.
LitheStatus lth_read_elements(LthReader *r, const LthNode *node, const LthPlacement *place,
                              LthSceneBody *body);
/// Whether a method takes its mesh from a file.
bool lth_method_has_file(const LthNode *method);
/// Report a label that the mesh file of the body at hand does not have.
void lth_check_label(LthReader *r, const LthNode *label);

LitheStatus lth_own_surface(LthReader *r, LthSurface *surface); ///< also frees it where that fails
LitheStatus lth_own_soup(LthReader *r, LthSoup *soup);
LitheStatus lth_own_wrap(LthReader *r, LthWrap *wrap);

/// Path of a file that the scene names, and a check that it can be read: NULL where it cannot, and that
/// has been reported at `node`.
LitheStatus lth_find_file(LthReader *r, const LthNode *node, const char **path);

/// --- parts ---

LitheStatus lth_read_where(LthReader *r, const LthNode *node, LthWhere *where);
LitheStatus lth_read_bodies(LthReader *r); // read_body.c
LitheStatus lth_read_material(LthReader *r, const LthNode *node, LthSceneBody *body);
LitheStatus lth_read_constraints(LthReader *r, const LthNode *list, LthSceneBody *body);
LitheStatus lth_read_loads(LthReader *r, const LthNode *list, LthSceneBody *body);
void lth_read_method(LthReader *r, const LthNode *node, LthSceneBody *body);
LitheStatus lth_read_embed(LthReader *r, const LthNode *node, const LthPlacement *place,
                           LthSceneBody *body);
/// Which body has this name, -1: none, which has been reported.
LitheIndex lth_find_body(LthReader *r, LthNode *name); // read_tie.c
LitheStatus lth_read_ties(LthReader *r);               // read_tie.c, after the bodies
LitheStatus lth_read_cuts(LthReader *r);               // read_cut.c, after the bodies
LitheStatus lth_read_colliders(LthReader *r);          // read_collider.c
LitheStatus lth_read_motion(LthReader *r, const LthNode *motion, LthCollider *collider);
void lth_read_adapt(LthReader *r); // read_adapt.c, after the bodies
void lth_read_time(LthReader *r);  // read_run.c
void lth_read_solver(LthReader *r);
void lth_read_contact(LthReader *r);
void lth_read_probes(LthReader *r);
void lth_read_exact(LthReader *r);
void lth_read_output(LthReader *r);

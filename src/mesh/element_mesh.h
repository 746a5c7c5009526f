/// Nodes and elements as mesh files list them: what `cg` computes on, and what polyhedra are made from.
#pragma once

#include "mesh/mesh.h"

/// Node order within an element is VTK's (vtkHexahedron, vtkQuadraticHexahedron, vtkTriQuadraticHexahedron,
/// vtkWedge, vtkQuadraticWedge, vtkPyramid, ...): corners first, then edge, face and body nodes. All have a
/// positive Jacobian: the nodes 0 1 2 of a tetrahedron or wedge, and 0 1 2 3 of the others, turn counter-clockwise
/// seen from the rest of the element (for wedges, VTK's text says the opposite of its shape functions).
typedef enum LthElementKind {
  LTH_TET4,
  LTH_TET10,
  LTH_HEX8,
  LTH_HEX20,
  LTH_HEX27,
  LTH_WEDGE6,
  LTH_WEDGE15,
  LTH_WEDGE18,
  LTH_PYRAMID5,
  LTH_PYRAMID13,
  LTH_PYRAMID14,
  LTH_POLYHEDRON, ///< for dg only
  LTH_ELEMENT_KINDS
} LthElementKind;

#define LTH_ELEMENT_MAX_NODES 27

/// What is known of a kind: name as in messages ("hex20"), nodes, corners, polynomial degree (1, 2), and its
/// faces: corner, then mid-edge, then mid-face local nodes, counter-clockwise seen from outside.
typedef struct LthElementShape {
  const char *name;
  int n_nodes, n_corners, degree, n_faces;
  struct {
    int n_corners, n_nodes;
    int8_t node[9];
  } face[6];
} LthElementShape;

const LthElementShape *lth_element_shape(LthElementKind kind);

typedef enum LthGroupOf { LTH_GROUP_ELEMENTS, LTH_GROUP_NODES, LTH_GROUP_FACES } LthGroupOf;

/// A named set of a mesh file: NSET, ELSET, SURFACE, Gmsh physical group.
typedef struct LthElementGroup {
  char *name;     ///< as in the file; a physical group without a name has its number
  LitheIndex tag; ///< number in the file, -1: none
  LthGroupOf of;
  LitheIndex n;
  LitheIndex *member; ///< elements or nodes ascending; faces: 8 * element + local face
} LthElementGroup;

/// Immutable once built. Nodes that no element uses are dropped by the readers.
typedef struct LthElementMesh {
  LitheIndex n_nodes, n_elements;
  double *nodes;           ///< rest places [m]                             (n_nodes x 3)
  int64_t *node_id;        ///< number in the file, or NULL                 (n_nodes)
  uint8_t *kind;           ///< LthElementKind                              (n_elements)
  uint8_t *reduced;        ///< 1: the reduced rule (C3D8R, C3D20R), or NULL (n_elements)
  LitheIndex *element_off; ///< (n_elements + 1) into element_node
  LitheIndex *element_node;
  int64_t *element_id;   ///< number in the file, or NULL                 (n_elements)
  LitheIndex *line;      ///< of the file where an element stands, or NULL (n_elements)
  LitheIndex *poly_off;  ///< (n_elements + 1) into poly_face; NULL where there are no polyhedra
  LitheIndex *poly_face; ///< of a polyhedron: n faces, then for each its n nodes and them, outward
  LthElementGroup *groups;
  LitheIndex n_groups;
} LthElementMesh;

void lth_element_mesh_destroy(LitheCtx *ctx, LthElementMesh **mesh);

/// The first group called `name` of that sort, or whose tag the text spells; NULL.
const LthElementGroup *lth_element_group(const LthElementMesh *mesh, LthGroupOf of,
                                         const char *name);

/// Check orientation and closedness and turn inverted elements into an error that names file, line and
/// element. `file` is for messages.
LitheStatus lth_element_mesh_check(LitheCtx *ctx, const LthElementMesh *mesh, const char *file);

/// One polyhedron an element: cell k of the mesh is element k. Non-planar faces are split into triangles, the
/// same way from both sides; mid-side nodes are left out. Groups become those of the mesh.
LitheStatus lth_mesh_from_elements(LitheCtx *ctx, const LthElementMesh *elements, const char *file,
                                   LthMesh **mesh);

/// Hexahedra of a grid as elements, degree 1 (hex8) or 2 (hex27; `serendipity`: hex20), or six tetrahedra a
/// cell (tet4, tet10) in the order of lth_mesh_hexahedra() and lth_mesh_tetrahedra(). `keep` (cells of the
/// grid, x fastest; NULL: all) leaves cells out.
LitheStatus lth_element_mesh_grid(LitheCtx *ctx, const LthGrid *grid, int degree, bool serendipity,
                                  bool tetrahedra, const uint8_t *keep, LthElementMesh **mesh);

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
  uint8_t *reduced;        ///< 1: the reduced rule (C3D6, C3D8R, C3D20R), or NULL (n_elements)
  LitheIndex *element_off; ///< (n_elements + 1) into element_node
  LitheIndex *element_node;
  int64_t *element_id;   ///< number in the file, or NULL                 (n_elements)
  LitheIndex *line;      ///< of the file where an element stands, or NULL (n_elements)
  LitheIndex *poly_off;  ///< (n_elements + 1) into poly_face; NULL where there are no polyhedra
  LitheIndex *poly_face; ///< of a polyhedron: n faces, then for each its n nodes and them, outward
  double rounding;       ///< of the coordinates where the file has short numbers [m], 0: doubles
  LthElementGroup *groups;
  LitheIndex n_groups;
} LthElementMesh;

void lth_element_mesh_destroy(LitheCtx *ctx, LthElementMesh **mesh);

/// The first group called `name` of that sort, or called so but for upper and lower case, or whose tag the text
/// spells; NULL.
const LthElementGroup *lth_element_group(const LthElementMesh *mesh, LthGroupOf of,
                                         const char *name);

/// "part.inp:17: element 4 (hex8)" for messages; the line where it is known, the file's number where it has one.
#define LTH_ELEMENT_TEXT_MAX 256
const char *lth_element_text(const LthElementMesh *mesh, const char *file, LitheIndex element,
                             char text[LTH_ELEMENT_TEXT_MAX]);

/// The faces of all elements, their corners without repetitions, and which two lie on each other.
typedef struct LthElementSides {
  LitheIndex n;
  LitheIndex *element_side; ///< (n_elements + 1) sides of an element, in the order of its faces
  LitheIndex *corner_off; ///< (n + 1) into corner; a face of fewer than 3 distinct corners has none
  LitheIndex *corner;     ///< nodes, counter-clockwise from outside the element
  LitheIndex *element;    ///< (n)
  LitheIndex *mate;       ///< the same face seen from the other element, -1: boundary  (n)
} LthElementSides;

/// List the faces of all elements; `mate` waits for lth_element_sides_match().
LitheStatus lth_element_sides_list(LitheCtx *ctx, const LthElementMesh *mesh,
                                   LthElementSides **sides);
/// Find the mates. LITHE_BAD_INPUT: three elements at a face, or two on the same side of it.
LitheStatus lth_element_sides_match(LitheCtx *ctx, const LthElementMesh *mesh, const char *file,
                                    LthElementSides *sides);
void lth_element_sides_destroy(LitheCtx *ctx, LthElementSides **sides);

/// Two halves of a key for lth_hash: the same for all orders of the corners of a face.
void lth_corner_key(const LitheIndex *corner, LitheIndex n, uint64_t key[2]);

/// Check orientation and closedness and turn inverted elements into an error that names file, line and
/// element. `file` is for messages.
LitheStatus lth_element_mesh_check(LitheCtx *ctx, const LthElementMesh *mesh, const char *file);

/// One polyhedron an element: cell k of the mesh is element k. Non-planar faces are split into triangles, the
/// same way from both sides; mid-side nodes are left out. Groups become those of the mesh: of elements its cells; of
/// faces and of nodes the boundary faces that are in them with all corners. Boundary faces that lie on each other
/// without being one get a warning.
LitheStatus lth_mesh_from_elements(LitheCtx *ctx, const LthElementMesh *elements, const char *file,
                                   LthMesh **mesh);

/// Hexahedra of a grid as elements, degree 1 (hex8) or 2 (hex27; `serendipity`: hex20), or six tetrahedra a
/// cell (tet4, tet10) in the order of lth_mesh_hexahedra() and lth_mesh_tetrahedra(). `keep` (cells of the
/// grid, x fastest; NULL: all) leaves cells out.
LitheStatus lth_element_mesh_grid(LitheCtx *ctx, const LthGrid *grid, int degree, bool serendipity,
                                  bool tetrahedra, const uint8_t *keep, LthElementMesh **mesh);

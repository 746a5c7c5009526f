/// What the readers of mesh files fill: nodes, elements and groups under the numbers of the file.
#pragma once

#include "io/id_map.h"
#include "io/text.h"
#include "mesh/element_mesh.h"

/// A group while it grows. Members are numbers of nodes or elements; a face is three of them: 0, an element and its
/// local face; or 1, and start and length of its corners in face_corner.
typedef struct LthBuilderGroup {
  char *name;
  LitheIndex tag;
  LthGroupOf of;
  int64_t *member;
  LitheCount n, cap;
} LthBuilderGroup;

typedef struct LthElementBuilder {
  LitheCtx *ctx;
  const char *file; ///< for messages
  double *x;        ///< (n_nodes x 3)
  int64_t *node_id; ///< (n_nodes)
  LitheIndex n_nodes, n_elements, n_groups;
  uint8_t *kind, *reduced; ///< (n_elements)
  int64_t *element_id;     ///< (n_elements)
  LitheIndex *line;        ///< (n_elements)
  LitheCount *node_off;    ///< (n_elements + 1) into node
  int64_t *node;           ///< numbers of the nodes of elements
  LitheCount *poly_off;    ///< (n_elements + 1) into poly
  int64_t *poly;           ///< of polyhedra: n faces, then for each its n nodes and their numbers
  int64_t *face_corner;    ///< corners of faces that groups name by them
  LthBuilderGroup *groups;
  LitheCount n_node, n_poly, n_face_corner;
  LitheCount cap_x, cap_id, cap_kind, cap_reduced, cap_element_id, cap_line, cap_off, cap_node,
      cap_poly_off, cap_poly, cap_corner, cap_groups;
  double rounding; ///< of the coordinates, see LthElementMesh
  bool keeps_last; ///< a node defined again replaces the one before; otherwise it is an error
  bool may_mirror; ///< wedges may be numbered either way round (.vtu)
} LthElementBuilder;

void lth_element_builder_free(LthElementBuilder *b);

LitheStatus lth_builder_node(LthElementBuilder *b, int64_t id, const double x[3]);

/// An element with nodes in VTK's order.
LitheStatus lth_builder_element(LthElementBuilder *b, LthElementKind kind, bool reduced, int64_t id,
                                LitheIndex line, const int64_t *node);

/// A polyhedron from its faces: n_faces, then for each its number of nodes and the nodes; `n` numbers in all.
LitheStatus lth_builder_polyhedron(LthElementBuilder *b, int64_t id, LitheIndex line,
                                   const int64_t *faces, LitheCount n);

/// The group of that name (upper or lower case do not matter where `any_case`) and sort; made if there is none.
LitheStatus lth_builder_group(LthElementBuilder *b, LthGroupOf of, LthWord name, LitheIndex tag,
                              bool any_case, LitheIndex *group);
LitheStatus lth_builder_member(LthElementBuilder *b, LitheIndex group, int64_t id);
/// Local face of an element, in the order of lth_element_shape().
LitheStatus lth_builder_face(LthElementBuilder *b, LitheIndex group, int64_t element, int face);
/// The face that has these corners, of whatever element.
LitheStatus lth_builder_face_of_corners(LthElementBuilder *b, LitheIndex group, int n,
                                        const int64_t *corner);

/// Resolve all numbers, scale, drop nodes that no element uses, check. The builder is to be freed all the same.
LitheStatus lth_builder_take(LthElementBuilder *b, double unit_scale, LthElementMesh **mesh);

/// Turn the faces of a polyhedron alike where they are not: each edge is then run once forth and once back.
/// `faces`: n faces, then for each its n nodes and them.
LitheStatus lth_polyhedron_orient(LitheCtx *ctx, LitheIndex *faces);

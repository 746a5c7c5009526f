/// Tables of the element kinds: nodes, corners and faces, in VTK's order of nodes.
#include "mesh/element_mesh.h"

// A face lists corners, mid-edge and mid-face nodes; a lower kind of the same shape uses the first of them.
// clang-format off

#define TET_FACES(n) {                                                                             \
    {3, n, {0, 1, 3, 4, 8, 7}},                                                                    \
    {3, n, {1, 2, 3, 5, 9, 8}},                                                                    \
    {3, n, {2, 0, 3, 6, 7, 9}},                                                                    \
    {3, n, {0, 2, 1, 6, 5, 4}}}

#define HEX_FACES(n) {                                                                             \
    {4, n, {0, 4, 7, 3, 16, 15, 19, 11, 20}},                                                      \
    {4, n, {1, 2, 6, 5, 9, 18, 13, 17, 21}},                                                       \
    {4, n, {0, 1, 5, 4, 8, 17, 12, 16, 22}},                                                       \
    {4, n, {3, 7, 6, 2, 19, 14, 18, 10, 23}},                                                      \
    {4, n, {0, 3, 2, 1, 11, 10, 9, 8, 24}},                                                        \
    {4, n, {4, 5, 6, 7, 12, 13, 14, 15, 25}}}

#define WEDGE_FACES(t, q) {                                                                        \
    {3, t, {0, 2, 1, 8, 7, 6}},                                                                    \
    {3, t, {3, 4, 5, 9, 10, 11}},                                                                  \
    {4, q, {0, 1, 4, 3, 6, 13, 9, 12, 15}},                                                        \
    {4, q, {1, 2, 5, 4, 7, 14, 10, 13, 16}},                                                       \
    {4, q, {2, 0, 3, 5, 8, 12, 11, 14, 17}}}

#define PYRAMID_FACES(t, q) {                                                                      \
    {4, q, {0, 3, 2, 1, 8, 7, 6, 5, 13}},                                                          \
    {3, t, {0, 1, 4, 5, 10, 9}},                                                                   \
    {3, t, {1, 2, 4, 6, 11, 10}},                                                                  \
    {3, t, {2, 3, 4, 7, 12, 11}},                                                                  \
    {3, t, {3, 0, 4, 8, 9, 12}}}

// clang-format on

static const LthElementShape shapes[LTH_ELEMENT_KINDS] = {
    [LTH_TET4] = {"tet4", 4, 4, 1, 4, TET_FACES(3)},
    [LTH_TET10] = {"tet10", 10, 4, 2, 4, TET_FACES(6)},
    [LTH_HEX8] = {"hex8", 8, 8, 1, 6, HEX_FACES(4)},
    [LTH_HEX20] = {"hex20", 20, 8, 2, 6, HEX_FACES(8)},
    [LTH_HEX27] = {"hex27", 27, 8, 2, 6, HEX_FACES(9)},
    [LTH_WEDGE6] = {"wedge6", 6, 6, 1, 5, WEDGE_FACES(3, 4)},
    [LTH_WEDGE15] = {"wedge15", 15, 6, 2, 5, WEDGE_FACES(6, 8)},
    [LTH_WEDGE18] = {"wedge18", 18, 6, 2, 5, WEDGE_FACES(6, 9)},
    [LTH_PYRAMID5] = {"pyramid5", 5, 5, 1, 5, PYRAMID_FACES(3, 4)},
    [LTH_PYRAMID13] = {"pyramid13", 13, 5, 2, 5, PYRAMID_FACES(6, 8)},
    [LTH_PYRAMID14] = {"pyramid14", 14, 5, 2, 5, PYRAMID_FACES(6, 9)},
    [LTH_POLYHEDRON] = {.name = "polyhedron", .degree = 1},
};

const LthElementShape *lth_element_shape(LthElementKind kind) { return &shapes[kind]; }

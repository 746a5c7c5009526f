/// Mesh files: Gmsh `.msh` (2.2 and 4.1), VTK `.vtu`, CalculiX and Abaqus `.inp`.
#pragma once

#include "mesh/element_mesh.h"

/// Read a mesh file by its ending. Coordinates are multiplied by `unit_scale`. The mesh is checked; nodes that no
/// element uses are dropped. LITHE_BAD_INPUT names file, line and element. Free with lth_element_mesh_destroy().
LitheStatus lth_mesh_file_read(LitheCtx *ctx, const char *path, double unit_scale,
                               LthElementMesh **mesh);

/// The same from memory; `format` is "msh", "vtu" or "inp", `name` is for messages.
LitheStatus lth_mesh_file_parse(LitheCtx *ctx, const char *name, const char *format,
                                const void *data, size_t size, double unit_scale,
                                LthElementMesh **mesh);

/// Whether the ending of a path is that of a mesh file.
bool lth_mesh_file_has_ending(const char *path);

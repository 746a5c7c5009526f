/// Gmsh mesh files, versions 2 and 4.1, text and binary.
#pragma once

#include "io/element_builder.h"

/// Enter the contents of a `.msh` file into a builder.
LitheStatus lth_msh_parse(LthElementBuilder *b, const char *data, size_t size);

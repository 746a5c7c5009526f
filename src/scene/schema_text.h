/// schema/scene.schema.json as bytes, made by the build (cmake/embed_text.cmake).
#pragma once

#include <stddef.h>

extern const char lth_scene_schema[];
extern const size_t lth_scene_schema_size;

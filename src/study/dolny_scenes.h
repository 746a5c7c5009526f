/// The scenes of studies/dolny, built into the library.
#pragma once

#include <stddef.h>

extern const char lth_scene_bunny[], lth_scene_circle[], lth_scene_compression[],
    lth_scene_expansion[], lth_scene_gravity[], lth_scene_rotation[], lth_scene_shear[];
extern const size_t lth_scene_bunny_size, lth_scene_circle_size, lth_scene_compression_size,
    lth_scene_expansion_size, lth_scene_gravity_size, lth_scene_rotation_size, lth_scene_shear_size;

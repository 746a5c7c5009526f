/// The scene as a public handle: the typed values, or what was wrong with the file.
#pragma once

#include "lithe/run.h"
#include "scene/scene.h"

struct LitheScene {
  LthScene *scene; ///< NULL where the file was bad
  LthSceneErrors errors;
  double read_seconds;
};

/// Everything public: include this one.
#pragma once

#include "lithe/base.h"
#include "lithe/convert.h"
#include "lithe/info.h"
#include "lithe/run.h"
#include "lithe/scene.h"
#include "lithe/study.h"
#include "lithe/verify.h"

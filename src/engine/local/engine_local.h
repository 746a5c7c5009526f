/// Engines that run in this process.
#pragma once

#include "la/engine.h"

extern const LthEngine lth_engine_cholmod; ///< "cholesky": SuiteSparse's supernodal CHOLMOD

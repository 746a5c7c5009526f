/// Sweeps: one key of a scene and the values that it takes.
#pragma once

#include "study/study_run.h"

typedef enum LthSweepKind {
  LTH_SWEEP_PLAIN, ///< refines nothing
  LTH_SWEEP_CELLS, ///< a number that grows as lengths shrink: cells, steps
  LTH_SWEEP_LENGTH ///< a length or a time that shrinks: cell_size, step, resolution
} LthSweepKind;

typedef struct LthSweepValue {
  const char *text;
  double number; ///< SI; of a list its first entry; NaN where it is none
} LthSweepValue;

#define LTH_SWEEP_VALUES_MAX 64

typedef struct LthSweep {
  const char *path, *key; ///< "bodies.0.method.cells", "cells"
  LthSweepKind kind;
  LthSweepValue value[LTH_SWEEP_VALUES_MAX];
  int n;
} LthSweep;

/// Take "PATH=VALUE,VALUE,..." apart; commas within brackets and quotes are part of a value.
LitheStatus lth_sweep_parse(LthStudyRun *run, const char *text, LthSweep *sweep);

/// Length that stands for value i, falling as things are refined; NaN where the sweep refines nothing.
double lth_sweep_length(const LthSweep *sweep, int i);

/// A number of result.json worth comparing.
typedef struct LthMainNumber {
  const char *path, *unit;
  bool is_error; ///< tends to 0
  bool is_field; ///< a figure of the solution: worth extrapolating
  int digits;
} LthMainNumber;

#define LTH_MAIN_NUMBERS_MAX 100

/// The main numbers that a result has, in its order.
int lth_main_numbers(LthStudyRun *run, const LthNode *json,
                     LthMainNumber numbers[LTH_MAIN_NUMBERS_MAX]);

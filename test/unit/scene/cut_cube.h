/// A cube that a cut of a scene has changed, for tests of blades.
#pragma once

#include "mesh/topology.h"
#include "scene/change.h"
#include "scene/cut.h"
#include "scene_text.h"

typedef struct Cut {
  Reading reading;
  LthWorld *world;
  const LthTopology *t;
  LthChangeNote note;
} Cut;

/// The scene's one cut, due by `time` (0: made at the start).
static inline Cut cut_made(const char *text, double time) {
  double times[2];
  bool changed = true;
  Cut c = {.reading = read_good(text)};
  CHECK_OK(c.reading.ctx, lth_world_create(c.reading.ctx, c.reading.scene, times, &c.world));
  if (time > 0) CHECK_OK(c.reading.ctx, lth_world_cut_due(c.reading.ctx, c.world, time, &changed));
  assert_true(changed);
  assert_int_equal(c.world->n_notes, 1);
  c.t = c.world->bodies[0]->change->topology;
  c.note = c.world->notes[0];
  return c;
}

static inline void end(Cut *c) {
  lth_world_destroy(c->reading.ctx, &c->world);
  end_reading(&c->reading);
}

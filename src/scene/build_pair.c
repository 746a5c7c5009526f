/// What is between bodies: ties, contact of every two, and of the parts of each.
#include "scene/change.h"

#include "base/tensor.h"

static LitheIndex first_row(const LthWorld *world, LitheIndex body) {
  LitheIndex row = 0;
  for (LitheIndex b = 0; b < body; b++) row += world->bodies[b]->disc->n_rows;
  return row;
}

static LitheCount first_dof(const LthWorld *world, LitheIndex body) {
  LitheCount dof = 0;
  for (LitheIndex b = 0; b < body; b++) dof += world->bodies[b]->disc->n_dofs;
  return dof;
}

static LthTieSide tie_side(const LthWorld *world, LitheIndex b, const LthPatches *patches) {
  const LthBody *body = world->bodies[b];
  return (LthTieSide){.name = body->def->name,
                      .disc = body->disc,
                      .patches = patches,
                      .young = body->young,
                      .poisson = body->poisson,
                      .space = body->space,
                      .flux = body->def->flux,
                      .penalty = body->def->penalty,
                      .eta = body->def->eta,
                      .warped = body->warped,
                      .first_row = first_row(world, b),
                      .first_dof = first_dof(world, b)};
}

static LitheStatus build_tie(LitheCtx *ctx, const LthWorld *world, const LthSceneTie *from,
                             LthWorldTie *to) {
  LthTieDef def = {.place = from->place};
  const LthBody *changed = NULL;
  for (int s = 0; s < 2; s++)
    if (world->bodies[from->body[s]]->staggered)
      LITHE_FAIL(
          ctx, LITHE_BAD_INPUT,
          "%s: `%s` is staggered, which ties cannot join; use `method.kind: dg` or cg for it, "
          "or one staggered body with a list of materials",
          from->place, world->bodies[from->body[s]]->def->name);
  for (int s = 0; s < 2; s++) {
    to->body[s] = from->body[s];
    LITHE_TRY(lth_build_patches(ctx, world->bodies[from->body[s]], from->place, &from->where,
                                &to->patches[s]));
    def.side[s] = tie_side(world, from->body[s], to->patches[s]);
    const LthBodyChange *change = world->bodies[from->body[s]]->change;
    if (change && change->is_running) changed = world->bodies[from->body[s]];
  }
  def.may_be_empty = changed;
  LITHE_TRY(lth_tie_create(ctx, &def, &to->tie));
  bool is_loss;
  return to->tie->n_couplings > 0 ? LITHE_OK : lth_body_lose(ctx, changed, from->place, &is_loss);
}

LitheStatus lth_world_build_ties(LitheCtx *ctx, LthWorld *world) {
  const LthScene *scene = world->scene;
  LTH_NEW(ctx, world->ties, scene->n_ties);
  for (; world->n_ties < scene->n_ties; world->n_ties++)
    LITHE_TRY(build_tie(ctx, world, &scene->ties[world->n_ties], &world->ties[world->n_ties]));
  return LITHE_OK;
}

void lth_world_free_ties(LitheCtx *ctx, LthWorld *world) {
  for (LitheIndex i = 0; world->ties && i < world->scene->n_ties; i++) {
    lth_tie_destroy(ctx, &world->ties[i].tie);
    for (int s = 0; s < 2; s++) lth_patches_destroy(ctx, &world->ties[i].patches[s]);
  }
  lth_free(ctx, world->ties);
  world->ties = NULL;
  world->n_ties = 0;
}

static LthPairSide pair_side(const LthBody *body) {
  return (LthPairSide){.name = body->def->name,
                       .points = lth_body_touch_points(body),
                       .surface = body->touch,
                       .surface_point = body->touch_point,
                       .modulus = lth_body_modulus(body),
                       .cell_size = body->cell_size,
                       .body_size = body->size,
                       .body_weight = lth_body_weight(body)};
}

static LthPartsSide parts_side(const LthBody *body) {
  const LthBodyParts *parts = body->parts;
  return (LthPartsSide){.name = body->def->name,
                        .points = parts->points,
                        .surface = parts->surface,
                        .first_point = parts->first_point,
                        .n_parts = parts->n,
                        .cracks = parts->cracks,
                        .modulus = lth_body_modulus(body),
                        .cell_size = body->cell_size,
                        .body_size = body->size,
                        .body_weight = body->mass * lth_v3_norm(body->scene->gravity)};
}

/// What follows the points by which a body touches another: those of its parts, where one of the two has several.
static const LthEmbedding *points_of(const LthWorld *world, const LthWorldPair *pair, int s) {
  const LthBody *body = world->bodies[pair->body[s]];
  return pair->by_parts ? body->parts->points : lth_body_touch_points(body);
}

/// Points of both bodies that a tie between them holds anyway.
static LitheStatus mark_tied(LitheCtx *ctx, const LthWorld *world, LthWorldPair *pair) {
  for (LitheIndex i = 0; i < world->n_ties; i++) {
    const LthWorldTie *tie = &world->ties[i];
    for (int s = 0; s < 2; s++) {
      int side = tie->body[0] == pair->body[s] ? 0 : 1;
      if (tie->body[side] != pair->body[s] || tie->body[1 - side] != pair->body[1 - s]) continue;
      const LthEmbedding *e = points_of(world, pair, s);
      if (!pair->tied[s]) LTH_NEW(ctx, pair->tied[s], e->n_points);
      LITHE_TRY(lth_tie_mark(ctx, tie->tie, side, e->n_points, e->rest, pair->tied[s]));
    }
  }
  return LITHE_OK;
}

/// Contact of the parts of one body (a = b), or of bodies of which one has several.
static LitheStatus build_parts_pair(LitheCtx *ctx, LthWorld *world, LthWorldPair *pair) {
  const LthScene *scene = world->scene;
  LthPartsDef def = {.n_sides = pair->body[0] == pair->body[1] ? 1 : 2,
                     .stiffness = scene->contact_stiffness,
                     .friction = scene->contact_friction,
                     .damping = scene->contact_damping};
  for (int s = 0; s < def.n_sides; s++) {
    def.side[s] = parts_side(world->bodies[pair->body[s]]);
    def.side[s].excluded = pair->tied[s];
  }
  return lth_contact_create_parts(ctx, &def, &pair->contact);
}

static LitheStatus build_pair(LitheCtx *ctx, LthWorld *world, LitheIndex a, LitheIndex b) {
  const LthScene *scene = world->scene;
  LthBody *bodies[2] = {world->bodies[a], world->bodies[b]};
  LthWorldPair *pair = &world->pairs[world->n_pairs++];
  pair->body[0] = a, pair->body[1] = b;
  pair->by_parts = bodies[0]->parts || bodies[1]->parts;
  for (int s = 0; s < 2; s++)
    LITHE_TRY(pair->by_parts ? lth_build_parts(ctx, bodies[s]) : lth_build_touch(ctx, bodies[s]));
  if (a != b) LITHE_TRY(mark_tied(ctx, world, pair));
  if (pair->by_parts) return build_parts_pair(ctx, world, pair);
  LthPairDef def = {.side = {pair_side(bodies[0]), pair_side(bodies[1])},
                    .stiffness = scene->contact_stiffness,
                    .friction = scene->contact_friction,
                    .damping = scene->contact_damping};
  for (int s = 0; s < 2; s++) def.side[s].excluded = pair->tied[s];
  return lth_contact_create_pair(ctx, &def, &pair->contact);
}

/// Has it parts, or sides of cracks, that may touch each other?
static bool touches_itself(const LthBody *body) { return body->n_parts > 1 || body->n_fronts > 0; }

LitheStatus lth_world_build_pairs(LitheCtx *ctx, LthWorld *world) {
  LitheIndex n = world->n_bodies;
  if (!world->scene->contact_bodies) return LITHE_OK;
  if (world->scene->dimension == 2) {
    if (n > 1)
      lth_warn(ctx, "contact.bodies: bodies in the plane touch colliders, but pass through each "
                    "other; `false` says that this is meant");
    return LITHE_OK;
  }
  for (LitheIndex b = 0; b < n; b++)
    if (touches_itself(world->bodies[b])) LITHE_TRY(lth_build_parts(ctx, world->bodies[b]));
  LTH_NEW(ctx, world->pairs, (LitheCount)n * (n + 1) / 2);
  for (LitheIndex a = 0; a < n; a++)
    for (LitheIndex b = a; b < n; b++)
      if (a != b || touches_itself(world->bodies[a])) LITHE_TRY(build_pair(ctx, world, a, b));
  return LITHE_OK;
}

void lth_world_free_pairs(LitheCtx *ctx, LthWorld *world) {
  for (LitheIndex i = 0; i < world->n_pairs; i++) {
    lth_contact_destroy(ctx, &world->pairs[i].contact);
    for (int s = 0; s < 2; s++) lth_free(ctx, world->pairs[i].tied[s]);
  }
  lth_free(ctx, world->pairs);
  world->pairs = NULL;
  world->n_pairs = 0;
}

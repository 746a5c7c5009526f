/// Growing a polygon soup.
#include "io/soup_builder.h"

#include <string.h>

LitheStatus lth_soup_builder_open(LitheCtx *ctx, const char *name, LthSoupBuilder *builder) {
  *builder = (LthSoupBuilder){.ctx = ctx, .name = name, .group = -1};
  LTH_NEW(ctx, builder->soup, 1);
  LTH_RESERVE(ctx, builder->soup->poly_off, builder->off_cap, 1);
  return LITHE_OK;
}

void lth_soup_builder_close(LthSoupBuilder *builder) {
  lth_soup_destroy(builder->ctx, &builder->soup);
  lth_free(builder->ctx, builder->group_slots);
  *builder = (LthSoupBuilder){.ctx = builder->ctx, .name = builder->name};
}

static LitheStatus too_many(const LthSoupBuilder *b, const char *what) {
  LITHE_FAIL(b->ctx, LITHE_BAD_INPUT,
             "%s: has more than 2^31 - 1 %s, which is more than can be used", b->name, what);
}

LitheStatus lth_soup_add_point(LthSoupBuilder *b, const double x[3]) {
  LthSoup *soup = b->soup;
  if (soup->n_points == INT32_MAX) return too_many(b, "points");
  LitheCount n = 3 * (LitheCount)soup->n_points;
  LTH_RESERVE(b->ctx, soup->points, b->point_cap, n + 3);
  memcpy(soup->points + n, x, 3 * sizeof *x);
  soup->n_points++;
  return LITHE_OK;
}

LitheStatus lth_soup_add_uv(LthSoupBuilder *b, const double uv[2]) {
  LthSoup *soup = b->soup;
  if (soup->n_uvs == INT32_MAX) return too_many(b, "texture coordinates");
  LitheCount n = 2 * (LitheCount)soup->n_uvs;
  LTH_RESERVE(b->ctx, soup->uvs, b->uv_cap, n + 2);
  memcpy(soup->uvs + n, uv, 2 * sizeof *uv);
  soup->n_uvs++;
  return LITHE_OK;
}

/// Texture coordinates of corners are stored from the first corner that has one; before it: -1.
static LitheStatus set_corner_uv(LthSoupBuilder *b, LitheIndex uv) {
  LthSoup *soup = b->soup;
  if (!soup->poly_uv && uv < 0) return LITHE_OK;
  bool is_first = !soup->poly_uv;
  LTH_RESERVE(b->ctx, soup->poly_uv, b->corner_uv_cap, b->n_corners + 1);
  if (is_first)
    for (LitheCount i = 0; i < b->n_corners; i++) soup->poly_uv[i] = -1;
  soup->poly_uv[b->n_corners] = uv;
  return LITHE_OK;
}

LitheStatus lth_soup_add_corner(LthSoupBuilder *b, LitheIndex point, LitheIndex uv) {
  if (b->n_corners == INT32_MAX) return too_many(b, "polygon corners");
  LTH_RESERVE(b->ctx, b->soup->poly_point, b->corner_cap, b->n_corners + 1);
  LITHE_TRY(set_corner_uv(b, uv));
  b->soup->poly_point[b->n_corners++] = point;
  return LITHE_OK;
}

LitheStatus lth_soup_end_polygon(LthSoupBuilder *b) {
  LthSoup *soup = b->soup;
  if (soup->n_polys == INT32_MAX - 1) return too_many(b, "polygons");
  LTH_RESERVE(b->ctx, soup->poly_off, b->off_cap, (LitheCount)soup->n_polys + 2);
  if (b->group >= 0) LTH_RESERVE(b->ctx, soup->poly_group, b->poly_group_cap, soup->n_polys + 1);
  if (b->group >= 0) soup->poly_group[soup->n_polys] = b->group;
  soup->poly_off[++soup->n_polys] = (LitheIndex)b->n_corners;
  return LITHE_OK;
}

static uint64_t hash_name(LthWord name) {
  uint64_t hash = 1469598103934665603u;
  for (size_t i = 0; i < name.length; i++)
    hash = (hash ^ (unsigned char)name.at[i]) * 1099511628211u;
  return hash;
}

/// Slot of a name: the one that holds it, or the free one where it belongs.
static LitheCount find_slot(const LthSoupBuilder *b, LthWord name) {
  LitheCount mask = b->n_group_slots - 1;
  LitheCount slot = (LitheCount)(hash_name(name) & (uint64_t)mask);
  for (; b->group_slots[slot]; slot = (slot + 1) & mask)
    if (lth_word_is(name, b->soup->group_names[b->group_slots[slot] - 1])) break;
  return slot;
}

/// Keep the hash table of names at most half full.
static LitheStatus grow_slots(LthSoupBuilder *b) {
  if (2 * ((LitheCount)b->soup->n_groups + 1) <= b->n_group_slots) return LITHE_OK;
  LitheCount n = b->n_group_slots ? 2 * b->n_group_slots : 64;
  LitheIndex *slots = NULL;
  LTH_NEW(b->ctx, slots, n);
  lth_free(b->ctx, b->group_slots);
  b->group_slots = slots;
  b->n_group_slots = n;
  for (LitheIndex g = 0; g < b->soup->n_groups; g++) {
    const char *text = b->soup->group_names[g];
    slots[find_slot(b, (LthWord){text, strlen(text)})] = g + 1;
  }
  return LITHE_OK;
}

static LitheStatus add_group(LthSoupBuilder *b, LthWord name, LitheIndex *group) {
  LITHE_TRY(grow_slots(b));
  LitheCount slot = find_slot(b, name);
  if (!b->group_slots[slot]) {
    LthSoup *soup = b->soup;
    char *copy = NULL;
    LTH_RESERVE(b->ctx, soup->group_names, b->group_cap, soup->n_groups + 1);
    LTH_NEW(b->ctx, copy, (LitheCount)name.length + 1);
    memcpy(copy, name.at, name.length);
    soup->group_names[soup->n_groups++] = copy;
    b->group_slots[slot] = soup->n_groups;
  }
  *group = b->group_slots[slot] - 1;
  return LITHE_OK;
}

LitheStatus lth_soup_set_group(LthSoupBuilder *b, LthWord name) {
  const char *nul = name.length ? memchr(name.at, 0, name.length) : NULL;
  if (nul) name.length = (size_t)(nul - name.at);
  if (name.length == 0) name = (LthWord){"default", 7};
  LthSoup *soup = b->soup;
  // polygons before the first group get a group of their own
  if (b->group < 0 && soup->n_polys > 0) {
    LitheIndex first = 0;
    LITHE_TRY(add_group(b, (LthWord){"default", 7}, &first));
    LTH_RESERVE(b->ctx, soup->poly_group, b->poly_group_cap, soup->n_polys);
    for (LitheIndex i = 0; i < soup->n_polys; i++) soup->poly_group[i] = first;
  }
  return add_group(b, name, &b->group);
}

LitheStatus lth_soup_builder_take(LthSoupBuilder *b, LthSoup **soup) {
  if (b->soup->n_polys == 0)
    LITHE_FAIL(b->ctx, LITHE_BAD_INPUT,
               "%s: has %d points but no polygons, expected a surface; a point cloud has to be "
               "turned into a surface first, for example with MeshLab's screened Poisson filter",
               b->name, b->soup->n_points);
  *soup = b->soup;
  b->soup = NULL;
  return LITHE_OK;
}

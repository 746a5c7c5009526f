/// What a deck says of single nodes and faces, gathered into sets of equal value.
#include "scene/convert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// A node or face with its values, on the way into a set.
typedef struct Item {
  double value[3];
  LitheIndex member;
} Item;

static int compare(const void *a, const void *b) {
  const Item *p = a, *q = b;
  for (int i = 0; i < 3; i++)
    if (p->value[i] != q->value[i]) return p->value[i] < q->value[i] ? -1 : 1;
  return (p->member > q->member) - (p->member < q->member);
}

void lth_convert_sets_free(LitheCtx *ctx, LthConvertSets *sets) {
  for (LitheIndex i = 0; i < sets->n; i++) lth_free(ctx, sets->set[i].member);
  lth_free(ctx, sets->set);
  *sets = (LthConvertSets){0};
}

static bool is_equal(const double a[3], const double b[3]) {
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/// A set for each run of items with the same values.
static LitheStatus gather(LitheCtx *ctx, LthGroupOf of, Item *items, LitheIndex n,
                          const bool has[3], LthConvertSets *sets) {
  qsort(items, (size_t)n, sizeof *items, compare);
  for (LitheIndex first = 0, end; first < n; first = end) {
    for (end = first; end < n && is_equal(items[end].value, items[first].value);) end++;
    LTH_RESERVE(ctx, sets->set, sets->cap, sets->n + 1);
    LthConvertSet *set = &sets->set[sets->n];
    *set = (LthConvertSet){.of = of, .n = end - first};
    memcpy(set->has, has, sizeof set->has);
    memcpy(set->value, items[first].value, sizeof set->value);
    sets->n++;
    LTH_NEW(ctx, set->member, set->n);
    for (LitheIndex i = 0; i < set->n; i++) set->member[i] = items[first + i].member;
  }
  return LITHE_OK;
}

static bool same_members(const LthConvertSet *a, LitheIndex n, const LitheIndex *member) {
  return a->n == n && memcmp(a->member, member, sizeof *member * (size_t)n) == 0;
}

/// Take components over from sets of the same members, from the end.
static void unite(LitheCtx *ctx, LthConvertSets *sets) {
  for (LitheIndex i = 0; i < sets->n; i++)
    for (LitheIndex j = sets->n; j-- > i + 1;) {
      LthConvertSet *to = &sets->set[i], *from = &sets->set[j];
      if (!same_members(to, from->n, from->member)) continue;
      bool clash = false;
      for (int a = 0; a < 3; a++) clash = clash || (to->has[a] && from->has[a]);
      if (clash) continue;
      for (int a = 0; a < 3; a++)
        if (from->has[a]) to->has[a] = true, to->value[a] = from->value[a];
      lth_free(ctx, from->member);
      memmove(from, from + 1, sizeof *from * (size_t)(sets->n - j - 1));
      sets->n--;
    }
}

LitheStatus lth_convert_holds(LthConvert *c, LthConvertSets *sets) {
  LitheStatus status = LITHE_OK;
  Item *items = NULL;
  LTH_NEW_OR(done, c->ctx, items, c->mesh->n_nodes);
  for (int a = 0; a < 3; a++) {
    LitheIndex n = 0;
    bool has[3] = {a == 0, a == 1, a == 2};
    for (LitheIndex i = 0; i < c->mesh->n_nodes; i++) {
      if (!c->is_held[3 * (LitheCount)i + a]) continue;
      items[n] = (Item){.member = i};
      items[n++].value[a] = c->held[3 * (LitheCount)i + a];
    }
    LITHE_TRY_OR(done, gather(c->ctx, LTH_GROUP_NODES, items, n, has, sets));
  }
  unite(c->ctx, sets);
done:
  lth_free(c->ctx, items);
  return status;
}

LitheStatus lth_convert_forces(LthConvert *c, LthConvertSets *sets) {
  static const bool all[3] = {true, true, true};
  static const double none[3] = {0, 0, 0};
  LitheStatus status = LITHE_OK;
  Item *items = NULL;
  LitheIndex n = 0;
  LTH_NEW_OR(done, c->ctx, items, c->mesh->n_nodes);
  for (LitheIndex i = 0; i < c->mesh->n_nodes; i++) {
    items[n].member = i;
    for (int a = 0; a < 3; a++) items[n].value[a] = c->force[3 * (LitheCount)i + a];
    n += !is_equal(items[n].value, none);
  }
  status = gather(c->ctx, LTH_GROUP_NODES, items, n, all, sets);
done:
  lth_free(c->ctx, items);
  return status;
}

LitheStatus lth_convert_pressures(LthConvert *c, LthConvertSets *sets) {
  static const bool first[3] = {true, false, false};
  LitheStatus status = LITHE_OK;
  Item *items = NULL;
  LitheIndex n = 0, n_faces = 0;
  for (LitheIndex e = 0; e < c->mesh->n_elements; e++)
    for (LitheIndex k = 0; k < LTH_CONVERT_FACES; k++)
      n_faces += c->pressure[LTH_CONVERT_FACES * e + k] != 0;
  LTH_NEW_OR(done, c->ctx, items, n_faces);
  for (LitheIndex f = 0; f < LTH_CONVERT_FACES * c->mesh->n_elements; f++)
    if (c->pressure[f] != 0) items[n++] = (Item){{c->pressure[f], 0, 0}, f};
  status = gather(c->ctx, LTH_GROUP_FACES, items, n, first, sets);
done:
  lth_free(c->ctx, items);
  return status;
}

static bool is_called(const LthElementGroup *group, const char *name) {
  return lth_word_is_any_case((LthWord){group->name, strlen(group->name)}, name);
}

/// Does only this group of the mesh have its name?
static bool is_unique(const LthElementMesh *mesh, const LthElementGroup *group) {
  LitheIndex n = 0;
  for (LitheIndex i = 0; i < mesh->n_groups; i++) n += is_called(&mesh->groups[i], group->name);
  return n == 1;
}

static const char *name_in_deck(const LthElementMesh *mesh, const LthConvertSet *set) {
  for (LitheIndex i = 0; i < mesh->n_groups; i++) {
    const LthElementGroup *group = &mesh->groups[i];
    if (group->of == set->of && same_members(set, group->n, group->member) &&
        is_unique(mesh, group))
      return group->name;
  }
  return NULL;
}

static bool is_taken(const LthElementMesh *mesh, const char *name) {
  for (LitheIndex i = 0; i < mesh->n_groups; i++)
    if (is_called(&mesh->groups[i], name)) return true;
  return false;
}

LitheStatus lth_convert_name_sets(LthConvert *c, const char *stem, LthConvertSets *sets,
                                  LitheIndex *n_new) {
  int number = 0;
  for (LitheIndex i = 0; i < sets->n; i++) {
    LthConvertSet *set = &sets->set[i];
    set->label = name_in_deck(c->mesh, set);
    if (set->label) continue;
    do snprintf(set->own, sizeof set->own, "%s-%d", stem, ++number);
    while (is_taken(c->mesh, set->own));
    set->label = set->own;
    (*n_new)++;
  }
  return LITHE_OK;
}

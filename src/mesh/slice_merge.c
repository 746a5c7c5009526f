/// Slivers go to the neighbour with the largest common face, the smallest first.
#include "mesh/slice.h"

#include "base/disjoint_sets.h"

#include <math.h>

/// An element whose volume is below this share of its area to the power 3/2 has none: its size along
/// one direction is rounding.
#define NO_VOLUME 1e-12
/// So it is where its volume is below this many units of rounding times its area.
#define NO_THICKNESS 64
/// A common face below this share of an element's area is a line or a point.
#define NO_CONTACT 1e-13
/// What may be lost where an element without volume has no neighbour, as a share of a full cell.
#define LOSS 1e-14

typedef struct HeapEntry {
  double volume;
  LitheIndex element;
} HeapEntry;

typedef struct Merger {
  Slicer *s;
  double limit;              ///< volume of a sliver [m^3]
  LitheIndex *parent;        ///< of elements
  LitheIndex *next, *last;   ///< chain of a group's elements, and its end (of roots)
  LitheIndex *cap_off, *cap; ///< parts between each element and others
  double *contact;           ///< scratch: common area with each group
  LitheIndex *touched;
  LitheCount n_touched;
  HeapEntry *heap;
  LitheCount n_heap, heap_cap;
} Merger;

static bool has_no_volume(const Slicer *s, LitheIndex i) {
  const SliceElements *e = &s->elements;
  double thickness = fmax(NO_VOLUME * sqrt(e->area[i]), NO_THICKNESS * s->rounding);
  return !(e->volume[i] > thickness * e->area[i]);
}

static bool is_sliver(const Merger *m, LitheIndex i) {
  return m->s->elements.volume[i] < m->limit || has_no_volume(m->s, i);
}

static bool is_smaller(HeapEntry a, HeapEntry b) {
  return a.volume != b.volume ? a.volume < b.volume : a.element < b.element;
}

static LitheStatus push(Merger *m, LitheIndex element) {
  LTH_RESERVE(m->s->ctx, m->heap, m->heap_cap, m->n_heap + 1);
  HeapEntry entry = {m->s->elements.volume[element], element};
  LitheCount i = m->n_heap++;
  for (; i > 0 && is_smaller(entry, m->heap[(i - 1) / 2]); i = (i - 1) / 2)
    m->heap[i] = m->heap[(i - 1) / 2];
  m->heap[i] = entry;
  return LITHE_OK;
}

static HeapEntry pop(Merger *m) {
  HeapEntry top = m->heap[0], entry = m->heap[--m->n_heap];
  LitheCount i = 0, j;
  for (; (j = 2 * i + 1) < m->n_heap; i = j) {
    if (j + 1 < m->n_heap && is_smaller(m->heap[j + 1], m->heap[j])) j++;
    if (!is_smaller(m->heap[j], entry)) break;
    m->heap[i] = m->heap[j];
  }
  m->heap[i] = entry;
  return top;
}

static LitheStatus list_caps(Merger *m) {
  const SliceElements *e = &m->s->elements;
  LTH_NEW(m->s->ctx, m->cap_off, (LitheCount)e->n + 2);
  for (LitheCount side = 0; side < 2 * m->s->parts.n; side++)
    if (e->of[side] >= 0 && e->of[side ^ 1] >= 0) m->cap_off[e->of[side] + 2]++;
  for (LitheIndex i = 0; i < e->n; i++) m->cap_off[i + 2] += m->cap_off[i + 1];
  LTH_NEW(m->s->ctx, m->cap, m->cap_off[e->n + 1]);
  for (LitheCount side = 0; side < 2 * m->s->parts.n; side++)
    if (e->of[side] >= 0 && e->of[side ^ 1] >= 0)
      m->cap[m->cap_off[e->of[side] + 1]++] = (LitheIndex)side;
  return LITHE_OK;
}

static LitheStatus start(Merger *m) {
  LitheCtx *ctx = m->s->ctx;
  SliceElements *e = &m->s->elements;
  LTH_NEW(ctx, m->parent, e->n);
  LTH_NEW(ctx, m->next, e->n);
  LTH_NEW(ctx, m->last, e->n);
  LTH_NEW(ctx, m->contact, e->n);
  LTH_NEW(ctx, m->touched, e->n);
  LTH_NEW(ctx, e->group, e->n);
  LITHE_TRY(list_caps(m));
  for (LitheIndex i = 0; i < e->n; i++) {
    m->parent[i] = m->last[i] = i;
    m->next[i] = -1;

    // a cavity that was given to its container has no sides of its own left
    if (e->area[i] > 0 && is_sliver(m, i)) LITHE_TRY(push(m, i));
    if (!(e->area[i] > 0)) e->group[i] = -1;
  }
  return LITHE_OK;
}

/// The group with the largest common face; -1 if there is none worth the name.
static LitheIndex find_neighbour(Merger *m, LitheIndex root) {
  const SliceElements *e = &m->s->elements;
  for (LitheIndex i = root; i >= 0; i = m->next[i])
    for (LitheIndex k = m->cap_off[i]; k < m->cap_off[i + 1]; k++) {
      LitheIndex other = lth_sets_root(m->parent, e->of[m->cap[k] ^ 1]);
      if (other == root || e->group[other] < 0) continue;
      double area = m->s->parts.area[m->cap[k] / 2];
      if (m->contact[other] == 0 && area > 0) m->touched[m->n_touched++] = other;
      m->contact[other] += area;
    }
  LitheIndex best = -1;
  double best_area = NO_CONTACT * e->area[root];
  for (LitheCount i = 0; i < m->n_touched; i++) {
    LitheIndex other = m->touched[i];
    if (m->contact[other] > best_area ||
        (best >= 0 && m->contact[other] == best_area && other < best)) {
      best = other;
      best_area = m->contact[other];
    }
  }
  return best;
}

static LitheStatus unite(Merger *m, LitheIndex sliver, LitheIndex neighbour) {
  SliceElements *e = &m->s->elements;
  double contact = m->contact[neighbour];
  LitheIndex root = sliver < neighbour ? sliver : neighbour, other = sliver ^ neighbour ^ root;
  m->parent[other] = root;
  m->next[m->last[root]] = other;
  m->last[root] = m->last[other];
  e->volume[root] += e->volume[other];
  e->area[root] = fmax(0, e->area[root] + e->area[other] - 2 * contact);
  e->n_merged++;
  return is_sliver(m, root) ? push(m, root) : LITHE_OK;
}

/// An element without a neighbour stays, unless it has no volume.
static LitheStatus leave(Merger *m, LitheIndex root) {
  SliceElements *e = &m->s->elements;
  bool is_lost = fabs(e->volume[root]) <= LOSS * m->s->cell_volume;
  if (is_lost && has_no_volume(m->s, root)) e->group[root] = -1;
  if (is_lost || e->volume[root] > 0) return LITHE_OK;
  LITHE_FAIL(m->s->ctx, LITHE_BAD_INPUT,
             "slicing: a part of the surface encloses %g m^3: it is inside out or crosses another "
             "part; check the surface's orientation",
             e->volume[root]);
}

static LitheStatus merge_all(Merger *m) {
  while (m->n_heap > 0) {
    HeapEntry top = pop(m);
    LitheIndex root = top.element;
    if (m->parent[root] != root || m->s->elements.volume[root] != top.volume) continue;
    m->n_touched = 0;
    LitheIndex other = find_neighbour(m, root);
    LITHE_TRY(other >= 0 ? unite(m, root, other) : leave(m, root));
    for (LitheCount i = 0; i < m->n_touched; i++) m->contact[m->touched[i]] = 0;
  }
  return LITHE_OK;
}

/// Number the groups in the order of their first elements.
static void number_groups(Merger *m) {
  SliceElements *e = &m->s->elements;
  for (LitheIndex i = 0; i < e->n; i++) {
    LitheIndex root = lth_sets_root(m->parent, i);
    if (root != i)
      e->group[i] = e->group[root];
    else if (e->group[i] >= 0) {
      e->area[e->n_groups] = e->area[i];
      e->group[i] = e->n_groups++;
    }
  }
}

LitheStatus lth_slice_merge(Slicer *s, double sliver) {
  Merger m = {.s = s, .limit = sliver * s->cell_volume};
  LitheStatus status = LITHE_OK;
  LITHE_TRY_OR(done, start(&m));
  LITHE_TRY_OR(done, merge_all(&m));
  number_groups(&m);
done:
  lth_free(s->ctx, m.parent);
  lth_free(s->ctx, m.next);
  lth_free(s->ctx, m.last);
  lth_free(s->ctx, m.cap_off);
  lth_free(s->ctx, m.cap);
  lth_free(s->ctx, m.contact);
  lth_free(s->ctx, m.touched);
  lth_free(s->ctx, m.heap);
  return status;
}

/// Bounding volume tree: median splits along the longest axis, leaves of a few items.
#include "geometry/bvh.h"

#include "base/tensor.h"

#define LEAF_ITEMS 4
#define STACK_MAX 96 // twice the depth of a balanced tree over 2^31 items, with room to spare

typedef struct Build {
  LthBvh *bvh;
  const double *boxes;
} Build;

static void box_union(double a[6], const double b[6]) {
  for (int i = 0; i < 3; i++) {
    a[i] = fmin(a[i], b[i]);
    a[3 + i] = fmax(a[3 + i], b[3 + i]);
  }
}

static double middle(const double *boxes, LitheIndex item, int axis) {
  return boxes[6 * (size_t)item + (size_t)axis] + boxes[6 * (size_t)item + 3 + (size_t)axis];
}

/// Order of two items along an axis; equal middles go by number so that the tree is unique.
static bool before(const double *boxes, int axis, LitheIndex p, LitheIndex q) {
  double a = middle(boxes, p, axis), b = middle(boxes, q, axis);
  return a < b || (a == b && p < q);
}

static void swap(LitheIndex *p, LitheIndex *q) {
  LitheIndex t = *p;
  *p = *q;
  *q = t;
}

/// Quickselect: item[k] gets its place in the order, smaller ones before it, larger ones behind.
static void select_item(const double *boxes, int axis, LitheIndex *item, LitheIndex n,
                        LitheIndex k) {
  LitheIndex low = 0, high = n - 1;
  while (low < high) {
    LitheIndex mid = low + (high - low) / 2;
    if (before(boxes, axis, item[mid], item[low])) swap(&item[mid], &item[low]);
    if (before(boxes, axis, item[high], item[low])) swap(&item[high], &item[low]);
    if (before(boxes, axis, item[high], item[mid])) swap(&item[high], &item[mid]);
    LitheIndex pivot = item[mid], i = low, j = high;
    while (i <= j) {
      while (before(boxes, axis, item[i], pivot)) i++;
      while (before(boxes, axis, pivot, item[j])) j--;
      if (i <= j) swap(&item[i++], &item[j--]);
    }
    if (k <= j)
      high = j;
    else if (k >= i)
      low = i;
    else
      return;
  }
}

static int longest_axis(const Build *b, LitheIndex first, LitheIndex n) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (LitheIndex i = first; i < first + n; i++)
    for (int a = 0; a < 3; a++) {
      double m = middle(b->boxes, b->bvh->item[i], a);
      low[a] = fmin(low[a], m);
      high[a] = fmax(high[a], m);
    }
  int axis = 0;
  for (int a = 1; a < 3; a++)
    if (high[a] - low[a] > high[axis] - low[axis]) axis = a;
  return axis;
}

/// Make the node over item[first, first + n) and everything below it; returns its number.
static LitheIndex build_node(Build *b, LitheIndex first, LitheIndex n) {
  LthBvh *t = b->bvh;
  LitheIndex node = t->n_nodes++;
  double *box = t->box + 6 * (size_t)node;
  for (int i = 0; i < 3; i++) box[i] = INFINITY, box[3 + i] = -INFINITY;
  if (n <= LEAF_ITEMS) {
    t->right[node] = -1;
    t->first[node] = first;
    t->count[node] = n;
    for (LitheIndex i = first; i < first + n; i++)
      box_union(box, b->boxes + 6 * (size_t)t->item[i]);
    return node;
  }
  select_item(b->boxes, longest_axis(b, first, n), t->item + first, n, n / 2);
  build_node(b, first, n / 2);
  t->right[node] = build_node(b, first + n / 2, n - n / 2);
  box_union(box, t->box + 6 * (size_t)(node + 1));
  box_union(box, t->box + 6 * (size_t)t->right[node]);
  return node;
}

LitheStatus lth_bvh_create_boxes(LitheCtx *ctx, LitheIndex n, const double *boxes, LthBvh **bvh) {
  LitheStatus status = LITHE_OK;
  LthBvh *t = NULL;
  *bvh = NULL;
  LTH_NEW(ctx, t, 1);
  LitheCount n_nodes =
      n > LEAF_ITEMS ? (LitheCount)n : 1; // leaves hold at least half of LEAF_ITEMS
  LTH_NEW_OR(done, ctx, t->item, n);
  LTH_NEW_OR(done, ctx, t->box, 6 * n_nodes);
  LTH_NEW_OR(done, ctx, t->right, n_nodes);
  LTH_NEW_OR(done, ctx, t->first, n_nodes);
  LTH_NEW_OR(done, ctx, t->count, n_nodes);
  for (LitheIndex i = 0; i < n; i++) t->item[i] = i;
  build_node(&(Build){t, boxes}, 0, n);
  LITHE_ASSERT(t->n_nodes <= n_nodes);
done:
  if (status != LITHE_OK) lth_bvh_destroy(ctx, &t);
  *bvh = t;
  return status;
}

void lth_bvh_destroy(LitheCtx *ctx, LthBvh **bvh) {
  if (!bvh || !*bvh) return;
  LthBvh *t = *bvh;
  lth_free(ctx, t->item);
  lth_free(ctx, t->box);
  lth_free(ctx, t->right);
  lth_free(ctx, t->first);
  lth_free(ctx, t->count);
  lth_free(ctx, t->tri_normal);
  lth_free(ctx, t->across);
  lth_free(ctx, t->point_normal);
  lth_free(ctx, t);
  *bvh = NULL;
}

double lth_box_distance2(const double box[6], const double x[3]) {
  double d2 = 0;
  for (int i = 0; i < 3; i++) {
    double d = fmax(fmax(box[i] - x[i], x[i] - box[3 + i]), 0);
    d2 += d * d;
  }
  return d2;
}

LitheIndex lth_bvh_nearest(const LthBvh *t, const double x[3], LthBvhDistance2 distance, void *self,
                           double *distance2) {
  LitheIndex stack[STACK_MAX], best = -1;
  double stack_d2[STACK_MAX];
  int top = 0;
  stack[top] = 0;
  stack_d2[top++] = lth_box_distance2(t->box, x);
  while (top > 0) {
    LitheIndex node = stack[--top];
    if (stack_d2[top] >= *distance2) continue;
    if (t->right[node] < 0) {
      for (LitheIndex i = t->first[node]; i < t->first[node] + t->count[node]; i++) {
        double d2 = distance(self, t->item[i], x, *distance2);
        if (d2 < *distance2) *distance2 = d2, best = t->item[i];
      }
      continue;
    }
    LitheIndex near = node + 1, far = t->right[node];
    double near_d2 = lth_box_distance2(t->box + 6 * (size_t)near, x);
    double far_d2 = lth_box_distance2(t->box + 6 * (size_t)far, x);
    if (far_d2 < near_d2) {
      swap(&near, &far);
      double d = near_d2;
      near_d2 = far_d2;
      far_d2 = d;
    }
    LITHE_ASSERT(top + 2 <= STACK_MAX);
    stack[top] = far, stack_d2[top++] = far_d2;
    stack[top] = near, stack_d2[top++] = near_d2;
  }
  return best;
}

void lth_bvh_visit(const LthBvh *t, const double x[3], double reach, LthBvhVisit visit,
                   void *self) {
  LitheIndex stack[STACK_MAX];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    LitheIndex node = stack[--top];
    if (lth_box_distance2(t->box + 6 * (size_t)node, x) > reach * reach) continue;
    if (t->right[node] >= 0) {
      LITHE_ASSERT(top + 2 <= STACK_MAX);
      stack[top++] = t->right[node];
      stack[top++] = node + 1;
      continue;
    }
    for (LitheIndex i = t->first[node]; i < t->first[node] + t->count[node]; i++)
      if (!visit(self, t->item[i])) return;
  }
}

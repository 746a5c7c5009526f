/// Contact lumped to elements, for coarse levels: every touch hangs on one block row of each side, and no more.
#include "embed/contact_priv.h"

#include <math.h>
#include <string.h>

#define ROWS_MOST 64 // that a touch is looked for in: the elements around a few samples

/// Block rows that the legs of one side of a touch reach, and how much of them.
typedef struct Reach {
  int n;
  LitheIndex row[ROWS_MOST];
  double share[ROWS_MOST]; ///< sum of |weights| of samples that read the row
  double all;              ///< of all samples
} Reach;

static void add_share(Reach *r, LitheIndex row, double share) {
  int i = 0;
  while (i < r->n && r->row[i] != row) i++;
  if (i == ROWS_MOST) return;
  if (i == r->n) r->row[r->n++] = row, r->share[i] = 0;
  r->share[i] += share;
}

static void find_reach(const LthEmbedding *e, const LthLeg *legs, int n, Reach *r) {
  r->n = 0;
  r->all = 0;
  for (int l = 0; l < n; l++)
    for (LitheCount k = e->off[legs[l].point]; k < e->off[legs[l].point + 1]; k++) {
      LitheIndex s = e->sample[k];
      double share = fabs(legs[l].weight * e->weight[k]);
      r->all += share;
      for (LitheCount i = e->sample_row_off[s]; i < e->sample_row_off[s + 1]; i++)
        add_share(r, e->sample_row[i], share);
    }
}

/// The row that most of the weight reads; of equal ones the first.
static int widest(const Reach *r) {
  int best = 0;
  for (int i = 1; i < r->n; i++)
    if (r->share[i] > r->share[best] * (1 + 1e-9)) best = i;
  return best;
}

/// phi (nb) of the row where the touch is, times `scale`: as if all of it hung there.
static void gather_phi(const LthEmbedding *e, const LthLeg *legs, int n, LitheIndex row,
                       double scale, LthContactEnd *end) {
  end->row = row;
  end->nb = e->row_func[row + 1] - e->row_func[row];
  memset(end->phi, 0, sizeof *end->phi * (size_t)end->nb);
  for (int l = 0; l < n; l++)
    for (LitheCount k = e->off[legs[l].point]; k < e->off[legs[l].point + 1]; k++) {
      LitheIndex s = e->sample[k];
      LitheCount at = e->sample_off[s];
      double rows = (double)(e->sample_row_off[s + 1] - e->sample_row_off[s]);
      for (LitheCount i = e->sample_row_off[s]; i < e->sample_row_off[s + 1]; i++) {
        LitheIndex other = e->sample_row[i];
        int nb = e->row_func[other + 1] - e->row_func[other];
        for (int j = 0; other == row && j < nb; j++)
          end->phi[j] += scale * legs[l].weight * e->weight[k] * rows * e->sample_weight[at + j];
        at += nb;
      }
    }
}

bool lth_contact_visit_lumps(const LthContact *c, bool all, LthContactLumpFn *visit, void *self) {
  for (int s = 0; s < c->n_sides; s++)
    if (c->side[s].points->sample_width != 1) return false;
  for (LitheIndex i = 0; i < c->n_touch; i++) {
    const LthTouch *touch = &c->touch[i];
    const int first[3] = {0, touch->n_own, touch->n_legs};
    LthContactEnd end[2];
    int n_ends = 0;
    if (!all && !touch->active) continue;
    for (int k = 0; k < 2 && first[k] < first[k + 1]; k++) {
      const LthLeg *legs = touch->leg + first[k];
      const LthContactSide *side = &c->side[legs->side];
      Reach reach;
      find_reach(side->points, legs, first[k + 1] - first[k], &reach);
      if (reach.n == 0) continue;
      int at = widest(&reach);
      gather_phi(side->points, legs, first[k + 1] - first[k], reach.row[at],
                 reach.all / reach.share[at], end + n_ends);
      end[n_ends++].row += side->first_row;
    }
    visit(self, n_ends, end, touch->D);
  }
  return true;
}

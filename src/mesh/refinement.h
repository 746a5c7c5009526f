/// Refinement that can be taken back: which cells of a topology are the parts of one that was divided
/// (docs/develop/topology.md, section 7).
#pragma once

#include "base/archive.h"
#include "mesh/topology.h"

typedef enum LthDivision { LTH_DIVIDE_EIGHT, LTH_DIVIDE_TWO } LthDivision;

/// The parts of a cell that was divided. Whole while all of them are cells: then they can be merged again. A part that
/// is cut, or merged with a cell from elsewhere, never comes back, and the family stays apart.
typedef struct LthFamily {
  double volume;       ///< of the divided cell [m^3]
  LitheIndex parent;   ///< family that the divided cell was a member of, -1: none
  LitheIndex n;        ///< parts that make it whole; 0: a free number
  LitheIndex n_alive;  ///< of them, those that are cells now
  LitheIndex n_within; ///< families whose `parent` this is
  uint8_t level;       ///< of the divided cell
} LthFamily;

/// Families by number, and the family of every record. Zero-initialise.
typedef struct LthRefinement {
  LthFamily *families;
  LitheIndex n_families;
  LitheIndex free_family; ///< 1 + the first free number, whose `parent` leads to the next; 0: none
  LitheIndex *family_of;  ///< by record, -1: none                          (n_records)
  LitheIndex n_records;
  LitheCount cap_families, cap_family_of;
} LthRefinement;

void lth_refinement_free(LitheCtx *ctx, LthRefinement *r);

/// Divide a cell of level `level`: by three planes along its box, or by one with the given normal, through its centroid.
/// Births from split->first on that are alive are the parts; split->n = 0: it cannot be divided and stays.
LitheStatus lth_refinement_divide(LitheCtx *ctx, LthRefinement *r, LthTopology *t, LitheIndex cell,
                                  uint8_t level, LthDivision division, const double normal[3],
                                  LthSplit *split);

/// After all divisions, and once whoever follows the topology has taken note of the cells: merge parts that births
/// `first` on of the log made and that are smaller than `share` of an eighth (a half) of what was divided into the
/// sibling with the largest common face.
LitheStatus lth_refinement_merge_slivers(LitheCtx *ctx, LthRefinement *r, LthTopology *t,
                                         LitheIndex first, LthDivision division, double share,
                                         LitheIndex *n_merged);

/// Whether n cells are all the parts of a family and no cut lies between them.
LitheStatus lth_refinement_may_merge(LitheCtx *ctx, const LthRefinement *r, const LthTopology *t,
                                     const LitheIndex *cells, LitheIndex n, bool *may);

/// Make the parts of a family (its n cells) one again; `*merged` is its record.
LitheStatus lth_refinement_merge(LitheCtx *ctx, LthRefinement *r, LthTopology *t, LitheIndex family,
                                 const LitheIndex *cells, LitheIndex *merged);

/// Read the log before it is forgotten: cells that died leave their families.
LitheStatus lth_refinement_follow(LitheCtx *ctx, LthRefinement *r, const LthTopology *t);

static inline LitheIndex lth_refinement_family(const LthRefinement *r, LitheIndex record) {
  return record < r->n_records ? r->family_of[record] : -1;
}

/// Cells of whole families, family by family: cells of number k are list[off[k]] ... list[off[k + 1] - 1]. (n + 1, n cells)
LitheStatus lth_refinement_list(LitheCtx *ctx, const LthRefinement *r, const LthTopology *t,
                                LitheIndex **off, LitheIndex **list);

void lth_refinement_archive(LitheCtx *ctx, LthRefinement *r, LthArchive *archive);

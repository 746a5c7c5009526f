/// Observers: what looks at a run at its output times and writes files.
///
/// `resumes`: go on with the files of an interrupted run; the observer's archive function, which walks over how far
/// they are, then cuts them there.
#pragma once

#include "io/json.h"
#include "scene/world.h"

/// history.csv: one row an output time.
typedef struct LthHistory LthHistory;
LitheStatus lth_history_open(LitheCtx *ctx, const char *folder, bool resumes, LthHistory **history);
LitheStatus lth_history_row(LitheCtx *ctx, LthHistory *history, const LthWorld *world);
void lth_history_archive(LthHistory *history, LthArchive *archive);
LitheStatus lth_history_close(LitheCtx *ctx, LthHistory **history);

/// Named points of the body: probes.csv, and their last values for the result.
typedef struct LthProbeValue {
  double displacement[3]; ///< [m]
  double stress[6];       ///< xx yy zz yz zx xy [Pa]
  double von_mises;       ///< [Pa]
} LthProbeValue;

typedef struct LthProbes LthProbes;
/// A probe belongs to the first body that holds it at rest; one outside all takes the nearest element, with a
/// warning. No file without probes.
LitheStatus lth_probes_open(LitheCtx *ctx, const char *folder, const LthWorld *world, bool resumes,
                            LthProbes **probes);
/// `u`: displacements of the whole world.
LthProbeValue lth_probe_value(const LthProbes *probes, const LthWorld *world, const double *u,
                              LitheIndex i);
LitheStatus lth_probes_row(LitheCtx *ctx, LthProbes *probes, const LthWorld *world);
/// A probe stays in its body, in the element that holds it now.
LitheStatus lth_probes_renew(LitheCtx *ctx, LthProbes *probes, const LthWorld *world);
void lth_probes_archive(LthProbes *probes, LthArchive *archive);
LitheStatus lth_probes_close(LitheCtx *ctx, LthProbes **probes);

/// fields_0000.vtu ... and fields.pvd of one body; where there are several, NAME_fields_0000.vtu and so on.
typedef struct LthFields LthFields;
LitheStatus lth_fields_open(LitheCtx *ctx, const char *folder, const LthBody *body,
                            LthFields **fields);
LitheStatus lth_fields_renew(LitheCtx *ctx, LthFields *fields, const LthBody *body);
LitheStatus lth_fields_frame(LitheCtx *ctx, LthFields *fields, const LthBody *body);
void lth_fields_archive(LthFields *fields, LthArchive *archive);
LitheStatus lth_fields_close(LitheCtx *ctx, LthFields **fields);

/// The embedded surface: surface.obj (at rest) with surface.pc2, numbered .obj .ply .stl; NAME_surface.obj where
/// there are several bodies.
typedef struct LthSurfaceOutput LthSurfaceOutput;
/// `period` is the time between frames [s].
LitheStatus lth_surface_output_open(LitheCtx *ctx, const char *folder, const LthBody *body,
                                    double period, bool resumes, LthSurfaceOutput **out);
/// The body's elements are others: where its surface has other points, numbered .obj follow in place of the cache.
LitheStatus lth_surface_output_renew(LitheCtx *ctx, LthSurfaceOutput *out, const LthBody *body);
/// Object `surface`: how many frames a cache that a cut has ended holds, and what follows it.
void lth_surface_output_put(LthJson *json, const LthSurfaceOutput *out);
LitheStatus lth_surface_output_frame(LitheCtx *ctx, LthSurfaceOutput *out, const LthBody *body);
void lth_surface_output_archive(LthSurfaceOutput *out, LthArchive *archive);
LitheStatus lth_surface_output_close(LitheCtx *ctx, LthSurfaceOutput **out);

/// "fields", or "NAME_fields" where the scene has several bodies: letters of the name that files cannot have
/// become underscores. Freed by lth_free().
LitheStatus lth_output_stem(LitheCtx *ctx, const LthBody *body, const char *what, char **stem);

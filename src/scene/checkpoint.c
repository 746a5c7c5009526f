/// Checkpoints: the head says whose state it is, the rest is one walk through the run.
#include "scene/checkpoint.h"

#include "io/checkpoint_file.h"
#include "io/file.h"
#include "scene/adapt.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

LitheStatus lth_checkpoint_open(LitheCtx *ctx, const LthScene *scene, const char *folder,
                                uint64_t digest, LthCheckpoint *c) {
  *c = (LthCheckpoint){.digest = digest};
  if (scene->checkpoint_period < 0) return LITHE_OK;
  c->scene = scene;
  LITHE_TRY(lth_path_join(ctx, folder, LTH_CHECKPOINT_NAME, &c->path));
  // the folder is resolved, the name is not: a link may go by another name than the file it leads to
  const char *slash = strrchr(scene->file, '/');
  char *absolute = realpath(scene->directory, NULL);
  LitheStatus status = lth_path_join(ctx, absolute ? absolute : scene->directory,
                                     slash ? slash + 1 : scene->file, &c->scene_path);
  free(absolute);
  return status;
}

void lth_checkpoint_close(LitheCtx *ctx, LthCheckpoint *c) {
  lth_free(ctx, c->path);
  lth_free(ctx, c->scene_path);
  lth_archive_free(ctx, &c->state);
  *c = (LthCheckpoint){0};
}

// --- the walk ---

/// Whose checkpoint it is. The same walk writes and reads.
static void walk_head(LthArchive *a, LthResume *r) {
  lth_archive_mark(a, "head");
  lth_archive_text(a, &r->version);
  lth_archive_text(a, &r->scene_file);
  lth_archive_text(a, &r->scene_path);
  LTH_ARCHIVE(a, r->digest);
  LTH_ARCHIVE(a, r->place);
  lth_archive_count(a, &r->n_overrides);
  if (a->is_reading && a->status == LITHE_OK) {
    r->overrides = lth_alloc(a->ctx, r->n_overrides, sizeof *r->overrides);
    if (!r->overrides) a->status = lth_fail(a->ctx, LITHE_NO_MEMORY, "out of memory");
  }
  for (LitheCount i = 0; i < r->n_overrides && a->status == LITHE_OK; i++)
    lth_archive_text(a, &r->overrides[i]);
}

/// Warnings so far, so that a result tells them all.
static void walk_warnings(LthArchive *a) {
  LitheCount n = lithe_ctx_warning_count(a->ctx);
  lth_archive_count(a, &n);
  for (LitheCount i = 0; i < n && a->status == LITHE_OK; i++) {
    char *text = a->is_reading ? NULL : (char *)lithe_ctx_warning(a->ctx, (LitheIndex)i);
    lth_archive_text(a, &text);
    if (!a->is_reading || !text) continue;
    lth_warn(a->ctx, "%s", text);
    lth_free(a->ctx, text);
  }
}

static void walk_world(LthArchive *a, LthWorld *world) {
  lth_archive_mark(a, "world");
  walk_warnings(a);
  lth_world_change_archive(world, a);
  lth_adapt_archive(world, a);
  if (a->status != LITHE_OK) return;
  lth_simulation_archive(world->sim, a);
}

// --- writing ---

LitheStatus lth_checkpoint_write_last(LitheCtx *ctx, LthCheckpoint *c) {
  if (!c->scene || c->state.size == 0) return LITHE_OK;
  c->written = lth_now();
  return lth_checkpoint_write(ctx, c->path, c->state.data, c->state.size);
}

LitheStatus lth_checkpoint_take(LitheCtx *ctx, LthCheckpoint *c, LthPlace place, LthWorld *world,
                                LthOutput *out) {
  if (!c->scene) return LITHE_OK;
  LthResume head = {.version = (char *)lithe_version(),
                    .scene_file = c->scene->file,
                    .scene_path = c->scene_path,
                    .overrides = c->scene->overrides,
                    .n_overrides = c->scene->n_overrides,
                    .digest = c->digest,
                    .place = place};
  lth_archive_begin(&c->state, ctx);
  walk_head(&c->state, &head);
  walk_world(&c->state, world);
  lth_output_archive(out, &c->state);
  LITHE_TRY(c->state.status);
  bool is_due = c->written == 0 || lth_now() - c->written >= c->scene->checkpoint_period;
  return is_due ? lth_checkpoint_write_last(ctx, c) : LITHE_OK;
}

// --- reading ---

/// The archive's failure with the file's name in front.
static LitheStatus name_failure(LitheCtx *ctx, const LthResume *r) {
  char *why = NULL;
  if (r->state.status != LITHE_BAD_INPUT) return r->state.status;
  LITHE_TRY(lth_copy_text(ctx, lithe_ctx_message(ctx), &why));
  lth_fail(ctx, LITHE_BAD_INPUT, "%s: cannot go on from it: %s", r->path, why);
  lth_free(ctx, why);
  return LITHE_BAD_INPUT;
}

LitheStatus lth_resume_open(LitheCtx *ctx, const char *folder, LthResume *r) {
  LitheCount size;
  *r = (LthResume){0};
  LITHE_TRY(lth_path_join(ctx, folder, LTH_CHECKPOINT_NAME, &r->path));
  if (access(r->path, F_OK) != 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: there is no checkpoint in this folder to go on from; a run writes them where "
               "the scene has `output: {checkpoint: SECONDS}`",
               folder);
  LITHE_TRY(lth_checkpoint_read(ctx, r->path, &r->data, &size));
  lth_archive_open(&r->state, ctx, r->data, size);
  walk_head(&r->state, r);
  if (r->state.status != LITHE_OK) return name_failure(ctx, r);
  if (strcmp(r->version, lithe_version()) != 0)
    LITHE_FAIL(ctx, LITHE_BAD_INPUT,
               "%s: written by lithe %s, this is lithe %s; go on with that one, or run the scene "
               "anew",
               r->path, r->version, lithe_version());
  return LITHE_OK;
}

void lth_resume_close(LitheCtx *ctx, LthResume *r) {
  for (LitheCount i = 0; r->overrides && i < r->n_overrides; i++) lth_free(ctx, r->overrides[i]);
  void *blocks[] = {r->overrides, r->version, r->scene_file, r->scene_path, r->data, r->path};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) lth_free(ctx, blocks[i]);
  *r = (LthResume){0};
}

LitheStatus lth_resume_check(LitheCtx *ctx, const LthResume *r, uint64_t digest) {
  if (r->digest == digest) return LITHE_OK;
  LITHE_FAIL(ctx, LITHE_BAD_INPUT,
             "%s: the scene %s, a file that it names or an override differs from what this "
             "checkpoint was written for; put it back, or run the scene anew",
             r->path, r->scene_file);
}

LitheStatus lth_resume_world(LitheCtx *ctx, LthResume *r, LthWorld *world) {
  walk_world(&r->state, world);
  return r->state.status == LITHE_OK ? LITHE_OK : name_failure(ctx, r);
}

LitheStatus lth_resume_output(LitheCtx *ctx, LthResume *r, LthOutput *out) {
  lth_output_archive(out, &r->state);
  return r->state.status == LITHE_OK ? LITHE_OK : name_failure(ctx, r);
}

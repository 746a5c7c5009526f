/// A checkpoint on disk: bytes with a head that tells a whole one of this machine from anything else.
#pragma once

#include "base/ctx.h"

/// Write `size` bytes under `path`, replacing an older file only when the new one is safely on the disk.
/// LITHE_NO_SPACE: the older file stands as it was.
LitheStatus lth_checkpoint_write(LitheCtx *ctx, const char *path, const char *data,
                                 LitheCount size);

/// Read them back; `*data` is freed by lth_free(). LITHE_BAD_INPUT: no such file, not a checkpoint, of another
/// format version or byte order, cut short, or with any bit changed.
LitheStatus lth_checkpoint_read(LitheCtx *ctx, const char *path, char **data, LitheCount *size);

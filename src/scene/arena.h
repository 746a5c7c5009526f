/// Memory of one scene: many small pieces that live and die together.
#pragma once

#include "base/ctx.h"

typedef struct LthArenaChunk LthArenaChunk;

/// Zero-initialise and set ctx. `failed` stays true once memory was out: callers may go on with the
/// NULL they got and ask at the end.
typedef struct LthArena {
  LitheCtx *ctx;
  LthArenaChunk *chunks;
  bool failed;
} LthArena;

/// Zeroed memory, aligned to 16; NULL where memory is out.
void *lth_arena_take(LthArena *arena, size_t bytes);

/// A copy of `length` bytes with a zero behind.
char *lth_arena_text(LthArena *arena, const char *text, size_t length);

/// printf into the arena.
char *lth_arena_print(LthArena *arena, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

void lth_arena_free(LthArena *arena);

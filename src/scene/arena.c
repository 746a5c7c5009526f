/// Chunks that double in use: small pieces share one, large ones get their own.
#include "scene/arena.h"

#include <stdio.h>
#include <string.h>

#define CHUNK_BYTES 16384

struct LthArenaChunk {
  LthArenaChunk *next;
  size_t used, size; ///< bytes behind this head
};

static LthArenaChunk *chunk_create(LthArena *arena, size_t bytes) {
  size_t size = bytes > CHUNK_BYTES ? bytes : CHUNK_BYTES;
  LthArenaChunk *chunk = lth_alloc(arena->ctx, 1, sizeof *chunk + 16 + size);
  if (!chunk) return NULL;
  chunk->size = size;
  chunk->next = arena->chunks;
  arena->chunks = chunk;
  return chunk;
}

void *lth_arena_take(LthArena *arena, size_t bytes) {
  size_t rounded = (bytes + 15) & ~(size_t)15;
  LthArenaChunk *chunk = arena->chunks;
  if (!chunk || chunk->size - chunk->used < rounded) chunk = chunk_create(arena, rounded);
  if (!chunk) {
    arena->failed = true;
    return NULL;
  }
  // the head is 24 bytes: its data start at the next multiple of 16
  char *data = (char *)chunk + ((sizeof *chunk + 15) & ~(size_t)15);
  void *piece = data + chunk->used;
  chunk->used += rounded;
  return piece;
}

char *lth_arena_text(LthArena *arena, const char *text, size_t length) {
  char *copy = lth_arena_take(arena, length + 1);
  if (copy && length) memcpy(copy, text, length);
  return copy;
}

char *lth_arena_print(LthArena *arena, const char *format, ...) {
  va_list args, again;
  va_start(args, format);
  va_copy(again, args);
  int length = vsnprintf(NULL, 0, format, args);
  va_end(args);
  char *text = length < 0 ? NULL : lth_arena_take(arena, (size_t)length + 1);
  if (text) vsnprintf(text, (size_t)length + 1, format, again);
  va_end(again);
  return text;
}

void lth_arena_free(LthArena *arena) {
  while (arena->chunks) {
    LthArenaChunk *next = arena->chunks->next;
    lth_free(arena->ctx, arena->chunks);
    arena->chunks = next;
  }
}

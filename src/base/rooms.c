/// Rooms in a range that grows at its end.
#include "base/rooms.h"

void lth_rooms_free(LitheCtx *ctx, LthRooms *rooms) {
  for (LitheIndex i = 0; i < rooms->n_sizes; i++) lth_free(ctx, rooms->sizes[i].free);
  lth_free(ctx, rooms->sizes);
  *rooms = (LthRooms){0};
}

static LthRoomSize *find_size(const LthRooms *rooms, LitheCount size) {
  for (LitheIndex i = 0; i < rooms->n_sizes; i++)
    if (rooms->sizes[i].size == size) return rooms->sizes + i;
  return NULL;
}

LitheCount lth_rooms_take(LthRooms *rooms, LitheCount size) {
  LthRoomSize *s = find_size(rooms, size);
  rooms->used += size;
  if (s && s->n_free > 0) return s->free[--s->n_free];
  LITHE_ASSERT(rooms->fence == 0 || size <= rooms->fence);
  if (rooms->fence > 0 && rooms->end % rooms->fence + size > rooms->fence)
    rooms->end += rooms->fence - rooms->end % rooms->fence;
  rooms->end += size;
  return rooms->end - size;
}

LitheStatus lth_rooms_give(LitheCtx *ctx, LthRooms *rooms, LitheCount at, LitheCount size) {
  LthRoomSize *s = find_size(rooms, size);
  if (!s) {
    LTH_RESERVE(ctx, rooms->sizes, rooms->sizes_cap, (LitheCount)rooms->n_sizes + 1);
    s = rooms->sizes + rooms->n_sizes++;
    *s = (LthRoomSize){.size = size};
  }
  LTH_RESERVE(ctx, s->free, s->cap, s->n_free + 1);
  s->free[s->n_free++] = at;
  rooms->used -= size;
  return LITHE_OK;
}

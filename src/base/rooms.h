/// Rooms in a range that grows at its end: those given back are taken again by whoever needs the same size.
#pragma once

#include "base/ctx.h"

/// Free rooms of one size.
typedef struct LthRoomSize {
  LitheCount size, *free, n_free, cap;
} LthRoomSize;

/// Zero-initialised it is empty and usable. Sizes are few: each is looked for in a list.
typedef struct LthRooms {
  LitheCount end;   ///< no room reaches beyond
  LitheCount fence; ///< no room lies across a multiple of it; 0: there are none
  LitheCount used;  ///< sum of the sizes of rooms that are taken
  LthRoomSize *sizes;
  LitheIndex n_sizes;
  LitheCount sizes_cap;
} LthRooms;

void lth_rooms_free(LitheCtx *ctx, LthRooms *rooms);

/// A room of `size` (at most the fence): where it begins.
LitheCount lth_rooms_take(LthRooms *rooms, LitheCount size);
LitheStatus lth_rooms_give(LitheCtx *ctx, LthRooms *rooms, LitheCount at, LitheCount size);

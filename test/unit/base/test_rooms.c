/// Rooms never overlap, are used again, and none lies across the fence.
#include "check.h"

#include "base/rooms.h"

typedef struct Room {
  LitheCount at, size;
} Room;

static void rooms_are_apart_and_used_again(void **state) {
  (void)state;
  LitheCtx *ctx = test_ctx();
  LthRooms rooms = {.fence = 64};
  static const LitheCount sizes[] = {1, 5, 17, 40, 64};
  enum { N = 200 };
  Room taken[N];
  uint64_t seed = 7;
  LitheCount end = 0, sum = 0;
  for (int i = 0; i < N; i++) {
    taken[i].size = sizes[i % 5];
    taken[i].at = lth_rooms_take(&rooms, taken[i].size);
    sum += taken[i].size;
  }
  assert_int_equal(rooms.used, sum);
  end = rooms.end;
  for (int k = 0; k < 5000; k++) {
    int i = (int)(N * test_random(&seed));
    CHECK_OK(ctx, lth_rooms_give(ctx, &rooms, taken[i].at, taken[i].size));
    taken[i].at = lth_rooms_take(&rooms, taken[i].size);
  }
  assert_int_equal(rooms.end, end);
  for (int i = 0; i < N; i++) {
    assert_true(taken[i].at / 64 == (taken[i].at + taken[i].size - 1) / 64);
    for (int j = 0; j < i; j++)
      assert_true(taken[i].at + taken[i].size <= taken[j].at ||
                  taken[j].at + taken[j].size <= taken[i].at);
  }
  lth_rooms_free(ctx, &rooms);
  assert_int_equal(lth_alloc_bytes(ctx), 0);
  lithe_ctx_destroy(&ctx);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rooms_are_apart_and_used_again),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

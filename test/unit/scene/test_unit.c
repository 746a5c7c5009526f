/// Units: names, prefixes, products of powers, and what is no unit.
#include "check.h"
#include "scene/unit.h"

#include <string.h>

static void check_unit(const char *text, double factor, int m, int kg, int s, int rad) {
  LthUnit unit;
  if (!lth_unit_parse(text, &unit, NULL, NULL)) fail_msg("%s is not read", text);
  const int want[LTH_BASE_UNITS] = {m, kg, s, rad};
  CHECK_NEAR(unit.factor / factor, 1, 4e-16);
  for (int i = 0; i < LTH_BASE_UNITS; i++) assert_int_equal(unit.power[i], want[i]);
}

static void reads_names_and_prefixes(void **state) {
  (void)state;
  check_unit("m", 1, 1, 0, 0, 0);
  check_unit("mm", 1e-3, 1, 0, 0, 0);
  check_unit("um", 1e-6, 1, 0, 0, 0);
  check_unit("µm", 1e-6, 1, 0, 0, 0);
  check_unit("km", 1e3, 1, 0, 0, 0);
  check_unit("g", 1e-3, 0, 1, 0, 0);
  check_unit("kg", 1, 0, 1, 0, 0);
  check_unit("t", 1e3, 0, 1, 0, 0);
  check_unit("ms", 1e-3, 0, 0, 1, 0);
  check_unit("min", 60, 0, 0, 1, 0);
  check_unit("h", 3600, 0, 0, 1, 0);
  check_unit("kN", 1e3, 1, 1, -2, 0);
  check_unit("GPa", 1e9, -1, 1, -2, 0);
  check_unit("hPa", 1e2, -1, 1, -2, 0);
  check_unit("kJ", 1e3, 2, 1, -2, 0);
  check_unit("mW", 1e-3, 2, 1, -3, 0);
  check_unit("Hz", 1, 0, 0, -1, 0);
  check_unit("rad", 1, 0, 0, 0, 1);
  check_unit("deg", 3.14159265358979323846 / 180, 0, 0, 0, 1);
  check_unit("°", 3.14159265358979323846 / 180, 0, 0, 0, 1);
  check_unit("L", 1e-3, 3, 0, 0, 0);
  check_unit("in", 0.0254, 1, 0, 0, 0);
  check_unit("bar", 1e5, -1, 1, -2, 0);
}

static void reads_products_of_powers(void **state) {
  (void)state;
  check_unit("kg/m^3", 1, -3, 1, 0, 0);
  check_unit("g/cm^3", 1000, -3, 1, 0, 0);
  check_unit("N/m^2", 1, -1, 1, -2, 0);
  check_unit("m/s^2", 1, 1, 0, -2, 0);
  check_unit("m s^-2", 1, 1, 0, -2, 0);
  check_unit("1/s", 1, 0, 0, -1, 0);
  check_unit("N*m", 1, 2, 1, -2, 0);
  check_unit("N·m", 1, 2, 1, -2, 0);
  check_unit("kN/m/m", 1e3, -1, 1, -2, 0);
  check_unit("mm3", 1e-9, 3, 0, 0, 0);
  check_unit("rad/s", 1, 0, 0, -1, 1);
  check_unit("", 1, 0, 0, 0, 0);
  check_unit("1", 1, 0, 0, 0, 0);
}

static void refuses_what_is_no_unit(void **state) {
  (void)state;
  static const char *const bad[] = {"x",    "kPaa", "m/",  "m^", "m^x", "/s",  "mmin", "kdeg",
                                    "m^33", "m**s", "2 m", "m)", "1/1", "s-2", "k",    "m/s/"};
  LthUnit unit;
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
    if (lth_unit_parse(bad[i], &unit, NULL, NULL)) fail_msg("%s is read as a unit", bad[i]);
}

static void names_the_part_that_is_wrong(void **state) {
  (void)state;
  LthUnit unit;
  const char *bad = NULL;
  size_t length = 0;
  assert_false(lth_unit_parse("kg/furlong^3", &unit, &bad, &length));
  assert_int_equal(length, 7);
  assert_memory_equal(bad, "furlong", 7);
}

static void tells_quantities_apart(void **state) {
  (void)state;
  LthUnit a, b;
  assert_true(lth_unit_parse("N/m^2", &a, NULL, NULL));
  assert_true(lth_unit_parse("MPa", &b, NULL, NULL));
  assert_true(lth_unit_same(&a, &b));
  assert_string_equal(lth_unit_quantity(&a), "a pressure");
  assert_true(lth_unit_parse("Hz", &a, NULL, NULL));
  assert_true(lth_unit_parse("rad/s", &b, NULL, NULL));
  assert_false(lth_unit_same(&a, &b));
}

static void suggests_the_nearest_name(void **state) {
  (void)state;
  assert_string_equal(lth_unit_nearest("kpa"), "kPa");
  assert_string_equal(lth_unit_nearest("kPaa"), "kPa");
  assert_string_equal(lth_unit_nearest("degr"), "deg");
  assert_string_equal(lth_unit_nearest("n"), "N");
  assert_null(lth_unit_nearest("furlong"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reads_names_and_prefixes), cmocka_unit_test(reads_products_of_powers),
      cmocka_unit_test(refuses_what_is_no_unit),  cmocka_unit_test(names_the_part_that_is_wrong),
      cmocka_unit_test(tells_quantities_apart),   cmocka_unit_test(suggests_the_nearest_name),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

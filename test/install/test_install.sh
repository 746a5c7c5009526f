#!/bin/sh
# Installs the build into a folder of its own and builds a program against it, by find_package and by
# pkg-config; then compiles each public header alone, as C and as C++.
# usage: test_install.sh SOURCE_DIR BUILD_DIR CC CXX [FLAGS]
set -eu
source=$1 build=$2 cc=$3 cxx=$4 flags=${5:-}
work=$build/test-install
rm -rf "$work"
mkdir -p "$work"
cmake --install "$build" --prefix "$work/prefix" >/dev/null

cmake -S "$source/test/install/consumer" -B "$work/by-cmake" -DCMAKE_PREFIX_PATH="$work/prefix" \
  -DCMAKE_C_COMPILER="$cc" -DCMAKE_C_FLAGS="$flags" >/dev/null
cmake --build "$work/by-cmake" >/dev/null
(cd "$work" && ./by-cmake/consumer)
echo "find_package(lithe): good"

# lithe.pc carries the prefix that was configured, not the one given to --install
pc=$(find "$work/prefix" -name lithe.pc)
PKG_CONFIG_PATH=$(dirname "$pc")
export PKG_CONFIG_PATH
# shellcheck disable=SC2046,SC2086
"$cc" $flags -o "$work/by-pkg-config" "$source/test/install/consumer/main.c" \
  $(pkg-config --define-variable=prefix="$work/prefix" --cflags --libs lithe)
(cd "$work" && ./by-pkg-config)
echo "pkg-config lithe: good"

for header in "$source"/include/lithe/*.h; do
  name=lithe/$(basename "$header")
  printf '#include <%s>\n' "$name" >"$work/alone.c"
  cp "$work/alone.c" "$work/alone.cpp"
  "$cc" -std=c11 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -I"$work/prefix/include" "$work/alone.c"
  "$cxx" -std=c++11 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -I"$work/prefix/include" "$work/alone.cpp"
done
echo "public headers: each compiles alone, as C and as C++"

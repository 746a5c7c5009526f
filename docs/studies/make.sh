#!/bin/sh
# Make docs/studies/dolny.md and its pictures from a run of the studies: docs/studies/make.sh [--quick]. OUT=DIR takes one that
# was made already.
set -eu
cd "$(dirname "$0")/../.."
out=${OUT:-out/docs-study}
[ -f "$out/index.md" ] || build/release/apps/lithe/lithe study dolny "$@" -o "$out" || echo "some verdict does not hold: the page says which"
rm -rf docs/studies/dolny
for picture in "$out"/dolny/*/*.svg; do
  to=docs/studies/dolny/$(basename "$(dirname "$picture")")
  mkdir -p "$to"
  cp "$picture" "$to/"
done
cp "$out/index.md" docs/studies/dolny.md

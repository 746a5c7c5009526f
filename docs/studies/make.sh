#!/bin/sh
# Make docs/studies/GROUP.md and its pictures from a run of the studies: docs/studies/make.sh dolny|kaufmann [--quick].
# OUT=DIR takes a run that was made already.
set -eu
cd "$(dirname "$0")/../.."
group=${1:-dolny}
[ $# -eq 0 ] || shift
out=${OUT:-out/docs-study-$group}
[ -f "$out/index.md" ] || build/release/apps/lithe/lithe study "$group" "$@" -o "$out" || echo "some verdict does not hold: the page says which"
rm -rf "docs/studies/$group"
for picture in "$out/$group"/*/*.svg; do
  to=docs/studies/$group/$(basename "$(dirname "$picture")")
  mkdir -p "$to"
  cp "$picture" "$to/"
done
cp "$out/index.md" "docs/studies/$group.md"

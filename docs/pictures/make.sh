#!/bin/sh
# Makes the pictures of the documentation anew. Needs python3-vtk9 and xvfb.
set -eu
cd "$(dirname "$0")/../.."
lithe=build/release/apps/lithe/lithe
render="xvfb-run -a /usr/bin/python3 tools/render_result.py"

"$lithe" run scenes/bunny-drop.yaml -o out/bunny-drop
$render out/bunny-drop docs/pictures/bunny-drop.png --frames 0,4,5,60 --floor 0 --zoom 1.15
$render out/bunny-drop docs/pictures/bunny-stress.png --what cut --shrink 0.94 --frames 5 --size 640x520

mkdir -p out/bunny-sliced
"$lithe" mesh scenes/bunny-drop.yaml -o out/bunny-sliced/fields_0000.vtu --set bodies.0.method.cells=16
$render out/bunny-sliced docs/pictures/bunny-sliced.png --what cut --shrink 0.9 --colour none --frames 0 \
  --size 640x560 --zoom 1.2

"$lithe" run scenes/cantilever.yaml -o out/cantilever
$render out/cantilever docs/pictures/cantilever.png --what elements --shrink 0.97 --up z --azimuth 15 --frames 0 \
  --size 640x420

"$lithe" run scenes/ears.yaml -o out/ears
"$lithe" run scenes/ears.yaml -o out/ears-embedded --set bodies.0.method.kind=cg --set bodies.0.method.mesh=embedded
$render out/ears,out/ears-embedded docs/pictures/ears.png --colour displacement --azimuth -50 --zoom 1.5 --size 480x420

"$lithe" run scenes/two-bunnies.yaml -o out/two-bunnies
$render out/two-bunnies docs/pictures/two-bunnies.png --frames 0,7,10,14 --floor 0 --zoom 1.25 --colour none --size 300x360

"$lithe" run scenes/bar-adapt.yaml -o out/bar-adapt
$render out/bar-adapt docs/pictures/bar-adapt.png --what elements --shrink 0.97 --up z --azimuth 15 --frames 0,15,24,35 \
  --size 460x380 --zoom 1.25

"$lithe" run scenes/bunny-cut.yaml -o out/bunny-cut
$render out/bunny-cut docs/pictures/bunny-cut.png --frames 0,4,9,14,20,32 --floor 0 --zoom 1.2 --colour none --size 300x320

"$lithe" run scenes/brain.yaml -o out/brain
$render out/brain docs/pictures/brain.png --what grid --frames 0 --up z --colour label,von_mises --clip 0,-0.02,0,0,-1,0 \
  --azimuth 20 --elevation 15 --size 460x400 --zoom 1.25

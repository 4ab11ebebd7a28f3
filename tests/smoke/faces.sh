# SPDX-License-Identifier: Apache-2.0
# majak faces: every face of a run, a few of them, of a part of it; twice the same; clear refusals.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
ok "$majak" map short.log -o hall

ok "$majak" faces
grep -q "segments  walls" out || fail "faces are not listed"
ok "$majak" faces hall
for file in faces.html options.toml occupancy.png occupancy.pgm occupancy.yaml inflated.pgm segments.svg walls.dxf sensor.png; do
  non_empty hall-faces/$file
done
grep -q 'id="segments"' hall-faces/faces.html || fail "the page lacks a face"
ok "$majak" faces hall/site.majak --all --threads 1 -o again
for file in hall-faces/*.svg hall-faces/walls.* hall-faces/*.pgm; do
  cmp -s "$file" "again/${file#hall-faces/}" || fail "another ${file#hall-faces/}"
done
ok "$majak" localize short.log --map hall-faces/occupancy.yaml -o on_face

ok "$majak" faces hall sensor --to 5 -o early
ok "$majak" faces hall sensor --near 0,0,3 -o near
[ "$(wc -c <early/sensor.svg)" -lt "$(wc -c <hall-faces/sensor.svg)" ] || fail "a part is as large as the whole"
ok "$majak" faces hall inflated --set robot.radius=0.1 -o thin
cmp -s thin/inflated.pgm hall-faces/inflated.pgm && fail "the robot's size changes nothing"

ok "$majak" faces hall segments --known hall-faces/walls.wkt -o begun
printf 'LINESTRING (40 40, 44 40)\n' >far.wkt
ok "$majak" faces hall segments --known far.wkt -o far
grep -q "44.0000 40.0000" far/walls.wkt || fail "a known wall that nobody looked at is gone"
refused "$majak" faces hall segments --known no_such.wkt

refused "$majak" faces no_such
refused "$majak" faces hall nose
refused "$majak" faces hall/map.yaml
refused "$majak" faces hall sensor --from 100000
refused "$majak" faces hall sensor --near here
refused "$majak" faces hall segments --set refinement.min_returns=1000000

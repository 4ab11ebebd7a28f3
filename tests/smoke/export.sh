# SPDX-License-Identifier: Apache-2.0
# majak export: the walls of a run in every format, twice the same; clear refusals.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
ok "$majak" map short.log -o hall

for format in svg dxf geojson wkt; do
  ok "$majak" export hall $format
  non_empty hall.$format
  grep -q "hall.$format: segments [0-9]*" out || fail "$(cat out)"
  ok "$majak" export hall/site.majak $format -o again.$format
  cmp -s hall.$format again.$format || fail "another $format"
done
[ "$(grep -c '^LINE' hall.dxf)" -gt 50 ] || fail "few walls: $(grep -c '^LINE' hall.dxf)"
ok "$majak" export hall wkt --set refinement.min_returns=500 -o long.wkt
[ "$(wc -c <long.wkt)" -lt "$(wc -c <hall.wkt)" ] || fail "the least number of returns changes nothing"

refused "$majak" export no_such dxf
refused "$majak" export hall docx
ok "$majak" export hall/map.yaml dxf -o cells.dxf
grep -q "cells_missed_percent [0-9.]* cells_added_percent [0-9.]*$" out || fail "$(cat out)"
[ "$(grep -c '^LINE' cells.dxf)" -gt 50 ] || fail "few walls of cells: $(grep -c '^LINE' cells.dxf)"
cp hall/map.png bare.png
refused "$majak" export bare.png dxf
ok "$majak" export bare.png dxf --map-resolution 0.05
refused "$majak" export hall dxf --set refinement.min_returns=1000000
refused "$majak" export hall dxf --set segments.colour=3
ok "$majak" export hall.dxf svg -o from_dxf.svg
cmp -s from_dxf.svg hall.svg || fail "walls of a file are other walls"
refused "$majak" export hall.dxf graphml

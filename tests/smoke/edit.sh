# SPDX-License-Identifier: Apache-2.0
# majak edit: corrections reach every file, are listed, survive a new optimisation, and can be taken
# back to the last byte; killed at any moment the run stays whole.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
ok "$majak" map short.log -o whole
cp -r whole hall

refused "$majak" edit hall
refused "$majak" edit hall --erase "1,2;3,4"
refused "$majak" edit hall --wall "1,2;x,4"
refused "$majak" edit hall --without-loop 1-2
refused "$majak" edit hall --undo
refused "$majak" edit no_such --list
ok "$majak" edit hall --list
grep -q '^no edits$' out || fail "$(cat out)"
diff -r whole hall || fail "what was refused changed the run"

ok "$majak" edit hall --wall "2,1;3,1;3,2" --forbid "1,1;2,1;2,2" --erase "0,0;0.5,0;0.5,0.5" --turn 10
[ "$(wc -l <out)" -eq 4 ] || fail "not four edits: $(cat out)"
non_empty hall/keepout.pgm hall/keepout.yaml $(printf 'hall/%s ' $result_files)
grep -q '4 edits by hand: 1 erased area, 1 wall, 1 forbidden zone, 1 turn' hall/report.html || fail "not in the report"
grep -q '"kind": "forbidden"' hall/summary.json || fail "not in summary.json"
cmp -s whole/map.pgm hall/map.pgm && fail "the map is not corrected"
cmp -s whole/trajectory.tum hall/trajectory.tum && fail "the poses are not turned"
for format in svg dxf geojson wkt; do
  ok "$majak" export hall $format
  grep -qi 'forbidden\|POLYGON' hall.$format || fail "no zone in hall.$format"
done
ok "$majak" faces hall segments occupancy inflated
ok "$majak" evaluate hall --truth in-log
grep '  ATE root' out >turned
ok "$majak" evaluate whole --truth in-log
grep '  ATE root' out >straight
cmp -s turned straight || fail "a turn changes the error: $(cat turned straight)"
ok "$majak" localize short.log --map hall -o there

for n in 4 3 2 1; do ok "$majak" edit hall --undo; done
grep -q '^no edits$' out || fail "$(cat out)"
for file in trajectory.tum graph.g2o map.png map.pgm map.yaml options.toml site.majak; do
  cmp -s whole/$file hall/$file || fail "$file is not what it was before the edits"
done
[ ! -e hall/keepout.pgm ] || fail "keepout.pgm stays"

ok "$majak" edit hall --upright
ok "$majak" edit hall --upright
[ "$(sed -n '2s/.*turn -\?\([0-9.]*\) deg/\1/p' out)" = 0.00 ] || fail "upright twice: $(cat out)"
ok "$majak" edit hall --undo
ok "$majak" edit hall --undo

# A closure off and on again; --without-loop of the map is the same edit.
ok "$majak" edit hall --closures
pair=$(awk '{ print $1; exit }' out)
[ -n "$pair" ] || fail "no closure to switch"
ok "$majak" edit hall --without-loop "$pair"
grep -q "closure_off $pair" out || fail "$(cat out)"
ok "$majak" edit hall --closures
grep -q "^$pair  switched off" out || fail "$(cat out)"
refused "$majak" edit hall --without-loop "$pair"
ok "$majak" edit hall --wall "2,1;3,1" --threads 1
ok "$majak" edit hall --with-loop "$pair"
ok "$majak" edit hall --undo
cmp -s whole/site.majak hall/site.majak || fail "a closure off and on again leaves another site"
ok "$majak" map short.log --without-loop "$pair" -o without
ok "$majak" edit without --list
grep -q "closure_off $pair" out || fail "$(cat out)"

# Killed at any moment, the run has the edits that were acknowledged.
for tenth in 1 3 5 7 9; do
  acknowledged=$("$majak" edit hall --list | grep -c wall)
  "$majak" edit hall --wall "2,1;3,$tenth" >/dev/null 2>&1 &
  pid=$!
  sleep 0.0$tenth
  kill -9 $pid 2>/dev/null
  wait $pid 2>/dev/null
  ok "$majak" edit hall --list
  [ "$(grep -c wall out)" -ge "$acknowledged" ] || fail "an edit is lost: $(cat out)"
done

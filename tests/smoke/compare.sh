# SPDX-License-Identifier: Apache-2.0
# majak compare: every method, every kind of truth, the same table twice, clear refusals.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
ok "$majak" map short.log -o hall

# column NAME METHOD FILE: a value of compare.csv.
column() {
  awk -F, -v name="$1" -v method="$2" \
    'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i } $1 == method { print $c }' "$3"
}
under() { awk -v v="$1" -v most="$2" 'BEGIN { exit !(v != "" && v < most) }'; }

# All of them on the map of this very log.
ok "$majak" compare short.log --map hall
non_empty short-compare/{compare.csv,compare.png,compare.svg,options.toml}
for method in global tracking monte-carlo markov dead-reckoning; do
  grep -q "^$method " out || fail "no row of $method"
  for name in cpu_mean_ms_a_scan belief_median_bytes error_median_m; do
    [ -n "$(column $name $method short-compare/compare.csv)" ] || fail "$method: no $name"
  done
  [ $method = dead-reckoning ] || under "$(column error_median_m $method short-compare/compare.csv)" 0.06 ||
    fail "$method errs: $(cat short-compare/compare.csv)"
done
for method in global monte-carlo; do
  under "$(column carried_told_lost_after_updates $method short-compare/compare.csv)" 20 || fail "$method did not say lost"
done
for method in global monte-carlo markov; do
  under "$(column carried_right_after_updates $method short-compare/compare.csv)" 40 || fail "$method did not come back"
done
[ -z "$(column carried_right_after_updates tracking short-compare/compare.csv)" ] || fail "tracking found the robot again"

# The same but for the times; the options can be fed back.
ok "$majak" compare short.log --map hall --methods global,monte-carlo -o a
ok "$majak" compare short.log --map hall --methods global,monte-carlo -o b --options a/options.toml
for folder in a b; do cut -d, -f1-11,14,16- $folder/compare.csv >$folder.csv; done
cmp -s a.csv b.csv || fail "another table: $(diff a.csv b.csv)"
cmp -s a/options.toml b/options.toml || fail "other options"

# Map files: truth from a file, else the log's own; it is not in this map's frame, and that is said.
ok "$majak" compare short.log --map hall/map.yaml --truth hall/trajectory.tum --methods tracking -o file
under "$(column error_p95_m tracking file/compare.csv)" 0.2 || fail "$(cat file/compare.csv)"
awk '$1 != "TRUEPOS"' short.log >blind.log
ok "$majak" compare blind.log --map hall/map.yaml -o blind
grep -q 'truth: none' out || fail "$(cat out)"
grep -q 'tracking left out' out || fail "tracking guessed where it starts"
[ -z "$(column error_median_m global blind/compare.csv)" ] || fail "an error without truth"
ok "$majak" compare blind.log --map hall/map.yaml --methods tracking --start 0,0,0 -o started
sed 's/^\([0-9.]*\) \([-0-9.]*\)/\1 7\2/' hall/trajectory.tum >elsewhere.tum
ok "$majak" compare short.log --map hall --methods global --truth elsewhere.tum -o elsewhere
grep -q 'not used' out || fail "truth of another place was believed: $(cat out)"

refused "$majak" compare no_such.log --map hall
refused "$majak" compare short.log --map no_such
refused "$majak" compare short.log --map hall --methods guessing
refused "$majak" compare short.log --map hall --methods ,
refused "$majak" compare short.log --map hall --truth no_such.tum
refused "$majak" compare short.log --map hall --start 1,2
refused "$majak" compare short.log --map hall --set global.cell=0
refused "$majak" compare short.log --map hall -o short.log
grep -v '^FLASER' short.log >no_laser.log
refused "$majak" compare no_laser.log --map hall
refused "$majak" compare blind.log --map hall/map.yaml --methods dead-reckoning
awk '/^FLASER/ && n++ < 3' blind.log >three.log
ok "$majak" compare three.log --map hall -o three

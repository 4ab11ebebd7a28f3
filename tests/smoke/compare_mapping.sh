# SPDX-License-Identifier: Apache-2.0
# majak compare without a map, majak map --method: every method, the same table twice, clear refusals.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1

# Every method makes the same files.
methods=$("$majak" map --help | awk '/^Methods/ { on = 1; next } on && /^  [a-z]/ { print $1; next } on { exit }')
[ "$(echo "$methods" | wc -l)" -ge 3 ] || fail "no methods in the help: $methods"
for method in $methods; do
  ok "$majak" map short.log --method "$method" -o "m-$method"
  non_empty "m-$method"/{trajectory.tum,map.png,report.html,site.majak}
  [ "$(wc -l <"m-$method/trajectory.tum")" -eq "$(wc -l <m-graph-slam/trajectory.tum)" ] || fail "$method: other scans"
done
refused "$majak" map short.log --method magic
grep -q 'there are: graph-slam' err || fail "$(cat err)"

# In simulated places, and on a log; but for the times the same twice, on any number of threads.
few="--methods graph-slam,incremental-ml,multi-planar --only seeds,straight --seeds 2 --no-times"
ok "$majak" compare $few --threads 1 -o a
ok "$majak" compare $few --threads 2 -o b --options a/options.toml
for file in table2.html table2.md table2.json options.toml; do
  non_empty a/$file
  cmp -s a/$file b/$file || fail "$file differs: $(diff a/$file b/$file | head -5)"
done
ok "$majak" compare short.log --methods incremental-ml --only seeds,crowd --seeds 1
grep -q '^incremental-ml *1 of 1' out || fail "$(cat out)"
grep -q "Truth: the log's own" short-compare/table2.md || fail "$(cat short-compare/table2.md)"
awk '$1 != "TRUEPOS"' short.log >blind.log
ok "$majak" compare blind.log --methods incremental-ml --only seeds --seeds 1 -o blind
grep -q 'No truth is known' out || fail "$(cat out)"

refused "$majak" compare --only nothing
refused "$majak" compare --methods magic
refused "$majak" compare no_such.log
refused "$majak" compare short.log --truth no_such.tum
refused "$majak" compare short.log --relations no_such.relations
refused "$majak" compare --map hall

# SPDX-License-Identifier: Apache-2.0
# A run that is killed leaves no half-written file under its final name: each file is the old one,
# the new one, or absent.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
ok "$majak" map short.log -o whole
started=$(date +%s%N)
ok "$majak" map short.log -o whole
took_ms=$((($(date +%s%N) - started) / 1000000))

for tenth in 1 2 3 4 5 6 7 8 9 10; do
  "$majak" map short.log -o killed >/dev/null 2>&1 &
  pid=$!
  sleep "$(awk -v ms=$took_ms -v t=$tenth 'BEGIN { print ms * t / 10000 }')"
  kill -9 $pid 2>/dev/null
  wait $pid 2>/dev/null
  for file in trajectory.tum graph.g2o map.png map.pgm map.yaml options.toml; do
    [ ! -e "killed/$file" ] || cmp -s "whole/$file" "killed/$file" || fail "killed at $tenth/10: $file is half-written"
  done
  if [ -e killed/report.html ]; then tail -c 20 killed/report.html | grep -q '</html>' || fail "report.html is cut"; fi
  if [ -e killed/site.majak ] && [ -e killed/trajectory.tum ]; then ok "$majak" evaluate killed; fi
done
ok "$majak" map short.log -o killed
cmp -s whole/trajectory.tum killed/trajectory.tum || fail "the run after the killed ones differs"
[ -z "$(find killed -name '*.partial*')" ] || fail "temporary files of killed runs are left: $(ls -a killed)"

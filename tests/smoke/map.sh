# SPDX-License-Identifier: Apache-2.0
# From a log to a result folder, with and without odometry: all files, one pose a scan, near the truth.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
scans=$(grep -c '^FLASER' short.log)

for flag in "" --no-odometry; do
  # shellcheck disable=SC2086
  ok "$majak" map short.log -o "result$flag" $flag
  for file in $result_files; do non_empty "result$flag/$file"; done
  poses=$(grep -vc '^#' "result$flag/trajectory.tum")
  [ "$poses" -eq "$scans" ] || fail "$poses poses for $scans scans"
  [ -z "$(find "result$flag" -name '*.partial*' -o -name '.*.?*')" ] || fail "temporary files are left"
  ok "$majak" evaluate "result$flag" --truth in-log --json
  # The median: without odometry nothing tells of the way along a bare corridor (scans marked degraded).
  median=$(sed -n '/"ate"/,/"rotation_deg"/ s/.*"median": \([0-9.e-]*\).*/\1/p' out | head -n 1)
  awk -v m="$median" 'BEGIN { exit !(m > 0 && m < 0.05) }' || fail "median error of $median m $flag"
  ok "$majak" evaluate "result$flag"
done
# The log's own stamps, in the log's order.
awk '/^FLASER/ { printf "%.6f\n", $(NF - 2) }' short.log >stamps
awk '!/^#/ { print $1 }' result/trajectory.tum | cmp -s stamps - || fail "the stamps are not the log's"
# Four times the wheels and the robot do not agree.
ok "$majak" simulate building --short --seed 5 --set robot.bumps=2 --set robot.slips=2 -o bumped.log
ok "$majak" map bumped.log -o bumped
grep -q '4 slips and bumps' out || fail "$(cat out)"
grep -A 1 '"slips"' bumped/summary.json | grep -q '"count": 4' || fail "no slips in summary.json"
grep -q 'Slips and bumps' bumped/report.html || fail "no slips in the report"

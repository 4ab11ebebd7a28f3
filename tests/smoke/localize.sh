# SPDX-License-Identifier: Apache-2.0
# majak localize: all files, an ellipse that grows, options that can be fed back, clear refusals.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1

ok "$majak" localize short.log
non_empty short-localize/{trajectory.tum,covariance.csv,summary.json,options.toml,trajectory.svg,trajectory.png}
grep -q 'against the truth' out || fail "the log has truth, but no error is said"
lines=$(wc -l <short-localize/trajectory.tum)
[ "$lines" -gt 1000 ] || fail "$lines poses only"
[ "$(wc -l <short-localize/covariance.csv)" -eq $((lines + 1)) ] || fail "not one covariance a pose"
awk -F, 'NR > 1 { trace = $2 + $5 + $7; if (trace < last * (1 - 1e-6)) exit 1; last = trace }' \
  short-localize/covariance.csv || fail "the covariance shrank"

# Its own options give the same bytes again; another start moves the path.
ok "$majak" localize short.log -o again --options short-localize/options.toml
cmp -s again/trajectory.tum short-localize/trajectory.tum || fail "the same options, another path"
cmp -s again/trajectory.png short-localize/trajectory.png || fail "the same path, another picture"
ok "$majak" localize short.log -o moved --start "10,-5,90" --set dead_reckoning.never_shrink=false --json
grep -q '"translation_mean_m"' out || fail "no error in the JSON"
head -n 1 moved/trajectory.tum | grep -q ' 10.000000 -5.000000 ' || fail "the start is not where it was told"
ok "$majak" evaluate moved/trajectory.tum --truth short-localize/trajectory.tum
grep -q 'ATE root mean square  *0.0000 m' out || fail "moved rigidly, but: $(cat out)"

grep -v '^ODOM\|^FLASER' short.log >nothing.log
awk '/^FLASER/ && n++ < 1' short.log >one.log
ok "$majak" localize one.log -o one
refused "$majak" localize nothing.log
refused "$majak" localize no_such.log
refused "$majak" localize short.log --method guessing
refused "$majak" localize short.log --start 1,2
refused "$majak" localize short.log --start 1,2,x
refused "$majak" localize short.log --set dead_reckoning.wheels=1
refused "$majak" localize short.log -o short.log

# Beacons: reflectors along the way, found again in the scans.
awk '$1 == "TRUEPOS" && n++ % 60 == 30 {
  printf "%d %.2f %.2f\n", ++b, $2 - 0.7 * sin($4), $3 + 0.7 * cos($4) }' short.log >hall.txt
ok "$majak" simulate building --short --seed 3 --reflectors hall.txt -o reflectors.log
ok "$majak" localize reflectors.log --method kalman --beacons hall.txt -o beacons --json
grep -q '"beacon"' out || fail "no beacon was used"
mean=$(sed -n 's/.*"translation_mean_m": \([0-9.e-]*\).*/\1/p' out)
awk -v m="$mean" 'BEGIN { exit !(m > 0 && m < 0.05) }' || fail "$mean m off with beacons; 0.02 were seen"
ok "$majak" localize reflectors.log --method beacons --beacons hall.txt -o alone
ok "$majak" localize short.log --method kalman-laser -o laser
grep -q 'kalman-laser' out || fail "$(cat out)"
refused "$majak" localize reflectors.log --method beacons -o none
printf '1 0 0\n1 2 2\n' >twice.txt
refused "$majak" localize reflectors.log --method kalman --beacons twice.txt

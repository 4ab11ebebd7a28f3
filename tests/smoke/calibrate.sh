# SPDX-License-Identifier: Apache-2.0
# majak calibrate: faults found, a file that map and localize take, the square-path test, refusals.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
ok "$majak" simulate building --short --seed 5 --set robot.left_scale=0.99 --set robot.track_scale=1.02 -o wrong.log

ok "$majak" calibrate wrong.log --track 0.4 -o robot.toml --json
grep -q '"wheel_difference"' out || fail "no wheel difference in the JSON: $(head -c 500 out)"
non_empty robot.toml
ok "$majak" calibrate wrong.log
grep -q 'turn per metre' out || fail "$(cat out)"

# Dead reckoning errs less by it, and the map still comes out.
error() { sed -n 's/.*"translation_mean_m": \([0-9.e-]*\).*/\1/p' out; }
ok "$majak" localize wrong.log -o raw --json && raw=$(error)
ok "$majak" localize wrong.log -o mended --options robot.toml --json && mended=$(error)
awk -v a="$raw" -v b="$mended" 'BEGIN { exit !(b > 0 && 3 * b < a) }' || fail "$raw m raw, $mended m mended"
ok "$majak" map wrong.log --options robot.toml -o map

# A car: speed and steering in a recording, mapped and calibrated.
ok "$majak" simulate building --short --drive ackermann --seed 5 --set robot.steering_offset=0.02 -o car.mcap
refused "$majak" calibrate car.mcap
grep -q 'wheelbase' err || fail "the wheelbase is not asked for: $(cat err)"
ok "$majak" calibrate car.mcap --wheelbase 0.4 -o car.toml
grep -q 'steering' out || fail "$(cat out)"
ok "$majak" localize car.mcap -o car-raw --set odometry.wheelbase=0.4 --json && raw=$(error)
ok "$majak" localize car.mcap -o car-mended --options car.toml --json && mended=$(error)
awk -v a="$raw" -v b="$mended" 'BEGIN { exit !(b > 0 && 3 * b < a) }' || fail "$raw m raw, $mended m mended"
refused "$majak" simulate --drive cart

printf '# true end less odometry\nleft 0.16 -0.15\nright 0.04 0.05\nleft 0.17 -0.17\nright 0.03 0.03\n' >ends.txt
ok "$majak" calibrate ends.txt --square 4 --track 0.4 -o square.toml
grep -q 'systematic error' out || fail "$(cat out)"
ok "$majak" localize wrong.log -o by-square --options square.toml
refused "$majak" calibrate ends.txt --square 0
printf 'left 1 2\nup 3 4\n' >bad.txt
refused "$majak" calibrate bad.txt --square 4
grep -q 'bad.txt:2: ' err || fail "the line is not said: $(cat err)"
printf 'left 1 2\n' >one.txt
refused "$majak" calibrate one.txt --square 4
grep '^#\|^ODOM' wrong.log >none.log  # wheels, but no laser
refused "$majak" calibrate none.log
refused "$majak" calibrate no_such.log

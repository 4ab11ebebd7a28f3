# SPDX-License-Identifier: Apache-2.0
# majak evaluate on trajectories: figures with units, JSON that is complete, errors in one line.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
awk 'BEGIN { for (i = 0; i < 100; ++i) printf "%d.250000 %.3f 0 0 0 0 0 1\n", i, i * 0.5 }' >line.tum
awk 'BEGIN { for (i = 0; i < 100; ++i) printf "%d.250000 %.3f 0.3 0 0 0 0 1\n", i, i * 0.5 + 0.4 }' >moved.tum
awk 'BEGIN { for (i = 0; i < 100; ++i) printf "%d.250000 %.4f 0 0 0 0 0 1\n", i, i * 0.505 }' >stretched.tum
printf '1.250000 5.250000 2.0 0 0 0 0 0\n1.250000 61.250000 30.0 0 0 0 0 0\n' >line.relations

ok "$majak" evaluate line.tum --relations line.relations
grep -q 'all .* 2 .*0.0000 +- 0.0000 m' out || fail "a straight line against itself: $(cat out)"
ok "$majak" evaluate stretched.tum --relations line.relations --json --worst
grep -q '"better_frame": "robot"' out || fail "no frame in the JSON"
grep -A 3 '"loop"' out | grep -q '"translation_m"' || fail "no loop relations in the JSON"
ok "$majak" evaluate moved.tum --truth line.tum
grep -q 'ATE root mean square  *0.0000 m' out || fail "moved rigidly: $(cat out)"
ok "$majak" evaluate moved.tum --truth line.tum --align none
grep -q 'ATE root mean square  *0.5000 m' out || fail "moved by 0.3 and 0.4 m: $(cat out)"
ok "$majak" evaluate stretched.tum --truth line.tum
grep -q 'over 10 m (RPE) .* 0.1000 +- 0.0000 m' out || fail "1 % too long: $(cat out)"

: >empty
printf '5000 6000 1 0 0 0 0 0\n' >other.relations
refused "$majak" evaluate no_such.tum --truth line.tum
refused "$majak" evaluate empty --truth line.tum
refused "$majak" evaluate line.tum --truth empty
refused "$majak" evaluate line.tum --relations empty
refused "$majak" evaluate line.tum --relations other.relations
refused "$majak" evaluate line.tum --truth in-log
refused "$majak" evaluate line.tum
refused "$majak" evaluate . --truth in-log

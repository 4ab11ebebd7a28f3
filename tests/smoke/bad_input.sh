# SPDX-License-Identifier: Apache-2.0
# Files that are no logs, and logs that are damaged: a one-line error and exit code 1, or a result.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1

: >empty
head -c 100000 /dev/urandom >random
printf 'hello\nworld\n' >text
head -c 100000 /dev/zero >zeros
gzip -c short.log >whole.gz
head -c $(($(wc -c <whole.gz) / 2)) whole.gz >cut.gz
head -c 20 whole.gz >stub.gz
{ head -c 5000 whole.gz; head -c 5000 /dev/urandom; tail -c +10001 whole.gz; } >damaged.gz
head -c $(($(wc -c <short.log) / 2 + 17)) short.log >cut.log
grep -m 1 -v FLASER short.log >no_scan.log
{ grep -v FLASER short.log | head -n 5; grep -m 1 FLASER short.log; } >one_scan.log
grep -v '^ODOM' short.log | sed 's/^\(FLASER.*\)$/\1/' >no_odometry.log
awk '/^FLASER/ && ++n % 7 == 0 { $10 = "nan"; $11 = "inf"; $12 = "-3.5"; $13 = "x" } { print }' short.log >bad_ranges.log
awk '/^FLASER/ && ++n % 5 == 0 { $2 = 5000 } { print }' short.log >bad_count.log
awk '/^FLASER/ { ++n } /^FLASER/ && n % 6 == 0 { held = $0; next } { print } held { print held; held = "" }' short.log >unsorted.log
{ head -n 200 short.log; head -c 3000000 /dev/zero | tr '\0' '1'; echo; tail -n +201 short.log; } >long_line.log
sed 's/$/\r/' short.log >crlf.log
awk '/^(FLASER|ODOM)/ { t = sprintf("%.6f", 1e6 - ++n * 0.1); $(NF - 2) = t; $NF = t } { print }' short.log >backwards.log
awk '/^FLASER/ && ++n % 9 == 0 { for (i = $2 + 3; i < $2 + 9; ++i) $i = "1e300" } { print }' short.log >far_away.log
awk '/^FLASER/ && ++n % 2 { $(NF - 2) = $NF = n % 4 == 1 ? "9e9" : "-9e9" } { print }' short.log >wild_stamps.log
awk 'BEGIN { for (i = 0; i < 40000; ++i) r = r " 2.5" } /^FLASER/ && ++n % 4 == 0 { $2 = 40000; $3 = r " " $3 } { print }' short.log >many_beams.log
mkdir folder

hopeless="no_such_file empty random text zeros folder stub.gz no_scan.log"
damaged="cut.gz damaged.gz cut.log one_scan.log no_odometry.log bad_ranges.log bad_count.log unsorted.log long_line.log crlf.log backwards.log far_away.log wild_stamps.log many_beams.log"

for file in $hopeless; do
  refused "$majak" info "$file"
  grep -q "$file" err || fail "info does not name $file: $(cat err)"
  refused "$majak" map "$file" -o result
  grep -q "$file" err || fail "map does not name $file: $(cat err)"
  [ ! -e result/trajectory.tum ] || fail "map of $file left a trajectory"
done

for file in $damaged; do
  refused_or_survived "$majak" info "$file"
  rm -rf result
  refused_or_survived "$majak" map "$file" -o result
  if [ -e result/summary.json ]; then for name in $result_files; do non_empty "result/$name"; done; fi
done

# The half that could be unpacked is read, and what was lost is said.
ok "$majak" info cut.gz
grep -qiE 'end|cut|trunc|damage' out || fail "info does not say that cut.gz ends early: $(cat out)"
ok "$majak" info long_line.log
ok "$majak" info crlf.log

# What may not be read or written; root may, so another user tries.
other=
if [ "$(id -u)" -eq 0 ]; then
  other="setpriv --reuid=65534 --regid=65534 --clear-groups"
  chmod 755 "$work"
  $other "$majak" --help >/dev/null 2>&1 || skip "needs the right to run majak as another user"
fi
cp short.log locked.log && chmod 000 locked.log
refused $other "$majak" info locked.log
mkdir no_way_in && cp short.log no_way_in && chmod 000 no_way_in
refused $other "$majak" info no_way_in
refused $other "$majak" map no_way_in/short.log -o result
chmod 644 short.log
mkdir locked && chmod 555 locked
refused $other "$majak" map short.log -o locked/result
mkdir -m 555 locked/result 2>/dev/null || { chmod 755 locked && mkdir -m 555 locked/result; }
refused $other "$majak" map short.log -o locked/result
[ -z "$(ls -A locked/result)" ] || fail "something was written into a folder without the right to"

# SPDX-License-Identifier: Apache-2.0
# majak simulate: every world gives a log that majak info can read; one seed gives the same bytes.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
for world in building ring corridor; do
  ok "$majak" simulate $world --short -o $world.log
  non_empty $world.log
  ok "$majak" info $world.log
  non_empty out
done
ok "$majak" simulate ring --short --seed 5 -o a.log
ok "$majak" simulate ring --short --seed 5 -o b.log
ok "$majak" simulate ring --short --seed 6 -o c.log
cmp -s a.log b.log || fail "one seed, two logs"
cmp -s a.log c.log && fail "two seeds, one log"
refused "$majak" simulate no_such_world -o d.log
[ ! -e d.log ] || fail "a log of no world"
ok "$majak" info a.log --json
non_empty out
# Reflectors shine in the log; a map of them that is none is refused, with the line.
printf '1 4 0.1\n2 9 2.0 door\n' >r.txt
ok "$majak" simulate ring --short --reflectors r.txt -o r.log
grep -q '^ROBOTLASER1 ' r.log || fail "no remissions in the log"
ok "$majak" info r.log
grep -q intensities out || fail "info says nothing of intensities: $(cat out)"
printf '1 4 0.1\n1 9 2\n' >twice.txt
refused "$majak" simulate ring --reflectors twice.txt -o twice.log
grep -q 'twice.txt:2:' err || fail "the error does not name the line: $(cat err)"
[ ! -e twice.log ] || fail "a log of no reflectors"
# A car in the park: its fixes come back from the recording, and the trunks are told.
ok "$majak" simulate park --short --satellites --landmarks trunks.txt --set simulate.felled=0.2 \
  --set simulate.felled_at=10 --vehicles 3 --people 3
[ "$(grep -c -v '^#' trunks.txt)" -gt 150 ] || fail "hardly a trunk: $(head -3 trunks.txt)"
grep -q '# gone from 10 s' trunks.txt || fail "none is felled"
ok "$majak" info park.mcap
grep -q 'GPS' out || fail "no fixes in the recording: $(cat out)"
grep -q 'every record was read' out || fail "something was not read: $(cat out)"
refused "$majak" simulate park --short --satellites -o park.log
grep -q 'mcap' err || fail "the error does not say what to do: $(cat err)"
[ ! -e park.log ] || fail "a log without its fixes"

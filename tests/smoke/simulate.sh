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

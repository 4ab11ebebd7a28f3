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

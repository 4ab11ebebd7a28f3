#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# majak view as its page meets it: the stream, corrections that outlive a killed program, a robot that is carried away, work
# that is watched.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
refused "$majak" view nothing-here
simulate
ok "$majak" map short.log -o run
"$majak" view run >refusal 2>&1 &
sleep 1
kill $! 2>/dev/null
grep -q "built without its viewer" refusal && skip "the viewer was not built"
command -v node >/dev/null && [ -d "$root/viewer/node_modules/ws" ] || skip "node or the viewer's packages are missing"
ok node "$root/tests/smoke/view_check.mjs" "$majak" "$root"
cat out
# What was corrected on the page is in the exports.
ok "$majak" edit run --list
grep -q wall out || fail "the wall is not listed"
ok "$majak" export run svg -o run.svg

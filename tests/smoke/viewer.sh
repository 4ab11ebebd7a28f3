#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The page itself: its types, its readers of the stream, then everything on it in a browser, served by the program, and where
# something has to go wrong by a server that only the tests have.
. "$(dirname "$0")/lib.sh"
command -v node >/dev/null && [ -d "$root/viewer/node_modules/playwright-core" ] || skip "node or the viewer's packages are missing"
browser=${CHROMIUM:-/usr/bin/chromium}
[ -x "$browser" ] || skip "chromium is missing"
cd "$root/viewer" || exit 1
ok node build.mjs --tests --all
ok node node_modules/typescript/bin/tsc --noEmit
ok node --test build/test/*.test.js

cd "$work" || exit 1
ok "$majak" simulate building --short --seed 3 -o short.log
ok "$majak" map short.log -o run
"$majak" view run >said 2>&1 &
program=$!
trap 'kill $program 2>/dev/null; rm -rf "$work"' EXIT
for _ in $(seq 100); do grep -q "http:" said && break; sleep 0.1; done
cd "$root/viewer" || exit 1
node --test-reporter=spec build/e2e/run.js "$(grep -o 'http://[^ ]*' "$work/said")" >"$work/browser" 2>&1 || {
  grep -v "^✔" "$work/browser" | tail -60
  fail "the page in a browser"
}
grep -E "^ℹ (tests|pass)" "$work/browser"

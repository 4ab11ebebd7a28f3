# SPDX-License-Identifier: Apache-2.0
# The layers and the house rules hold, and their checks can tell when they do not.
. "$(dirname "$0")/lib.sh"

"$root/tools/check_layers" "$root" || fail "layers"
"$root/tools/check_house" "$root" || fail "house rules"

mkdir -p "$work/majak/core" "$work/majak/io" "$work/majak/odd"
cd "$work" || exit 1
licence='// SPDX-License-Identifier: Apache-2.0'
printf '%s\n#pragma once\n' "$licence" >majak/core/fine.hpp
printf '%s\n#include "majak/core/fine.hpp"\n' "$licence" >majak/io/fine.cpp
rmdir majak/odd
"$root/tools/check_layers" . >out || fail "a fine tree is refused: $(cat out)"
"$root/tools/check_house" . >out || fail "a fine tree is refused: $(cat out)"

expect() {  # expect TOOL FILE TEXT LINE...: the tool refuses the file made of these lines
  local tool=$1 file=$2 text=$3
  shift 3
  printf '%s\n' "$@" >"$file"
  if "$root/tools/$tool" . >out; then fail "$tool accepts: $*"; fi
  grep -q "$text" out || fail "$tool of '$*' says: $(cat out)"
  rm "$file"
}
expect check_layers majak/core/a.hpp 'core includes io' '#include "majak/io/x.hpp"'
expect check_layers majak/core/a.hpp 'is no layer' '#include "majak/nowhere/x.hpp"'
expect check_layers majak/core/a.hpp 'majak/<layer>' '#include "fine.hpp"'
expect check_layers majak/io/a.hpp 'majak/<layer>' '#include "app/commands.hpp"'
mkdir majak/odd
expect check_layers majak/odd/a.hpp 'no layer of this name' ''
rmdir majak/odd
expect check_house majak/core/a.cpp 'SPDX' 'int x;'
expect check_house majak/core/a.hpp 'pragma once' "$licence" 'int x;'
expect check_house majak/core/a.cpp 'does not print' "$licence" 'void f() { std::cout << 1; }'
expect check_house majak/core/a.cpp 'does not exit' "$licence" 'void f() { std::exit(1); }'
expect check_house majak/core/a.cpp 'no clock' "$licence" 'auto t = std::chrono::steady_clock::now();'
expect check_house majak/core/a.cpp 'angle_diff' "$licence" 'double d = a.theta - b.theta;'
mkdir docs tests
printf '%s\nTEST(Pose, Turns) {}\n' "$licence" >tests/pose_test.cpp
echo '`Pose.Turns`' >docs/COVERAGE.md
"$root/tools/check_house" . >out || fail "a test that exists is refused: $(cat out)"
expect check_house docs/COVERAGE.md 'Pose.Jumps' '`Pose.Jumps`'

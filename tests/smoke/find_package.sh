# SPDX-License-Identifier: Apache-2.0
# Another project finds the installed library by find_package(majak), links it and runs.
#   find_package.sh MAJAK ROOT BUILD-FOLDER
. "$(dirname "$0")/lib.sh"
build=$3
ok cmake --install "$build" --prefix "$work/prefix"
"$work/prefix/bin/majak" --help >/dev/null || fail "the installed program does not run"
non_empty "$work/prefix/include/majak/core/pose2.hpp"
ok cmake -S "$root/tests/consumer" -B "$work/consumer" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" \
  ${CMAKE_CXX_FLAGS:+-DCMAKE_CXX_FLAGS="$CMAKE_CXX_FLAGS"}
ok cmake --build "$work/consumer"
ok "$work/consumer/consumer"
grep -qx '0.5000' "$work/out" || fail "the consumer says $(cat "$work/out")"

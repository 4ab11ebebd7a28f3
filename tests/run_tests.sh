# SPDX-License-Identifier: Apache-2.0
# One process for all tests of a layer, so that what tests share is computed once.
#   run_tests.sh PROGRAM LAYER    of LAYER.Suite.Name only those that match MAJAK_TEST_FILTER, if set
set -eu
program=$1
layer=$2
[ -n "${MAJAK_TEST_FILTER:-}" ] || exec "$program"
chosen=$("$program" --gtest_list_tests | awk -v layer="$layer" '
  /^[^ ].*\.( |$)/ { suite = $1; next }
  /^  / { print layer "." suite $1 }' | { grep -E -- "$MAJAK_TEST_FILTER" || true; } | sed "s/^$layer\.//" | paste -sd:)
[ -z "$chosen" ] || exec "$program" --gtest_filter="$chosen"

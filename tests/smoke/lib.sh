# SPDX-License-Identifier: Apache-2.0
# Shared by the smoke tests: each is called as `bash NAME.sh PATH-TO-MAJAK SOURCE-ROOT` and fails with
# the first expectation that does not hold. `skip REASON` leaves the test out, visibly.
set -u
majak=$1
root=$2
work=$(mktemp -d)
trap 'chmod -R u+rwx "$work"; rm -rf "$work"' EXIT

fail() { echo "FAILED: $*"; exit 1; }
skip() { echo "skipped: $*"; exit 77; }

# ok COMMAND...: exit code 0. What it said is in $work/out and $work/err.
ok() {
  "$@" >"$work/out" 2>"$work/err" || fail "exit code $? of: $* -- $(head -c 2000 "$work/err")"
}

# refused COMMAND...: exit code 1, and one line that begins with the program's name.
refused() {
  local code=0
  "$@" >"$work/out" 2>"$work/err" || code=$?
  [ $code -eq 1 ] || fail "exit code $code instead of 1 of: $* -- $(head -c 2000 "$work/err")"
  one_line_error "$*"
}

one_line_error() {
  [ "$(wc -l <"$work/err")" -eq 1 ] || fail "not one line of error but: $(head -c 2000 "$work/err") -- of: $1"
  grep -q '^majak: .' "$work/err" || fail "an error that does not begin with majak: $(cat "$work/err")"
}

# refused_or_survived COMMAND...: damaged input may be refused like that, or survived with exit code 0.
refused_or_survived() {
  local code=0
  "$@" >"$work/out" 2>"$work/err" || code=$?
  case $code in
    0) ;;
    1) one_line_error "$*" ;;
    *) fail "exit code $code of: $* -- $(head -c 2000 "$work/err")" ;;
  esac
}

non_empty() {
  local file
  for file in "$@"; do [ -s "$file" ] || fail "$file is missing or empty"; done
}

# The files of a result folder that scripts rely on.
result_files="trajectory.tum graph.g2o map.png map.pgm map.yaml options.toml summary.json report.html site.majak"

# A short simulated log, made once a script.
simulate() {
  [ -s "$work/short.log" ] || ok "$majak" simulate building --short --seed 3 -o "$work/short.log"
}

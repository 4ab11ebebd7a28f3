# SPDX-License-Identifier: Apache-2.0
# Every subcommand explains itself; what is no subcommand or no option is refused.
. "$(dirname "$0")/lib.sh"

ok "$majak" --help
grep -q evaluate "$work/out" || fail "--help does not list evaluate"
commands=$("$majak" --help | sed -n '/^Subcommands:/,$ s/^  \([a-z]\+\) .*/\1/p')
[ -n "$commands" ] || fail "no subcommands in --help"
for command in $commands; do
  ok "$majak" "$command" --help
  grep -q "majak $command" "$work/out" || fail "$command --help has no example"
  refused "$majak" "$command" --no-such-option
done
for arguments in "" "nosuchcommand" "--no-such-option"; do
  # shellcheck disable=SC2086
  refused "$majak" $arguments
done

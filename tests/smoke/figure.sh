# SPDX-License-Identifier: Apache-2.0
# majak figure: every figure that is listed is drawn, as SVG and as PNG, twice with equal bytes.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1

ok "$majak" figure
numbers=$(sed -n 's/^ *\([0-9]\+[a-z]\?\)  .*/\1/p' out)
[ -n "$numbers" ] || fail "no figures are listed"
for n in $numbers; do
  ok "$majak" figure "$n" -o a
  ok "$majak" figure "$n" -o b
  non_empty a/figure"$n".svg a/figure"$n".png
  head -c 8 a/figure"$n".png | cmp -s - <(printf '\x89PNG\r\n\x1a\n') || fail "figure $n: no PNG"
  tail -n 1 a/figure"$n".svg | grep -q '</svg>' || fail "figure $n: the SVG is not whole"
  for file in figure"$n".svg figure"$n".png; do cmp -s a/$file b/$file || fail "$file: two runs, two files"; done
done
ok "$majak" figure 5 short.log -o log
non_empty log/figure5.svg log/figure5.png
refused "$majak" figure 2 short.log
refused "$majak" figure 999
refused "$majak" figure 5 no_such.log
refused "$majak" figure x

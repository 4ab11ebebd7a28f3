# SPDX-License-Identifier: Apache-2.0
# majak label, majak route and the exports of rooms; names stay when a run is mapped anew.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
ok "$majak" map short.log -o hall

ok "$majak" label hall
grep -q '^corridor 1' out || fail "$(cat out)"
room=$(grep -m1 -o 'room .* at [-0-9.]*,[-0-9.]*' out | sed 's/.* at //')
ok "$majak" label hall -- "$room" kitchen
ok "$majak" label hall
grep -q '^kitchen' out || fail "no kitchen: $(cat out)"
ok "$majak" map short.log -o hall --set grid.resolution=0.05
ok "$majak" label hall
grep -q '^kitchen' out || fail "no kitchen any more: $(cat out)"
for format in graphml json; do
  ok "$majak" export hall $format
  non_empty hall.$format
  grep -q kitchen hall.$format || fail "$format without names"
done
ok "$majak" route hall --from kitchen --to "corridor 1" -o way
grep -q '^[0-9.]* m, at the narrowest' out || fail "$(cat out)"
non_empty way/route.png
ok "$majak" label hall --remove kitchen

refused "$majak" label hall 900,900 moon
refused "$majak" label hall -- "$room"
refused "$majak" label hall --remove kitchen
refused "$majak" route hall --from nowhere --to "corridor 1"
refused "$majak" route hall --from 900,900 --to "corridor 1"
echo '{' >hall/labels.json
refused "$majak" label hall

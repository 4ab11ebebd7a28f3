# SPDX-License-Identifier: Apache-2.0
# majak export as solids: twice the same, and as other people's programs see them. These are not
# needed to build or test majak; they are asked where they have been installed by
#   npm install --prefix ~/.cache/majak three@0.187 gltf-validator@2.0.0-dev.3.10
# ($MAJAK_NPM names another place).
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
ok "$majak" map short.log -o hall
for format in wrl glb ply; do
  ok "$majak" export hall $format
  non_empty hall.$format
  ok "$majak" export hall $format -o again.$format
  cmp -s hall.$format again.$format || fail "another $format"
done
ok "$majak" export hall ply --set raise.height=3 --set raise.floor=false -o bare.ply
[ "$(wc -c <bare.ply)" -lt "$(wc -c <hall.ply)" ] || fail "a solid without floor is as large"
refused "$majak" export hall glb --set raise.height=0

place=${MAJAK_NPM:-$HOME/.cache/majak}
[ -d "$place/node_modules/three" ] && [ -d "$place/node_modules/gltf-validator" ] && command -v node >/dev/null ||
  skip "no three and gltf-validator in $place"
ok node "$root/tests/smoke/solid_check.mjs" "$place" hall.glb hall.wrl hall.ply
cat out

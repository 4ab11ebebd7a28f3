# SPDX-License-Identifier: Apache-2.0
# Solids as other people's programs see them: Khronos' validator of glTF, three.js' loaders of VRML and
# PLY. `./dev test` installs them where there is npm:
#   npm install --prefix ~/.cache/majak three@0.187 gltf-validator@2.0.0-dev.3.10
# ($MAJAK_NPM names another place).
. "$(dirname "$0")/lib.sh"
place=${MAJAK_NPM:-$HOME/.cache/majak}
[ -d "$place/node_modules/three" ] && [ -d "$place/node_modules/gltf-validator" ] && command -v node >/dev/null ||
  skip "no three and gltf-validator in $place"
cd "$work" || exit 1
ok "$majak" simulate solid_yard --second down --nod 15 --tilt tilt.txt -o yard.log
ok "$majak" map yard.log -o yard
ok "$majak" faces yard walls-3d solid elevation --log yard.log --look down --tilt tilt.txt
for solid in walls solid elevation; do
  for format in glb wrl ply; do non_empty yard-faces/$solid.$format; done
  ok node "$root/tests/smoke/solid_check.mjs" "$place" yard-faces/$solid.glb yard-faces/$solid.wrl yard-faces/$solid.ply
  cat out
done

# SPDX-License-Identifier: Apache-2.0
# majak export as solids: twice the same; what a second laser out of the plane saw.
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
refused "$majak" export hall glb --log short.log
refused "$majak" export hall glb --log no_such.log
refused "$majak" faces hall solid

# A second laser that stands upright, then one that nods.
ok "$majak" simulate solid_rooms --second up -o rooms.log
[ "$(grep -c '^RLASER' rooms.log)" -eq "$(grep -c '^FLASER' rooms.log)" ] || fail "not as many scans of both lasers"
ok "$majak" map rooms.log -o rooms
ok "$majak" faces rooms solid walls-3d elevation --log rooms.log --look up
non_empty rooms-faces/solid.glb rooms-faces/solid.png rooms-faces/points.ply rooms-faces/walls.wrl rooms-faces/elevation.ply
ok "$majak" faces rooms solid --log rooms.log --threads 1 -o one
cmp -s one/solid.glb rooms-faces/solid.glb || fail "another solid with one thread"
ok "$majak" export rooms glb --log rooms.log
cmp -s rooms.glb rooms-faces/solid.glb || fail "export and face differ"
refused "$majak" faces rooms solid --log rooms.log --look back
refused "$majak" faces rooms solid --log rooms.log --set mounting.laser=3
ok "$majak" simulate solid_yard --second down --nod 15 --tilt tilt.txt -o yard.log
ok "$majak" map yard.log -o yard
ok "$majak" faces yard elevation --log yard.log --look down --tilt tilt.txt
non_empty yard-faces/elevation.png yard-faces/elevation.glb
echo "no numbers" >bad.txt
refused "$majak" faces yard elevation --log yard.log --look down --tilt bad.txt

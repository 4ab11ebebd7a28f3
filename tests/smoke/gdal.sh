# SPDX-License-Identifier: Apache-2.0
# What majak exports opens in GDAL: every wall is there, in its place.
. "$(dirname "$0")/lib.sh"
command -v ogrinfo >/dev/null && command -v gdalinfo >/dev/null || skip "no GDAL here (apt-get install gdal-bin)"
simulate
cd "$work" || exit 1
ok "$majak" map short.log -o hall
ok "$majak" export hall dxf
walls=$(grep -c '^LINE' hall.dxf)

# extent FILE: the corners of all that is in it, as GDAL sees them, to the centimetre.
extent() { sed -n 's/^Extent: //p' "$1" | grep -o -- '-\?[0-9]*\.[0-9]*' | awk '{ printf "%.2f ", $1 }'; }

ok ogrinfo -q -al -so hall.dxf
ok ogrinfo -al -so hall.dxf entities
grep -q "Feature Count: $walls" out || fail "GDAL sees another number of lines than $walls in hall.dxf: $(grep Count out)"
of_dxf=$(extent out)
[ -n "$of_dxf" ] || fail "no extent: $(cat out)"
ok "$majak" export hall geojson
ok ogrinfo -al -so hall.geojson
grep -q "Feature Count: $walls" out || fail "hall.geojson: $(grep Count out)"
[ "$(extent out)" = "$of_dxf" ] || fail "hall.geojson lies elsewhere: $(extent out), not $of_dxf"
grep -q "sigma_offset: Real" out || fail "no sigma of walls: $(cat out)"
ok "$majak" export hall wkt
printf 'id,WKT\n1,"%s"\n' "$(cat hall.wkt)" >wkt.csv
ok ogrinfo -al -so wkt.csv
[ "$(extent out)" = "$of_dxf" ] || fail "hall.wkt lies elsewhere: $(extent out), not $of_dxf"
ok gdalinfo hall/map.pgm
grep -q "Size is [0-9]*, [0-9]*" out || fail "map.pgm: $(cat out)"

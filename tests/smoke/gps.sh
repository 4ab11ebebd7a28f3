# SPDX-License-Identifier: Apache-2.0
# What a satellite receiver says: a log of its own, and beside another one.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
cat >track.nmea <<'TEXT'
$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A
$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47
$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*48
$GPGSA,A,3,04,05,,09,12,,,24,,,,,2.5,1.3,2.1*39
noise
TEXT
ok "$majak" info track.nmea
grep -q 'NMEA log' out || fail "not taken for an NMEA log: $(cat out)"
grep -q 'wrong checksum' out || fail "the wrong checksum is not told: $(cat out)"
gzip -c track.nmea >track.gz
ok "$majak" info track.gz
ok "$majak" simulate ring --short -o ring.log
ok "$majak" info ring.log --gps track.nmea
grep -q GPS out || fail "no fixes beside the log: $(cat out)"
refused "$majak" info ring.log --gps no_such_file
grep -q no_such_file err || fail "the error does not name the file: $(cat err)"

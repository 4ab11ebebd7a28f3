# SPDX-License-Identifier: Apache-2.0
# A laser that is not there, as a user would work with one: recorded, mapped live, cut off by a kill.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1

emulate() {  # emulate OPTIONS...: in the background, until $emulator is killed
  "$majak" emulate --boot "${boot:-0}" "$@" >port 2>&1 &
  emulator=$!
  for _ in $(seq 50); do [ -s port ] && break; sleep 0.1; done
  if grep -q "no pseudo-terminal" port; then skip "this machine has no pseudo-terminals"; fi
  [ -s port ] && return
  fail "majak emulate does not begin"
}
scans() { "$majak" info "$1" | awk '/^  records/ { print $2 + 0; exit }'; }
beams() { "$majak" info "$1" | awk '/^  beams x step/ { print $(NF - 3); exit }'; }

emulate --link laser --set fault.pollution=true
trap 'kill $emulator 2>/dev/null; rm -rf "$work"' EXIT

# Mapped live and kept: the recording gives the same bytes.
ok "$majak" map laser --baud 500000 --resolution 180/0.5 --duration 5 --record live.mcap -o live
grep -q "the front window is dirty" out || fail "nothing is said of a dirty window"
ok "$majak" map live.mcap -o again
[ "$(scans live.mcap)" -gt 60 ] || fail "only $(scans live.mcap) scans came"
cmp live/trajectory.tum again/trajectory.tum || fail "the recording maps otherwise than the device did"

# On a terminal it says what the device does and how many scans have come.
if command -v script >/dev/null; then
  for command in "record laser -o shown.mcap" "map laser -o shown"; do
    script -qec "'$majak' $command --duration 4" shown.txt >/dev/null || fail "majak $command: $(cat shown.txt)"
    grep -q "receiving scans at [0-9]* baud: [0-9]* scans" shown.txt || fail "no progress of majak $command"
  done
fi

# Killed in the middle: what came until then opens.
"$majak" record laser -o killed.mcap >/dev/null 2>&1 &
recorder=$!
sleep 5
kill -9 $recorder
wait $recorder 2>/dev/null
[ "$(scans killed.mcap)" -gt 60 ] || fail "a killed recording has $(scans killed.mcap) scans"

# Turn by turn, and turns put together to a resolution that no device sends in one piece.
ok "$majak" record laser -o turns.mcap --duration 3 --interlaced --resolution 180/0.5 --baud 500000
[ "$(beams turns.mcap)" = 181 ] || fail "a turn has $(beams turns.mcap) beams"
ok "$majak" record laser -o merged.mcap --duration 4 --merge-turns --resolution 180/0.25
[ "$(beams merged.mcap)" = 721 ] || fail "four turns have $(beams merged.mcap) beams"
[ "$(scans merged.mcap)" -gt 20 ] || fail "only $(scans merged.mcap) scans were put together"
refused "$majak" record laser --merge-turns --baud 38400
refused "$majak" record laser --resolution 180/0.25

# Other formats, and back.
ok "$majak" convert live.mcap live.log
ok "$majak" convert live.log live2.mcap
[ "$(scans live2.mcap)" = "$(scans live.mcap)" ] || fail "converting loses scans"

kill $emulator
wait $emulator
refused "$majak" record laser

# Nothing answers.
boot=100 emulate --link laser
refused "$majak" map laser --duration 1 -o nothing
grep -q "no scan came" err || fail "of a device that says nothing: $(cat err)"
kill $emulator
wait $emulator

# A newer one, on the network; and the first one's recording in place of a world.
emulate live.mcap --tcp 0
ok "$majak" record "$(cat port)" -o network.mcap --duration 3
[ "$(scans network.mcap)" -gt 20 ] || fail "only $(scans network.mcap) scans came over the network"
"$majak" info network.mcap | grep -q "20.00 m and more is no return" || fail "an LMS1xx sees 20 m"
ok "$majak" record "$(cat port)" -o near.mcap --duration 1 --max-range 3
"$majak" info near.mcap | grep -q "3.00 m and more is no return" || fail "--max-range does nothing"
kill $emulator
wait $emulator
exit 0

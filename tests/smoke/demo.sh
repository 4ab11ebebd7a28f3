# SPDX-License-Identifier: Apache-2.0
# majak demo thesis: on a recording, twice the same but for the times; clear refusals.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
ok "$majak" simulate park --short --satellites --beams 361 --set satellites.outage=8 --seed 2 --landmarks trunks.txt -o park.mcap

ok "$majak" demo thesis park.mcap --cut-off 20
non_empty park-demo/{report.html,demonstration.png,demonstration.svg,trajectory.tum,landmarks.csv,options.toml}
grep -q 'with all satellites' out || fail "no score of the whole: $(cat out)"
grep -q 'report.html' out || fail "nothing is named to open"
ok "$majak" demo thesis park.mcap --cut-off 20 --landmarks trunks.txt --options park-demo/options.toml -o again
grep -q "against the true trunks" out || fail "no error of the trunks: $(cat out)"
for file in trajectory.tum landmarks.csv options.toml; do
  cmp -s park-demo/$file again/$file || fail "another $file"
done

refused "$majak" demo thesis no_such.log
refused "$majak" demo opera park.mcap
refused "$majak" demo thesis park.mcap --antenna 1
refused "$majak" demo thesis park.mcap --landmarks park-demo/options.toml
refused "$majak" demo thesis park.mcap --landmarks no_such.txt
refused "$majak" demo thesis park.mcap --set ekf_slam.near=0
ok "$majak" simulate building --short --seed 3 -o hall.log
awk '$1 != "TRUEPOS"' hall.log >blind.log
refused "$majak" demo thesis blind.log
grep -q 'fixes' err || fail "it does not say what is missing: $(cat err)"

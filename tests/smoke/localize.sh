# SPDX-License-Identifier: Apache-2.0
# majak localize: all files, an ellipse that grows, options that can be fed back, clear refusals.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1

ok "$majak" localize short.log
non_empty short-localize/{trajectory.tum,covariance.csv,summary.json,options.toml,trajectory.svg,trajectory.png}
grep -q 'against the truth' out || fail "the log has truth, but no error is said"
lines=$(wc -l <short-localize/trajectory.tum)
[ "$lines" -gt 1000 ] || fail "$lines poses only"
[ "$(wc -l <short-localize/covariance.csv)" -eq $((lines + 1)) ] || fail "not one covariance a pose"
awk -F, 'NR > 1 { trace = $2 + $5 + $7; if (trace < last * (1 - 1e-6)) exit 1; last = trace }' \
  short-localize/covariance.csv || fail "the covariance shrank"

# Its own options give the same bytes again; another start moves the path.
ok "$majak" localize short.log -o again --options short-localize/options.toml
cmp -s again/trajectory.tum short-localize/trajectory.tum || fail "the same options, another path"
cmp -s again/trajectory.png short-localize/trajectory.png || fail "the same path, another picture"
ok "$majak" localize short.log -o moved --start "10,-5,90" --set dead_reckoning.never_shrink=false --json
grep -q '"translation_mean_m"' out || fail "no error in the JSON"
head -n 1 moved/trajectory.tum | grep -q ' 10.000000 -5.000000 ' || fail "the start is not where it was told"
ok "$majak" evaluate moved/trajectory.tum --truth short-localize/trajectory.tum
grep -q 'ATE root mean square  *0.0000 m' out || fail "moved rigidly, but: $(cat out)"

grep -v '^ODOM\|^FLASER' short.log >nothing.log
awk '/^FLASER/ && n++ < 1' short.log >one.log
ok "$majak" localize one.log -o one
refused "$majak" localize nothing.log
refused "$majak" localize no_such.log
refused "$majak" localize short.log --method guessing
refused "$majak" localize short.log --start 1,2
refused "$majak" localize short.log --start 1,2,x
refused "$majak" localize short.log --set dead_reckoning.wheels=1
refused "$majak" localize short.log -o short.log

# Beacons: reflectors along the way, found again in the scans.
awk '$1 == "TRUEPOS" && n++ % 60 == 30 {
  printf "%d %.2f %.2f\n", ++b, $2 - 0.7 * sin($4), $3 + 0.7 * cos($4) }' short.log >hall.txt
ok "$majak" simulate building --short --seed 3 --reflectors hall.txt -o reflectors.log
ok "$majak" localize reflectors.log --method kalman --beacons hall.txt -o beacons --json
grep -q '"beacon"' out || fail "no beacon was used"
mean=$(sed -n 's/.*"translation_mean_m": \([0-9.e-]*\).*/\1/p' out)
awk -v m="$mean" 'BEGIN { exit !(m > 0 && m < 0.05) }' || fail "$mean m off with beacons; 0.02 were seen"
ok "$majak" localize reflectors.log --method beacons --beacons hall.txt -o alone
ok "$majak" localize short.log --method kalman-laser -o laser
grep -q 'kalman-laser' out || fail "$(cat out)"
refused "$majak" localize reflectors.log --method beacons -o none
printf '1 0 0\n1 2 2\n' >twice.txt
refused "$majak" localize reflectors.log --method kalman --beacons twice.txt

# ---- On known maps -----------------------------------------------------------------------------------

# near FOLDER MOST: the median way off the run's own poses, m, where it did not say that it is lost.
near() {
  awk -F'[ ,]' -v most="$2" '
    FILENAME ~ /hall/ { x[$1] = $2; y[$1] = $3; next }
    FILENAME ~ /covariance/ { health[$1] = $NF; next }
    ($1 in x) && health[$1] != "lost" { off[n++] = sqrt(($2 - x[$1])^2 + ($3 - y[$1])^2) }
    END { for (i = 0; i < n; ++i) far += off[i] > most; exit !(n > 1000 && far < n / 2) }' \
    hall/trajectory.tum "$1/covariance.csv" "$1/trajectory.tum" ||
    fail "$1: more than half of the poses are $2 m off, or few are sure"
}
awk '$1 != "TRUEPOS"' short.log >blind.log
ok "$majak" map blind.log -o hall

# Every kind of map, by the method that finds the place by itself.
for map in hall hall/site.majak hall/map.yaml; do
  ok "$majak" localize blind.log --map $map -o on_map
  non_empty on_map/{trajectory.tum,covariance.csv,summary.json,options.toml,trajectory.svg,trajectory.png}
  grep -q '^global: ' out && grep -q 'found after' out || fail "$map: $(cat out)"
  near on_map 0.1
  rm -r on_map
done
# A bare picture begins at its corner; the YAML tells where that is.
cp hall/map.png plan.png
ok "$majak" localize blind.log --map plan.png --map-resolution 0.05 -o picture
origin=$(sed -n 's/^origin: \[\([^]]*\)\]/\1/p' hall/map.yaml)
awk -v o="$origin" '{ split(o, at, ","); $2 += at[1]; $3 += at[2]; print }' picture/trajectory.tum >moved.tum
mv moved.tum picture/trajectory.tum
near picture 0.1

# Every method; those that must be told are.
for method in global tracking monte-carlo markov; do
  ok "$majak" localize blind.log --map hall --method $method -o $method --start 0,0,0 --json
  non_empty $method/{trajectory.tum,covariance.csv,summary.json,options.toml,trajectory.png}
  [ "$(wc -l <$method/trajectory.tum)" -eq "$(wc -l <hall/trajectory.tum)" ] || fail "$method: not one pose a scan"
  near $method 0.1
done
head -n 1 monte-carlo/hypotheses.csv | grep -q '^time,probability,x,y,theta$' || fail "no hypotheses"
ok "$majak" localize blind.log --map hall -o fed_back --options global/options.toml
cmp -s fed_back/trajectory.tum global/trajectory.tum || fail "the same options, another path"
grep -q '^\[global\]' global/options.toml || fail "the options of global search are missing"

# Maps that nobody can be on, and things that are no map: one line each.
pgm() { printf 'P2\n20 20\n255\n'; for _ in $(seq 400); do echo "$1"; done; }
pgm 205 >unknown.pgm
pgm 254 >no_wall.pgm
pgm 0 >no_floor.pgm
for name in unknown no_wall no_floor; do
  refused "$majak" localize blind.log --map $name.pgm --map-resolution 0.05
  grep -q "$name.pgm" err || fail "which map? $(cat err)"
done
refused "$majak" localize blind.log --map no_such
refused "$majak" localize blind.log --map no_such.yaml
refused "$majak" localize blind.log --map plan.png
grep -q -- '--map-resolution' err || fail "it does not say what is missing: $(cat err)"
refused "$majak" localize blind.log --map plan.png --map-resolution -1
mkdir -p empty
refused "$majak" localize blind.log --map empty
refused "$majak" localize blind.log --map global
refused "$majak" localize blind.log --map short.log
refused "$majak" localize blind.log --map hall/trajectory.tum
printf 'image: gone.pgm\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n' >gone.yaml
refused "$majak" localize blind.log --map gone.yaml
head -c 3000 hall/map.pgm >cut.pgm
refused "$majak" localize blind.log --map cut.pgm --map-resolution 0.05
head -c 30000 hall/site.majak >cut.majak
refused "$majak" localize blind.log --map cut.majak
for method in tracking monte-carlo markov global; do
  refused "$majak" localize blind.log --method $method
  grep -q -- '--map' err || fail "it does not say what is missing: $(cat err)"
done
refused "$majak" localize --map hall

# Logs that tell nothing of the place.
grep -v '^FLASER' blind.log >no_laser.log
for method in global tracking monte-carlo markov; do
  refused "$majak" localize no_laser.log --map hall --method $method
done
awk '$1 == "FLASER" { if (++n > 40) exit; for (i = 3; i < 3 + $2; ++i) $i = 81.91 } { print }' blind.log >no_beam.log
for method in global monte-carlo markov; do
  ok "$majak" localize no_beam.log --map hall --method $method -o no_beam --json
  grep -q '"ok": 0,' out || fail "$method is sure of its place without a single return: $(cat out)"
done

# Trunks as landmarks: no map is needed, every option has a name.
ok "$majak" simulate park --short --seed 3 -o park.mcap
for method in ekf-slam landmark-graph; do
  ok "$majak" localize park.mcap --method $method -o $method --set ekf_slam.wheelbase=2.7 --set trunks.max_range=40 \
    --set association.gate=0.98 --json
  non_empty $method/{trajectory.tum,covariance.csv,summary.json,options.toml,trajectory.png}
  mean=$(sed -n 's/.*"translation_mean_m": \([0-9.e-]*\).*/\1/p' out)
  awk -v m="$mean" 'BEGIN { exit !(m > 0 && m < 0.45) }' || fail "$method: $mean m off; 0.35 were seen"
  grep -q '^max_range = 40' $method/options.toml || fail "$method: the option is not in options.toml"
done
ok "$majak" localize park.mcap --method ekf-slam -o again_slam --options ekf-slam/options.toml
cmp -s again_slam/trajectory.tum ekf-slam/trajectory.tum || fail "the same options, another path"
refused "$majak" localize park.mcap --method ekf-slam --set trunks.no_such=1
refused "$majak" localize park.mcap --method ekf-slam --set association.gate=2

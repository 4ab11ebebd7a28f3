# SPDX-License-Identifier: Apache-2.0
# Same bytes for 1, 2 and 8 threads, twice in a row.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
first=
for threads in 1 2 8 2; do
  rm -rf result
  ok "$majak" map short.log -o result --threads $threads
  hash=$(cd result && sha256sum trajectory.tum graph.g2o map.png map.pgm map.yaml options.toml)
  first=${first:-$hash}
  [ "$hash" = "$first" ] || fail "$threads threads gave other bytes: $(diff <(echo "$first") <(echo "$hash"))"
done

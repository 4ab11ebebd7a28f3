# SPDX-License-Identifier: Apache-2.0
# A full disk: a one-line error, exit code 1, and no half-written file under a final name.
. "$(dirname "$0")/lib.sh"
simulate
cd "$work" || exit 1
refused "$majak" simulate corridor -o /dev/full
refused bash -c '"$0" info short.log >/dev/full' "$majak"
mkdir small
mount -t tmpfs -o size=200k tmpfs small 2>/dev/null || skip "needs the right to mount a small file system"
trap 'umount "$work/small"; rm -rf "$work"' EXIT
head -c 150000 /dev/zero >small/filler
refused "$majak" simulate corridor -o small/corridor.log
[ ! -e small/corridor.log ] || fail "a cut log stands under its final name"
refused "$majak" map short.log -o small/result
for file in $result_files; do
  [ ! -e "small/result/$file" ] || [ -s "small/result/$file" ] || fail "$file is empty"
done
[ ! -e small/result/site.majak ] || fail "a site of a few kB"

# SPDX-License-Identifier: Apache-2.0
# What became of each single test, out of ctest's log: the output of those that failed, why others were left out, and
# the counts. A program that dies fails the test it was at.
function record(how, name) {
  ++count[how]
  if (how != "failed") return
  names = names "failed: " name "\n"
  printf "%s\n", said
}
function skip(why, name) {
  record("skipped", name)
  if (!(why in first)) first[why] = name
  ++reasons[why]
}
function close_test(how, name) {
  if (how == "failed") ++failures
  if (how == "skipped") skip(reason, name)
  else record(how, name)
  test = ""
}

/^[0-9]+\/[0-9]+ Testing: / {
  program = $3
  layer = program
  sub(/^unit\./, "", layer)
  unit = program ~ /^unit\./
  failures = tests = 0
  test = said = reason = ""
  next
}
unit && /^\[ RUN      \] / { test = layer "." $4; said = reason = ""; ++tests }
{ said = said $0 "\n" }
next_is_reason { reason = $0; next_is_reason = 0 }
/: Skipped$/ { next_is_reason = 1 }
/^skipped: / { reason = substr($0, 10) }
unit && test != "" && /\[       OK \] / { close_test("passed", test) }
unit && test != "" && /\[  FAILED  \] / { close_test("failed", test) }
unit && test != "" && /\[  SKIPPED \] / { close_test("skipped", test) }
/^<end of output>/ && test != "" { close_test("failed", test " (did not end)") }
/^Test Passed/ && !unit { close_test(reason != "" ? "skipped" : "passed", program) }  # ctest calls both so
/^(Test Failed|Test Timeout|Unable to find executable)/ && !failures { record("failed", program) }

END {
  for (why in reasons) printf "skipped %d: %s (%s%s)\n", reasons[why], why, first[why], (reasons[why] > 1 ? " ..." : "") | "sort"
  close("sort")
  printf "%s%d passed, %d failed, %d skipped\n", names, count["passed"], count["failed"], count["skipped"]
  exit !(count["passed"] + count["failed"] + count["skipped"])
}

# What the groups share, sourced in the guest: steps with a name, waiting with a limit, running the test programs.

build=build/release

say() {
  echo "--- $*"
}

fail() {
  echo "failed: $*"
  exit 1
}

# The group could not prove what it is for: the last line of its log says why.
skip() {
  echo "$*"
  exit 77
}

expect_equal() {
  [[ $1 == "$2" ]] || fail "expected '$2', and it is '$1'"
}

# wait_for WHAT COMMAND...: until the command succeeds, at most 20 s.
wait_for() {
  local what=$1 try
  shift
  for ((try = 0; try < 200; ++try)); do
    if "$@"; then return; fi
    sleep 0.1
  done
  fail "waited in vain for $what"
}

# expect_end_of PROCESS: a child that must end by itself, with whatever status.
expect_end_of() {
  has_ended() { ! kill -0 "$1" 2>/dev/null; }
  wait_for "process $1 to end" has_ended "$1"
}

# run_tests PROGRAM [ARGUMENT...]: a program of tests from the host's build folder. A test that skips itself proves
# nothing here.
run_tests() {
  local program=$1
  shift
  [[ -x $build/$program ]] || skip "$program is not built; only what stands above was tested"
  say "$program $*"
  "$build/$program" "$@" | tee /tmp/tests || fail "$program $*"
  if grep -q '^\[  SKIPPED \]' /tmp/tests; then fail "tests skipped themselves"; fi
  grep -Eq '^\[  PASSED  \] [1-9]' /tmp/tests || fail "no test passed"
}

# run_each_test PROGRAM COMMAND...: each test in a process of its own, with the command before it; all of them, even
# after a failure.
run_each_test() {
  local program=$1 name failed=()
  shift
  [[ -x $build/$program ]] || skip "$program is not built; only what stands above was tested"
  "$build/$program" --gtest_list_tests | awk '/^[^ ]/ { suite = $1 } /^ / { print suite $1 }' >/tmp/names
  [[ -s /tmp/names ]] || fail "$program holds no tests"
  while IFS= read -r name; do
    "$@"
    (run_tests "$program" "--gtest_filter=$name") || failed+=("$name")
  done </tmp/names
  ((${#failed[@]} == 0)) || fail "${#failed[@]} of $(wc -l </tmp/names) tests: ${failed[*]}"
}

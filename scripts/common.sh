# What the scripts share: where the tree is, how many jobs fit, and commands with a log and short output.
# Sourced, not run. Leaves the shell in the top folder of the tree.

cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Prints the comment block that opens a script: its help text.
show_help() {
  awk 'NR > 1 { if (!/^#/) exit; sub(/^# ?/, ""); print }' "$1"
}

fail() {
  echo "$*" >&2
  exit 1
}

# Compilers of this code take about 1.5 GB each: as many jobs as processors, and no more than memory allows.
job_count() {
  local memory_kb fitting
  memory_kb=$(awk '/^MemAvailable/ { print $2 }' /proc/meminfo)
  fitting=$((${memory_kb:-1500000} / 1500000))
  local jobs
  jobs=$(nproc)
  ((jobs > fitting)) && jobs=$fitting
  ((jobs < 1)) && jobs=1
  echo "${HEADWAY_JOBS:-$jobs}"
}

# Reads a build's or ctest's output and shows how far it is: a line for each quarter, or one moving line on a terminal.
# Lines look like "[12/130] ..." (ninja) or " 12/130 Test ..." (ctest).
show_progress() {
  local name=$1 line shown=0 quarter done all
  while IFS= read -r line; do
    [[ $line =~ ^[[:space:]]*\[?([0-9]+)/([0-9]+)[\]\ ] ]] || continue
    done=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]}
    ((all >= 20)) || continue
    if [[ -t 1 ]]; then
      printf '\r%s: %d of %d ' "$name" "$done" "$all"
    else
      quarter=$((done * 4 / all))
      ((quarter > shown)) && printf '%s: %d of %d\n' "$name" "$done" "$all"
      ((quarter > shown)) && shown=$quarter
    fi
  done
  [[ -t 1 ]] && printf '\r\033[K'
  return 0
}

# run_logged NAME COMMAND...: runs the command with its output in build/log/NAME.log; on failure shows the log's end.
run_logged() {
  local name=$1 log=build/log/${1// /-}.log begin=$SECONDS status=0
  shift
  mkdir -p build/log
  "$@" </dev/null 2>&1 | tee "$log" | show_progress "$name" || status=$?
  if ((status != 0)); then
    grep -n -m 5 -E 'error:|FAILED:|CMake Error' "$log" >&2 || true
    echo "--- the last lines of $log:" >&2
    tail -n 40 "$log" >&2
    echo "$name: failed (status $status); all of it stands in $log" >&2
    return "$status"
  fi
  echo "$name: done in $((SECONDS - begin)) s"
}

# The machine's tools, unless the caller says that they are there.
run_setup() {
  [[ ${HEADWAY_SKIP_SETUP:-0} == 1 ]] || scripts/setup "$@"
}

# Real images and maps are looked for next to the tree, where nobody says where they are.
use_shared_data() {
  if [[ -z ${HEADWAY_DATA-} && -d ../shared/data ]]; then
    HEADWAY_DATA=$(realpath ../shared/data)
    export HEADWAY_DATA
  fi
}

# The tree's own C++ files, without the generated ones.
cpp_files() {
  find . \( -name build -o -name .git \) -prune -o \( -name '*.cpp' -o -name '*.h' \) -print | sed 's|^\./||' | sort |
    while IFS= read -r file; do
      head -n 1 "$file" | grep -q '^// GENERATED ' || echo "$file"
    done
}

# build PRESET [TARGET...]: configures and builds build/PRESET.
build() {
  local preset=$1
  shift
  run_logged "configure $preset" cmake --preset "$preset"
  run_logged "build $preset" cmake --build --preset "$preset" -j "$(job_count)" ${1:+--target "$@"}
}

# run_tests PRESET [CTEST ARGUMENT...]: ctest in parallel; shows what failed, and ends with ctest's own summary.
run_tests() {
  local preset=$1 log=build/log/test-$1.log status=0 skipped
  shift
  mkdir -p build/log
  # Random properties draw the same cases on every run; RC_PARAMS= (empty) draws new ones.
  RC_PARAMS="${RC_PARAMS-seed=2008}" ctest --preset "$preset" -j "$(job_count)" --no-label-summary "$@" </dev/null 2>&1 |
    tee "$log" | show_progress "test $preset" || status=$?
  # Each failed test's line and what it said, up to the next test's lines.
  awk '/^ *[0-9]+\/[0-9]+ Test +#/ { on = /\*\*\*/ && !/\*\*\*Skipped/ } /^ *Start +[0-9]+:|tests (passed|FAILED)/ { on = 0 } on' \
    "$log" | head -n 400
  skipped=$(grep -c '\*\*\*Skipped' "$log" || true)
  ((skipped == 0)) || echo "test $preset: $skipped of them skipped themselves; $log says why"
  ((status == 0)) || echo "test $preset: failed; all of it stands in $log"
  awk '/tests passed|tests FAILED/ { on = 1 } /did not run/ { on = 0 } on && NF' "$log"
  if grep -q 'No tests were found' "$log"; then fail "test $preset: no tests were found"; fi
  return "$status"
}

# What the sanitizers check and say, for the builds asan and tsan.
use_sanitizer_options() {
  local folder=$PWD/tests/sanitizers
  export ASAN_OPTIONS=detect_stack_use_after_return=1:check_initialization_order=1:strict_init_order=1
  export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
  export LSAN_OPTIONS=suppressions=$folder/leaks.txt:print_suppressions=0
  export TSAN_OPTIONS=suppressions=$folder/threads.txt:halt_on_error=1:second_deadlock_stack=1
  # Fewer cases of each random property: the code under a sanitizer is several times slower.
  export RC_PARAMS="${RC_PARAMS-seed=2008 max_success=30}"
}

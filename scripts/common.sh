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

# Reads a build's or ctest's output and shows how far it is: each tenth on its own line, or one moving line on a
# terminal. Lines look like "[12/130] ..." (ninja) or " 12/130 Test ..." (ctest).
show_progress() {
  local name=$1 line shown=-1 tenth done all
  while IFS= read -r line; do
    [[ $line =~ ^[[:space:]]*\[?([0-9]+)/([0-9]+)[\]\ ] ]] || continue
    done=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]}
    ((all >= 20)) || continue
    if [[ -t 1 ]]; then
      printf '\r%s: %d of %d ' "$name" "$done" "$all"
    else
      tenth=$((done * 10 / all))
      ((tenth > shown)) && printf '%s: %d of %d\n' "$name" "$done" "$all"
      ((tenth > shown)) && shown=$tenth
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

# build PRESET [TARGET...]: configures and builds build/PRESET.
build() {
  local preset=$1
  shift
  run_logged "configure $preset" cmake --preset "$preset"
  run_logged "build $preset" cmake --build --preset "$preset" -j "$(job_count)" ${1:+--target "$@"}
}

# run_tests PRESET [CTEST ARGUMENT...]: ctest in parallel; shows what failed and ctest's own summary.
run_tests() {
  local preset=$1 log=build/log/test-$1.log status=0
  shift
  mkdir -p build/log
  ctest --preset "$preset" -j "$(job_count)" --no-label-summary "$@" </dev/null 2>&1 |
    tee "$log" | show_progress "test $preset" || status=$?
  if ((status != 0)); then
    grep -B 2 -A 60 -E '\*\*\*(Failed|Timeout|Exception|Not Run)' "$log" | head -n 400 >&2 || true
  fi
  local skipped
  skipped=$(grep -c '\*\*\*Skipped' "$log" || true)
  ((skipped == 0)) || echo "test $preset: $skipped skipped (the log says why: $log)"
  sed -n '/tests passed/,$p' "$log" | sed '/^$/d; /The following tests did not run/,/^Errors while/{/Skipped/d; /did not run/d}'
  ((status != 0)) && echo "test $preset: failed; all of it stands in $log" >&2
  return "$status"
}

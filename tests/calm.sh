#!/usr/bin/env bash
# Runs the test command N times (10 unless given), and says of each run whether it passed, how long it took, and what failed. With LOAD=1 a
# busy loop for each core runs beside it. A red run is a defect of the program or of a test, never of the machine.
#
#     tests/calm.sh 10
#     LOAD=1 tests/calm.sh 10
set -uo pipefail
cd "$(dirname "$0")/.."
runs=${1:-10}
command=(cargo test --workspace --no-fail-fast)
"${command[@]}" --no-run --quiet || exit 1
logs=$(mktemp -d)
loops=()
if [ -n "${LOAD:-}" ]; then
    for _ in $(seq "$(nproc)"); do
        (while :; do :; done) &
        loops+=($!)
    done
    trap 'kill "${loops[@]}"' EXIT
fi
failed=0
for run in $(seq "$runs"); do
    begun=$SECONDS
    "${command[@]}" > "$logs/$run" 2>&1 && verdict=passed || { verdict=FAILED; failed=$((failed + 1)); }
    echo "run $run of $runs: $verdict in $((SECONDS - begun)) s"
    sed -n 's/^test \(.*\) \.\.\. FAILED$/    \1/p' "$logs/$run"
done
echo "$failed of $runs failed; the logs are in $logs"
[ "$failed" -eq 0 ]

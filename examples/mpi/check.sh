#!/usr/bin/env bash
# 1, 2 and 3 ranks give the bits of a run without MPI, and a rank that fails ends the job.
set -euo pipefail
cd "$(dirname "$0")/../.."

# Open MPI refuses to run as root unless told twice.
[ "$(id -u)" -ne 0 ] || export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

cargo build --release -p sweep-mpi
program=${CARGO_TARGET_DIR:-target}/release/sweep-mpi
serial=$("$program" --serial)
for ranks in 1 2 3; do
  farmed=$(mpirun --oversubscribe ${MPIRUN_FLAGS:-} -n "$ranks" "$program")
  [ "$farmed" = "$serial" ] || { echo "$ranks ranks: $farmed, without MPI $serial"; exit 1; }
  echo "$ranks ranks: $farmed"
done
echo "the same bits"
for ranks in 1 2 3; do
  status=0
  timeout -s KILL 60 mpirun --oversubscribe ${MPIRUN_FLAGS:-} -n "$ranks" "$program" --channel nonsense 2>/dev/null || status=$?
  [ "$status" -ne 0 ] && [ "$status" -ne 137 ] || { echo "$ranks ranks: status $status of a sweep that fails"; exit 1; }
done
echo "a sweep that fails ends"

#!/usr/bin/env bash
# 1, 2 and 3 ranks give the bits of a run without MPI.
set -euo pipefail
cd "$(dirname "$0")/../.."

# Open MPI refuses to run as root unless told twice.
[ "$(id -u)" -ne 0 ] || export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

cargo build --release -p sweep-mpi
program=target/release/sweep-mpi
serial=$("$program" --serial)
for ranks in 1 2 3; do
  farmed=$(mpirun --oversubscribe ${MPIRUN_FLAGS:-} -n "$ranks" "$program")
  [ "$farmed" = "$serial" ] || { echo "$ranks ranks: $farmed, without MPI $serial"; exit 1; }
  echo "$ranks ranks: $farmed"
done
echo "the same bits"

#!/usr/bin/env bash
# 1, 2 and 3 ranks give the bits of a run without MPI.
set -euo pipefail
cd "$(dirname "$0")/../.."

cargo build --release -p sweep-mpi
program=target/release/sweep-mpi
serial=$("$program" --serial)
for ranks in 1 2 3; do
  farmed=$(mpirun --oversubscribe ${MPIRUN_FLAGS:-} -n "$ranks" "$program")
  [ "$farmed" = "$serial" ] || { echo "$ranks ranks: $farmed, without MPI $serial"; exit 1; }
  echo "$ranks ranks: $farmed"
done
echo "the same bits"

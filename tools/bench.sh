#!/usr/bin/env bash
# Prints speed and memory as one table: medians of runs on this machine, each with its target where it has one, and how
# many targets are met; exit 1 where one is missed. Installs what is missing (see cmake/packages.txt).
#   ./tools/bench.sh                    all rows, in a few minutes
#   ./tools/bench.sh --json bench.json  and the figures for a script
#   ./tools/bench.sh --only photons     one group: elastic, photons, neuron, fluorescence, sheet
#   ./tools/bench.sh --write FOLDER     only the scenes (with --only of one group), for `fluovox render`
set -euo pipefail
cd "$(dirname "$0")/.."
./tools/setup.sh fluovox_bench
build/release/bench/fluovox_bench "$@"

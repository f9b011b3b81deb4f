#!/usr/bin/env bash
# Prints speed and memory of the main job: medians of runs on this machine, to be compared as ratios within one run.
# Asserts nothing. Installs what is missing (see cmake/packages.txt).
set -euo pipefail
cd "$(dirname "$0")/.."
./tools/setup.sh fluovox_bench
build/release/bench/fluovox_bench

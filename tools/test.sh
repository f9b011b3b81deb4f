#!/usr/bin/env bash
# Builds fluovox and runs its whole test suite. Installs what is missing (see cmake/packages.txt).
#   ./tools/test.sh            everything
#   ./tools/test.sh -R Dye     only tests whose name matches (arguments go to ctest)
set -euo pipefail
cd "$(dirname "$0")/.."
./tools/setup.sh
ctest --preset release -j "$(nproc)" "$@"

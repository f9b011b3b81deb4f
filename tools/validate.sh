#!/usr/bin/env bash
# Compares fluovox with every published number it knows of: prints one table, writes validation.md with plots
# (into the folder given with -o, by default build/validation) and exits 1 when they disagree.
#   ./tools/validate.sh              all cases, less than 15 minutes on two cores
#   ./tools/validate.sh --seed 7     the same with other random numbers
#   ./tools/validate.sh cube60       only cases with that word in their name
#   ./tools/validate.sh --spread 60  many short runs of each case: do they scatter as their standard errors say?
set -euo pipefail
cd "$(dirname "$0")/.."
./tools/setup.sh fluovox_validate
case " $* " in *" -o "*) ;; *) set -- -o build/validation "$@" ;; esac
exec build/release/tests/validation/fluovox_validate "$@"

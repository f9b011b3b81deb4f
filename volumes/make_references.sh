#!/usr/bin/env bash
# Renders the small reference pictures that the tests compare with (volumes/*/reference.exr), with more samples and
# other random numbers than the tests use. Needed only when a scene is meant to look different.
#   ./volumes/make_references.sh [NAME...]
set -euo pipefail
cd "$(dirname "$0")/.."
./tools/setup.sh fluovox_program
names=("$@")
((${#names[@]})) || names=(neuron beads cuvette-gfp cuvette-rfp)
for name in "${names[@]}"; do
    build/release/tools/fluovox render "volumes/$name/scene.toml" -o "volumes/$name/reference.exr" --seed 4711 \
        --set "camera.resolution=[32,32]" --set film.spectrum.bins=7 --set render.samples=2048
    rm -f "volumes/$name/reference.png"
done

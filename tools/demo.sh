#!/usr/bin/env bash
# From a mesh to a fluorescence image: writes the neuron specimen, voxelizes it, renders it,
# and prints which file to open. Installs what is missing (see cmake/packages.txt).
set -euo pipefail
cd "$(dirname "$0")/.."
./tools/setup.sh fluovox_program
fluovox=build/release/tools/fluovox
"$fluovox" demo neuron -o demo/neuron
"$fluovox" render demo/neuron/scene.toml -o demo/neuron/neuron.exr
echo "Open demo/neuron/neuron.png (preview) or demo/neuron/neuron.exr (spectral image)."

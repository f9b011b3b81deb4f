#!/usr/bin/env bash
# From a mesh to fluorescence images: writes the neuron specimen, voxelizes it, renders it; then a light-sheet stack of
# two neurons. Prints which files to open. Installs what is missing (see cmake/packages.txt). A second run keeps the
# finished stack, a stopped one goes on.
set -euo pipefail
cd "$(dirname "$0")/.."
./tools/setup.sh fluovox_program
fluovox=build/release/tools/fluovox
"$fluovox" demo neuron -o demo/neuron
"$fluovox" info demo/neuron/neuron.vdb --preview demo/neuron/voxels.png
"$fluovox" render demo/neuron/scene.toml -o demo/neuron/neuron.exr
sheet=demo/lightsheet-neuron
[[ -f $sheet/scene.toml ]] || "$fluovox" demo lightsheet-neuron -o $sheet
"$fluovox" render $sheet/scene.toml -o $sheet/stack.ome.tif
echo "The voxels of the neuron are in demo/neuron/voxels.png (maximum projection)."
echo "Open demo/neuron/neuron.png (preview) or demo/neuron/neuron.exr (spectral image);"
echo "and $sheet/stack.png (projection), $sheet/stack.apng (film) or $sheet/stack.ome.tif (Fiji: Bio-Formats; napari)."

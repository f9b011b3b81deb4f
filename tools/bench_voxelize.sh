#!/usr/bin/env bash
# What voxelizing costs and how right it is, beside Debian's vdb_tool on the same meshes in the same run (compare the
# ratios, not the seconds). Closed meshes: the error is against the signed volume.
#   ./tools/bench_voxelize.sh MESH...         (default: the meshes of ../shared/specimens/mesh, where they are)
set -euo pipefail
cd "$(dirname "$0")/.."
./tools/setup.sh fluovox_program
fluovox=$PWD/build/release/tools/fluovox
meshes=("$@")
((${#meshes[@]})) || meshes=(../shared/specimens/mesh/*.{ply,obj})
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export LC_ALL=C TIMEFORMAT='%U %S'

# CPU seconds of a command, user and system.
cpu() { { time "$@" >/dev/null 2>"$folder/err"; } 2>&1 | awk '{ printf "%.2f", $1 + $2 }'; }
value() { grep -m1 "\"$1\"" "$folder/report.json" | sed 's/.*: *//; s/,$//'; }

printf '%-42s %6s %9s %12s %10s %10s %9s %12s\n' mesh voxels cpu_s cpu_1thread error_% winding_% peak_MB vdb_tool_s
for mesh in "${meshes[@]}"; do
    [[ -f $mesh ]] || continue
    for resolution in 64 256 1024; do
        run=("$fluovox" voxelize "$mesh" -o "$folder/out.vdb" --dye EGFP=1uM --resolution "$resolution"
            --max-bytes 1e12 --report "$folder/report.json")
        two=$(cpu "${run[@]}")
        one=$(cpu "${run[@]}" --threads 1)
        rival=-
        if command -v vdb_tool >/dev/null; then
            rival=$(cpu vdb_tool -quiet -read "$mesh" -mesh2ls dim="$resolution" -ls2fog)
        fi
        error=$(grep -E '^      "volume_um3"|^          "volume_um3"' "$folder/report.json" | sed 's/.*: *//; s/,$//' |
            awk 'NR == 1 { voxels = $1 } NR == 2 { printf "%+.4f", 100 * (voxels / $1 - 1) }')
        printf '%-42s %6s %9s %12s %10s %10.3f %9.0f %12s\n' "$(basename "$mesh")" "$resolution" "$two" "$one" "$error" \
            "$(value winding_share | awk '{ print 100 * $1 }')" "$(value peak_memory_bytes | awk '{ print $1 / 1e6 }')" "$rival"
    done
done

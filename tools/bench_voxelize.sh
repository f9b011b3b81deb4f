#!/usr/bin/env bash
# How right voxelizing is and what it costs, beside Debian's vdb_tool on the same meshes in the same run: compare the
# ratios, not the seconds. Made shapes (boxes, cylinders, damage on purpose) come from the tests, with their errors.
#   ./tools/bench_voxelize.sh [FOLDER]       (default: ../shared/specimens, with mesh/ and swc/)
set -euo pipefail
cd "$(dirname "$0")/.."
./tools/setup.sh fluovox_program unit_voxelize
fluovox=$PWD/build/release/tools/fluovox
specimens=${1:-../shared/specimens}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export LC_ALL=C TIMEFORMAT='%U %S'

cpu() { { time "$@" >/dev/null 2>"$folder/err"; } 2>&1 | awk '{ printf "%.2f", $1 + $2 }'; }
# The first value of that name in the report; volume_um3 of the voxels comes before that of the mesh.
value() { grep -m"${2:-1}" "\"$1\"" "$folder/report.json" | tail -1 | sed 's/.*: *//; s/,$//'; }
fill() { # FILE RESOLUTION [OPTIONS]
    local file=$1 resolution=$2
    shift 2
    "$fluovox" voxelize "$file" -o "$folder/out.vdb" --dye EGFP=1uM --resolution "$resolution" --max-bytes 1e12 \
        --report "$folder/report.json" "$@"
}
volume() { fill "$@" >/dev/null 2>&1 && value volume_um3; }

# CASE FILE RESOLUTION MUST_% [TRUTH]: without a truth, the signed volume of the mesh.
row() {
    local name=$1 file=$specimens/$2 resolution=$3 must=$4 truth=${5:-} rival='-' rival_MB='-'
    [[ -f $file ]] || return 0
    local two one
    one=$(cpu fill "$file" "$resolution" --threads 1)
    two=$(cpu fill "$file" "$resolution")
    [[ -n $truth ]] || truth=$(value volume_um3 2)
    if command -v vdb_tool >/dev/null && [[ $file != *.swc ]]; then
        rival=$(cpu command time -f '%M' -o "$folder/rival" vdb_tool -quiet -read "$file" -mesh2ls "dim=$resolution" -ls2fog) || rival='fails'
        rival_MB=$(tail -1 "$folder/rival" | awk '{ printf "%.0f", $1 / 1e3 }')
    fi
    printf '%-34s %6s %8s %9s %8s %7s %9s %5s %9s %9s\n' "$name" "$resolution" "$must" \
        "$(awk -v a="$(value volume_um3)" -v b="$truth" 'BEGIN { printf "%+.3f", 100 * (a / b - 1) }')" \
        "$(value winding_share | awk '{ printf "%.2f", 100 * $1 }')" "$one" "$two" \
        "$(value peak_memory_bytes | awk '{ printf "%.0f", $1 / 1e6 }')" "$rival" "$rival_MB"
}

printf '%-34s %6s %8s %9s %8s %7s %9s %5s %9s %9s\n' case voxels must_% error_% wind_% cpu_s cpu_s_all MB vdb_tool vdb_MB
closed=(nucleus_nmv_4_hq.obj spine_nmv_5_hq.obj pinky_seg_28673074_closed.ply)
for mesh in "${closed[@]}"; do
    row "$mesh" "mesh/$mesh" 64 0.5
    row "$mesh" "mesh/$mesh" 256 0.1
    row "$mesh" "mesh/$mesh" 1024 0.05
done
mesh=$specimens/mesh
if [[ -f $mesh/pinky_seg_28673074_closed.ply ]]; then
    fill "$mesh/pinky_seg_28673074_closed.ply" 64 >/dev/null
    twin=$(value volume_um3 2)
    row 'pinky open, against its twin' mesh/pinky_seg_28673074_open.ply 256 1.5 "$twin"
    row 'pinky open, against its twin' mesh/pinky_seg_28673074_open.ply 1024 1.5 "$twin"
    fly=$(volume "$mesh/fly_da1pn_722817260.ply" 2048 --inside winding)
    row 'fly, against winding at 2048' mesh/fly_da1pn_722817260.ply 256 3 "$fly"
    row 'bunny, against winding' mesh/stanford_bunny.obj 256 1 "$(volume "$mesh/stanford_bunny.obj" 256 --inside winding)"
    row 'unwelded fragments' mesh/pinky_28336523.ply 256 0.1
    row 'spines near 1e6' mesh/microns_864691134884740346_spines.obj 256 0.1
    row 'open sheets, against winding' mesh/rat_nmj.obj 64 3 "$(volume "$mesh/rat_nmj.obj" 128 --inside winding)"
fi
row 'cortical cell from SWC, at 4 x' swc/allen_Scnn1a_L4pyr_328933585.swc 3000 1 \
    "$([[ -d $specimens/swc ]] && volume "$specimens/swc/allen_Scnn1a_L4pyr_328933585.swc" 6000)"

printf '\n%-48s %8s %10s\n' 'made shape' must_% error_%
FLUOVOX_FIGURES=1 build/release/tests/unit/unit_voxelize --gtest_filter='Voxelize.*:Morphology.ACorticalCell*' |
    sed -n 's/^figure: //p'
echo

# One thread against two, in the voxelizing phase (file reading apart): several runs of each, in turn.
median() { sort -n | awk '{ v[NR] = $1 } END { print v[int((NR + 1) / 2)] }'; }
for name in "${closed[@]}"; do
    [[ -f $mesh/$name ]] || continue
    for run in 1 2 3 4 5 6 7; do
        for threads in 1 2; do
            fill "$mesh/$name" 1024 --threads "$threads" >/dev/null
            value voxelizing_seconds >>"$folder/$threads-$name"
        done
    done
    awk -v n="$name" -v a="$(median <"$folder/1-$name")" -v b="$(median <"$folder/2-$name")" \
        -v c="$(sort -n "$folder/1-$name" | head -1)" -v d="$(sort -n "$folder/2-$name" | head -1)" \
        'BEGIN { printf "%-34s 1024  two threads against one: median %.3f s / %.3f s = %.2f, best %.2f\n", n, a, b, a / b, c / d }'
done
# What two threads can reach at most just now: the same work twice at once, against once.
busy() { awk 'BEGIN { for (i = 0; i < 20000000; i++) s += i * 0.5 }'; }
TIMEFORMAT=%R
once=$({ time busy; } 2>&1)
twice=$({ time { busy & busy & wait; }; } 2>&1)
awk -v a="$once" -v b="$twice" 'BEGIN { printf "(this machine, just now: two independent programs get %.2f processors)\n", 2 * a / b }'

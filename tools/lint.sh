#!/usr/bin/env bash
# Runs clang-tidy (see .clang-tidy) over the sources and headers that differ from a git revision, or over those named.
#   ./tools/lint.sh               what differs from main, committed or not
#   ./tools/lint.sh --since REV   what differs from REV
#   ./tools/lint.sh --all         every source, and headers through them (many minutes)
#   ./tools/lint.sh FILE...       these
set -euo pipefail
cd "$(dirname "$0")/.."
command -v clang-tidy >/dev/null || { echo "lint: clang-tidy is not installed" >&2; exit 1; }
[[ -f build/dev/compile_commands.json ]] || cmake --preset dev >&2

since=main
case "${1:-}" in
    --all) mapfile -t files < <(git ls-files 'src/*.cpp' 'tools/*.cpp' 'tests/*.cpp' 'bench/*.cpp') ;;
    -*|"")
        [[ "${1:-}" == --since ]] && since=${2:?--since needs a revision}
        mapfile -t files < <({ git diff --name-only --diff-filter=d "$(git merge-base "$since" HEAD)"
                               git ls-files --others --exclude-standard; } | grep -E '^(src|tools|tests|bench)/.*\.(cpp|h)$' | sort -u) ;;
    *) files=("$@") ;;
esac
# Only what this build compiles has flags to be read with; a header gets those of the source that is named most like it.
known=()
for file in "${files[@]}"; do
    if [[ "$file" == *.h ]] || grep -qF "\"$PWD/$file\"" build/dev/compile_commands.json; then
        known+=("$file")
    else
        echo "not built here: $file" >&2
    fi
done
((${#known[@]})) || { echo "lint: nothing to look at" >&2; exit 0; }
# g++'s own warning options mean nothing to clang, and -Wconversion means changes of sign to it as well.
printf '%s\0' "${known[@]}" |
    xargs -0 -n 1 -P "$(nproc)" clang-tidy -p build/dev --quiet --extra-arg=-Wno-unknown-warning-option \
        --extra-arg=-Wno-sign-conversion

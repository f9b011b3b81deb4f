#!/usr/bin/env bash
# Brings a bare Debian 12 machine to where fluovox builds: installs the packages of cmake/packages.txt
# that are missing (root or sudo), then configures and builds the release preset. Does nothing twice.
# Sourced or run by demo.sh and test.sh; takes the CMake targets to build as arguments (default: all).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

missing=()
while read -r package; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done < <(sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' cmake/packages.txt)

if ((${#missing[@]})); then
    echo "Installing ${#missing[@]} Debian packages: ${missing[*]}" >&2
    as_root=()
    if ((EUID != 0)); then
        command -v sudo >/dev/null || { echo "setup: needs root or sudo to install: ${missing[*]}" >&2; exit 1; }
        as_root=(sudo)
    fi
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq >&2
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2
fi

[[ -f build/release/build.ninja ]] || cmake --preset release >&2
cmake --build --preset release ${1:+--target "$@"} >&2

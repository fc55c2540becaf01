#!/bin/bash
# clang-tidy with the checks of .clang-tidy: scripts/tidy.sh over all sources, scripts/tidy.sh COMMIT over those that
# differ from that commit. Fails at the first kind of mistake it finds.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

install_packages clang++-14:clang-14 clang-tidy-14:clang-tidy-14
build clang poretwin_proto
mapfile -t sources < <(if [ $# -gt 0 ]; then git diff --name-only --diff-filter=d "$1" -- '*.cpp'; else git ls-files '*.cpp'; fi)
say "clang-tidy: ${#sources[@]} files"
[ ${#sources[@]} -eq 0 ] || printf '%s\n' "${sources[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy-14 -p build/clang --quiet

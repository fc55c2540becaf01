#!/bin/bash
# Runs clang-tidy with the checks of .clang-tidy. scripts/tidy.sh checks all sources, scripts/tidy.sh COMMIT the sources that differ
# from that commit. Fails if clang-tidy reports a mistake.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

install_packages clang++-14:clang-14 clang-tidy-14:clang-tidy-14
build clang poretwin_proto
mapfile -t sources < <(if [ $# -gt 0 ]; then git diff --name-only --diff-filter=d "$1" -- '*.cpp'; else git ls-files '*.cpp'; fi)
say "clang-tidy: ${#sources[@]} files"
[ ${#sources[@]} -eq 0 ] || printf '%s\n' "${sources[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy-14 -p build/clang --quiet

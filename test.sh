#!/bin/bash
# Installs what is missing, builds and runs the tests: ./test.sh [PRESET [options of ctest]]. Safe to run twice.
# The asan and tsan presets take the unit and interface tests; release takes all.
set -euo pipefail
cd "$(dirname "$0")"
. scripts/setup.sh

preset=${1:-release}
shift || true
install_packages
build "$preset"
labels=()
case $preset in
  asan | tsan) labels=(-L 'unit|interface') ;;
esac
say "testing: $preset"
exec ctest --preset "$preset" -j "$(nproc)" "${labels[@]}" "$@"

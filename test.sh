#!/bin/bash
# Installs what is missing, builds and runs the tests: ./test.sh [PRESET [options of ctest]]. Safe to run twice.
# The asan and tsan presets take the unit and interface tests; release takes all.
set -euo pipefail
cd "$(dirname "$0")"
. scripts/setup.sh

preset=${1:-release}
shift || true
install_packages
targets=() labels=()
case $preset in
  asan | tsan) targets=(unit_tests) labels=(-L 'unit|interface') ;;
esac
build "$preset" "${targets[@]}"
say "testing: $preset"
exec ctest --preset "$preset" -j "$(nproc)" "${labels[@]}" "$@"

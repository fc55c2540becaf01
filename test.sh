#!/bin/bash
# Installs what is missing, builds and runs the tests: ./test.sh [PRESET [options of ctest]]. Safe to run twice.
# The asan and tsan presets take the unit and interface tests; release takes all.
set -euo pipefail
cd "$(dirname "$0")"
. scripts/setup.sh

preset=${1:-release}
shift || true
targets=() labels=() commands=()
case $preset in
  asan | tsan) targets=(unit_tests) labels=(-L 'unit|interface') ;;
  *) commands=($test_commands) ;;
esac
install_packages "${commands[@]}"
build "$preset" "${targets[@]}"
say "testing: $preset"
exec ctest --preset "$preset" -j "$(nproc)" "${labels[@]}" "$@"

#!/bin/bash
# Installs what is missing, builds and runs the tests: ./test.sh [PRESET [options of ctest]]. Safe to run twice.
# The asan and tsan presets take the unit and interface tests; release takes all. `full` takes all tests with the address
# sanitizer, the unit and interface tests with the thread sanitizer, all sources by clang-tidy and by clang 14, the release
# tests, and then what takes long or needs a network: the Debian packages on a fresh Debian (root).
set -euo pipefail
cd "$(dirname "$0")"
. scripts/setup.sh

preset=${1:-release}
shift || true
targets=() labels=() commands=($test_commands)
case $preset in
  asan | tsan) targets=(unit_tests) labels=(-L 'unit|interface') commands=() ;;
  full) packages+=" ffmpeg fish lintian man-db mypy paraview python3-build python3-paraview python3-setuptools python3-wheel xvfb zsh" ;; # what some tests do without otherwise
esac
install_packages "${commands[@]}"
if [ "$preset" = full ]; then
  build asan
  say "testing: asan, all"
  ctest --preset asan -j "$(nproc)" "$@"
  ./test.sh tsan "$@"
  scripts/tidy.sh
  build clang
  build release
  say "testing: release"
  ctest --preset release -j "$(nproc)" "$@"
  scripts/packages.sh
  exec scripts/package_smoke.sh
fi
build "$preset" "${targets[@]}"
say "testing: $preset"
exec ctest --preset "$preset" -j "$(nproc)" "${labels[@]}" "$@"

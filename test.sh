#!/bin/bash
# Installs missing packages, builds, and runs the tests: ./test.sh [PRESET [options of ctest]]. May be repeated.
# PRESET (default release) is a preset of CMakePresets.json, or `full`.
# asan, tsan (address, thread sanitizer): unit and interface tests. release: all tests.
# full: all tests with the address sanitizer, the unit and interface tests with the thread sanitizer, clang-tidy and clang 14 on all
# sources, all tests of the release build, and finally what takes long and needs a network: the Debian packages on a fresh Debian
# (needs root).
set -euo pipefail
cd "$(dirname "$0")"
. scripts/setup.sh

preset=${1:-release}
shift || true
targets=() labels=() commands=($test_commands)
case $preset in
  asan | tsan) targets=(unit_tests) labels=(-L 'unit|interface') commands=() ;;
  full) packages+=" ffmpeg fish $tiles_packages lintian man-db mypy paraview python3-build python3-paraview python3-setuptools python3-wheel xvfb zsh" ;; # where these are missing, parts of some tests are skipped
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

#!/bin/bash
# Installs missing packages, builds, and runs a case: ./run.sh [CASE [options of `poretwin run`]]. May be repeated.
set -euo pipefail
cd "$(dirname "$0")"
. scripts/setup.sh

case " $* " in *" --tiles "*) packages+=" $tiles_packages" ;; esac
install_packages
build release poretwin poretwin-coupler poretwin-fluid poretwin-pore poretwin-joint poretwin-solid
say "running: ${1:-terzaghi}"
exec build/release/bin/poretwin run "${@:-terzaghi}"

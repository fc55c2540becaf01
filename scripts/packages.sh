#!/bin/bash
# Builds the Debian packages into build/packages: scripts/packages.sh. May be repeated.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh

packages+=" dpkg-dev"  # for dpkg-shlibdeps
install_packages
build release installable
rm -rf build/packages
cpack --config build/release/CPackConfig.cmake -B build/packages >build/release/cpack.log || { cat build/release/cpack.log; exit 1; }
rm -rf build/packages/_CPack_Packages
ls -l build/packages

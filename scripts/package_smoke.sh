#!/bin/bash
# Installs the packages of build/packages on a fresh Debian 12 and uses them: runs a case, and the conformance suite for an example
# solver in Python and one in C++. Then it removes the packages. FRESH: see scripts/fresh_debian.sh.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh
. scripts/fresh_debian.sh

fresh_debian smoke
mkdir "$root/packages"
cp build/packages/*.deb "$root/packages"

say "installing the packages"
inside 'apt-get update -q && apt-get install -qy --no-install-recommends /packages/*.deb' >"$place/log" 2>&1 || { tail -30 "$place/log" >&2; exit 1; }
say "a case, from a folder of its own"
inside 'poretwin --version && mkdir /work && cd /work && poretwin run terzaghi --until 0.05 --json told.json && test -s runs/terzaghi/pictures/fluid_pore_pressure.png && python3 -c "import json; assert json.load(open(\"told.json\"))[\"exit\"] == 0"'
say "Python"
inside 'cd /work && python3 -c "import poretwin, importlib.metadata as m; assert m.version(\"poretwin\") == poretwin.__version__"
  poretwin peer conformance /usr/share/doc/python3-poretwin/examples/seepage.toml python3 /usr/share/doc/python3-poretwin/examples/rigid_solid.py'
say "a solver in C++"
inside 'apt-get install -qy --no-install-recommends g++ cmake make >/dev/null 2>&1
  cd /work && for target in participant participant_shared; do
    rm -rf example build && cp -r /usr/share/doc/libporetwin-dev/examples/cpp example && sed -i "s/poretwin::participant)/poretwin::$target)/" example/CMakeLists.txt
    cmake -S example -B build >/dev/null && cmake --build build >/dev/null
    poretwin peer conformance /usr/share/doc/python3-poretwin/examples/seepage.toml build/rigid-solid
  done'
say "removing the packages"
inside 'apt-get remove -qy poretwin libporetwin-dev python3-poretwin >/dev/null 2>&1; ! ls -d /usr/share/poretwin /usr/lib/python3/dist-packages/poretwin 2>/dev/null'
say "the packages hold on a fresh Debian 12"

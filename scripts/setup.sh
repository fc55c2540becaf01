# Functions common to run.sh, test.sh and the scripts: installing packages, configuring, building. Source this file from the
# repository's root; every step may be repeated.

packages="cmake ninja-build g++ pkg-config libzmq3-dev cppzmq-dev libprotobuf-dev protobuf-compiler libhdf5-dev libeigen3-dev
libtomlplusplus-dev voro++-dev libcli11-dev libspdlog-dev libfmt-dev libgtest-dev libgmock-dev librapidcheck-dev libbenchmark-dev
nlohmann-json3-dev iproute2 python3-zmq python3-protobuf python3-numpy python3-scipy python3-h5py python3-matplotlib"

# Several processes that share the particles of one solver (--tiles).
tiles_packages="libopenmpi-dev libtrilinos-zoltan-dev openmpi-bin"

# Commands that only the tests need, with their packages (COMMAND:PACKAGE). A command that is there, from whatever source, is not
# installed again. gfortran compiles an example of a user's own material model.
test_commands="node:nodejs npm:npm chromium:chromium gfortran:gfortran"

say() { printf '== %s\n' "$*"; }

# install_packages [COMMAND:PACKAGE...]: installs those of $packages that are missing, and each PACKAGE whose COMMAND is missing.
install_packages() {
  local missing=() package
  for package in "$@"; do
    command -v "${package%%:*}" >/dev/null || missing+=("${package##*:}")
  done
  for package in $packages; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  if [ ${#missing[@]} -eq 0 ]; then
    say "packages: all there"
    return
  fi
  say "packages: installing ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "these packages are missing and there is neither root nor sudo: ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"
}

# build PRESET [TARGET...]: configures a preset of CMakePresets.json and builds the targets (none named: all).
build() {
  local preset=$1
  shift
  say "configuring: $preset"
  cmake --preset "$preset" >/dev/null
  say "building: $preset"
  cmake --build --preset "$preset" ${1:+--target "$@"}
}

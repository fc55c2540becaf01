#!/bin/bash
# Takes the first steps of a new user on a fresh Debian 12: clone, ./run.sh, viewing the run in a browser. Prints seconds and CPU
# seconds of each step.
# Fails if a step fails. Whether all steps take less than ten minutes is only reported: it depends on machine and network.
# Needs Chromium and node (installed when missing). FRESH: see scripts/fresh_debian.sh.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/setup.sh
. scripts/fresh_debian.sh

passed+=(https_proxy npm_config_registry SSL_CERT_FILE)
viewer=
end() {
  [ -z "$viewer" ] || { kill "$viewer"; wait "$viewer"; } 2>/dev/null || true
  leave
}
fresh_debian newcomer chromium:chromium node:nodejs npm:npm
trap end EXIT
node view/tests/look.mjs "$place/browser"  # installs what drives the browser; its time is not counted
git bundle create "$root/poretwin.bundle" HEAD >/dev/null 2>&1  # is cloned in place of a repository on a server

# step WHAT COMMAND...: runs the command with its output in the log, and prints its time.
whole=0
step() {
  local what=$1 begun ended TIMEFORMAT='%U %S'
  shift
  begun=$(date +%s.%N)
  { time "$@" >"$place/log" 2>&1 || { tail -30 "$place/log" >&2; echo "newcomer.sh: failed: $what" >&2; exit 1; }; } 2>"$place/cpu"
  ended=$(date +%s.%N)
  awk -v what="$what" -v s="$(echo "$ended $begun" | awk '{print $1 - $2}')" '{printf "%-46s %7.1f s %7.1f CPU s\n", what, s, $1 + $2}' <(tail -1 "$place/cpu")
  whole=$(awk -v a="$whole" -v b="$ended" -v c="$begun" 'BEGIN {print a + b - c}')
}

# Shows the run in a browser until its particles are drawn.
look() {
  local link
  "${in_root[@]}" /bin/bash -c 'cd /root/poretwin && exec build/release/bin/poretwin view runs/terzaghi --port 0' >"$place/view" 2>&1 &
  viewer=$!
  until link=$(grep -om1 'http:[^ ]*token=[^ ]*' "$place/view"); do
    kill -0 "$viewer" || { cat "$place/view"; return 1; }
    sleep 0.5
  done
  node view/tests/look.mjs "$place/browser" "$link"
}

step "apt-get install git, git clone" inside 'apt-get update -q && apt-get install -qy --no-install-recommends git ca-certificates && cd /root && git clone -q /poretwin.bundle poretwin'
step "./run.sh: packages" inside 'cd /root/poretwin && . scripts/setup.sh && install_packages'
step "./run.sh: build, and the case terzaghi" inside 'cd /root/poretwin && ./run.sh && test -s runs/terzaghi/pictures/fluid_pore_pressure.png'
step "poretwin view: the run in a browser" look
awk -v s="$whole" 'BEGIN {printf "%-46s %7.1f s (%s ten minutes)\n", "in all", s, s < 600 ? "under" : "over"}'

# Makes a fresh Debian 12 in a chroot, for scripts that test there. Source this file after setup.sh, from the repository's root.
# Needs root, debootstrap (installed when missing) and a Debian mirror. The variable FRESH may name a file (tar) in which the fresh
# Debian is kept for reuse.

passed=(http_proxy)  # variables that commands in the chroot inherit where they are set

# fresh_debian NAME [COMMAND:PACKAGE...]: makes the fresh Debian in $root, in the temporary folder $place, which is removed when the
# script ends. "${in_root[@]}" COMMAND... then runs a command in it. Each PACKAGE is installed on this machine if its COMMAND is
# missing.
fresh_debian() {
  local name=$1 fresh=${FRESH:-} file variable
  shift
  [ "$(id -u)" -eq 0 ] || { echo "$(basename "$0"): a chroot needs root; start it as root" >&2; exit 1; }
  packages="debootstrap"
  install_packages "$@"
  place=$(mktemp -d "/tmp/poretwin-$name-XXXXXX")
  root=$place/root
  trap leave EXIT
  if [ -n "$fresh" ] && [ -f "$fresh" ]; then
    say "a fresh Debian 12: from $fresh"
    mkdir "$root"
    tar -xf "$fresh" -C "$root"
  else
    say "a fresh Debian 12"
    debootstrap --variant=minbase bookworm "$root" http://deb.debian.org/debian >"$place/log" || { tail "$place/log" >&2; exit 1; }
    [ -z "$fresh" ] || tar -cf "$fresh" -C "$root" .
  fi
  mount -t proc proc "$root/proc"
  mkdir -p "$root/dev/shm"
  mount -t tmpfs tmpfs "$root/dev/shm"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  mkdir -p "$root/usr/local/share/ca-certificates"  # this machine's additional certificates
  for file in /usr/local/share/ca-certificates/*.crt; do [ ! -f "$file" ] || cp "$file" "$root/usr/local/share/ca-certificates/"; done
  for file in /etc/apt/apt.conf.d/*proxy*; do [ ! -f "$file" ] || cp "$file" "$root/etc/apt/apt.conf.d/"; done
  in_root=(chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive)
  for variable in "${passed[@]}"; do [ -z "${!variable:-}" ] || in_root+=("$variable=${!variable}"); done
}

# inside COMMANDS: runs the commands by a shell in the chroot, which stops at the first failure.
inside() { "${in_root[@]}" /bin/bash -euc "$1"; }

leave() {
  for mounted in dev/shm proc; do mountpoint -q "$root/$mounted" && umount "$root/$mounted"; done
  rm -rf --one-file-system "$place"
}

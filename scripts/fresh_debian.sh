# A fresh Debian 12 in a chroot, for the scripts that try things on one. Source it after setup.sh, from the repository's root.
# Needs root, debootstrap (installed when missing) and a Debian mirror. FRESH names a file that keeps the fresh Debian for the next time.

passed=(http_proxy)  # variables that commands inside see, where they are set

# fresh_debian NAME [COMMAND:PACKAGE...]: makes it at $root, in the scratch folder $place, which goes when the script ends;
# "${in_root[@]}" COMMAND... runs inside. Installs what is missing here, too.
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
  mkdir -p "$root/usr/local/share/ca-certificates"  # whom this machine trusts beyond Debian's: ca-certificates takes them up
  for file in /usr/local/share/ca-certificates/*.crt; do [ ! -f "$file" ] || cp "$file" "$root/usr/local/share/ca-certificates/"; done
  for file in /etc/apt/apt.conf.d/*proxy*; do [ ! -f "$file" ] || cp "$file" "$root/etc/apt/apt.conf.d/"; done
  in_root=(chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive)
  for variable in "${passed[@]}"; do [ -z "${!variable:-}" ] || in_root+=("$variable=${!variable}"); done
}

# inside COMMANDS: by a shell in it that stops at the first that fails.
inside() { "${in_root[@]}" /bin/bash -euc "$1"; }

leave() {
  for mounted in dev/shm proc; do mountpoint -q "$root/$mounted" && umount "$root/$mounted"; done
  rm -rf --one-file-system "$place"
}

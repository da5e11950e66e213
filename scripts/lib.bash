# What the scripts of this folder share: sourced by them, from the root of the checkout.
set -euo pipefail
export LC_ALL=C.UTF-8

# Prints a stage's heading; the time since the one before is told where that took a while.
heading() {
  printf '\n== %s\n' "$1"
}

die() {
  printf '%s: %s\n' "${0##*/}" "$1" >&2
  exit 1
}

# Runs a command as root: directly, or with sudo.
as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    die "this is neither root nor is there sudo: as root, run '$*' in $PWD, then come back"
  fi
}

# build_dependencies [OPTIONS OF apt-get build-dep]: the Debian packages that debian/control names.
# apt is asked only when dpkg-checkbuilddeps (itself of build-essential) misses something.
build_dependencies() {
  local profiles=("${@/#--build-profiles=/-P}")
  if command -v dpkg-checkbuilddeps >/dev/null &&
    dpkg-checkbuilddeps "${profiles[@]}" 2>/dev/null; then
    return
  fi
  heading "Debian packages"
  # An unreachable third-party source must not stop what Debian's own archive can serve.
  as_root apt-get update -q || echo "apt-get update failed: going on with the lists at hand"
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get build-dep -q -y --no-install-recommends "$@" ./ ||
    die "apt-get could not install the packages that debian/control names (see above)"
}

# The version of clang that debian/control names: that of Debian 12 or of Debian 13.
clang_version() {
  if command -v clang++-14 >/dev/null; then echo 14; else echo 19; fi
}

# Compilers at once: one per core, as far as 1.5 GB of memory each go.
jobs_at_once() {
  local cores memory_kb
  cores=$(nproc)
  memory_kb=$(sed -n 's/^MemTotal: *\([0-9]*\) kB/\1/p' /proc/meminfo)
  local fit=$((memory_kb / 1500000))
  echo $((fit < 1 ? 1 : (fit < cores ? fit : cores)))
}

# configure_sanitized FOLDER SANITIZERS [CMAKE OPTIONS...]. At -O1 twice as quick to compile as at -O2,
# and the stacks are whole.
configure_sanitized() {
  local said
  said=$(cmake -S . -B "$1" -G Ninja "-DGPRODOM_SANITIZE=$2" "-DCMAKE_CXX_COMPILER=clang++-$(clang_version)" \
    -DCMAKE_BUILD_TYPE=Debug "-DCMAKE_CXX_FLAGS_DEBUG=-O1 -g1" -DGPRODOM_BENCHMARKS=OFF "${@:3}" 2>&1) ||
    { echo "$said"; die "cmake could not configure $1 (see above)"; }
}

# Memory and undefined behaviour; scripts/fuzz needs the same and its programs, so they share a folder.
configure_address() {
  configure_sanitized build-asan address,undefined -DGPRODOM_FUZZ=ON
}

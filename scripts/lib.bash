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

# Compilers at once: one per core, as far as 1.5 GB of memory each go.
jobs_at_once() {
  local cores memory_kb
  cores=$(nproc)
  memory_kb=$(sed -n 's/^MemTotal: *\([0-9]*\) kB/\1/p' /proc/meminfo)
  local fit=$((memory_kb / 1500000))
  echo $((fit < 1 ? 1 : (fit < cores ? fit : cores)))
}

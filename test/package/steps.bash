# What the scripts of this folder share, in a minimal Debian with /check: sourced by them.
set -euo pipefail
cd /check
export LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive
config=/etc/gprodom/gprodom.yaml
packages=(gprodom libgprodom0 python3-gprodom)

step() { printf -- '-- inside: %s\n' "$1"; }
fail() { printf 'inside: %s\n' "$1" >&2; exit 1; }

# apt, whose words are shown only where it fails.
quietly() {
  "$@" >/check/said 2>&1 </dev/null || { cat /check/said; fail "$*"; }
}
keep_edited=(-o Dpkg::Options::=--force-confdef -o Dpkg::Options::=--force-confold)
install() {
  quietly apt-get -q -y --no-install-recommends "${keep_edited[@]}" install "$@"
}

# rms EST TRUTH OPTIONS...: the RMS error of a score, in metres.
rms() {
  gprodom score "$@" --json | sed -n 's/^ *"ate_rmse_m": \([^,]*\),*$/\1/p'
}
at_most() {
  printf '%-55s %s m\n' "$1" "$2"
  awk -v e="$2" -v b="$3" 'BEGIN { exit !(e != "" && e <= b) }' || fail "$1: more than $3 m"
}

# Minimal Debian systems, in which packages are built, installed and tried: sourced after lib.bash by
# the scripts that check packages, from the root of the checkout. They have set `out`, where packages
# are left, and `work`, a temporary folder.
shopt -s inherit_errexit

# Exit code 3 where a root file system cannot be made and entered.
need_namespaces() {
  [ "$(id -u)" -eq 0 ] ||
    { echo "${0##*/}: run it as root: it makes a root file system and enters it" >&2; exit 3; }
  unshare --mount --pid --fork --mount-proc true 2>/dev/null ||
    { echo "${0##*/}: namespaces are not permitted here (unshare --mount --pid)" >&2; exit 3; }
}

# need_tools PACKAGE...: commands named as the packages that bring them.
need_tools() {
  local tool missing=()
  for tool in "$@"; do
    command -v "$tool" >/dev/null || missing+=("$tool")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  heading "Debian packages: ${missing[*]}"
  apt-get update -q || echo "apt-get update failed: going on with the lists at hand"
  DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}"
}

# sources_of RELEASE: lines of sources.list, on the Debian archive that this machine's apt uses.
sources_of() {
  apt-get indextargets --format 'deb $(REPO_URI) $(CODENAME) $(COMPONENT)' \
    'Created-By: Packages' 'Origin: Debian' |
    sed -nE "s/ (bookworm|trixie)/ $1/p" | sort -u | grep . ||
    die "apt knows no Debian archive here: run apt-get update, or see /etc/apt/sources.list.d"
}

# archive_has RELEASE ARCHITECTURE: whether that archive serves them.
archive_has() {
  local lists
  lists=$(mktemp -d -p "$work")
  mkdir -p "$lists/partial"
  sources_of "$1" | grep " $1 main" | sed "s/^deb /deb [arch=$2] /" >"$lists.list"
  apt-get update -q -o Dir::Etc::SourceList="$lists.list" -o Dir::Etc::SourceParts=- \
    -o Dir::State::Lists="$lists" -o APT::Architectures::="$2" >/dev/null 2>&1 || true
  compgen -G "$lists/*_dists_$1_main_binary-$2_Packages*" >/dev/null
}

# base_of RELEASE: prints the file of a minimal system, which is made again after a day.
base_of() {
  local base=$out/$1.tar.gz
  if [ -z "$(find "$base" -mtime -1 2>/dev/null)" ]; then
    apt-config dump --format '%f "%v";%n' Acquire | grep -vE '""|::(IndexTargets|Changelogs|cdrom)::' \
      >"$work/apt.conf"
    sources_of "$1" >"$work/sources"
    mmdebstrap --quiet --variant=minbase --include=gpgv --aptopt="$work/apt.conf" \
      --aptopt='APT::Install-Recommends "false"' --dpkgopt=force-unsafe-io "$1" \
      "$base" - <"$work/sources" >&2 || { rm -f "$base"; die "mmdebstrap failed (see above)"; }
  fi
  echo "$base"
}

# new_root RELEASE NAME: prints the folder of a new minimal system, with /check in it.
new_root() {
  local base root=$work/$2
  base=$(base_of "$1")
  mkdir "$root"
  tar -x -f "$base" -C "$root"
  cp /etc/resolv.conf "$root/etc/"
  mkdir "$root/check" "$root/ccache"
  echo "$root"
}

# enter ROOT COMMAND...: with mounts and processes of its own, and the compiler's cache at /ccache.
enter() {
  local cache=${CCACHE_DIR:-$HOME/.cache/ccache}
  mkdir -p "$cache"
  unshare --mount --pid --fork --mount-proc sh -e -c '
    root=$1; cache=$2; shift 2
    mount -t proc proc "$root/proc"
    mount --rbind /dev "$root/dev"
    mount --bind "$cache" "$root/ccache"
    exec chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root "$@"' sh "$1" "$cache" \
    LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive CCACHE_DIR=/ccache "${@:2}"
}

# enter_quietly ROOT COMMAND...: its words are shown only where it fails.
enter_quietly() {
  enter "$@" >"$work/said" 2>&1 </dev/null || { tail -n 40 "$work/said"; die "${*:2}: failed"; }
}

# copy_sources FOLDER: this checkout as it stands.
copy_sources() {
  mkdir -p "$1"
  git ls-files -z --cached --others --exclude-standard | tar -c --null -T - | tar -x -C "$1"
}

# build_packages LOG COMMAND...: dpkg-buildpackage, by a command that enters where it is to run. Without
# packages of debugging symbols, which nothing here looks at.
build_packages() {
  local log=$1
  shift
  "$@" >"$log" 2>&1 ||
    { tail -n 20 "$log"; df -h "$out"; die "dpkg-buildpackage failed; all of it is in $log"; }
}
build_options() {
  echo "DEB_BUILD_OPTIONS=nocheck noautodbgsym parallel=$(jobs_at_once)"
}

# make_previous PACKAGES FOLDER: in FOLDER the packages under an older number, with the configuration of 0.1,
# which had every key: the version before.
make_previous() {
  local deb tree
  mkdir -p "$2"
  for deb in "$1"/{gprodom,libgprodom0,python3-gprodom}_*.deb; do
    tree=$(mktemp -d -p "$work")
    dpkg-deb --raw-extract "$deb" "$tree"
    sed -i -E '/^(Version|Depends):/s/(Version: |\(= )[^)]+/\10.0.1/g' "$tree/DEBIAN/control"
    [ ! -d "$tree/etc" ] || cp test/package/gprodom-0.1.yaml "$tree/etc/gprodom/gprodom.yaml"
    dpkg-deb --root-owner-group --build "$tree" "$2" >/dev/null
  done
}

# root_with RELEASE NAME PACKAGES: prints the folder of a new minimal system, in whose /check lie what
# test/package and debian/tests take: packages (new/, from the folder PACKAGES), the sequence, scripts/live.
root_with() {
  local root
  root=$(new_root "$1" "$2")
  mkdir "$root/check/new"
  cp "$3"/*.deb "$root/check/new/"
  cp -r scripts/live test/package/* sample/*-cmu-gpr.zip "$root/check/"
  git ls-files -z --cached --others --exclude-standard debian sample test/outside \
    test/python/{conftest,made_drive,packets,test_export}.py test/python/pytest.ini \
    examples/cpp/{beacons,front_end} |
    tar -c --null -T - | tar -x --one-top-level="$root/check/source"
  echo "$root"
}

# run_autopkgtest RELEASE PACKAGES: debian/tests, in a minimal system.
run_autopkgtest() {
  local root
  root=$(root_with "$1" tests "$2")
  enter "$root" sh -e -c '
    { apt-get -q update && apt-get -q -y --no-install-recommends install autopkgtest; } \
      >/check/said 2>&1 || { cat /check/said; exit 1; }
    cd /check && autopkgtest new/*.deb source/ -- null >/check/said 2>&1 || { cat /check/said; exit 1; }
    sed -n "/ summary$/,\$p" /check/said'
  rm -rf "$root"
}

# begin_piuparts RELEASE PACKAGES starts it, as process $piuparts; end_piuparts PACKAGES waits for it. What
# systemd and debconf leave, on which the packages depend, is ignored.
begin_piuparts() {
  local path ignored=()
  for path in ~root/.ssh/ /var/{cache,lib,log}/private/ /var/lib/systemd/{coredump,pstore}/ \
    /etc/default/locale /etc/vconsole.conf /var/cache/debconf/tmp.ci/; do
    ignored+=("--ignore=$path")
  done
  piuparts --no-upgrade-test --no-eatmydata --keep-sources-list -d "$1" "${ignored[@]}" \
    -b "$out/$1.tar.gz" "$2"/{gprodom,libgprodom0,libgprodom-dev,python3-gprodom,ros2-gprodom}_*.deb \
    >"$2/piuparts.log" 2>&1 &
  piuparts=$!
}
end_piuparts() {
  wait "$piuparts" || { tail -n 40 "$1/piuparts.log"; die "piuparts: all of it is in $1/piuparts.log"; }
  piuparts=
  grep -E "PASS|leftover|WARN" "$1/piuparts.log" || true
}

# since STARTED: the time that a script has taken so far.
since() {
  echo "-- $((SECONDS - $1)) s"
}

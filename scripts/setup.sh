# shellcheck shell=bash disable=SC2154
# From a bare clone to a built program: packages, build folder, build. Sourced by run.sh, test.sh, .ci/run and the scripts
# beside it, which `set -euo pipefail` and set `repo`, the absolute path of the clone.
# All of it writes to stderr, because stdout belongs to the program. Exit status 2: the set-up could not be done.

note() { printf 'evenstep: %s\n' "$*" >&2; }
fail() { note "$@"; exit 2; }

# --- packages ---------------------------------------------------------------------------------------------------------

package_lists=("$repo/scripts/packages.txt")
lists_are_fresh=   # once the lists of what can be installed have been fetched
tests=OFF   # whether the build has the tests: they need packages that running does not

# with_tests : the build that set_up makes has the tests, and what they need is installed
with_tests() {
  package_lists+=("$repo/scripts/test-packages.txt")
  tests=ON
}

# A line for each package: its name, or alternatives, such as "libclang-rt-14-dev | libclang-rt-dev": the names that releases
# of Debian have for it. The last one may be "none", where a release may be without it.
packages_wanted() { sed -E 's/[[:space:]]*(#.*)?$//; /^$/d' "${package_lists[@]}"; }

# packages_missing : the lines of which no alternative is installed
packages_missing() {
  local wanted names line name
  local -A is_installed
  mapfile -t wanted < <(packages_wanted | sort -u)
  read -ra names <<<"${wanted[*]//|/ }"
  # dpkg-query exits with 1 when one name is unknown to it, and prints the others all the same.
  while read -r name; do is_installed[$name]=yes; done \
    < <(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "${names[@]}" 2>/dev/null | sed -n 's/^installed //p')
  for line in "${wanted[@]}"; do
    for name in ${line//|/ }; do
      [[ ! ${is_installed[$name]-} ]] || continue 2
    done
    printf '%s\n' "$line"
  done
}

# packages_chosen LINE... : of each line the first alternative that apt has (the first of all, if it has none of them). Says
# so where that is another one.
packages_chosen() {
  local line first name
  for line in "$@"; do
    first=${line%% *}
    for name in ${line//|/ }; do
      if [[ $line == "$first" || $name == none ]] || apt-cache show "$name" >/dev/null 2>&1; then break; fi
      name=$first
    done
    case $name in
      none) note "this system has no package $first: what needs it is left out" ;;
      "$first") printf '%s\n' "$name" ;;
      *) note "this system has no package $first: $name is installed in its place"; printf '%s\n' "$name" ;;
    esac
  done
}

# run_apt ARGUMENTS... : apt-get through "${as_root[@]}". It waits for the dpkg lock by itself, but not for the locks on
# its lists and downloads, which a machine's own daily update holds for some minutes after the first boot.
run_apt() {
  local log status give_up=$((SECONDS + 300))
  log=$(mktemp) || fail "no temporary file can be made under ${TMPDIR:-/tmp}"
  while :; do
    status=0
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive LC_ALL=C apt-get -o DPkg::Lock::Timeout=300 "$@" </dev/null 2>&1 |
      tee -- "$log" >&2 || status=$?
    if ((status == 0 || SECONDS >= give_up)) || ! grep -qi 'could not get lock\|unable to lock' -- "$log"; then break; fi
    note "another program is using apt-get; trying again in 5 s"
    sleep 5
  done
  rm -f -- "$log"
  return "$status"
}

install_packages() {
  local missing chosen as_root=() install
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    is_configured || note "not a Debian system: nothing is installed, the build is tried with what is here. Needed, by" \
      "their Debian names: $(packages_wanted | sed 's/ | /|/g' | tr '\n' ' ')"
    return 0
  fi
  mapfile -t missing < <(packages_missing)
  ((${#missing[@]})) || return 0
  note "packages are missing and will be installed: ${missing[*]// | /|}"

  if (($(id -u) != 0)); then
    if command -v sudo >/dev/null; then
      as_root=(sudo)
      [[ -t 2 ]] || as_root=(sudo -n)   # nobody is there to type a password
    fi
    if ((${#as_root[@]} == 0)) || ! "${as_root[@]}" true; then
      mapfile -t chosen < <(packages_chosen "${missing[@]}")
      install="apt-get install -y --no-install-recommends ${chosen[*]}"
      note "installing them needs root. Run this line, then try again:"
      if ((${#as_root[@]})); then
        echo "sudo apt-get update && sudo $install" >&2
      else
        echo "su -c 'apt-get update && $install'" >&2
      fi
      exit 2
    fi
  fi
  [[ $lists_are_fresh ]] || run_apt update ||
    fail "apt-get update failed: see its errors above. Is there a network, and are the package sources right?"
  lists_are_fresh=yes
  mapfile -t chosen < <(packages_chosen "${missing[@]}")
  ((${#chosen[@]})) || return 0
  run_apt install -y --no-install-recommends "${chosen[@]}" ||
    fail "apt-get install failed: see its errors above. Debian 12 and 13 have all of: ${chosen[*]}"
}

# --- build folder -----------------------------------------------------------------------------------------------------

# The first of these that belongs to us and can be written: build/ in the clone; for a read-only clone, or a build/ of
# another user (root's after `sudo ./run.sh`), a folder in the user's cache or the temporary folder, named after user and
# clone. Never a folder of somebody else: programs are run from it, and files of two owners in one build break it.
build_folder() {
  local folder name
  name=evenstep-build-$(id -u)-$(printf '%s' "$repo" | sha256sum | cut -c1-12)
  for folder in "$repo/build" ${XDG_CACHE_HOME:+"$XDG_CACHE_HOME/$name"} "${TMPDIR:-/tmp}/$name"; do
    if mkdir -p -- "$folder" 2>/dev/null && [[ -O $folder && -w $folder ]]; then
      printf '%s\n' "$folder"
      return 0
    fi
  done
  fail "no folder to build in: neither $repo/build nor ${TMPDIR:-/tmp}/$name is ours to write"
}

# --- build ------------------------------------------------------------------------------------------------------------

# A cache that names another source folder came along when the clone was moved or copied.
is_configured() {
  local home
  [[ -e $build/build.ninja && -e $build/CMakeCache.txt ]] || return 1
  home=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build/CMakeCache.txt")
  [[ $home -ef $repo ]]
}

# has_tests : the tests are part of the configured build
has_tests() { ! grep -q '^EVENSTEP_BUILD_TESTS:BOOL=OFF$' "$build/CMakeCache.txt"; }

configure() {  # configure PRESET [--fresh]
  note "configuring ${build/#"$repo/"/}"
  (cd -- "$repo" && cmake "${@:2}" --preset "$1" -B "$build" -D EVENSTEP_BUILD_TESTS="$tests") \
    >"$build/configure.log" 2>&1 || {
    cat -- "$build/configure.log" >&2
    fail "CMake could not configure the build: see above"
  }
}

# compile NOTE TARGET... : says NOTE if there is anything to build. The whole output is in build.log.
compile() {
  cmake --build "$build" --target "${@:2}" --parallel "$(nproc)" 2>&1 | tee -- "$build/build.log" | show_progress "$1" || {
    [[ -t 2 ]] || cat -- "$build/build.log" >&2
    fail "the build failed: see above"
  }
}

# Ninja's lines on stdin: prints NOTE before the first that builds something, and on a terminal a running count. Whatever
# else there is to read (the compiler's words) is printed in full.
show_progress() {  # show_progress NOTE
  local line building=
  while IFS= read -r line; do
    case $line in
      *'Re-checking globbed directories'* | *'Re-running CMake'* | 'ninja: no work to do.' | '-- '*) ;;
      '['[0-9]*/*)
        [[ $building ]] || note "$1"
        building=yes
        if [[ -t 2 ]]; then printf '\r%s\e[K' "${line%%]*}]"; fi
        ;;
      *) if [[ -t 2 ]]; then printf '\r\e[K%s\n' "$line"; fi ;;
    esac
  done
  if [[ $building && -t 2 ]]; then printf '\r\e[K'; fi
}

# set_up PRESET TARGET... : afterwards `build` is the build folder of the preset (CMakePresets.json), and each TARGET in it
# is up to date. `release` has the build folder itself, any other preset a folder of its name in it. One caller at a time.
set_up() {
  local preset=$1
  shift
  build=$(build_folder)
  [[ $preset == release ]] || build+=/$preset
  # PoCL keeps compiled kernels below HOME unless told otherwise, and answers every call with error -36 where it cannot.
  export POCL_CACHE_DIR=${POCL_CACHE_DIR:-$build/pocl-cache}
  mkdir -p -- "$POCL_CACHE_DIR"
  (
    flock -n 9 || { note "waiting for another build in $build"; flock 9; }
    install_packages
    if ! is_configured; then
      configure "$preset" --fresh
      compile "building (the first time: some minutes)" "$@"
    else
      # Tests come into a build that has none, and stay: run.sh and test.sh take turns in one folder, and what the program is
      # made of is the same with and without them.
      if [[ $tests == ON ]] && ! has_tests; then configure "$preset"; fi
      compile "building what changed" "$@"
    fi
  ) 9>"$build/.lock" </dev/null >&2
}

#!/usr/bin/env bash
# debian_test.sh SOURCE_DIR BUILD_DIR : makes the Debian packages of the build, and installs, uses and removes them in a new
# Debian of this machine's release (tests/distro/new_debian.sh). debian_test.sh commands : prints how the packages are made,
# as in docs/begin/install.md
set -euo pipefail
commands=$'cmake --preset release\ncmake --build build\ncpack --config build/CPackConfig.cmake -B packages'
if [[ $1 == commands ]]; then
  printf '%s\n' "$commands"
  exit
fi
source_dir=$1 build_dir=$2
source "$source_dir/tests/distro/new_debian.sh"
new_debian "$(. /etc/os-release && echo "$VERSION_CODENAME")"

cpack_command=$(tail -1 <<<"$commands")
cpack_command=${cpack_command/build\//$build_dir/}
quietly ${cpack_command/packages/$debian/packages}
quietly within apt-get update
try_packages

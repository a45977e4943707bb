#!/usr/bin/env bash
# symbols.sh LIBRARY HEADER : checks that the shared library exports exactly the functions that the header declares.
set -uo pipefail
command -v nm >/dev/null || { echo 'skipped: nm (binutils) is not installed'; exit 77; }
diff <(grep -oE '\bevenstep_remap_[a-z_]+\(' "$2" | tr -d '(' | sort -u) \
  <(nm -D --defined-only "$1" | awk '{ print $3 }' | sort -u) ||
  { echo '< declared, > shown'; exit 1; }

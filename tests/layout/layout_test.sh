#!/usr/bin/env bash
# layout_test.sh SOURCE_DIR CASE : runs one case; exits 1 on failure, 77 when it cannot run here (its output says why).
set -uo pipefail
sources=$1
format=$sources/scripts/format.sh
work=$(mktemp -d "${TMPDIR:-/tmp}/evenstep-layout-XXXXXX")
trap 'rm -rf "$work"' EXIT
cp "$sources/.clang-format" "$work"

fail() { printf 'FAILED: %s\n' "$1"; exit 1; }
# in_copy MODE : checks the files in $work
in_copy() {
  EVENSTEP_FORMAT_ROOT=$work "$format" "$1" >"$work/out" 2>&1
  status=$?
  ((status != 77)) || { cat "$work/out"; exit 77; }
}
line_of() { printf '%*s' "$1" '' | tr ' ' "$2"; }

# The check builds asan-ubsan only after half of its time, and fuzz never; the preset dev is built by another test.
case_cmake_can_configure_the_presets_of_clang() {
  local preset
  command -v clang++ >/dev/null || { echo "skipped: there is no clang++"; exit 77; }
  for preset in asan-ubsan fuzz; do
    cmake -S "$sources" --preset "$preset" -B "$work/$preset" >"$work/out" 2>&1 || { cat "$work/out"; fail "$preset"; }
  done
}
case_no_line_is_longer_than_125_columns() { "$format" columns; }
case_the_sources_are_laid_out_by_clang_format() { "$format" layout; }
case_a_line_of_126_columns_is_seen_in_every_kind_of_file() {
  local name
  for name in a.cpp a.h a.cl a.sh a.cmake CMakeLists.txt; do
    line_of 125 x >"$work/$name"
    in_copy columns
    ((status == 0)) || fail "125 columns in $name are too many"
    line_of 126 x >"$work/$name"
    in_copy columns
    ((status == 1)) && grep -qF "./$name:1: longer" "$work/out" || fail "126 columns in $name are not seen"
    rm "$work/$name"
  done
}
case_columns_are_characters_not_bytes() {
  line_of 124 x >"$work/a.cpp"
  printf '\303\251\n' >>"$work/a.cpp"
  in_copy columns
  ((status == 0)) || fail "a letter of two bytes counts twice"
}
case_another_layout_is_seen_and_mended() {
  printf 'int  f( ){return 1;}\n' >"$work/a.cpp"
  in_copy layout
  ((status == 1)) && grep -qF './a.cpp:1' "$work/out" || fail "it is not seen"
  in_copy fix
  in_copy layout
  ((status == 0)) || fail "it is not mended"
}
# Catch2 indents the name of a failed test by what comes before the first ": ", and aborts if that leaves no room in its 79
# columns.
case_catch2_can_print_the_name_of_every_test() {
  local names
  names=$(grep -rhoE 'TEST_CASE\("[^"]+' "$sources/tests" --include='*.cpp' | sed -nE 's/^TEST_CASE\("(.{74,}): .*/\1/p')
  [[ ! $names ]] || fail "\": \" comes too late in: $names"
}
# CMake takes a name with ";" for two names. Neither is a test, so both would pass without running anything.
case_no_name_of_a_test_has_a_semicolon() {
  local names string='"([^"\\]|\\.)*"'
  names=$(grep -rhPzo "TEST_CASE\(\s*($string\s*)*\"[^\"]*;[^\"]*\"" "$sources/tests" --include='*.cpp' | tr '\0' '\n')
  [[ ! $names ]] || fail "\";\" in: $names"
}
case_no_file_has_marks_of_a_merge() {
  local marks
  marks=$(grep -rnIE '^\s*(<{7}|>{7}) ' "$sources" --exclude-dir=.git --exclude-dir='build*' | head -n 5)
  [[ ! $marks ]] || fail "marks of a merge: $marks"
}
case_what_is_built_is_not_looked_at() {
  mkdir "$work/build" "$work/build-dev"
  line_of 126 x | tee "$work/build/a.cpp" >"$work/build-dev/a.cpp"
  in_copy columns
  ((status == 0)) || fail "files of a build are looked at"
}

declare -F "case_$2" >/dev/null || { echo "no case $2"; exit 2; }
"case_$2"

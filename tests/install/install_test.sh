#!/usr/bin/env bash
# install_test.sh SOURCE_DIR BUILD_DIR WORK CASE [ARGUMENT] : runs one case; prints what was said and exits with 1 on
# failure, with 77 when it cannot run here. The case goes_into_a_clean_prefix comes first: it makes WORK/prefix.
set -euo pipefail
source_dir=$1 build_dir=$2 work=$3 name=$4
prefix="$work/a moved prefix"
here=$work/$name${5:+-$(basename -- "$5")}
rm -rf -- "$here"
mkdir -p -- "$here"
cd -- "$here"

fail() { printf 'FAILED: %s\n' "$*"; exit 1; }
quietly() { "$@" >"$here/log" 2>&1 || { cat "$here/log"; fail "$*"; }; }
# refused TEXT COMMAND... : the command fails and says TEXT (line breaks do not matter)
refused() {
  local text=$1
  shift
  if "$@" >log 2>&1; then fail "this should be refused: $*"; fi
  tr -s ' \n' ' ' <log | grep -qF -- "$text" || { cat log; fail "it does not say '$text': $*"; }
}

# Switches off the packages of others that evenstep uses, as on a machine that has only a compiler and CMake.
without_packages=()
for package in fmt spdlog glm tomlplusplus CLI11 nlohmann_json Boost; do
  without_packages+=(-D "CMAKE_DISABLE_FIND_PACKAGE_$package=ON")
done

case_goes_into_a_clean_prefix() {
  rm -rf -- "$work/a prefix" "$prefix"
  local component
  for component in runtime dev; do
    quietly cmake --install "$build_dir" --component "$component" --prefix "$work/a prefix"
  done
  # The other cases run after the move, so what relies on the path of the prefix or of the build does not work in them.
  mv -- "$work/a prefix" "$prefix"
  ! grep -rlIF -e "$work/a prefix" -e "$build_dir" -e "$source_dir" -- "$prefix" || fail "installed files with such a path"
}
case_the_program_has_a_version_and_finds_its_scenarios() {
  local version
  version=$(sed -nE 's/^project\(evenstep VERSION ([0-9.]+).*/\1/p' "$source_dir/CMakeLists.txt")
  [[ $("$prefix/bin/evenstep" --version) == "evenstep $version" ]] || fail "another version than $version"
  grep -qx "version: $version" "$source_dir/CITATION.cff" || fail "CITATION.cff names another version"
  [[ $(grep -m1 '^## ' "$source_dir/CHANGELOG.md") == "## $version" ]] || fail "CHANGELOG.md begins with another version"
  quietly "$prefix/bin/evenstep" run scenarios/paper/figure-1-spring.toml
  grep -q PASS log || { cat log; fail "no verdict"; }
  quietly "$prefix/bin/evenstep" list
  grep -q 'a moved prefix/share/evenstep/scenarios/paper/figure-1.toml' log || { cat log; fail "list finds no scenario"; }
  mkdir -p scenarios/paper   # a scenario in the current folder takes precedence
  echo 'format = 2' >scenarios/paper/figure-1-spring.toml
  refused 'scenarios/paper/figure-1-spring.toml:1' "$prefix/bin/evenstep" run scenarios/paper/figure-1-spring.toml
}
case_each_header_compiles_alone() {
  local flags=(-std=c++20 -fsyntax-only -Wall -Wextra -Werror "-I$prefix/include")
  (cd -- "$prefix/include" && find evenstep -name '*.h' | sort) >headers
  (($(wc -l <headers) >= 100)) || fail "too few headers are installed"
  xargs -a headers -P "$(nproc)" -I HEADER \
    sh -c 'header=$1; shift; echo "#include <$header>" | ${CXX:-c++} "$@" -x c++ -' sh HEADER "${flags[@]}" >log 2>&1 ||
    { cat log; fail "a header needs another before it"; }
}
case_a_component_brings_what_it_sees_and_no_more() {
  cat >CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(components LANGUAGES CXX)
find_package(evenstep ${VERSION} REQUIRED COMPONENTS ${COMPONENTS})
get_property(imported DIRECTORY PROPERTY IMPORTED_TARGETS)
list(SORT imported)
message(STATUS "imported: ${imported}")
END
  quietly cmake -S . -B build -D CMAKE_PREFIX_PATH="$prefix" -D COMPONENTS="remap;scheduler" "${without_packages[@]}"
  local targets='Threads::Threads;evenstep::clock;evenstep::evenstep;evenstep::remap;evenstep::remap_c;'
  targets+='evenstep::remap_c_shared;evenstep::scheduler;evenstep::time'
  grep -qx -- "-- imported: $targets" log || { cat log; fail "other targets"; }
  refused "without the component 'solver'; it has: time, clock" \
    cmake -S . -B build -D CMAKE_PREFIX_PATH="$prefix" -D COMPONENTS="remap;solver"
  refused 'find_package for module fmt called with REQUIRED' \
    cmake -S . -B build2 -D CMAKE_PREFIX_PATH="$prefix" -D COMPONENTS=harness "${without_packages[@]}"
  refused 'compatible with requested version "0.3"' \
    cmake -S . -B build3 -D CMAKE_PREFIX_PATH="$prefix" -D COMPONENTS=remap -D VERSION=0.3
}
case_pkg_config_finds_it() {
  command -v pkg-config >/dev/null || { echo "skipped: pkg-config is not installed"; exit 77; }
  export PKG_CONFIG_PATH
  PKG_CONFIG_PATH=$(dirname -- "$(find "$prefix" -name evenstep-remap.pc)")
  local package version flags
  version=$("$prefix/bin/evenstep" --version)
  for package in evenstep evenstep-remap evenstep-scheduler; do
    [[ evenstep\ $(pkg-config --modversion "$package") == "$version" ]] || fail "$package: another version"
  done
  eval "flags=($(pkg-config --cflags --libs evenstep-scheduler))"
  quietly "${CXX:-c++}" -std=c++20 "$source_dir/examples/scheduler/two_lanes.cpp" -o two_lanes "${flags[@]}" ${LDFLAGS-}
  ./two_lanes | grep -q '12 ticks' || fail "the program does not run"
  eval "flags=($(pkg-config --cflags --libs evenstep))"
  quietly "${CXX:-c++}" -std=c++20 "$source_dir/apps/main.cpp" -o my_evenstep "${flags[@]}" ${LDFLAGS-}
  [[ $(./my_evenstep --version) == "$version" ]] || fail "the program does not run"
}
# A program in C99, compiled and linked as C: with the shared library, and with the static one where all is static.
case_pkg_config_serves_a_program_in_c() {
  command -v pkg-config >/dev/null || { echo "skipped: pkg-config is not installed"; exit 77; }
  export PKG_CONFIG_PATH
  PKG_CONFIG_PATH=$(dirname -- "$(find "$prefix" -name evenstep-remap-c.pc)")
  local flags libraries program=$source_dir/examples/remap_c/remap_c.c
  [[ $("$prefix/bin/evenstep" --version) == "evenstep $(pkg-config --modversion evenstep-remap-c)" ]] ||
    fail "another version"
  eval "flags=($(pkg-config --cflags --libs evenstep-remap-c))"
  quietly "${CC:-cc}" -std=c99 "$program" -o shared "${flags[@]}" -lm ${LDFLAGS-}
  eval "libraries=$(pkg-config --variable=libdir evenstep-remap-c)"   # with the blanks of the path as a shell wants them
  LD_LIBRARY_PATH=$libraries quietly ./shared
  LD_LIBRARY_PATH=$libraries ldd shared | grep -q "$(basename -- "$prefix").*libevenstep_remap_c" ||
    fail "not the shared library of the prefix"
  eval "flags=($(pkg-config --static --cflags --libs evenstep-remap-c))"
  quietly "${CC:-cc}" -std=c99 -static "$program" -o static "${flags[@]}" -lm ${LDFLAGS-}
  quietly ./static
}

# A project with its own settings that adds evenstep as a folder.
case_a_parent_keeps_its_settings_and_targets() {
  cat >CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(parent VERSION 7.1 LANGUAGES CXX)
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_FLAGS "-DPARENT")
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
add_library(mine STATIC mine.cpp)
foreach(name IN ITEMS check docs install_test examples)   # names that projects like
  add_custom_target(${name})
endforeach()

function(all_targets out folder)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(below IN LISTS folders)
    all_targets(more ${below})
    list(APPEND targets ${more})
  endforeach()
  set(${out} ${targets} PARENT_SCOPE)
endfunction()
# Variables, properties of the folder, of the whole and of the parent's target; what a target is made of.
function(look out)
  get_cmake_property(variables VARIABLES)
  list(FILTER variables INCLUDE REGEX "^(CMAKE|CPACK|BUILD|CTEST)_")
  list(FILTER variables EXCLUDE REGEX "^CMAKE_(ARG|CURRENT_FUNCTION|MATCH|HAVE_LIBC_PTHREAD)")
  list(SORT variables)
  set(seen "")
  foreach(variable IN LISTS variables)
    string(APPEND seen "${variable} = ${${variable}}\n")
  endforeach()
  foreach(property IN ITEMS COMPILE_OPTIONS COMPILE_DEFINITIONS INCLUDE_DIRECTORIES LINK_OPTIONS LINK_DIRECTORIES TESTS
      IMPORTED_TARGETS)
    get_property(value DIRECTORY PROPERTY ${property})
    string(APPEND seen "folder ${property} = ${value}\n")
  endforeach()
  foreach(property IN ITEMS GLOBAL_DEPENDS_NO_CYCLES RULE_LAUNCH_COMPILE USE_FOLDERS GLOBAL_DEPENDS_DEBUG_MODE JOB_POOLS)
    get_property(value GLOBAL PROPERTY ${property})
    string(APPEND seen "global ${property} = ${value}\n")
  endforeach()
  foreach(property IN ITEMS COMPILE_OPTIONS CXX_STANDARD POSITION_INDEPENDENT_CODE UNITY_BUILD LINK_LIBRARIES)
    get_property(value TARGET mine PROPERTY ${property})
    string(APPEND seen "mine ${property} = ${value}\n")
  endforeach()
  set(${out} "${seen}" PARENT_SCOPE)
endfunction()

look(before)
add_subdirectory("${EVENSTEP_SOURCE}" evenstep)
look(after)
file(WRITE before "${before}")
file(WRITE after "${after}")
all_targets(targets ${EVENSTEP_SOURCE})
list(FILTER targets EXCLUDE REGEX "^evenstep(_|$)")
if(targets)
  message(FATAL_ERROR "targets with other people's names: ${targets}")
endif()
END
  echo 'int mine() { return __cplusplus == 201703L ? 1 : 2; }' >mine.cpp
  quietly cmake -S . -B build -D EVENSTEP_SOURCE="$source_dir"
  [[ -s before ]] || fail "nothing was compared"
  diff before after || fail "evenstep changes these settings of its parent (< before, > after)"
  grep -q '^CMAKE_BUILD_TYPE:STRING=$' build/CMakeCache.txt || fail "CMAKE_BUILD_TYPE of the parent is set"
  ! grep -q 'EVENSTEP_\(BUILD_TESTS\|BUILD_BENCH\|INSTALL\):BOOL=ON' build/CMakeCache.txt ||
    fail "tests, benchmarks or the installation come along unasked"
  quietly cmake --install build --prefix "$here/prefix"
  [[ ! -e prefix/include ]] || fail "the parent's installation has evenstep in it"
}
# There are no packages, only a compiler. The parent's flags are strict.
case_fetchcontent_builds_clock_scheduler_and_remap_with_a_compiler_alone() {
  cat >CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(parent LANGUAGES CXX)
include(FetchContent)
set(EVENSTEP_COMPONENTS remap scheduler)
FetchContent_Declare(evenstep URL https://example.invalid/evenstep.tar.gz)
FetchContent_MakeAvailable(evenstep)
add_executable(two_lanes "${TWO_LANES}")
target_link_libraries(two_lanes PRIVATE evenstep::scheduler evenstep::remap)
enable_testing()
add_test(NAME two_lanes COMMAND two_lanes)
END
  quietly cmake -S . -B build -D FETCHCONTENT_SOURCE_DIR_EVENSTEP="$source_dir" -D CMAKE_UNITY_BUILD=ON \
    -D TWO_LANES="$source_dir/examples/scheduler/two_lanes.cpp" -D CMAKE_CXX_FLAGS=-Werror "${without_packages[@]}"
  quietly cmake --build build --parallel 2 --target two_lanes
  quietly ctest --test-dir build --no-tests=error
}
case_components_that_are_not_there_and_tests_of_a_part_are_refused() {
  refused "there is no 'solver'; there are: all apps" cmake -S "$source_dir" -B build -D EVENSTEP_COMPONENTS=solver
  refused 'The tests and benchmarks need all of evenstep' \
    cmake -S "$source_dir" -B build2 -D EVENSTEP_COMPONENTS=remap -D EVENSTEP_BUILD_TESTS=ON
  refused 'set EVENSTEP_OPENCL to OFF' \
    cmake -S "$source_dir" -B build3 -D EVENSTEP_COMPONENTS=sim -D OPENCL_INCLUDE_DIR=OPENCL_INCLUDE_DIR-NOTFOUND \
    -D CMAKE_FIND_ROOT_PATH=/nowhere -D CMAKE_FIND_ROOT_PATH_MODE_INCLUDE=ONLY
  quietly cmake -S "$source_dir" -B build4 -D EVENSTEP_OPENCL=OFF -D EVENSTEP_HIDAPI=OFF -D EVENSTEP_INVERSE3=OFF \
    -D EVENSTEP_DRAW=OFF -D EVENSTEP_PROFILES=OFF -D EVENSTEP_SCOPE=OFF -D CMAKE_FIND_ROOT_PATH_MODE_PROGRAM=NEVER
}
case_a_compiler_or_library_that_is_too_old_is_refused_with_its_version() {
  local package folders=() packages=(fmt spdlog glm tomlplusplus CLI11 nlohmann_json)
  CXXFLAGS='-U__GNUC__ -D__GNUC__=11 -U__clang_major__ -D__clang_major__=11 -w' refused 'or later: ' \
    cmake -S "$source_dir" -B build -D EVENSTEP_COMPONENTS=time
  grep -qE 'needs (GNU 12|Clang 14) or later' log || { cat log; fail "not which version is needed"; }
  # Packages that are empty, and all but one of them new enough.
  for package in "${packages[@]}" Boost; do   # CMake 3.30 and later look for Boost there, too
    mkdir "$package"
    touch "$package/${package}Config.cmake"
    echo 'set(PACKAGE_VERSION_COMPATIBLE ON)' >"$package/${package}ConfigVersion.cmake"
    folders+=(-D "${package}_DIR=$here/$package")
  done
  for package in "${packages[@]}"; do
    echo 'set(PACKAGE_VERSION 0.1)' >"$package/${package}ConfigVersion.cmake"
    refused "configuration file for package \"$package\" that is compatible with requested version" cmake -S "$source_dir" \
      -B "build-$package" "${folders[@]}" -D CMAKE_FIND_ROOT_PATH=/nowhere -D CMAKE_FIND_ROOT_PATH_MODE_PACKAGE=ONLY
    echo 'set(PACKAGE_VERSION_COMPATIBLE ON)' >"$package/${package}ConfigVersion.cmake"
  done
}
case_the_package_of_python_is_a_component_of_its_own() {
  local module python
  module=$(find "$build_dir/apps/python/evenstep" -name '_core.*.so' 2>/dev/null)
  [[ $module ]] || { echo "skipped: EVENSTEP_PYTHON is off"; exit 77; }
  [[ ! -d $prefix/lib/python3 ]] || fail "another component brings it"
  quietly cmake --install "$build_dir" --component python --prefix "$here/only"
  [[ $(cd only && find . -mindepth 2 -maxdepth 2 | sort | tr '\n' ' ') == './lib/python3 ./share/doc ' ]] ||
    fail "it brings more"
  python=$(sed -n 's/^_Python3_EXECUTABLE:INTERNAL=//p' "$build_dir/CMakeCache.txt")
  "$python" -c 'import numpy' 2>/dev/null || { echo "skipped: $python has no numpy"; exit 77; }
  cat >use.py <<'END'
import sys
import evenstep
run = evenstep.run(sys.argv[1])
print(evenstep.__file__, run.verdict, len(run.series["paper"].steps))
END
  PYTHONPATH=$here/only/lib/python3/dist-packages quietly "$python" use.py \
    "$prefix/share/evenstep/scenarios/paper/figure-1-spring.toml"
  grep -qx "$here/only/lib/python3/dist-packages/evenstep/__init__.py pass 1799" log || { cat log; fail "another answer"; }
}
# The commands of docs/begin/install.md, exactly as they are there, and the project that its listings make.
case_the_page_says_what_works() {
  source "$source_dir/tests/install/page.sh"
}
# use_example FOLDER
use_example() {
  [[ $1 != */csharp ]] || command -v mcs >/dev/null || { echo "skipped: there is no mcs (Debian: mono-mcs)"; exit 77; }
  cp -r -- "$1" example
  quietly cmake -S example -B build -D CMAKE_PREFIX_PATH="$prefix"   # its output does not depend on optimization
  quietly cmake --build build
  PATH=$prefix/bin:$PATH quietly ctest --test-dir build --no-tests=error --output-on-failure
}

case $name in
  example) use_example "$5" ;;
  *) "case_$name" ;;
esac

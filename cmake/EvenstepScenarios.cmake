# evenstep_add_scenarios(DIRECTORY folder [LABELS label...] [RECURSE] [PROGRAM target])
#
# A ctest for each scenario (*.toml) in `folder`, with RECURSE also for those below it: "scenario: folder/name.toml". It
# passes if `evenstep run` exits with 0, that is if all expectations hold; its output has the verdict table and, if it
# fails, the command that runs it again. Its run folder (figures, summary.json, junit.xml) is evenstep-runs/folder/name in
# the build folder.
#
#   folder   relative to the calling CMakeLists.txt; if it is not below that, names start with its last part. A folder
#            without a scenario is an error. Scenarios that are added later are found by the next build. As in `evenstep run
#            FOLDER`, run folders inside are not searched.
#   LABELS   labels of all of these tests. The `tags` of a scenario, also those that it inherits, are labels of its test:
#            `ctest -LE '^long$'` leaves out the long ones.
#   PROGRAM  a target that calls evenstep::command_line, if scenarios name parts of your own; default: evenstep itself
#
# evenstep_add_sizing(NAME name RECORDINGS folder [LATENCY time] [LEAD time] [RINGS samples forces] [MAP map]
#                     [PER time [CONFIDENCE share]] [LABELS label...] [PROGRAM target] [OPTIONS option...])
#
# A ctest for each recording in `folder`: "sizing: name: folder/file". It passes if what the program has is enough for the
# timing of the recording, at any phase of the device (`evenstep size --fits`). Its output says what would be, which hitch
# sets it, and the command that says so again. Its run folder, for `evenstep compare` and `evenstep index`, is
# evenstep-runs/sizing/name/folder/file in the build folder.
#
#   RECORDINGS  every file of the folder but *.md: timing.csv, lists of steps, files of profilers, scenarios. A file that is
#               none of these is a test that fails. Recordings that are added later are found by the next build.
#   LATENCY     such as "20 ms"; with LEAD, RINGS, MAP, PER and CONFIDENCE as in `--fits`. One of LATENCY, LEAD and RINGS
#               must be given.
#   PER         such as "1 h": enough for so long, with CONFIDENCE "95 %" (default) and one late segment at most. It
#               fails where the recording does not say.
#   OPTIONS     further options of `evenstep size`: --sampling "1 kHz", --emission linear, --rate "1 %", --steps 15
#
# Both work after find_package(evenstep COMPONENTS program), and where evenstep is a part of the build. enable_testing() or
# include(CTest) must come first; after include(CTest) with BUILD_TESTING=OFF they add nothing. There is no exit code for
# "skipped": a scenario that is named is run, and what it needs and does not find (an OpenCL device) is a failure that says
# so.
include_guard(GLOBAL)

# The tags of a scenario: its own, or those of the last file in `extends` that has some. This reads as much TOML as it needs
# to; what it does not understand has no tags here, and `evenstep run` judges the file.
function(_evenstep_tags out file depth)
  set(${out} "" PARENT_SCOPE)
  if(depth GREATER 16 OR NOT EXISTS "${file}")  # a chain that has no end is reported by the run
    return()
  endif()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
  file(READ "${file}" text)
  # Brackets and semicolons have a meaning in lists of CMake. In front of the first table are the keys of the top.
  string(REPLACE ";" " " text "\n${text}")
  string(REGEX REPLACE "\n[ \t]*\\[.*" "\n" text "${text}")
  string(REGEX REPLACE "\n[ \t]*#[^\n]*" "" text "${text}")
  if(text MATCHES "\n[ \t]*tags[ \t]*=[ \t]*\\[([^]]*)\\]")
    string(REGEX MATCHALL "[\"'][^\"']*[\"']" tags "${CMAKE_MATCH_1}")
    string(REGEX REPLACE "[\"']" "" tags "${tags}")
    set(${out} "${tags}" PARENT_SCOPE)
    return()
  endif()
  if(text MATCHES "\n[ \t]*extends[ \t]*=[ \t]*\\[([^]]*)\\]")
    string(REGEX MATCHALL "[\"'][^\"']*[\"']" bases "${CMAKE_MATCH_1}")
    string(REGEX REPLACE "[\"']" "" bases "${bases}")
    get_filename_component(folder "${file}" DIRECTORY)
    math(EXPR deeper "${depth} + 1")
    foreach(base IN LISTS bases)
      get_filename_component(base "${base}" ABSOLUTE BASE_DIR "${folder}")
      _evenstep_tags(inherited "${base}" ${deeper})
      if(inherited)
        set(${out} "${inherited}" PARENT_SCOPE)
      endif()
    endforeach()
  endif()
endfunction()

# Whether the file is in a folder that a run or a study has left: the resolved.toml there is no scenario of the user's.
function(_evenstep_in_run_folder out file root)
  set(${out} FALSE PARENT_SCOPE)
  get_filename_component(folder "${file}" DIRECTORY)
  while(NOT folder STREQUAL root)
    if(EXISTS "${folder}/summary.json" OR EXISTS "${folder}/study.json")
      set(${out} TRUE PARENT_SCOPE)
      return()
    endif()
    get_filename_component(folder "${folder}" DIRECTORY)
  endwhile()
endfunction()

# _evenstep_tests(FUNCTION USAGE FOLDER PROGRAM GLOB PATTERN) : what both functions do first. Sets in the caller `wanted`,
# which is FALSE if no tests are to be added, `program`, `root` (the folder), `files` and `base`, from which names of tests
# begin.
macro(_evenstep_tests function usage folder program_given glob pattern)
  set(wanted TRUE)
  if(ARG_UNPARSED_ARGUMENTS OR ARG_KEYWORDS_MISSING_VALUES)
    message(FATAL_ERROR "${function}: '${ARG_UNPARSED_ARGUMENTS}${ARG_KEYWORDS_MISSING_VALUES}' is not understood; ${usage}")
  endif()
  if(DEFINED BUILD_TESTING AND NOT BUILD_TESTING)
    set(wanted FALSE)
  elseif(NOT CMAKE_TESTING_ENABLED)
    message(FATAL_ERROR "${function}: CMake would ignore the tests; call enable_testing() first")
  endif()

  if(NOT "${program_given}" STREQUAL "")
    if(NOT TARGET "${program_given}")
      message(FATAL_ERROR "${function}: PROGRAM '${program_given}' is not a target; add_executable() it first")
    endif()
    set(program "${program_given}")
  elseif(TARGET evenstep::evenstep)
    set(program evenstep::evenstep)
  elseif(wanted)
    message(FATAL_ERROR "${function}: there is no program evenstep::evenstep; "
      "find_package(evenstep COMPONENTS program) first, or name a target with PROGRAM")
  endif()

  get_filename_component(root "${folder}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_SOURCE_DIR}")
  file(${glob} files LIST_DIRECTORIES FALSE CONFIGURE_DEPENDS "${root}/${pattern}")
  list(SORT files)
  # Paths from the CMakeLists.txt are shorter to read, and where the tests run they are right.
  set(base "${CMAKE_CURRENT_SOURCE_DIR}")
  cmake_path(IS_PREFIX base "${root}" NORMALIZE is_below)
  if(NOT is_below)
    get_filename_component(base "${root}" DIRECTORY)
  endif()
endmacro()

function(evenstep_add_sizing)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "NAME;RECORDINGS;LATENCY;LEAD;MAP;PER;CONFIDENCE;PROGRAM" "RINGS;LABELS;OPTIONS")
  set(usage "evenstep_add_sizing(NAME name RECORDINGS folder [LATENCY time] [LEAD time] [RINGS samples forces] [MAP map] \
[PER time [CONFIDENCE share]] [LABELS label...] [PROGRAM target] [OPTIONS option...])")
  if(NOT ARG_NAME OR NOT ARG_RECORDINGS OR NOT (ARG_LATENCY OR ARG_LEAD OR ARG_RINGS))
    message(FATAL_ERROR "evenstep_add_sizing: NAME, RECORDINGS, or all of LATENCY, LEAD and RINGS are missing; ${usage}")
  endif()
  _evenstep_tests(evenstep_add_sizing "${usage}" "${ARG_RECORDINGS}" "${ARG_PROGRAM}" GLOB "*")
  if(NOT wanted)
    return()
  endif()
  list(FILTER files EXCLUDE REGEX "(/\\.[^/]*|\\.md)$")
  if(NOT files)
    message(FATAL_ERROR "evenstep_add_sizing: no recording in ${root}")
  endif()
  set(fits "")
  foreach(what IN ITEMS LATENCY LEAD RINGS MAP PER CONFIDENCE)
    if(ARG_${what})
      string(TOLOWER ${what} word)
      string(REPLACE ";" " " value "${ARG_${what}}")
      list(APPEND fits "${word} ${value}")
    endif()
  endforeach()
  list(JOIN fits ", " fits)
  foreach(file IN LISTS files)
    file(RELATIVE_PATH name "${base}" "${file}")
    add_test(NAME "sizing: ${ARG_NAME}: ${name}" WORKING_DIRECTORY "${base}"
      COMMAND "$<TARGET_FILE:${program}>" size "${name}" --fits "${fits}" ${ARG_OPTIONS}
        --out "${CMAKE_CURRENT_BINARY_DIR}/evenstep-runs/sizing/${ARG_NAME}/${name}")
    set_tests_properties("sizing: ${ARG_NAME}: ${name}" PROPERTIES LABELS "${ARG_LABELS}")
  endforeach()
endfunction()

function(evenstep_add_scenarios)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "RECURSE" "DIRECTORY;PROGRAM" "LABELS")
  set(usage "evenstep_add_scenarios(DIRECTORY folder [LABELS label...] [RECURSE] [PROGRAM target])")
  if(NOT ARG_DIRECTORY)
    message(FATAL_ERROR "evenstep_add_scenarios: DIRECTORY is missing; ${usage}")
  endif()
  set(glob GLOB)
  if(ARG_RECURSE)
    set(glob GLOB_RECURSE)
  endif()
  _evenstep_tests(evenstep_add_scenarios "${usage}" "${ARG_DIRECTORY}" "${ARG_PROGRAM}" ${glob} "*.toml")
  if(NOT wanted)
    return()
  endif()
  set(added 0)
  foreach(file IN LISTS files)
    _evenstep_in_run_folder(left_by_a_run "${file}" "${root}")
    if(left_by_a_run)
      continue()
    endif()
    math(EXPR added "${added} + 1")
    file(RELATIVE_PATH name "${base}" "${file}")
    string(REGEX REPLACE "\\.toml$" "" folder "${name}")
    _evenstep_tags(tags "${file}" 0)
    add_test(NAME "scenario: ${name}" WORKING_DIRECTORY "${base}"
      COMMAND "$<TARGET_FILE:${program}>" run "${name}" --out "${CMAKE_CURRENT_BINARY_DIR}/evenstep-runs/${folder}")
    set(labels ${ARG_LABELS} ${tags})
    list(REMOVE_DUPLICATES labels)
    set_tests_properties("scenario: ${name}" PROPERTIES LABELS "${labels}")
  endforeach()
  if(added EQUAL 0)
    message(FATAL_ERROR "evenstep_add_scenarios: no scenario (*.toml) in ${root}")
  endif()
endfunction()

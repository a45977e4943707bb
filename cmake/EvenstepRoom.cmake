# A room is one static library with an include root of its own: a header of a room that is not named in SEES is simply
# not found by the compiler, so the direction of dependencies is enforced by the build.
#
#   evenstep_room(remap SEES time SOURCES src/a.cpp ...  PUBLIC_LIBRARIES glm::glm  PRIVATE_LIBRARIES fmt::fmt)
#
# The package of a library `package::name` is looked for; that of a system library is not. A room can be installed, and
# find_package(evenstep COMPONENTS remap) then finds what it sees, too, and the packages of its libraries.

add_library(evenstep_options INTERFACE)
target_compile_options(evenstep_options INTERFACE
  -ffp-contract=off          # bits must not depend on which compiler fuses what; evenstep::time asks its users for the same
  -Wall -Wextra -Wshadow -Wno-missing-field-initializers)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # A precompiled header that does not fit would be ignored, and take longer than none. On arm64 g++ tells of each pair that
  # g++ 9 passed in another way.
  target_compile_options(evenstep_options INTERFACE -Werror=invalid-pch -Wno-psabi)
else()
  target_compile_options(evenstep_options INTERFACE -Wno-unknown-pragmas)   # "GCC ivdep" is only for g++
endif()
if(EVENSTEP_SANITIZE)
  include(${CMAKE_CURRENT_LIST_DIR}/EvenstepSanitize.cmake)
endif()

# The oldest versions that evenstep has been built and tested with (Debian 12's; docs/begin/install.md).
set(EVENSTEP_OLDEST_fmt 9.1)
set(EVENSTEP_OLDEST_spdlog 1.10)
set(EVENSTEP_OLDEST_glm 0.9.9)
set(EVENSTEP_OLDEST_tomlplusplus 3.3)
set(EVENSTEP_OLDEST_CLI11 2.1)
set(EVENSTEP_OLDEST_nlohmann_json 3.11)
set(EVENSTEP_OLDEST_Boost 1.74)
set(EVENSTEP_OLDEST_GNU 12)
set(EVENSTEP_OLDEST_Clang 14)
if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS "${EVENSTEP_OLDEST_${CMAKE_CXX_COMPILER_ID}}")
  message(FATAL_ERROR "evenstep needs ${CMAKE_CXX_COMPILER_ID} ${EVENSTEP_OLDEST_${CMAKE_CXX_COMPILER_ID}} or later: "
    "${CMAKE_CXX_COMPILER} is ${CMAKE_CXX_COMPILER_VERSION}. Name another one with CXX or CMAKE_CXX_COMPILER")
endif()

# Only headers of these are used, and only in sources: a program that links an installed room does not need them.
set(EVENSTEP_HEADERS_ONLY Boost CLI11 nlohmann_json)

# evenstep_alone(SOURCE ...) : these sources are never compiled together with others of their target, so their unnamed
# namespaces may have names that others have too.
function(evenstep_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# evenstep_find(OUT LIBRARY ...) : finds the packages of these libraries; OUT are those that a user of them needs, too.
macro(evenstep_find out)
  set(${out} "")
  foreach(library IN ITEMS ${ARGN})
    if(library MATCHES "^(.+)::")
      set(package ${CMAKE_MATCH_1})
      if(NOT TARGET ${library})
        find_package(${package} ${EVENSTEP_OLDEST_${package}} REQUIRED)
      endif()
      if(NOT package IN_LIST EVENSTEP_HEADERS_ONLY)
        list(APPEND ${out} ${package})
      endif()
    endif()
  endforeach()
endmacro()

# Runs take as long with these rooms at -O1 (docs/internals/testing.md), and they compile in three quarters of the time of
# -O2.
set(EVENSTEP_ROOMS_AT_O1 apps campaigns catalogue format harness inverse3 pages plugins reports_writers text)

function(evenstep_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;SEES;PUBLIC_LIBRARIES;PRIVATE_LIBRARIES" ${ARGN})
  add_library(evenstep_${name} STATIC ${ROOM_SOURCES})
  add_library(evenstep::${name} ALIAS evenstep_${name})
  evenstep_headers(${name} include)
  target_include_directories(evenstep_${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_compile_features(evenstep_${name} PUBLIC cxx_std_20)

  evenstep_find(packages ${ROOM_PUBLIC_LIBRARIES} ${ROOM_PRIVATE_LIBRARIES})
  set(private $<BUILD_INTERFACE:evenstep_options>)
  foreach(library IN LISTS ROOM_PRIVATE_LIBRARIES)
    string(REGEX REPLACE "::.*" "" package ${library})
    if(package IN_LIST EVENSTEP_HEADERS_ONLY)
      set(library $<BUILD_INTERFACE:${library}>)
    endif()
    list(APPEND private ${library})
  endforeach()
  list(TRANSFORM ROOM_SEES PREPEND evenstep:: OUTPUT_VARIABLE seen)
  target_link_libraries(evenstep_${name} PUBLIC ${seen} ${ROOM_PUBLIC_LIBRARIES} PRIVATE ${private})
  set_target_properties(evenstep_${name} PROPERTIES EXPORT_NAME ${name}
    EVENSTEP_SEES "${ROOM_SEES}" EVENSTEP_PACKAGES "${packages}")
  evenstep_compile(${name})
  if(EVENSTEP_INSTALL)
    evenstep_install_room(${name})
  endif()
endfunction()

# evenstep_headers(ROOM FOLDER) : public headers of the room, if there is such a folder
function(evenstep_headers room folder)
  if(IS_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/${folder})
    target_include_directories(evenstep_${room} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/${folder}>)
    if(EVENSTEP_INSTALL)
      install(DIRECTORY ${folder}/evenstep DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev
        FILES_MATCHING PATTERN "*.h")
    endif()
  endif()
endfunction()

# evenstep_part(ROOM PART SOURCES) : more sources of the room, and the headers of PART/include; compiled as those of a room
# of the name ROOM_PART would be
function(evenstep_part room part)
  evenstep_headers(${room} ${part}/include)
  set(name ${room}_${part})
  add_library(evenstep_${name} OBJECT ${ARGN})
  get_target_property(folders evenstep_${room} INCLUDE_DIRECTORIES)
  get_target_property(libraries evenstep_${room} LINK_LIBRARIES)
  target_include_directories(evenstep_${name} PRIVATE ${folders})
  target_link_libraries(evenstep_${name} PRIVATE ${libraries})
  target_compile_features(evenstep_${name} PRIVATE cxx_std_20)
  evenstep_compile(${name})
  target_sources(evenstep_${room} PRIVATE $<TARGET_OBJECTS:evenstep_${name}>)
endfunction()

# evenstep_compile(NAME) : sets how the target of a room, or of a part of one, is compiled
function(evenstep_compile name)
  # It can become a part of a shared object, which then shows nothing of it. What could be replaced from outside would not be
  # inlined, either: 317 instructions of the map instead of 288.
  set_target_properties(evenstep_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  if(EVENSTEP_SANITIZE AND NOT name IN_LIST EVENSTEP_ROOMS_THAT_COMPUTE)
    target_compile_options(evenstep_${name} PRIVATE -O0)
  elseif(PROJECT_IS_TOP_LEVEL AND name IN_LIST EVENSTEP_ROOMS_AT_O1)
    target_compile_options(evenstep_${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
endfunction()

# evenstep_install_room(NAME) : its library and its file of targets
function(evenstep_install_room name)
  install(TARGETS evenstep_${name} EXPORT evenstep-${name} INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
  install(EXPORT evenstep-${name} NAMESPACE evenstep:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/evenstep COMPONENT dev)
endfunction()

# A room is one static library with an include root of its own: a header of a room that is not named in SEES is simply
# not found by the compiler, so the direction of dependencies is enforced by the build.
#
#   evenstep_room(remap SEES time SOURCES src/a.cpp ...  PUBLIC_LIBRARIES glm::glm  PRIVATE_LIBRARIES fmt::fmt)

add_library(evenstep_options INTERFACE)
target_compile_options(evenstep_options INTERFACE
  -ffp-contract=off          # bits must not depend on which compiler fuses what
  -Wall -Wextra -Wshadow -Wno-missing-field-initializers)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # A precompiled header that does not fit would be ignored, and take longer than none.
  target_compile_options(evenstep_options INTERFACE -fcoroutines -Werror=invalid-pch)
endif()
if(EVENSTEP_SANITIZE)
  include(EvenstepSanitize)
endif()

# evenstep_alone(SOURCE ...) : these sources are never compiled together with others of their target, so that a name in an
# unnamed namespace of theirs may be another's, too.
function(evenstep_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

function(evenstep_room name)
  cmake_parse_arguments(ROOM "" "ROOT" "SOURCES;SEES;PUBLIC_LIBRARIES;PRIVATE_LIBRARIES" ${ARGN})
  if(NOT ROOM_ROOT)
    set(ROOM_ROOT ${CMAKE_CURRENT_SOURCE_DIR})
  endif()
  add_library(evenstep_${name} STATIC ${ROOM_SOURCES})
  add_library(evenstep::${name} ALIAS evenstep_${name})
  target_include_directories(evenstep_${name} PUBLIC ${ROOM_ROOT}/include PRIVATE ${ROOM_ROOT})
  target_link_libraries(evenstep_${name} PRIVATE evenstep_options)
  foreach(seen IN LISTS ROOM_SEES)
    target_link_libraries(evenstep_${name} PUBLIC evenstep::${seen})
  endforeach()
  target_link_libraries(evenstep_${name} PUBLIC ${ROOM_PUBLIC_LIBRARIES} PRIVATE ${ROOM_PRIVATE_LIBRARIES})
  if(EVENSTEP_SANITIZE AND NOT name IN_LIST EVENSTEP_ROOMS_THAT_COMPUTE)
    target_compile_options(evenstep_${name} PRIVATE -O0)
  endif()
endfunction()

# A build with sanitizers: every program of it stops at the first report, and carries its options and suppressions with it,
# so that it is checked the same way however it is started. ASAN_OPTIONS and the like still win. TSan needs no suppression:
# it has nothing to say about PoCL, LLVM and the OpenCL loader.
target_compile_options(evenstep_options INTERFACE -fsanitize=${EVENSTEP_SANITIZE} -fno-sanitize-recover=all
  -fno-omit-frame-pointer)
if(NOT CMAKE_CXX_FLAGS MATCHES "-g")
  target_compile_options(evenstep_options INTERFACE -g1)   # lines in the reports: a fifth of the time to compile
endif()
target_compile_definitions(evenstep_options INTERFACE _GLIBCXX_ASSERTIONS)
foreach(sanitizer IN ITEMS address thread)   # for the tests: each compiler has macros of its own
  if(EVENSTEP_SANITIZE MATCHES ${sanitizer})
    string(TOUPPER EVENSTEP_SANITIZE_${sanitizer} macro)
    target_compile_definitions(evenstep_options INTERFACE ${macro})
  endif()
endforeach()
target_link_options(evenstep_options INTERFACE -fsanitize=${EVENSTEP_SANITIZE})
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  # clang 14 cannot assemble this check of function types in a coroutine ("Cannot represent a difference across sections").
  target_compile_options(evenstep_options INTERFACE -fno-sanitize=function)
endif()
if(EVENSTEP_SANITIZE MATCHES undefined AND NOT EVENSTEP_FUZZ)
  # A check of every access through a pointer, which takes half the time to build. What it finds, the address sanitizer finds
  # at the access itself. The fuzz targets have all of them.
  target_compile_options(evenstep_options INTERFACE -fno-sanitize=null,alignment,object-size,vptr)
endif()
if(EVENSTEP_FUZZ)
  target_compile_options(evenstep_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# The rooms in which a run spends its time. Without optimisation the others compile in a third of the time.
set(EVENSTEP_ROOMS_THAT_COMPUTE time clock remap scheduler sim loop device reports)

set(suppressions ${CMAKE_CURRENT_LIST_DIR}/sanitizers/lsan.supp)
file(READ ${suppressions} lsan_suppressions)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${suppressions})
configure_file(${CMAKE_CURRENT_LIST_DIR}/sanitizers/options.cpp.in ${PROJECT_BINARY_DIR}/sanitizer_options.cpp @ONLY)
add_library(evenstep_sanitizer_options STATIC ${PROJECT_BINARY_DIR}/sanitizer_options.cpp)
target_link_libraries(evenstep_options INTERFACE evenstep_sanitizer_options)
target_link_options(evenstep_options INTERFACE LINKER:--undefined=evenstep_sanitizer_options)

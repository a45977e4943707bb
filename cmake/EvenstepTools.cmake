# Tools that make a build faster where they are installed. Neither changes what is built.

# ccache, unless the user has named a launcher. Where there is a precompiled header it caches nothing unless it is told to
# trust the header's macros and date. They can be trusted here: no source reads __DATE__ or __TIME__.
if(NOT CMAKE_CXX_COMPILER_LAUNCHER)
  find_program(EVENSTEP_CCACHE ccache)
  if(EVENSTEP_CCACHE)
    # A user without a home has no folder for the cache, and ccache then compiles nothing.
    set(empty ${CMAKE_BINARY_DIR}/CMakeFiles/empty)
    file(WRITE ${empty}.cpp "")
    execute_process(COMMAND ${EVENSTEP_CCACHE} ${CMAKE_CXX_COMPILER} -c ${empty}.cpp -o ${empty}.o
      RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
    if(status EQUAL 0)
      set(CMAKE_CXX_COMPILER_LAUNCHER ${EVENSTEP_CCACHE})
    endif()
  endif()
endif()
if(CMAKE_CXX_COMPILER_LAUNCHER MATCHES "(^|/)ccache$")
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CMAKE_CXX_COMPILER_LAUNCHER})
endif()

# g++ collects its garbage from 128 MB on, again and again; where every job may have 2 GB it need not.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  cmake_host_system_information(RESULT memory_MiB QUERY TOTAL_PHYSICAL_MEMORY)
  cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
  math(EXPR each_MiB "${memory_MiB} / (${cores} + 2)")   # as many jobs as Ninja has
  if(each_MiB GREATER_EQUAL 2048)
    add_compile_options($<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=1048576>)
  endif()
endif()

# mold or lld, unless the user has chosen a linker.
include(CheckLinkerFlag)
if(NOT CMAKE_EXE_LINKER_FLAGS MATCHES "-fuse-ld=")
  check_linker_flag(CXX -fuse-ld=mold EVENSTEP_HAS_MOLD)
  if(EVENSTEP_HAS_MOLD)
    add_link_options(-fuse-ld=mold)
  else()
    check_linker_flag(CXX -fuse-ld=lld EVENSTEP_HAS_LLD)
    if(EVENSTEP_HAS_LLD)
      add_link_options(-fuse-ld=lld)
    endif()
  endif()
endif()

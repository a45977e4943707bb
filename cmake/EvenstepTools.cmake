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

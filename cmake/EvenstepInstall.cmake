# What is installed besides the rooms themselves: the files for find_package and pkg-config, and Debian packages of it all.
# Component `runtime`: the program, its scenarios and documents; `dev`: libraries, headers and those files.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/evenstep)

# From the lowest room to the highest: what each needs, itself last, and the packages of all these.
set(EVENSTEP_NEEDS "")
foreach(room IN LISTS built)
  get_target_property(seen evenstep_${room} EVENSTEP_SEES)
  get_target_property(packages_of_${room} evenstep_${room} EVENSTEP_PACKAGES)
  set(needs_of_${room} "")
  foreach(other IN LISTS seen)
    list(APPEND needs_of_${room} ${needs_of_${other}})
    list(APPEND packages_of_${room} ${packages_of_${other}})
  endforeach()
  list(APPEND needs_of_${room} ${room})
  list(REMOVE_DUPLICATES needs_of_${room})
  list(REMOVE_DUPLICATES packages_of_${room})
  string(APPEND EVENSTEP_NEEDS "set(_evenstep_needs_${room} ${needs_of_${room}})\n"
    "set(_evenstep_packages_${room} ${packages_of_${room}})\n")
endforeach()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/evenstepConfig.cmake.in ${PROJECT_BINARY_DIR}/evenstepConfig.cmake
  INSTALL_DESTINATION ${package_folder} NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/evenstepConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/evenstepConfig.cmake ${PROJECT_BINARY_DIR}/evenstepConfigVersion.cmake
  DESTINATION ${package_folder} COMPONENT dev)
# Functions for users, each in a file of its own.
install(DIRECTORY ${CMAKE_CURRENT_LIST_DIR}/ DESTINATION ${package_folder} COMPONENT dev
  FILES_MATCHING PATTERN EvenstepScenarios.cmake PATTERN sanitizers EXCLUDE)

# evenstep_pkgconfig_file(FILE DESCRIPTION LINE...) : the prefix is found from where the file is, so that the whole can be
# moved.
function(evenstep_pkgconfig_file file description)
  list(JOIN ARGN "\n" lines)
  file(RELATIVE_PATH up ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
  file(WRITE ${PROJECT_BINARY_DIR}/${file}.pc
    "prefix=\${pcfiledir}/${up}\n"
    "libdir=\${prefix}/${CMAKE_INSTALL_LIBDIR}\n"
    "includedir=\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}\n\n"
    "Name: ${file}\nDescription: ${description}\nVersion: ${PROJECT_VERSION}\n${lines}\n")
  install(FILES ${PROJECT_BINARY_DIR}/${file}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
endfunction()

# evenstep_pkgconfig(FILE DESCRIPTION ROOM...) : the static libraries of these rooms and of what they see, the highest first.
function(evenstep_pkgconfig file description)
  set(rooms "")
  set(packages "")
  foreach(room IN LISTS ARGN)
    list(APPEND rooms ${needs_of_${room}})
    list(APPEND packages ${packages_of_${room}})
  endforeach()
  list(REMOVE_DUPLICATES packages)
  set(libraries "")
  set(requires "")
  foreach(room IN LISTS built)
    if(room IN_LIST rooms)
      string(PREPEND libraries " -levenstep_${room}")
    endif()
  endforeach()
  foreach(package IN LISTS packages)
    if(package STREQUAL "Threads")
      string(APPEND libraries " -pthread")
    else()
      string(APPEND requires " ${package}")
    endif()
  endforeach()
  string(APPEND libraries " -l${CMAKE_DL_LIBS}")
  evenstep_pkgconfig_file(${file} "${description}" "Requires:${requires}" "Cflags: -I\${includedir} -ffp-contract=off"
    "Libs: -L\${libdir}${libraries}")
endfunction()

if(remap IN_LIST built)
  evenstep_pkgconfig(evenstep-remap "maps between real time and simulation time (C++20)" remap)
  # For a C compiler. The shared library needs no other; the static one (pkg-config --static) needs the rooms, too.
  set(libraries "")
  foreach(room IN LISTS needs_of_remap)
    string(PREPEND libraries " -levenstep_${room}")
  endforeach()
  evenstep_pkgconfig_file(evenstep-remap-c "maps between real time and simulation time (C)"
    "Cflags: -I\${includedir} -DEVENSTEP_REMAP_SHARED" "Libs: -L\${libdir} -levenstep_remap_c"
    "Libs.private:${libraries} -lstdc++ -lm -pthread")
endif()
if(scheduler IN_LIST built)
  evenstep_pkgconfig(evenstep-scheduler "a virtual clock and a deterministic scheduler (C++20)" scheduler)
endif()
evenstep_pkgconfig(evenstep "${PROJECT_DESCRIPTION} (C++20)" ${built})

install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/ARCHITECTURE.md
  DESTINATION share/doc/evenstep COMPONENT runtime)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION share/doc/evenstep COMPONENT runtime)
foreach(package IN ITEMS evenstep/runtime libevenstep-dev/dev)   # where Debian wants a licence
  get_filename_component(component ${package} NAME)
  get_filename_component(package ${package} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/${package} RENAME copyright COMPONENT ${component})
  install(FILES ${PROJECT_SOURCE_DIR}/third_party/uplot/LICENSE DESTINATION share/doc/${package} RENAME copyright.uplot
    COMPONENT ${component})
endforeach()
if(NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()

# cpack -G DEB
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME evenstep)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_PACKAGE_CONTACT "the authors of evenstep <evenstep@localhost>")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL runtime dev)
if(EVENSTEP_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME evenstep)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
# Opened by the runs that need them; apt installs them unless told otherwise.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS
  "ocl-icd-libopencl1 | libopencl1, pocl-opencl-icd | opencl-icd, libhidapi-hidraw0, libsqlite3-0, zlib1g")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "libegl1, libgl1-mesa-dri")   # visualizations that draw
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libevenstep-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libfmt-dev, libspdlog-dev, libtomlplusplus-dev, libglm-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "evenstep (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-evenstep)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
# The extension module is for one version of CPython.
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3.${Python3_VERSION_MINOR}, python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS ${CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS})
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-pytest, evenstep (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The package evenstep of Python, with its plugin of pytest.")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "The program evenstep, its scenarios and documents.")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Headers, static libraries, and the files of CMake and pkg-config.")
include(CPack)

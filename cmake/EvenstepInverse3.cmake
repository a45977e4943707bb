# EVENSTEP_INVERSE3: on where Boost.Beast is there, since nothing else needs it.
find_path(EVENSTEP_BEAST boost/beast/websocket.hpp)
mark_as_advanced(EVENSTEP_BEAST)
set(there OFF)
if(EVENSTEP_BEAST)
  set(there ON)
endif()
<<<<<<< HEAD
option(EVENSTEP_INVERSE3 "A Haply Inverse3 through its service (needs Boost.Beast); without it there are simulated ones"
  ${there})
=======
option(EVENSTEP_INVERSE3 "A Haply Inverse3 through its service (needs Boost.Beast); without it simulated ones" ${there})
>>>>>>> inverse3
if(EVENSTEP_INVERSE3 AND NOT EVENSTEP_BEAST)
  message(FATAL_ERROR "boost/beast/websocket.hpp is not there: install libboost-dev, or set EVENSTEP_INVERSE3 to OFF")
elseif(NOT EVENSTEP_BEAST)
  message(STATUS "EVENSTEP_INVERSE3 is off: boost/beast/websocket.hpp is not there (libboost-dev)")
elseif(NOT EVENSTEP_INVERSE3)
  message(STATUS "EVENSTEP_INVERSE3 is off: it was switched off")
endif()

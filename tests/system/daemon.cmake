# SPDX-License-Identifier: BSD-3-Clause
# The daemon as it is started, and its real-time promises.
if(TARGET cliquevod)
  cliquevo_add_system_test(test_system_daemon SOURCES daemon_test.cpp DEPENDS cliquevod cliquevo)
endif()
# An interposed allocator and a sanitizer's own cannot share a program.
if(TARGET cliquevod AND NOT CLIQUEVO_SANITIZE)
  cliquevo_add_system_test(test_realtime_calls
    SOURCES realtime_calls_test.cpp interpose/interposer.cpp
    LIBRARIES cliquevo_daemon_lib ${CMAKE_DL_LIBS})
endif()

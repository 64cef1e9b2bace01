# SPDX-License-Identifier: BSD-3-Clause
# The daemon as it is started, and its real-time promises.
if(TARGET cliquevod)
  cliquevo_add_system_test(test_system_daemon SOURCES daemon_test.cpp DEPENDS cliquevod cliquevo)
endif()
if(TARGET cliquevod AND NOT CLIQUEVO_SANITIZE)
  # One of its cases compiles the library once more, as a part of another project.
  cliquevo_add_test(test_system_install system SOURCES install_test.cpp TIMEOUT 1500
    DEPENDS cliquevod cliquevo pages cliquevo_odometry cliquevo_headers_verify_interface_header_sets
    ENVIRONMENT "CLIQUEVO_CACHE=${PROJECT_BINARY_DIR}/renders")
  target_compile_definitions(test_system_install PRIVATE
    CLIQUEVO_BUILD_DIR="${PROJECT_BINARY_DIR}" CLIQUEVO_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
# An interposed allocator and a sanitizer's own cannot share a program.
if(TARGET cliquevod AND NOT CLIQUEVO_SANITIZE)
  cliquevo_add_system_test(test_realtime_calls
    SOURCES realtime_calls_test.cpp interpose/interposer.cpp
    LIBRARIES cliquevo_daemon_lib ${CMAKE_DL_LIBS})
endif()
# The package and its unit in a booted container.
if(TARGET cliquevod AND NOT CLIQUEVO_SANITIZE)
  cliquevo_add_system_test(test_system_service WHOLE SOURCES service_test.cpp booted_root.cpp
    LIBRARIES cliquevo_lcmtypes fmt::fmt DEPENDS cliquevod cliquevo pages cliquevo_odometry)
  target_compile_definitions(test_system_service PRIVATE
    CLIQUEVO_BUILD_DIR="${PROJECT_BINARY_DIR}" CLIQUEVO_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
# The packages on a bare Debian.
if(CLIQUEVO_DRAWING AND NOT CLIQUEVO_SANITIZE)
  cliquevo_add_system_test(test_packages WHOLE SOURCES packages_test.cpp
    DEPENDS cliquevod cliquevo pages cliquevo_odometry)
  target_compile_definitions(test_packages PRIVATE CLIQUEVO_VERSION="${PROJECT_VERSION}"
    CLIQUEVO_BUILD_DIR="${PROJECT_BINARY_DIR}" CLIQUEVO_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
if(TARGET cliquevod)
  cliquevo_add_system_test(test_system_recording SOURCES recording_test.cpp
    LIBRARIES cliquevo_recording PkgConfig::LCM DEPENDS cliquevod cliquevo)
  cliquevo_add_test(test_recording_soak bench SOURCES recording_soak_test.cpp LIBRARIES cliquevo_recording
    DEPENDS cliquevod TIMEOUT 900 ENVIRONMENT "CLIQUEVO_CACHE=${PROJECT_BINARY_DIR}/renders")
  cliquevo_add_test(test_large_sensor bench SOURCES large_sensor_test.cpp LIBRARIES fmt::fmt nlohmann_json::nlohmann_json
    DEPENDS cliquevod cliquevo TIMEOUT 900 ENVIRONMENT "CLIQUEVO_CACHE=${PROJECT_BINARY_DIR}/renders")
endif()
find_program(CLIQUEVO_DOXYGEN doxygen)
if(CLIQUEVO_DOXYGEN)
  add_test(NAME Doc.EveryPublicMemberIsDescribed COMMAND ${CLIQUEVO_DOXYGEN} ${PROJECT_BINARY_DIR}/Doxyfile)
  set_tests_properties(Doc.EveryPublicMemberIsDescribed PROPERTIES LABELS system TIMEOUT 300)
endif()

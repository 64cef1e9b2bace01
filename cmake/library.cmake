# SPDX-License-Identifier: BSD-3-Clause
# The library for other programs: namespaced targets and headers below cliquevo/, the same for add_subdirectory() and,
# installed, for find_package(). A public header is made of one of ours: its includes of others become <cliquevo/...>.
include(CMakePackageConfigHelpers)

set(CLIQUEVO_LIBRARY_COMPONENT dev CACHE INTERNAL "Install component of the library")
set(cliquevo_include ${PROJECT_BINARY_DIR}/include)

# Ours -> cliquevo/<name>.h.
set(public_headers
  core/base/camera_model.h core/base/image.h core/base/isa.h core/base/result.h core/base/rigid_transform.h
  core/base/time.h
  stereo/dense_stereo.h stereo/rectify.h stereo/rectify_params.h stereo/stereo_params.h
  core/vo/calibration_check.h core/vo/check_list.h core/vo/evidence.h core/vo/movers.h core/vo/seen_feature.h core/vo/step_times.h
  core/vo/verdict.h core/vo/visual_odometry.h core/vo/vo_params.h
  core/odometry/odometry.h core/odometry/odometry_params.h)

set(made_headers)
foreach(header ${public_headers})
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${header})
  get_filename_component(name ${header} NAME)
  file(READ ${PROJECT_SOURCE_DIR}/${header} text)
  foreach(other ${public_headers})
    get_filename_component(other_name ${other} NAME)
    string(REPLACE "#include \"${other}\"" "#include <cliquevo/${other_name}>" text "${text}")
  endforeach()
  if(text MATCHES "#include \"([^\"]*)\"")
    message(FATAL_ERROR "${header} is public and includes ${CMAKE_MATCH_1}, which is not: see cmake/library.cmake")
  endif()
  file(CONFIGURE OUTPUT ${cliquevo_include}/cliquevo/${name} CONTENT "${text}" @ONLY)
  list(APPEND made_headers ${cliquevo_include}/cliquevo/${name})
endforeach()
configure_file(cmake/version.h.in ${cliquevo_include}/cliquevo/version.h @ONLY)
list(APPEND made_headers ${cliquevo_include}/cliquevo/version.h)

add_library(cliquevo_headers INTERFACE)
target_sources(cliquevo_headers INTERFACE FILE_SET HEADERS BASE_DIRS ${cliquevo_include} FILES ${made_headers})
target_link_libraries(cliquevo_headers INTERFACE Eigen3::Eigen)
target_compile_features(cliquevo_headers INTERFACE cxx_std_20)
# Builds by itself what includes one header alone: cliquevo_headers_verify_interface_header_sets.
set_target_properties(cliquevo_headers PROPERTIES EXPORT_NAME headers VERIFY_INTERFACE_HEADER_SETS ON)

# cliquevo::NAME is the archive with the public headers, without the flags and folders that we compile it with.
function(cliquevo_public_library name)
  cmake_parse_arguments(ARG "" "" "NEEDS" ${ARGN})
  set_target_properties(cliquevo_${name} PROPERTIES EXPORT_NAME ${name}_archive)
  add_library(cliquevo_public_${name} INTERFACE)
  target_link_libraries(cliquevo_public_${name} INTERFACE cliquevo_headers $<LINK_ONLY:cliquevo_${name}>)
  foreach(other ${ARG_NEEDS})
    target_link_libraries(cliquevo_public_${name} INTERFACE cliquevo_public_${other})
  endforeach()
  set_target_properties(cliquevo_public_${name} PROPERTIES EXPORT_NAME ${name})
  add_library(cliquevo::${name} ALIAS cliquevo_public_${name})
  install(TARGETS cliquevo_public_${name} cliquevo_${name} EXPORT cliquevo
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${CLIQUEVO_LIBRARY_COMPONENT})
endfunction()
cliquevo_public_library(base)
cliquevo_public_library(stereo NEEDS base)
cliquevo_public_library(vo NEEDS base)
cliquevo_public_library(odometry NEEDS stereo vo)

set_target_properties(cliquevo_options PROPERTIES EXPORT_NAME options)
install(TARGETS cliquevo_options EXPORT cliquevo)
install(TARGETS cliquevo_headers EXPORT cliquevo
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT ${CLIQUEVO_LIBRARY_COMPONENT})
install(EXPORT cliquevo NAMESPACE cliquevo:: FILE cliquevo-targets.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/cliquevo COMPONENT ${CLIQUEVO_LIBRARY_COMPONENT})

# Before 1.0 a minor version may change the interface, a patch may not.
configure_package_config_file(cmake/cliquevo-config.cmake.in ${PROJECT_BINARY_DIR}/cliquevo-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/cliquevo PATH_VARS CMAKE_INSTALL_DATADIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cliquevo-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/cliquevo-config.cmake ${PROJECT_BINARY_DIR}/cliquevo-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/cliquevo COMPONENT ${CLIQUEVO_LIBRARY_COMPONENT})

# The API's pages: tools/doc.
configure_file(docs/api/Doxyfile.in ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)

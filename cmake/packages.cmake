# SPDX-License-Identifier: BSD-3-Clause
# The Debian packages (`cpack -G DEB`; tools/package makes a repository and an image of them too): a component each.
set(CLIQUEVO_MAINTAINER "cliquevo maintainers <maintainers@cliquevo.invalid>")
include(${CMAKE_CURRENT_LIST_DIR}/install.cmake)

set(CPACK_PACKAGE_NAME cliquevo)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_VENDOR cliquevo)
set(CPACK_PACKAGE_CONTACT ${CLIQUEVO_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# cliquevo_package_documents(COMPONENT NAME): the package's copyright and changelog.
macro(cliquevo_package_documents component name)
  set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME ${component})
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/packed/copyright.${component} CONTENT "${licence}" @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/packed/copyright.${component} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} RENAME copyright)
  install_packed(${PROJECT_BINARY_DIR}/packed/changelog ${CMAKE_INSTALL_DATADIR}/doc/${name} changelog)
endmacro()

# cliquevo_package(COMPONENT NAME SECTION DEPENDS SUMMARY DESCRIPTION): a package of what was installed as COMPONENT.
macro(cliquevo_package component name section depends summary description)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} id)
  set(CPACK_DEBIAN_${id}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${id}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${id}_PACKAGE_DEPENDS "${depends}")
  set(CPACK_COMPONENT_${id}_DESCRIPTION "${summary}\n${description}")
  cliquevo_package_documents(${component} ${name})
endmacro()

set(CPACK_COMPONENTS_ALL)
# kill, for the unit's reload.
cliquevo_package(runtime cliquevo science procps "real-time stereo visual odometry"
"Stereo frames go in; a stream of 6-DOF poses comes out, each with its
covariance and a verdict. No IMU, no GPU, no map.
This package has the daemon cliquevod with its service, and the command
cliquevo: cameras, recordings, replay, evaluation, simulator.")
install(FILES systemd/debian/lintian-overrides DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME cliquevo)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS systemd)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "cliquevo-tools, liblcm-java, libjchart2d-java, default-jdk-headless")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/systemd/debian/conffiles
  ${PROJECT_SOURCE_DIR}/systemd/debian/postinst ${PROJECT_SOURCE_DIR}/systemd/debian/prerm
  ${PROJECT_SOURCE_DIR}/systemd/debian/postrm)

if(CLIQUEVO_DRAWING)
  foreach(part three uPlot)
    file(READ tools/view/page/vendor/${part}.LICENSE text)
    string(APPEND licence "\n\n${part}, inside the view's page:\n\n${text}")
  endforeach()
  cliquevo_package(tools cliquevo-tools science "cliquevo (= ${PROJECT_VERSION})" "view, plots and reports of cliquevo"
"What is seen, in a browser: cliquevo view, live or of a recording; the
options --plot and --report of replay, eval and compare; calibration from
views of a board; video files as recordings.")
  set(CPACK_DEBIAN_TOOLS_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_TOOLS_PACKAGE_REPLACES "cliquevo (<< 0.2.0)")
  set(CPACK_DEBIAN_TOOLS_PACKAGE_BREAKS "cliquevo (<< 0.2.0)")
  file(READ LICENSE licence)
endif()

if(CLIQUEVO_ROS2)
  cliquevo_package(ros2 cliquevo-ros2 science "cliquevo (= ${PROJECT_VERSION})" "poses of cliquevo for ROS 2"
"The bridge cliquevo ros2: odometry, transforms, images and diagnostics
for ROS 2 over DDS. No ROS needs to be installed.")
  set(CPACK_DEBIAN_ROS2_PACKAGE_SHLIBDEPS ON)
endif()

cliquevo_package(dev libcliquevo-dev libdevel libeigen3-dev "cliquevo's stereo and odometry as a library"
"Headers, static libraries and the configuration for CMake: rectified or
raw image pairs in, poses with covariance and verdict out.")
set(CPACK_DEBIAN_DEV_PACKAGE_REPLACES "cliquevo (<< 0.2.0)")
set(CPACK_DEBIAN_DEV_PACKAGE_BREAKS "cliquevo (<< 0.2.0)")

# A further package is what is installed as a component of its own and a cliquevo_package() here. That of the Python
# module describes itself.
if(CLIQUEVO_PYTHON)
  include(${CMAKE_CURRENT_LIST_DIR}/python_package.cmake)
  list(APPEND CPACK_COMPONENTS_ALL python)
  cliquevo_package_documents(python python3-cliquevo)
endif()
include(CPack)

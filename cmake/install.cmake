# SPDX-License-Identifier: BSD-3-Clause
# What goes where: programs, service, configuration, message types, and the library for find_package(cliquevo). Then the
# Debian package of all that (`cpack -G DEB`).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The service names its program and configuration by full path: /usr (the presets' prefix) and /etc.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # packing does not build the tests
install(TARGETS cliquevo cliquevod RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES systemd/cliquevod.service DESTINATION lib/systemd/system)
install(FILES systemd/cliquevo.sysusers DESTINATION lib/sysusers.d RENAME cliquevo.conf)
install(FILES systemd/60-cliquevo.sysctl DESTINATION lib/sysctl.d RENAME 60-cliquevo.conf)
install(FILES systemd/60-cliquevo.rules DESTINATION lib/udev/rules.d)
install(FILES config/cliquevo.yaml DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/cliquevo)
install(DIRECTORY daemon/lcmtypes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/cliquevo/lcmtypes FILES_MATCHING PATTERN "*.lcm")
install(FILES config/cliquevo.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/cliquevo)
install(FILES config/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME cliquevo)
install(FILES README.md CHANGELOG.md docs/configuration.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES systemd/network-cameras.conf DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples)
install(FILES tools/view/page/vendor/three.LICENSE tools/view/page/vendor/uPlot.LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR}/licences)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

# The library: stereo and odometry, with Eigen in their interface and nothing else.
set(rooms base stereo vo)
foreach(room ${rooms})
  set_target_properties(cliquevo_${room} PROPERTIES EXPORT_NAME ${room})
endforeach()
set_target_properties(cliquevo_options PROPERTIES EXPORT_NAME options)
install(TARGETS cliquevo_options cliquevo_base cliquevo_stereo cliquevo_vo EXPORT cliquevo
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT cliquevo NAMESPACE cliquevo:: FILE cliquevo-targets.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/cliquevo)
file(WRITE ${PROJECT_BINARY_DIR}/cliquevo-config.cmake [[
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4 NO_MODULE)
find_dependency(Threads)
include(${CMAKE_CURRENT_LIST_DIR}/cliquevo-targets.cmake)
]])
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cliquevo-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/cliquevo-config.cmake ${PROJECT_BINARY_DIR}/cliquevo-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/cliquevo)
foreach(header
    core/base/camera_model.h core/base/image.h core/base/isa.h core/base/result.h core/base/rigid_transform.h
    core/base/time.h core/vo/evidence.h core/vo/movers.h core/vo/seen_feature.h core/vo/self_check.h core/vo/step_times.h core/vo/verdict.h
    core/vo/visual_odometry.h core/vo/vo_params.h
    stereo/dense_stereo.h stereo/rectify.h stereo/rectify_params.h stereo/stereo_params.h)
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cliquevo/${folder})
endforeach()

set(CPACK_PACKAGE_NAME cliquevo)
set(CPACK_PACKAGE_VENDOR cliquevo)
set(CPACK_PACKAGE_CONTACT "cliquevo maintainers <maintainers@cliquevo.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# kill, for the unit's reload.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "procps")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "systemd")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "liblcm-java, libjchart2d-java, default-jdk-headless, libeigen3-dev")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/systemd/debian/conffiles;${PROJECT_SOURCE_DIR}/systemd/debian/postinst;${PROJECT_SOURCE_DIR}/systemd/debian/prerm)
include(CPack)

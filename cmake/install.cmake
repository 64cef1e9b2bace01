# SPDX-License-Identifier: BSD-3-Clause
# What goes where: programs, service, configuration, message types; library.cmake has the library. Then the Debian
# package of all that (`cpack -G DEB`).
include(GNUInstallDirs)

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
if(TARGET cliquevo_python)
  include(cmake/python_package.cmake)
endif()
include(CPack)

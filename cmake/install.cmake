# SPDX-License-Identifier: BSD-3-Clause
# What goes where, by package (a component each): the vehicle's, what draws, the library. packages.cmake packs them.
include(GNUInstallDirs)

set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # packing does not build the tests

# What a vehicle needs. The service names its program and configuration by full path: /usr (the presets' prefix) and /etc.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME runtime)
install(TARGETS cliquevo cliquevod RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES systemd/cliquevod.service DESTINATION lib/systemd/system)
install(FILES systemd/cliquevo.sysusers DESTINATION lib/sysusers.d RENAME cliquevo.conf)
install(FILES systemd/60-cliquevo.sysctl DESTINATION lib/sysctl.d RENAME 60-cliquevo.conf)
install(FILES systemd/60-cliquevo.rules DESTINATION lib/udev/rules.d)
install(FILES config/cliquevo.yaml DESTINATION ${CMAKE_INSTALL_FULL_SYSCONFDIR}/cliquevo)
install(DIRECTORY daemon/lcmtypes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/cliquevo/lcmtypes FILES_MATCHING PATTERN "*.lcm")
install(FILES config/cliquevo.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/cliquevo)
install(FILES README.md CHANGELOG.md docs/configuration.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES systemd/network-cameras.conf DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples)

# Pages for man and words for shells, written by the program itself from its options.
set(pages ${PROJECT_BINARY_DIR}/pages)
set(page_files ${pages}/cliquevo.1 ${pages}/cliquevod.8 ${pages}/cliquevo.bash ${pages}/_cliquevo ${pages}/cliquevo.fish)
set(writer cliquevo)
if(CLIQUEVO_DRAWING)
  set(writer cliquevo-tools)  # whose options are all of them
endif()
add_custom_command(OUTPUT ${page_files} COMMAND ${writer} config pages --out ${pages} DEPENDS ${writer} VERBATIM
  COMMENT "Writing man pages and completion")
add_custom_target(pages ALL DEPENDS ${page_files})
find_program(CLIQUEVO_GZIP gzip REQUIRED)
# Packed as Debian wants it: the same bytes whenever it is done.
function(install_packed file destination name)
  set(packed ${PROJECT_BINARY_DIR}/packed/${destination}/${name}.gz)
  install(CODE "file(MAKE_DIRECTORY \"${PROJECT_BINARY_DIR}/packed/${destination}\")
    execute_process(COMMAND ${CLIQUEVO_GZIP} -9nc \"${file}\" OUTPUT_FILE \"${packed}\" COMMAND_ERROR_IS_FATAL ANY)"
    COMPONENT ${CMAKE_INSTALL_DEFAULT_COMPONENT_NAME})
  install(FILES ${packed} DESTINATION ${destination})
endfunction()
install_packed(${pages}/cliquevo.1 ${CMAKE_INSTALL_MANDIR}/man1 cliquevo.1)
install_packed(${pages}/cliquevod.8 ${CMAKE_INSTALL_MANDIR}/man8 cliquevod.8)
install(FILES ${pages}/cliquevo.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME cliquevo)
install(FILES ${pages}/_cliquevo DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${pages}/cliquevo.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)

# What draws. `cliquevo` finds it there.
if(CLIQUEVO_DRAWING)
  set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME tools)
  install(TARGETS cliquevo-tools RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/cliquevo)
endif()

# What stands in every package.
file(READ LICENSE licence)
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of SOURCE_DATE_EPOCH where it is set
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/packed/changelog @ONLY CONTENT
"cliquevo (${PROJECT_VERSION}) stable; urgency=medium

  * What changed for users: /usr/share/doc/cliquevo/CHANGELOG.md.

 -- ${CLIQUEVO_MAINTAINER}  ${date}
")

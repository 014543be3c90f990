# What is installed: the program, the files it starts from, and what makes it a service of the machine. `cpack` in the
# build folder makes a Debian package of the same.
include(GNUInstallDirs)
install(TARGETS headway RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY config/ DESTINATION ${CMAKE_INSTALL_DATADIR}/headway/config
        FILES_MATCHING PATTERN "*.yaml" PATTERN "*.dbc"
        PATTERN "systemd" EXCLUDE PATTERN "debian" EXCLUDE PATTERN "udev" EXCLUDE)
# Below /usr and /usr/local, systemd and udev look here themselves.
install(FILES config/systemd/headway.service DESTINATION lib/systemd/system)
install(FILES config/systemd/headway.conf DESTINATION lib/sysusers.d)
install(FILES config/udev/60-headway.rules DESTINATION lib/udev/rules.d)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_CONTACT "Headway <headway@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "systemd, udev")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
foreach(script postinst prerm postrm)
  list(APPEND CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/config/debian/${script})
endforeach()
include(CPack)

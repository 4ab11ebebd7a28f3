# cmake --install, and find_package(majak) for other projects:
#   find_package(majak REQUIRED)
#   target_link_libraries(mine PRIVATE majak::slam majak::io)
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

get_property(layers GLOBAL PROPERTY MAJAK_LAYERS)
install(TARGETS ${layers} EXPORT majak_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY majak DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
install(EXPORT majak_targets FILE majakTargets.cmake NAMESPACE majak::
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/majak)

configure_package_config_file(cmake/majakConfig.cmake.in majakConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/majak)
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(majakConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/majakConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/majakConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/majak)

if(TARGET majak)
  install(TARGETS majak RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

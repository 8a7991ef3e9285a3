# Install rules and the package files behind find_package(strak).
include(CMakePackageConfigHelpers)
get_property(rooms GLOBAL PROPERTY STRAK_ROOMS)
add_library(strak_all INTERFACE)
target_link_libraries(strak_all INTERFACE ${rooms})
add_library(strak::strak ALIAS strak_all)
set_target_properties(strak_all PROPERTIES EXPORT_NAME strak)
install(TARGETS ${rooms} strak_all EXPORT strakTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY strak DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(EXPORT strakTargets NAMESPACE strak:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/strak)
configure_package_config_file(cmake/strakConfig.cmake.in ${PROJECT_BINARY_DIR}/strakConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/strak)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/strakConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/strakConfig.cmake ${PROJECT_BINARY_DIR}/strakConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/strak)

# Install target and CMake package: find_package(kalfem) gives kalfem::kalfem and one target per folder.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

get_property(libraries GLOBAL PROPERTY KALFEM_LIBRARIES)
add_library(kalfem_all INTERFACE)
set_target_properties(kalfem_all PROPERTIES EXPORT_NAME kalfem)
target_link_libraries(kalfem_all INTERFACE ${libraries})

install(TARGETS kalfem_flags kalfem_all ${libraries} EXPORT kalfem ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS kalfem_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY src/kalfem DESTINATION include FILES_MATCHING PATTERN "*.hpp")
install(EXPORT kalfem NAMESPACE kalfem:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kalfem)
configure_package_config_file(cmake/kalfemConfig.cmake.in kalfemConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kalfem)
write_basic_package_version_file(kalfemConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/kalfemConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/kalfemConfigVersion.cmake cmake/FindCHOLMOD.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kalfem)

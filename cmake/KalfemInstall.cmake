# SPDX-License-Identifier: Apache-2.0
# Install target and CMake package: find_package(kalfem COMPONENTS core formats study) gives kalfem::core,
# kalfem::formats and kalfem::study, each with the third-party packages that it needs and no others. kalfem::kalfem is
# all of them. `cmake --install <build> --component core` installs the core alone, `--component command` the command.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
include(PublicHeaders)

get_property(every GLOBAL PROPERTY KALFEM_LIBRARIES)
foreach(library ${every})
  string(REPLACE kalfem_ "" folder ${library})
  if(NOT folder IN_LIST KALFEM_CORE_LIBRARIES AND NOT folder IN_LIST KALFEM_FORMATS_LIBRARIES
     AND NOT folder IN_LIST KALFEM_STUDY_LIBRARIES)
    message(FATAL_ERROR "${library} belongs to no component: name it in cmake/PublicHeaders.cmake")
  endif()
endforeach()
add_custom_target(kalfem_libraries DEPENDS ${every})

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/kalfem)
configure_package_config_file(cmake/kalfemConfig.cmake.in kalfemConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(kalfemConfigVersion.cmake COMPATIBILITY SameMinorVersion)
set(lower "")
set(needed "")
foreach(component core formats study)
  string(TOUPPER ${component} COMPONENT)
  add_library(kalfem_component_${component} INTERFACE)
  list(TRANSFORM KALFEM_${COMPONENT}_LIBRARIES PREPEND kalfem_ OUTPUT_VARIABLE libraries)
  target_link_libraries(kalfem_component_${component} INTERFACE ${libraries} ${lower})
  set_target_properties(kalfem_component_${component} PROPERTIES EXPORT_NAME ${component})
  set(lower kalfem_component_${component})
  list(APPEND needed ${libraries})
  # A folder of the same name as its component is exported as its library.
  if(component IN_LIST KALFEM_${COMPONENT}_LIBRARIES)
    set_target_properties(kalfem_${component} PROPERTIES EXPORT_NAME ${component}_library)
  endif()
  add_subdirectory(cmake/installed installed/${component})
endforeach()

set(said ${CMAKE_CURRENT_BINARY_DIR}/apps/kalfem)  # by the command of itself
install(TARGETS kalfem_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT command)
install(FILES ${said}/kalfem.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT command)
install(FILES ${said}/kalfem.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME kalfem COMPONENT command)
install(FILES ${said}/kalfem.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT command)
install(FILES packaging/kalfem-watch.service DESTINATION lib/systemd/system COMPONENT command)
install(FILES ${said}/kalfem.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/kalfem COMPONENT command)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command
        FILES_MATCHING PATTERN "*.md" PATTERN "*.bib" PATTERN "*.png" PATTERN "*.svg" PATTERN site EXCLUDE)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command PATTERN "*.kalfem-*" EXCLUDE PATTERN __pycache__ EXCLUDE)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT licence)

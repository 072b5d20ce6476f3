# SPDX-License-Identifier: Apache-2.0
# Install target and CMake package: find_package(kalfem COMPONENTS core formats study) gives kalfem::core,
# kalfem::formats and kalfem::study, each with the third-party packages that it needs and no others. kalfem::kalfem is
# all of them. `cmake --install <build> --component core` installs the core alone.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
include(PublicHeaders)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/kalfem)
set(lower "")
foreach(component core formats study)
  string(TOUPPER ${component} COMPONENT)
  set(libraries ${KALFEM_${COMPONENT}_LIBRARIES})
  list(TRANSFORM libraries PREPEND kalfem_)
  add_library(kalfem_component_${component} INTERFACE)
  target_link_libraries(kalfem_component_${component} INTERFACE ${libraries} ${lower})
  set(lower kalfem_component_${component})
  set(exported ${libraries})
  # A folder of the same name as its component is exported as its library.
  if(component IN_LIST KALFEM_${COMPONENT}_LIBRARIES)
    set_target_properties(kalfem_${component} PROPERTIES EXPORT_NAME ${component}_library)
  endif()
  set_target_properties(kalfem_component_${component} PROPERTIES EXPORT_NAME ${component})
  if(component STREQUAL core)
    list(APPEND exported kalfem_flags)
  endif()
  install(TARGETS ${exported} kalfem_component_${component} EXPORT kalfem_${component}
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component})
  install(EXPORT kalfem_${component} NAMESPACE kalfem:: FILE kalfem_${component}.cmake DESTINATION ${package_folder}
          COMPONENT ${component})
  foreach(header ${KALFEM_${COMPONENT}_HEADERS})
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES src/kalfem/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kalfem/${folder}
            COMPONENT ${component})
  endforeach()
endforeach()

get_property(every GLOBAL PROPERTY KALFEM_LIBRARIES)
foreach(library ${every})
  string(REPLACE kalfem_ "" folder ${library})
  if(NOT folder IN_LIST KALFEM_CORE_LIBRARIES AND NOT folder IN_LIST KALFEM_FORMATS_LIBRARIES
     AND NOT folder IN_LIST KALFEM_STUDY_LIBRARIES)
    message(FATAL_ERROR "${library} belongs to no component: name it in cmake/PublicHeaders.cmake")
  endif()
endforeach()

install(TARGETS kalfem_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT command)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/apps/kalfem/kalfem.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT command)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/apps/kalfem/kalfem.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/kalfem
        COMPONENT command)
configure_package_config_file(cmake/kalfemConfig.cmake.in kalfemConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(kalfemConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/kalfemConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/kalfemConfigVersion.cmake
              cmake/FindCHOLMOD.cmake cmake/FindHDF5Library.cmake cmake/FindMatio.cmake cmake/FindMUMPS.cmake cmake/FindSndFile.cmake
              cmake/FindUMFPACK.cmake
        DESTINATION ${package_folder} COMPONENT core)

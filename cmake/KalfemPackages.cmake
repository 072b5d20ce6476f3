# SPDX-License-Identifier: Apache-2.0
# Debian packages by CPack, as scripts/package makes them: kalfem (the command) and libkalfem-dev (the C++ libraries).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The kalfem developers <kalfem@localhost.localdomain>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "identification of nonlinear structures from vibration records")
set(CPACK_COMPONENTS_ALL command core formats study)
foreach(component core formats study)
  set(CPACK_COMPONENT_${component}_GROUP dev)
  string(TOUPPER ${component} COMPONENT)
  set(CPACK_COMPONENT_${COMPONENT}_GROUP dev)
endforeach()
set(CPACK_COMPONENT_COMMAND_GROUP command)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_SET_DESTDIR OFF)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/DebianFiles.cmake)
set(CPACK_KALFEM_FILES ${PROJECT_SOURCE_DIR}/packaging/debian)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME kalfem)
set(CPACK_DEBIAN_COMMAND_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COMMAND_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMMAND_PACKAGE_RECOMMENDS librsvg2-bin)  # figures as PNG
set(CPACK_DEBIAN_COMMAND_DESCRIPTION "The command kalfem takes the linear parts of a structure (masses, a mesh, or a
Nastran, Abaqus or CalculiX deck), the nonlinear elements between them and a
few measured accelerations. An unscented Kalman filter over reduced
substructures finds the unknown parameters with their deviations, and the
motion where no sensor is, and says whether to trust the numbers.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libkalfem-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libc6-dev, libeigen3-dev (>= 3.4), libopenblas-dev, libsuitesparse-dev, libfmt-dev, libmuparser-dev, \
libhdf5-dev, zlib1g-dev, libsndfile1-dev, libmatio-dev, libyaml-cpp-dev, nlohmann-json3-dev, libpagmo-dev, libboost-dev, libssl-dev")
set(CPACK_DEBIAN_DEV_DESCRIPTION "Headers, static libraries and a CMake package: find_package(kalfem) gives
kalfem::core, kalfem::formats and kalfem::study for programs that identify and
update finite-element models of nonlinear structures.")
include(CPack)

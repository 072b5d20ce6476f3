# SPDX-License-Identifier: Apache-2.0
# hdf5::hdf5, to link to: CMake's own FindHDF5 wants a project in C.
find_library(HDF5_C_LIBRARY NAMES hdf5 hdf5_serial PATH_SUFFIXES hdf5/serial)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(HDF5Library REQUIRED_VARS HDF5_C_LIBRARY)
if(HDF5Library_FOUND AND NOT TARGET hdf5::hdf5)
  add_library(hdf5::hdf5 UNKNOWN IMPORTED)
  set_target_properties(hdf5::hdf5 PROPERTIES IMPORTED_LOCATION ${HDF5_C_LIBRARY})
endif()

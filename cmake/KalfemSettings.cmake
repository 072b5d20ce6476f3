# SPDX-License-Identifier: Apache-2.0
# Language, warnings, third-party packages and the flags that every target shares.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Paths count from the project's folder and precompiled headers by their text, so that every clone finds what another
  # one on the machine has compiled.
  set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_DEPEND=1 CCACHE_PCH_EXTSUM=1
                                  CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
endif()

include(CheckLinkerFlag)
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  check_linker_flag(CXX -fuse-ld=lld KALFEM_HAS_LLD)  # four times as fast as ld, for forty programs
  if(KALFEM_HAS_LLD)
    add_link_options(-fuse-ld=lld)
  endif()
endif()

# Programs look for shared libraries where the system has them, never in a folder of the build or the current one.
set(CMAKE_SKIP_RPATH ON)
# Their addresses are drawn anew at each start, and the tables of the dynamic linker are read-only.
add_link_options($<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-pie> LINKER:-z,relro,-z,now)

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(BLAS REQUIRED)
find_package(LAPACK REQUIRED)
find_package(CHOLMOD REQUIRED)
find_package(UMFPACK REQUIRED)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(ZLIB REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(SndFile REQUIRED)
find_package(Matio REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)
find_package(muparser REQUIRED)
find_package(Mosquitto)  # without it there is no MQTT
if(KALFEM_MPI)
  find_package(MPI REQUIRED COMPONENTS C)
  find_package(MUMPS REQUIRED)
endif()

add_library(kalfem_flags INTERFACE)
target_compile_features(kalfem_flags INTERFACE cxx_std_20)
target_link_libraries(kalfem_flags INTERFACE Eigen3::Eigen)
# A fixed alignment keeps Eigen's types the same in the library and in programs compiled with other processor flags.
target_compile_definitions(kalfem_flags INTERFACE EIGEN_MAX_ALIGN_BYTES=64)

# Nor may Eigen's arrays of fixed size be aligned otherwise in a program that uses the installed library: members of
# public structs would stand elsewhere. Eigen derives this from the processor for which a file is compiled.
set(processor_flags "")
if(KALFEM_NATIVE AND NOT KALFEM_SANITIZE)
  set(processor_flags -march=native)
endif()
execute_process(COMMAND ${CMAKE_CXX_COMPILER} ${processor_flags} -dM -E -x c++ /dev/null OUTPUT_VARIABLE macros)
set(static_alignment 16)
if(macros MATCHES "__AVX512F__")
  set(static_alignment 64)
elseif(macros MATCHES "__AVX__")
  set(static_alignment 32)
endif()
target_compile_definitions(kalfem_flags INTERFACE $<INSTALL_INTERFACE:EIGEN_MAX_STATIC_ALIGN_BYTES=${static_alignment}>)

add_library(kalfem_private_flags INTERFACE)
target_compile_options(kalfem_private_flags INTERFACE -Wall -Wextra -Wpedantic -Wno-deprecated-enum-enum-conversion -Wno-uninitialized
                       -Wno-psabi  # lanes of eight numbers never leave the file that makes them
                       -fno-math-errno -fPIC)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # what it takes for certain in Eigen's inlined loops
  target_compile_options(kalfem_private_flags INTERFACE -Wno-maybe-uninitialized -Wno-stringop-overflow -Wno-array-bounds -Wno-restrict
                         -Wno-stringop-overread)
elseif(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  # Some laws' loops have branches that cannot run side by side. Without a time in them, precompiled headers of one content
  # are one to ccache.
  target_compile_options(kalfem_private_flags INTERFACE -Wno-pass-failed "SHELL:-Xclang -fno-pch-timestamp")
endif()
if(NOT KALFEM_SANITIZE AND NOT KALFEM_LIBFUZZER)  # which check more than these do
  target_compile_options(kalfem_private_flags INTERFACE -fstack-protector-strong -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2)
endif()
if(KALFEM_NATIVE AND NOT KALFEM_SANITIZE)
  target_compile_options(kalfem_private_flags INTERFACE -march=native)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
    # A column of a covariance tile is one register, not two: the plain filter's step is 1.8 times as fast at 256 states.
    target_compile_options(kalfem_private_flags INTERFACE -mprefer-vector-width=512)
  endif()
endif()
if(KALFEM_LIBFUZZER)
  target_compile_options(kalfem_private_flags INTERFACE -fsanitize=fuzzer-no-link,address)
  target_link_options(kalfem_private_flags INTERFACE -fsanitize=address)
endif()
if(KALFEM_SANITIZE)
  # Eigen 3.4 binds references to the first element of empty matrices without reading it: null is left to the address
  # sanitizer, which stops where it is read.
  target_compile_options(kalfem_private_flags INTERFACE -fsanitize=address,undefined -fno-sanitize=null -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(kalfem_private_flags INTERFACE -fsanitize=address,undefined)
endif()

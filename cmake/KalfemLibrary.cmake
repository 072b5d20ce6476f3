# SPDX-License-Identifier: Apache-2.0
# One static library for each folder of src/kalfem, and the test programs. All are compiled file by file with the same
# settings; tests are linked to the libraries as they are shipped.

add_library(kalfem_settings INTERFACE)
target_link_libraries(kalfem_settings INTERFACE kalfem_flags kalfem_private_flags)
target_compile_options(kalfem_settings INTERFACE $<IF:$<CXX_COMPILER_ID:GNU>,-Wshadow=local,-Wshadow>)

# kalfem_precompiled_headers(<name> [LIBRARIES <target> ...] HEADERS <header> ...): headers that most files of a kind
# include, precompiled once. kalfem_precompiled(<target> [<name>]) uses them.
#
# ccache knows such a header by a digest of its text, <header>.pch.sum: the bytes of the file hold the folder in which it
# was made, and a second clone would find nothing in the cache. Headers are named as in <...> for the same reason.
option(KALFEM_PRECOMPILE "Precompile the headers that most files include" ON)
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")  # without the header's own name, whose folder ccache would not leave out
  set(CMAKE_CXX_COMPILE_OPTIONS_USE_PCH -Xclang -include-pch -Xclang <PCH_FILE>)
endif()
function(kalfem_precompiled_headers name)
  cmake_parse_arguments(ARG "" "" "LIBRARIES;HEADERS" ${ARGN})
  file(WRITE ${CMAKE_BINARY_DIR}/${name}.cpp "")
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} kalfem_settings)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/cmake)
  if(NOT KALFEM_PRECOMPILE)
    return()
  endif()
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
  if(CCACHE AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    list(TRANSFORM ARG_HEADERS REPLACE "(.+)" "#include \\1\n" OUTPUT_VARIABLE includes)
    list(JOIN includes "" includes)
    file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/${name}.hxx CONTENT "${includes}")
    set(sum ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${name}.dir/cmake_pch.hxx.pch.sum)
    add_custom_command(OUTPUT ${sum} DEPFILE ${sum}.d DEPENDS ${CMAKE_BINARY_DIR}/${name}.hxx VERBATIM
                       COMMAND ${CMAKE_COMMAND} -DCOMPILER=${CMAKE_CXX_COMPILER} -DHEADER=${CMAKE_BINARY_DIR}/${name}.hxx -DOUTPUT=${sum}
                               "-DINCLUDES=${PROJECT_SOURCE_DIR}/src;${PROJECT_SOURCE_DIR}/cmake;$<TARGET_PROPERTY:Eigen3::Eigen,INTERFACE_INCLUDE_DIRECTORIES>"
                               -P ${PROJECT_SOURCE_DIR}/cmake/HeaderDigest.cmake)
    add_custom_target(${name}_digest DEPENDS ${sum})
  endif()
endfunction()
function(kalfem_precompiled target)
  set(headers kalfem_headers)
  if(ARGN)
    set(headers ${ARGN})
  endif()
  if(KALFEM_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM ${headers})
    if(TARGET ${headers}_digest)
      add_dependencies(${target} ${headers}_digest)
    endif()
  endif()
endfunction()
set(common <eigen_instances.hpp> <algorithm> <array> <cmath> <filesystem> <fstream> <functional> <limits> <map>
           <memory> <numbers> <numeric> <optional> <set> <span> <sstream> <string> <string_view> <utility> <variant> <vector>)
set(identification <kalfem/identification/record_estimate.hpp> <kalfem/identification/parameterised_structure.hpp>)
set(case <nlohmann/json.hpp> <kalfem/casefile/description.hpp> <kalfem/steps/run_study.hpp> <kalfem/page/page.hpp>)
kalfem_precompiled_headers(kalfem_headers HEADERS ${common})
kalfem_precompiled_headers(kalfem_identification_headers HEADERS ${common} ${identification})
kalfem_precompiled_headers(kalfem_case_headers LIBRARIES fmt::fmt HEADERS ${common} ${identification} ${case})

# kalfem_library(<folder> SOURCES ... [USES <folder> ...] [LIBRARIES <target> ...] [HEADERS <precompiled headers>])
#
# The static library of one folder of src/kalfem, with the folders that it includes (the test "layers" sees to that).
# LIBRARIES are third-party targets.
function(kalfem_library name)
  cmake_parse_arguments(ARG "" "HEADERS" "SOURCES;USES;LIBRARIES" ${ARGN})
  set(target kalfem_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  add_library(kalfem::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<INSTALL_INTERFACE:include>)
  list(TRANSFORM ARG_USES PREPEND kalfem_)
  target_link_libraries(${target} PUBLIC kalfem_flags ${ARG_USES} ${ARG_LIBRARIES} PRIVATE $<BUILD_INTERFACE:kalfem_settings>)
  kalfem_precompiled(${target} ${ARG_HEADERS})
  set_property(GLOBAL APPEND PROPERTY KALFEM_LIBRARIES ${target})
endfunction()

# What tests share: where the sources and the command are, models and cases that many of them build.
function(kalfem_test_settings)
  get_property(libraries GLOBAL PROPERTY KALFEM_LIBRARIES)
  set(places ${PROJECT_SOURCE_DIR}/tests/base/places.cpp)
  add_library(kalfem_test_support STATIC ${places} ${PROJECT_SOURCE_DIR}/tests/model/fe_models.cpp ${PROJECT_SOURCE_DIR}/tests/casefile/case_run.cpp)
  target_link_libraries(kalfem_test_support PUBLIC ${libraries} PRIVATE kalfem_settings)
  target_include_directories(kalfem_test_support PUBLIC ${PROJECT_SOURCE_DIR}/tests)
  set_source_files_properties(${places} PROPERTIES SKIP_PRECOMPILE_HEADERS ON
                              COMPILE_DEFINITIONS "KALFEM_SOURCE_DIR=\"${PROJECT_SOURCE_DIR}\";KALFEM_COMMAND=\"${CMAKE_BINARY_DIR}/bin/kalfem\"")
  kalfem_precompiled(kalfem_test_support kalfem_case_headers)
  add_library(kalfem_test_settings INTERFACE)
  target_link_libraries(kalfem_test_settings INTERFACE kalfem_test_support ${libraries} kalfem_settings GTest::gtest)
  kalfem_precompiled_headers(kalfem_test_headers LIBRARIES GTest::gtest HEADERS <gtest/gtest.h> ${common})
  kalfem_precompiled_headers(kalfem_identification_test_headers LIBRARIES GTest::gtest HEADERS <gtest/gtest.h> ${common} ${identification})
  kalfem_precompiled_headers(kalfem_case_test_headers LIBRARIES GTest::gtest fmt::fmt HEADERS <gtest/gtest.h> ${common} ${identification} ${case})
endfunction()

# kalfem_suites(<program> <property> <value> ...): one ctest entry for each suite of a GoogleTest program.
function(kalfem_suites program)
  string(REPLACE ";" " " properties "${ARGN}")
  set(entries ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.cmake)
  add_custom_command(TARGET ${program} POST_BUILD BYPRODUCTS ${entries} VERBATIM
                     COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${program}> -DENTRIES=${entries} -DPROPERTIES=${properties}
                             -P ${PROJECT_SOURCE_DIR}/cmake/ListSuites.cmake)
  set(included ${CMAKE_CURRENT_BINARY_DIR}/${program}_included.cmake)
  file(WRITE ${included} "if(EXISTS \"${entries}\")\n  include(\"${entries}\")\nelse()\n  add_test(${program} NOT_BUILT)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${included})
endfunction()

# kalfem_test(<name> [OF <stem> ...] [SOURCES ...] [LIBRARIES ...] [LABELS ...]
#             [TIMEOUT s] [EACH | WHOLE])
#
# A GoogleTest program <name>_test in tests/<folder> of the files <stem>_test.cpp, of <name>_test.cpp without any. Every suite in it is a ctest entry, as most tests are over before a process
# has started. EACH: every test is one, for tests that run for long or may be skipped; WHOLE: the program is one, for
# suites that share a long set-up.
function(kalfem_test name)
  cmake_parse_arguments(ARG "EACH;WHOLE" "TIMEOUT" "OF;SOURCES;LIBRARIES;LABELS" ${ARGN})
  if(NOT ARG_OF)
    set(ARG_OF ${name})
  endif()
  list(TRANSFORM ARG_OF APPEND _test.cpp)
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(KALFEM_SANITIZE)
    math(EXPR ARG_TIMEOUT "10 * ${ARG_TIMEOUT}")
  endif()
  set(cost 0)
  if("slow" IN_LIST ARG_LABELS)
    set(cost 100)  # started first, so that no long one is left alone at the end
  endif()
  add_executable(${name}_test ${ARG_OF} ${ARG_SOURCES})
  target_link_libraries(${name}_test PRIVATE ${ARG_LIBRARIES} GTest::gtest_main kalfem_test_settings)
  set(headers kalfem_test_headers)
  if(DEFINED KALFEM_TEST_HEADERS)  # of a folder of tests
    set(headers ${KALFEM_TEST_HEADERS})
  endif()
  kalfem_precompiled(${name}_test ${headers})
  set_target_properties(${name}_test PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  set(properties TIMEOUT ${ARG_TIMEOUT} COST ${cost})
  if(ARG_LABELS)
    list(APPEND properties LABELS ${ARG_LABELS})
  endif()
  if(ARG_WHOLE)
    add_test(NAME ${name} COMMAND ${name}_test)
    set_tests_properties(${name} PROPERTIES ${properties})
  elseif(ARG_EACH)
    gtest_discover_tests(${name}_test DISCOVERY_MODE PRE_TEST NO_PRETTY_VALUES PROPERTIES ${properties})
  else()
    kalfem_suites(${name}_test ${properties})
  endif()
endfunction()

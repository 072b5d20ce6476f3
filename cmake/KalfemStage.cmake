# kalfem_precompiled(<target> SETTINGS <target> HEADERS ...): headers precompiled once, for all targets that are compiled with
# these settings and reuse them.
function(kalfem_precompiled target)
  cmake_parse_arguments(ARG "" "SETTINGS" "HEADERS" ${ARGN})
  file(WRITE ${CMAKE_BINARY_DIR}/${target}.cpp "")
  add_library(${target} OBJECT ${CMAKE_BINARY_DIR}/${target}.cpp)
  target_link_libraries(${target} PRIVATE ${ARG_SETTINGS})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_precompile_headers(${target} PRIVATE ${ARG_HEADERS})
endfunction()

# What precompiled headers hold: Eigen's decompositions, which are compiled once in the base stage; its common expressions;
# finite-element models.
set(KALFEM_EIGEN_INSTANCES ${PROJECT_SOURCE_DIR}/src/kalfem/base/eigen_instances.hpp)
set(KALFEM_EIGEN_EXPRESSIONS ${PROJECT_SOURCE_DIR}/cmake/eigen_expressions.hpp)
set(KALFEM_MODEL_HEADER ${PROJECT_SOURCE_DIR}/src/kalfem/model/finite_element_model.hpp)

# Settings of the stages that compute, and of the rim, which reads and writes and is compiled for a short build.
add_library(kalfem_stage_settings INTERFACE)
target_link_libraries(kalfem_stage_settings INTERFACE kalfem_flags kalfem_private_flags)
target_compile_options(kalfem_stage_settings INTERFACE -Wshadow $<$<CONFIG:Release>:-O2>)
add_library(kalfem_rim_settings INTERFACE)
target_link_libraries(kalfem_rim_settings INTERFACE kalfem_flags kalfem_private_flags)
target_compile_options(kalfem_rim_settings INTERFACE -Wshadow $<$<CONFIG:Release>:-O1>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")  # functions of more than a few lines are called, not copied: a fifth less to compile
  target_compile_options(kalfem_rim_settings INTERFACE "$<$<CONFIG:Release>:SHELL:-mllvm -inline-threshold=25>")
endif()
set(KALFEM_COMMON_HEADERS ${KALFEM_EIGEN_INSTANCES} <Eigen/Sparse> <string> <vector> <map> <memory> <optional> <functional> <algorithm>)
kalfem_precompiled(kalfem_stage_headers SETTINGS kalfem_stage_settings
                   HEADERS ${KALFEM_COMMON_HEADERS} ${KALFEM_EIGEN_EXPRESSIONS})
kalfem_precompiled(kalfem_rim_headers SETTINGS kalfem_rim_settings
                   HEADERS ${KALFEM_COMMON_HEADERS} ${KALFEM_EIGEN_EXPRESSIONS} ${KALFEM_MODEL_HEADER})
# What all files see that deal with a case.
kalfem_precompiled(kalfem_case_headers SETTINGS kalfem_rim_settings
                   HEADERS ${KALFEM_COMMON_HEADERS} ${PROJECT_SOURCE_DIR}/src/kalfem/casefile/study.hpp)

# kalfem_stage(<folder> SOURCES ... [USES <stage> ...] [LIBRARIES <target> ...] [RIM | CASE])
#
# One static library for one folder of src/kalfem, with what it needs of those above it in the data flow (the test "layers"
# sees to that). LIBRARIES are third-party targets. RIM: compiled with the settings of the rim;
# CASE: with these and the precompiled header of what deals with a case.
function(kalfem_stage name)
  cmake_parse_arguments(ARG "RIM;CASE" "" "SOURCES;USES;LIBRARIES" ${ARGN})
  set(settings stage)
  set(headers stage)
  if(ARG_RIM OR ARG_CASE)
    set(settings rim)
    set(headers rim)
  endif()
  if(ARG_CASE)
    set(headers case)
  endif()
  set(target kalfem_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  add_library(kalfem::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<INSTALL_INTERFACE:include>)
  list(TRANSFORM ARG_USES PREPEND kalfem_)
  target_link_libraries(${target} PUBLIC kalfem_flags ${ARG_USES} ${ARG_LIBRARIES}
                        PRIVATE $<BUILD_INTERFACE:kalfem_${settings}_settings>)
  target_precompile_headers(${target} REUSE_FROM kalfem_${headers}_headers)
  set_property(GLOBAL APPEND PROPERTY KALFEM_STAGES ${target})
endfunction()

# kalfem_tested_library(): all stages in one shared library, to which tests are linked. It keeps to its own copies of
# templates: without that, those of a test that is compiled for a short build would take the place of the library's.
function(kalfem_tested_library)
  get_property(stages GLOBAL PROPERTY KALFEM_STAGES)
  add_library(kalfem_tested SHARED)
  foreach(stage ${stages})
    target_sources(kalfem_tested PRIVATE $<TARGET_OBJECTS:${stage}>)
  endforeach()
  set_target_properties(kalfem_tested PROPERTIES LINKER_LANGUAGE CXX)
  target_link_libraries(kalfem_tested PUBLIC kalfem_flags PRIVATE ${stages})
  target_include_directories(kalfem_tested PUBLIC ${PROJECT_SOURCE_DIR}/src)
  target_link_options(kalfem_tested PRIVATE $<$<CONFIG:Release>:-Wl,-Bsymbolic>)
endfunction()

# kalfem_test_headers(): the one precompiled header of all tests, and the settings that they share with it.
function(kalfem_test_headers)
  add_library(kalfem_test_settings INTERFACE)
  target_link_libraries(kalfem_test_settings INTERFACE kalfem_flags kalfem_private_flags GTest::gtest)
  target_compile_options(kalfem_test_settings INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wshadow=local>)
  target_compile_definitions(kalfem_test_settings INTERFACE KALFEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
                                                            KALFEM_COMMAND="${CMAKE_BINARY_DIR}/bin/kalfem")
  kalfem_precompiled(kalfem_test_headers SETTINGS kalfem_test_settings
                     HEADERS <gtest/gtest.h> ${KALFEM_EIGEN_INSTANCES} ${KALFEM_EIGEN_EXPRESSIONS} ${KALFEM_MODEL_HEADER}
                             <algorithm> <filesystem> <fstream> <iostream> <map> <numbers> <optional> <random> <sstream>
                             <string> <vector>)
  target_compile_options(kalfem_test_headers PRIVATE $<$<CONFIG:Release>:-O0>)
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
#             [TIMEOUT s] [EACH | WHOLE] [OPTIMISED])
#
# A GoogleTest program <name>_test in tests/<folder> of the files <stem>_test.cpp, of <name>_test.cpp without any. Every suite in it is a ctest entry, as most tests are over before a process
# has started. EACH: every test is one, for tests that run for long or may be skipped; WHOLE: the program is one, for
# suites that share a long set-up. OPTIMISED: the tests compute for long themselves.
function(kalfem_test name)
  cmake_parse_arguments(ARG "EACH;WHOLE;OPTIMISED" "TIMEOUT" "OF;SOURCES;LIBRARIES;LABELS" ${ARGN})
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
  target_include_directories(${name}_test PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(${name}_test PRIVATE kalfem_tested ${ARG_LIBRARIES} GTest::gtest_main kalfem_test_settings)
  if(ARG_OPTIMISED)
    target_compile_options(${name}_test PRIVATE $<$<CONFIG:Release>:-O1>)
    target_precompile_headers(${name}_test REUSE_FROM kalfem_rim_headers)
  else()
    target_compile_options(${name}_test PRIVATE $<$<CONFIG:Release>:-O0>)
    target_precompile_headers(${name}_test REUSE_FROM kalfem_test_headers)
  endif()
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

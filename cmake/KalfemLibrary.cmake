# One static library for each folder of src/kalfem, and the test programs. All are compiled file by file with the same
# settings; tests are linked to the libraries as they are shipped.

add_library(kalfem_settings INTERFACE)
target_link_libraries(kalfem_settings INTERFACE kalfem_flags kalfem_private_flags)
target_compile_options(kalfem_settings INTERFACE $<IF:$<CXX_COMPILER_ID:GNU>,-Wshadow=local,-Wshadow>)

# Eigen and the standard containers, precompiled: half of what most files would spend on reading headers.
option(KALFEM_PRECOMPILE "Precompile the headers that most files include" ON)
file(WRITE ${CMAKE_BINARY_DIR}/kalfem_headers.cpp "")
add_library(kalfem_headers OBJECT ${CMAKE_BINARY_DIR}/kalfem_headers.cpp)
target_link_libraries(kalfem_headers PRIVATE kalfem_settings)
if(KALFEM_PRECOMPILE)
  target_precompile_headers(kalfem_headers PRIVATE <Eigen/Dense> <Eigen/Sparse> <algorithm> <functional> <map> <memory>
                            <optional> <string> <vector>)
endif()
function(kalfem_precompiled target)
  if(KALFEM_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM kalfem_headers)
  endif()
endfunction()

# kalfem_library(<folder> SOURCES ... [USES <folder> ...] [LIBRARIES <target> ...])
#
# The static library of one folder of src/kalfem, with the folders that it includes (the test "layers" sees to that).
# LIBRARIES are third-party targets.
function(kalfem_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;USES;LIBRARIES" ${ARGN})
  set(target kalfem_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  add_library(kalfem::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<INSTALL_INTERFACE:include>)
  list(TRANSFORM ARG_USES PREPEND kalfem_)
  target_link_libraries(${target} PUBLIC kalfem_flags ${ARG_USES} ${ARG_LIBRARIES} PRIVATE $<BUILD_INTERFACE:kalfem_settings>)
  kalfem_precompiled(${target})
  set_property(GLOBAL APPEND PROPERTY KALFEM_LIBRARIES ${target})
endfunction()

# What tests share: where the sources and the command are.
function(kalfem_test_settings)
  get_property(libraries GLOBAL PROPERTY KALFEM_LIBRARIES)
  add_library(kalfem_test_settings INTERFACE)
  target_link_libraries(kalfem_test_settings INTERFACE ${libraries} kalfem_settings GTest::gtest)
  target_include_directories(kalfem_test_settings INTERFACE ${PROJECT_SOURCE_DIR}/tests)
  target_compile_definitions(kalfem_test_settings INTERFACE KALFEM_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
                                                            KALFEM_COMMAND="${CMAKE_BINARY_DIR}/bin/kalfem")
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
  kalfem_precompiled(${name}_test)
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

# SPDX-License-Identifier: Apache-2.0
# Writes the ctest entries of a GoogleTest program, one a suite:
#   cmake -DPROGRAM=<file> -DENTRIES=<file to write> -DPROPERTIES="<name> <value> ..." -P ListSuites.cmake
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\n[A-Za-z0-9_/]+\\.[ \n]" suites "${listed}")  # tests are indented
set(entries "")
foreach(suite ${suites})
  string(REGEX REPLACE "[.\n ]" "" suite "${suite}")
  string(APPEND entries "add_test(\"${suite}\" \"${PROGRAM}\" \"--gtest_filter=${suite}.*\")\n"
                        "set_tests_properties(\"${suite}\" PROPERTIES ${PROPERTIES})\n")
endforeach()
file(WRITE ${ENTRIES} "${entries}")

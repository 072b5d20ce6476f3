# SPDX-License-Identifier: Apache-2.0
# Writes OUTPUT, which says what the command is built from, where that has changed:
#   cmake -DSOURCE=<the project> -DCOMPILER=<name version> -DPROCESSOR=<for which> -DOUTPUT=<file> -P build_stamp.cmake
# Of sources without their history, the environment variable KALFEM_COMMIT says the commit.
set(commit "$ENV{KALFEM_COMMIT}")
find_program(git git)
if(git AND EXISTS ${SOURCE}/.git AND NOT commit)
  execute_process(COMMAND ${git} -C ${SOURCE} rev-parse --short=12 HEAD OUTPUT_VARIABLE commit
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND ${git} -C ${SOURCE} diff --quiet HEAD RESULT_VARIABLE changed OUTPUT_QUIET ERROR_QUIET)
  if(commit AND changed)
    string(APPEND commit " with changes")
  endif()
endif()
if(NOT commit)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[
#include "build_stamp.hpp"

namespace kalfem::command {

const char* const build_stamp = "commit @commit@, @COMPILER@, @PROCESSOR@";

}  // namespace kalfem::command
]] @ONLY)

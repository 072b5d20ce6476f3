# SPDX-License-Identifier: Apache-2.0
# Run by CPack on the staged files of each Debian package: adds its copyright and changelog, compresses what Debian's
# policy wants compressed, and takes what only a debugger reads out of the static libraries.
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of the commit: SOURCE_DATE_EPOCH
foreach(package kalfem libkalfem-dev)
  set(group command)
  if(package STREQUAL libkalfem-dev)
    set(group dev)
  endif()
  set(share ${CPACK_TEMPORARY_DIRECTORY}/${group}/usr/share)
  set(documents ${share}/doc/${package})
  file(MAKE_DIRECTORY ${documents})
  file(COPY ${CPACK_KALFEM_FILES}/copyright DESTINATION ${documents} FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  file(WRITE ${documents}/changelog "kalfem (${CPACK_PACKAGE_VERSION}) bookworm; urgency=medium

  * The changes of this version are in CHANGELOG.md of its sources.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
  file(GLOB pages ${documents}/changelog ${share}/man/man1/*.1)
  foreach(page ${pages})
    run(gzip -9nf ${page})
  endforeach()
  file(GLOB_RECURSE archives ${CPACK_TEMPORARY_DIRECTORY}/${group}/usr/lib/*.a)
  foreach(archive ${archives})
    run(strip --strip-debug --enable-deterministic-archives --remove-section=.comment --remove-section=.note ${archive})
  endforeach()
endforeach()

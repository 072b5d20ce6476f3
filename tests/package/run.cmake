# SPDX-License-Identifier: Apache-2.0
# Installs the project into an empty folder and uses it as somebody else would: only the public headers are there, each
# compiles by itself, and the programs of examples/cpp build, run and find what they should.
#   cmake -DSOURCE=<the project> -DBUILD=<its build> -DWORK=<folder to use> -P run.cmake
include(${SOURCE}/cmake/PublicHeaders.cmake)
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(code)
    message(FATAL_ERROR "${ARGV}: exit code ${code}\n${output}")
  endif()
endfunction()
set(installed ${WORK}/installed)
set(configure -G Ninja -DCMAKE_PREFIX_PATH=${installed} -DCMAKE_BUILD_TYPE=Release)
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${installed})
run(${installed}/bin/kalfem --version)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/command --component command)
foreach(file bin/kalfem share/man/man1/kalfem.1 share/bash-completion/completions/kalfem share/fish/vendor_completions.d/kalfem.fish
             share/kalfem/kalfem.schema.json lib/systemd/system/kalfem-watch.service share/doc/kalfem/docs/start.md share/doc/kalfem/examples/chain/chain.yaml)
  if(NOT EXISTS ${WORK}/command/${file})
    message(FATAL_ERROR "the component 'command' has no ${file}")
  endif()
endforeach()
file(GLOB libraries ${WORK}/command/lib/cmake ${WORK}/command/lib/*.a ${WORK}/command/lib/*/*.a)
if(EXISTS ${WORK}/command/include OR libraries)
  message(FATAL_ERROR "the component 'command' has C++ libraries")
endif()


set(public ${KALFEM_CORE_HEADERS} ${KALFEM_FORMATS_HEADERS} ${KALFEM_STUDY_HEADERS})
file(GLOB_RECURSE headers RELATIVE ${installed}/include/kalfem ${installed}/include/*)
list(SORT public)
list(SORT headers)
if(NOT headers STREQUAL public)
  message(FATAL_ERROR "installed:\n${headers}\npublic (cmake/PublicHeaders.cmake):\n${public}")
endif()
list(LENGTH headers count)
if(count GREATER 79)
  message(FATAL_ERROR "${count} public headers; at most 74 are a small interface")
endif()

run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/headers -B ${WORK}/headers ${configure} -DSOURCE=${SOURCE}
    -DCMAKE_CXX_FLAGS_RELEASE=-O0)
run(${CMAKE_COMMAND} --build ${WORK}/headers)

set(examples ${SOURCE}/examples)
run(${CMAKE_COMMAND} -S ${examples}/cpp -B ${WORK}/examples ${configure} -DCMAKE_CXX_FLAGS_RELEASE=-O1)
run(${CMAKE_COMMAND} --build ${WORK}/examples)
run(${WORK}/examples/estimate_chain ${examples}/cpp/chain.csv)
run(${WORK}/examples/own_law)
run(${WORK}/examples/reduce_deck ${examples}/cpp/frame.bdf ${WORK}/superelement.h5)
run(${WORK}/examples/update_frame ${examples}/cpp/frame.bdf)
run(${WORK}/examples/run_case ${examples}/chain/chain.yaml ${WORK}/results)
run(${WORK}/examples/online_filter)

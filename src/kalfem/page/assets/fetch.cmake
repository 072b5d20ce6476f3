# SPDX-License-Identifier: Apache-2.0
# cmake -DFOLDER=<where to> -DSOURCE=<folder of package.json> -P fetch.cmake
#
# Fetches packages from npm, in the versions that package-lock.json pins. npm is looked for here, when they are needed:
# configuring the project and building the other folders need none.
set(way_out "To build without charts on the page, and without npm: scripts/build --no-page-parts (KALFEM_PAGE_PARTS=OFF).")
find_program(NPM npm)
if(NOT NPM)
  message(FATAL_ERROR "The page's parts, uPlot and three.js, come from npm, which is not installed (Debian: apt-get install npm). ${way_out}")
endif()
file(MAKE_DIRECTORY ${FOLDER})
file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json ${SOURCE}/.npmrc DESTINATION ${FOLDER})
execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --loglevel=error
                WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE code)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "npm could not fetch the page's parts: uplot, three and esbuild in the versions of package-lock.json. ${way_out}")
endif()
file(TOUCH ${FOLDER}/fetched)

# cmake -DFOLDER=<where to> -DSOURCE=<folder of package.json> -P fetch.cmake
#
# Fetches packages from npm, in the versions that package-lock.json pins. npm is looked for here, when they are needed:
# configuring the project and building the other folders need none.
find_program(NPM npm)
if(NOT NPM)
  message(FATAL_ERROR "The report's web parts come from npm, which is not installed. Install it (Debian: apt-get install npm), "
                      "or build only the folders that you need, such as the target kalfem_estimation.")
endif()
file(MAKE_DIRECTORY ${FOLDER})
file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json ${SOURCE}/.npmrc DESTINATION ${FOLDER})
execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --loglevel=error
                WORKING_DIRECTORY ${FOLDER} COMMAND_ERROR_IS_FATAL ANY)
file(TOUCH ${FOLDER}/fetched)

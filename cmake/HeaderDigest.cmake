# SPDX-License-Identifier: Apache-2.0
# Writes a digest of the text that a header includes, with what it depends on beside it.
#   cmake -DCOMPILER=... -DINCLUDES=... -DHEADER=... -DOUTPUT=... -P HeaderDigest.cmake
list(TRANSFORM INCLUDES PREPEND -isystem)
execute_process(COMMAND ${COMPILER} -std=c++20 -E -P -MD -MT ${OUTPUT} -MF ${OUTPUT}.d ${INCLUDES} -x c++ ${HEADER}
                OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
string(SHA256 digest "${text}")
file(WRITE ${OUTPUT} "${digest}\n")

# SPDX-License-Identifier: Apache-2.0
# cmake -DOUTPUT=<file.cpp> -DASSETS="<function>=<file>;..." -P embed.cmake
#
# Writes a C++ source in which each function returns the bytes of its file. Byte arrays rather than string literals:
# compilers limit the length of a literal and give escapes in it a meaning.
set(text "#include \"kalfem/page/embedded_assets.hpp\"\n\nnamespace kalfem::assets {\n")
foreach(asset IN LISTS ASSETS)
  string(REPLACE "=" ";" asset "${asset}")
  list(GET asset 0 function)
  list(GET asset 1 file)
  file(READ "${file}" bytes HEX)
  if(bytes STREQUAL "")
    message(FATAL_ERROR "${file} is empty")
  endif()
  string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(APPEND text "\nstatic const unsigned char ${function}_bytes[] = {\n${bytes}};\n"
         "std::string_view ${function}() {\n"
         "  return {reinterpret_cast<const char*>(${function}_bytes), sizeof ${function}_bytes};\n}\n")
endforeach()
file(WRITE "${OUTPUT}" "${text}\n}  // namespace kalfem::assets\n")

# SPDX-License-Identifier: Apache-2.0
# Writes OUTPUT, which holds the files of the cases below FOLDER: cmake -DFOLDER=... -DOUTPUT=... -P starter_files.cmake
file(GLOB files RELATIVE ${FOLDER} ${FOLDER}/*/*.yaml ${FOLDER}/*/*.csv ${FOLDER}/*/*.bdf)
list(SORT files)
set(entries "")
foreach(file ${files})
  get_filename_component(kind ${file} DIRECTORY)
  get_filename_component(name ${file} NAME)
  file(READ ${FOLDER}/${file} text)
  string(APPEND entries "{\"${kind}\", \"${name}\", R\"kalfem(${text})kalfem\"},\n")
endforeach()
file(WRITE ${OUTPUT} "#include \"new_case.hpp\"

namespace kalfem::command {

const std::vector<StarterFile>& starter_files() {
  static const std::vector<StarterFile> files{
${entries}};
  return files;
}

}  // namespace kalfem::command
")

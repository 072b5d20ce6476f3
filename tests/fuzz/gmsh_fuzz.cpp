// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/gmsh/gmsh.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    kalfem::parse_gmsh({reinterpret_cast<const char*>(data), size}, "fuzz.msh");
  } catch (const kalfem::InvalidInput&) {  // what a reader may do with damaged input
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matrices.hpp"

// All formats of text, and gzip, as the content says: CalculiX's triplets, matrices between nodes, user elements, maps.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  for (const char* name : {"fuzz.mtx", "fuzz.sti"}) {
    try {
      kalfem::parse_matrices(bytes, name);
    } catch (const kalfem::InvalidInput&) {  // what a reader may do with damaged input
    }
  }
  for (const int directions : {0, 3}) {
    try {
      kalfem::parse_dof_map(bytes, "fuzz.dof", {.directions = directions});
    } catch (const kalfem::InvalidInput&) {
    }
  }
  return 0;
}

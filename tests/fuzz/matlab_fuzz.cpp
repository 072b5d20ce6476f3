// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matrices.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    kalfem::parse_matrices({reinterpret_cast<const char*>(data), size}, "fuzz.mat",
                           {.format = kalfem::MatrixFormat::matlab});
  } catch (const kalfem::InvalidInput&) {  // what a reader may do with damaged input
  }
  return 0;
}

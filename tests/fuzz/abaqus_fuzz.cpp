// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <string>

#include "kalfem/formats/abaqus.hpp"

// Whatever stands in a deck, it is read or refused by InvalidInput. Included files do not exist here.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    kalfem::parse_abaqus(std::string(reinterpret_cast<const char*>(data), size), "deck.inp",
                         [](const std::filesystem::path& path) -> std::string {
                           throw kalfem::InvalidInput("'" + path.string() + "' is not here", "", "");
                         });
  } catch (const kalfem::InvalidInput&) {
  }
  return 0;
}

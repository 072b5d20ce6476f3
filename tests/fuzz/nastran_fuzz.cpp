// SPDX-License-Identifier: Apache-2.0
// Any text is a model, or InvalidInput with at least one issue; nothing else. Built with -fsanitize=fuzzer,address.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "kalfem/formats/nastran.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto deck = kalfem::parse_nastran(std::string(reinterpret_cast<const char*>(data), size), "fuzz.bdf");
    if (deck.model.mesh.node_ids.size() != static_cast<std::size_t>(deck.model.mesh.node_count())) std::abort();
    static_cast<void>(kalfem::validate(deck.model));
  } catch (const kalfem::InvalidInput& error) {
    if (error.issues().empty()) std::abort();
  }
  return 0;
}

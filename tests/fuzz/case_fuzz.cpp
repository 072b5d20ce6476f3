// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/yaml/case_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto form = kalfem::description::case_schema();
  try {
    kalfem::read_case_text({reinterpret_cast<const char*>(data), size}, "fuzz.yaml", form,
                           [](const std::string&) { return std::optional<std::string>(); });
  } catch (const kalfem::InvalidInput&) {  // what a reader may do with damaged input
  }
  return 0;
}

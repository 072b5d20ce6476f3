#include "kalfem/casefile/case_reader.hpp"
#include "kalfem/casefile/description_form.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    kalfem::read_case_text({reinterpret_cast<const char*>(data), size}, "fuzz.yaml", kalfem::description::case_form(),
                           [](const std::string&) { return std::optional<std::string>(); });
  } catch (const kalfem::InvalidInput&) {  // what a reader may do with damaged input
  }
  return 0;
}

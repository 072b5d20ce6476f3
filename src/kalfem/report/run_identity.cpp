#include "kalfem/report/run_identity.hpp"

#include <fmt/format.h>

#include <cstdint>

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

/// Fowler, Noll and Vo's hash FNV-1a of 64 bits: the same on every computer, as std::hash is not.
class Hash {
public:
  void add(const std::string& text) {
    for (const char c : text) state_ = (state_ ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  }
  [[nodiscard]] std::uint64_t value() const { return state_; }

private:
  std::uint64_t state_ = 0xCBF29CE484222325U;
};

void drop_times(Json& json) {
  if (json.is_object()) {
    json.erase("seconds");
    json.erase("timing");
  }
  for (auto& item : json)
    if (item.is_structured()) drop_times(item);
}

}  // namespace

std::string run_identity(const Study& study, const Json& summary) {
  Json numbers = summary;
  drop_times(numbers);
  Hash hash;
  hash.add(study.resolved_case);
  hash.add(numbers.dump(-1, ' ', false, Json::error_handler_t::replace));
  return fmt::format("{:016x}", hash.value());
}

}  // namespace kalfem

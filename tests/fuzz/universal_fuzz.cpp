// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/measured_selection.hpp"
#include "kalfem/formats/universal/universal.hpp"

namespace {

/// What a reader promises of everything that it returns.
void check(const kalfem::MeasuredFile& file) {
  bool sound = true;
  for (const auto& channel : file.channels) {
    sound = sound && channel.values.size() > 0 && !channel.name.empty() && channel.interval >= 0.0;
    sound = sound && (channel.times.size() == 0 || channel.times.size() == channel.values.size());
  }
  for (const auto& function : file.functions)
    sound = sound && function.values.size() > 0 && function.values.size() == function.lines.size();
  for (const auto& shape : file.shapes) sound = sound && shape.values.rows() == static_cast<long>(shape.nodes.size());
  for (const auto& node : file.nodes)
    for (const double coordinate : node.position) sound = sound && std::isfinite(coordinate);
  if (!sound) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string file = "fuzz.unv";
  try {
    const auto measured = kalfem::parse_universal({reinterpret_cast<const char*>(data), size}, file);
    check(measured);
    for (const bool missing : {false, true}) {
      for (const auto& channel : measured.channels) {
        try {
          kalfem::select_record(measured, {{.column = channel.name, .owner = "a", .unit = "m/s^2"}},
                                {.sample_rate = 100.0, .missing = missing}, file);
        } catch (const kalfem::InvalidInput&) {
        }
      }
    }
    kalfem::select_frequency_responses(measured, {}, file);
  } catch (const kalfem::InvalidInput&) {  // what a reader may do with damaged input
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/write_frf_table.hpp"

#include <fmt/format.h>

#include <iterator>
#include <string>

#include "kalfem/base/atomic_file.hpp"

namespace kalfem {

void write_frf_table(const std::filesystem::path& path, const FrequencyResponse& response) {
  std::string text = "frequency [Hz]";
  const auto out = std::back_inserter(text);
  for (const auto& output : response.outputs)
    fmt::format_to(out, ",{0}_re [{1}],{0}_im [{1}]", output.name, output.unit);
  for (Eigen::Index line = 0; line < response.lines.size(); ++line) {
    fmt::format_to(out, "\n{}", response.lines[line]);
    for (const auto& value : response.values.row(line)) fmt::format_to(out, ",{},{}", value.real(), value.imag());
  }
  write_file_atomically(path, text + "\n");
}

}  // namespace kalfem

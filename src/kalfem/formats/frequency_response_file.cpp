// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/frequency_response_file.hpp"

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/formats/measured_selection.hpp"

namespace kalfem {

FrequencyResponse read_frequency_responses(const std::filesystem::path& file, const FrfTableOptions& options) {
  const MeasuredFormat* format = measured_format(file);
  if (format == nullptr) return read_frf_table(file, options);
  if (options.content != FrfColumnContent::complex)
    throw InvalidInput(Issue{{file.string(), 0},
                             "the file says itself whether its values are complex",
                             "it is a " + std::string(format->name),
                             "remove `values`"});
  return select_frequency_responses(format->read(file, {.channels = options.outputs}), options.outputs, file);
}

}  // namespace kalfem

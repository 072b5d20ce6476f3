// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/measured_file.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// Responses of a structure, whatever moved it.
struct OutputRecord {
  Record record;                           ///< SI where the file states units that are understood
  std::vector<MeasuredPlace> places;       ///< of the channels, as far as they are known
  std::vector<std::string> left_out = {};  ///< forces of the file, when no channels were asked for
};

/// The named channels of a measured file of any format, or all that are no forces; of a case (.yaml) its sensors. The
/// channels of `inputs` come first in the record, without a place. Throws InvalidInput as the readers do, for a case
/// without a record or with inputs, and where no channel is left.
OutputRecord read_outputs(const std::filesystem::path& file, const std::vector<std::string>& channels,
                          std::optional<double> sample_rate, const std::vector<std::string>& inputs = {});

}  // namespace kalfem

#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/casefile/description.hpp"
#include "kalfem/records/record_preparation.hpp"

namespace kalfem {

/// Reads the channels of the case's sensors, one row a sensor in their order, and prepares the record as the case asks.
/// Throws InvalidInput (missing file or channel, units that do not fit, samples that are not finite unless the case
/// skips them, an empty part, a channel without any number in it or with one value throughout).
PreparedRecord read_measured_record(const description::Case& given);

}  // namespace kalfem

#pragma once

#include "kalfem/casefile/description.hpp"
#include "kalfem/study/measured_record.hpp"

namespace kalfem {

/// Reads the channels of the case's sensors. Throws InvalidInput (missing file or channel, units that do not fit,
/// samples that are not finite unless the case skips them, an empty part, a channel without any number in it or with
/// one value throughout).
MeasuredRecord read_measured_record(const description::Case& given);

}  // namespace kalfem

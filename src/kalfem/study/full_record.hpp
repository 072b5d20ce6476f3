#pragma once

#include "kalfem/identification/filter_run.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// The measured record of the case with the noise of each channel. Throws InvalidInput where per cent of a channel that
/// is 0 throughout are no noise.
FullRecord measured_record(const Study& study);

/// Throws the same for a simulated record.
void check_noise(const Study& study, const std::vector<double>& noise, const std::string& channel);

}  // namespace kalfem

#pragma once

#include "kalfem/study/study.hpp"

namespace kalfem {

/// Gives each channel of the measured record the unit and the noise of its sensor. Throws InvalidInput where per cent
/// of a channel that is 0 throughout are no noise.
void set_noise(Study& study);

/// Throws the same for a record with one channel a sensor; `channel` names one in the message.
void check_noise(const Study& study, const Record& record, const std::string& channel);

}  // namespace kalfem

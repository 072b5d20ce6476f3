#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/study/study.hpp"

namespace kalfem {

/// What all files of one run carry, so that files of two runs are told apart: 16 hexadecimal digits, a hash of the case
/// with all its defaults and of the numbers in its summary. Times that were taken are left out: the same run again has
/// the same identity.
std::string run_identity(const Study& study, const nlohmann::ordered_json& summary);

}  // namespace kalfem

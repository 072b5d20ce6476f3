#pragma once

#include <nlohmann/json.hpp>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// The object "updating" of summary.json.
nlohmann::ordered_json updating_summary(const Study& study, const UpdatingOutcome& outcome);

}  // namespace kalfem

#pragma once

#include <nlohmann/json.hpp>

#include "kalfem/casefile/stages.hpp"

namespace kalfem {

/// The object "updating" of summary.json.
nlohmann::ordered_json updating_summary(const Study& study, const UpdatingStage& stage);

}  // namespace kalfem

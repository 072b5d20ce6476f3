#pragma once

#include <nlohmann/json.hpp>

#include "kalfem/casefile/stages.hpp"

namespace kalfem {

/// summary.json: all SI; keys only where the stage ran; null where unknown; never NaN.
nlohmann::ordered_json summarise(const Study& study, const StudyResults& results);

}  // namespace kalfem

#pragma once

#include <nlohmann/json.hpp>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// summary.json: all SI; keys only where the stage ran; null where unknown; never NaN. `run` is run_identity().
/// Of `timing`, total_s covers every other part and never falls below their sum: the stages run one after another, and
/// each part is the time that passed on the clock, however many threads it used. estimate_split_s divides the time of
/// the filter; `output` may pass in a thread beside `predict` and `update`.
nlohmann::ordered_json summarise(const Study& study, const StudyResults& results);

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Everything of kalfem::core: describe a structure, simulate it, choose its sensors, identify its modes from a record
/// alone, estimate its states and parameters from a record, infer their posterior, validate them on another record, or
/// update it by modes, frequency responses, deflections and records. Files of other programs (kalfem::formats) and case
/// files (kalfem::study) have headers of their own:
///     kalfem/formats/tables/csv.hpp, kalfem/formats/deck.hpp, kalfem/formats/matrices/write.hpp
///     kalfem/report/run_case.hpp
#include "kalfem/api/compare.hpp"
#include "kalfem/api/correlate.hpp"
#include "kalfem/api/estimate.hpp"
#include "kalfem/api/finite_elements.hpp"
#include "kalfem/api/infer.hpp"
#include "kalfem/api/laws.hpp"
#include "kalfem/api/live_filter.hpp"
#include "kalfem/api/online_filter.hpp"
#include "kalfem/api/place.hpp"
#include "kalfem/api/predict.hpp"
#include "kalfem/api/sensors.hpp"
#include "kalfem/api/simulate.hpp"
#include "kalfem/api/statics.hpp"
#include "kalfem/api/structure.hpp"
#include "kalfem/api/update.hpp"
#include "kalfem/api/validate.hpp"
#include "kalfem/api/vibration.hpp"
#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/modal/identify_modes.hpp"
#include "kalfem/records/clock_lag.hpp"
#include "kalfem/records/record.hpp"

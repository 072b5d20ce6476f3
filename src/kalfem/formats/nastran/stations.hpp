// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/formats/nastran/bulk_data.hpp"

namespace kalfem::nastran {

/// A station of PBEAM or PBEAML as its card gives it.
struct StationFields {
  double place = 1.0;                    ///< X/XB
  std::map<std::size_t, double> values;  ///< that are not blank, by position
};

/// Place and values of a station.
using Station = std::pair<double, std::vector<double>>;

/// All stations from end A (0) to end B (1), in order. What is blank at end B is as at end A; what is blank between is
/// linear from end to end. Throws CardError for a place that is not in (0, 1], or that stands twice.
std::vector<Station> filled_stations(const std::vector<double>& end_a, std::vector<StationFields> given,
                                     const std::string& title);

/// The section of a beam: one all along where its stations are equal; else that of end A, with all of them.
SectionCard along(std::vector<std::pair<double, SectionCard>> stations);

}  // namespace kalfem::nastran

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/correlation/point_match.hpp"
#include "kalfem/page/page.hpp"

namespace kalfem {

/// Each point with its node, the next one, and how its axes look in the model.
Table point_match_table(const PointMatch& match, const Mesh& mesh);
/// The turn as an axis and an angle, the shift, and how well the points fit.
std::string fit_words(const PlaceFit& fit);
/// Other positions that fit as well, and points that are not sure, a line each; empty where all is sure.
std::string doubts(const PointMatch& match);

}  // namespace kalfem

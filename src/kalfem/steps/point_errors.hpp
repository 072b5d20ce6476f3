// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/records/spectrum.hpp"
#include "kalfem/steps/reported_quantities.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Everything of lumped parts and connectors; of finite elements the points and gauges that the case wants shown, if it
/// names some.
bool shown(const Study& study, const PointQuantity& quantity);
/// NRMSE of a step's points against the reference after the sample `settled`; "at rest" for points that do not move.
/// Of finite-element substructures only the points that the case wants shown, where it names some.
Table error_table(const std::string& title, const Study& study, const std::vector<PointQuantity>& points,
                  Eigen::Index settled);
/// " (band of the excitation: 0.5 to 30 Hz)"; empty where it has none.
std::string band_words(const std::optional<FrequencyBand>& band);

/// Tells points that move from those that do not: the rms of their reference is below a millionth (120 dB) of the
/// largest of its kind (displacements, forces, ...), which is rounding of the mesh and of the solution. An error
/// relative to it says nothing.
class RestingPoints {
public:
  /// `settled`: first sample that counts, as for the errors.
  RestingPoints(const std::vector<PointQuantity>& points, Eigen::Index settled);
  [[nodiscard]] bool rests(const PointQuantity& point) const;

private:
  [[nodiscard]] double moved(const PointQuantity& point) const;

  Eigen::Index settled_;
  std::map<ObservedQuantity, double> largest_;
};

/// Adds the errors of a point's estimate against its truth, where that is known.
void add_errors(nlohmann::ordered_json& errors, const PointQuantity& point, const RestingPoints& resting);

}  // namespace kalfem

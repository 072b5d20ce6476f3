// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/correlation/correlate.hpp"
#include "kalfem/correlation/point_match.hpp"
#include "kalfem/correlation/response_agreement.hpp"
#include "kalfem/identification/finite_element_part.hpp"

namespace kalfem {

/// Where the geometry of a measured file puts its points on the model.
struct PlacedPoints {
  PointMatch match;
  std::vector<std::string> contradictions = {};  ///< to the nodes that the case gives the points, a sentence each
};

/// A point that is one degree of freedom, times a factor.
struct ReportedPoint {
  std::string name;
  Eigen::Index dof = 0;  ///< of the model
  double weight = 1.0;
};

/// A comparison of modes, mode by mode and sensor by sensor.
struct CorrelatedComparison {
  std::string name;
  std::string substructure;
  Correlation correlation;
  std::vector<MeasuredMode> measured = {};
  std::vector<DofCombination> points =
      {};                          ///< of their shapes, as combinations of the substructure's degrees of freedom
  double above = 0.0;              ///< [Hz] modes of the model up to this frequency are not elastic ones
  FiniteElementPartPtr part = {};  ///< the substructure; null where it has no mesh
  std::optional<PlacedPoints> placed = {};   ///< nothing where the file has no geometry or the substructure no mesh
  std::vector<ReportedPoint> reported = {};  ///< of the substructure, whose expanded motion tables show
};

/// A comparison of frequency responses, output by output.
struct CorrelatedResponses {
  std::string name;
  std::vector<ResponseAgreement> responses;
};

struct CorrelationOutcome {
  std::vector<CorrelatedComparison> comparisons;
  std::vector<CorrelatedResponses> responses = {};
  bool updated = false;  ///< with the updated model; otherwise as the case gives it
  double seconds = 0.0;
};

}  // namespace kalfem

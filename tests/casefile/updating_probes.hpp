// SPDX-License-Identifier: Apache-2.0
// The structure of two masses whose updating is looked at key by key.
#pragma once

#include "casefile/probes.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/steps/updating/compute.hpp"

namespace kalfem::wiring {

inline const std::string at = "update.", compare_at = at + "compare.*.";

/// Two masses in a row from the ground, 2 % modal damping; the first spring is refined.
inline Study with_update(const std::string& text, const Sections& more = {}) {
  Sections sections{
      {"substructures",
       "{s: {masses: {a: 2, b: 3}, springs: [{name: k, from: ground, to: a, stiffness: 800}, {name: m, from: a, "
       "to: b, stiffness: 500}], damping: {modal: 2 %}}}"},
      {"connectors", ""},
      {"excitation", ""},
      {"sensors", ""},
      {"simulate", ""},
      {"update", "{" + text + "}"}};
  for (const auto& [key, value] : more) sections[key] = value;
  return study_of(lumped_case(sections));
}

inline Study with_comparison(const std::string& text, const Sections& more = {}) {
  return with_update("parameters: {s.k.stiffness: {}}, compare: {first: {" + text + "}}", more);
}

/// Mass and stiffness of the substructure with its first spring as stiff as given.
inline std::pair<Eigen::MatrixXd, Eigen::MatrixXd> matrices(double k = 800.0) {
  return {Eigen::Vector2d(2, 3).asDiagonal(), Eigen::Matrix2d{{k + 500, -500}, {-500, 500}}};
}

inline NormalModes modes_at(double k = 800.0) {
  const auto [m, s] = matrices(k);
  return normal_modes(m.sparseView(), s.sparseView());
}

inline std::vector<ComparisonResidual> residuals_of(const Study& study, const StudyResults& results = {}) {
  const auto residuals = all_comparisons(study, results);
  return residuals;
}

inline Eigen::VectorXd residual_at(const Study& study, double k, const StudyResults& results = {}) {
  return residuals_of(study, results)
      .at(0)
      .continuation_steps.back()
      ->evaluate(Eigen::VectorXd::Constant(1, k), false)
      ->values;
}

inline Eigen::VectorXd residual_of(const std::string& text, double k = 800.0) {
  return residual_at(with_comparison(text), k);
}

}  // namespace kalfem::wiring

// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/comparisons_likelihood.hpp"

#include "kalfem/inference/residual_likelihood.hpp"
#include "kalfem/steps/updating/compute.hpp"
#include "kalfem/steps/updating/search.hpp"

namespace kalfem {

ParameterLikelihood likelihood_of_comparisons(const Study& study, const StudyResults& results) {
  const auto comparisons = all_comparisons(study, results);
  std::string words;
  for (const auto& each : comparisons) words += (words.empty() ? "the comparisons of `update`: " : ", ") + each.kind;
  Eigen::Index dofs = study.model->system().size();
  for (const auto& elements : study.structure->finite_elements) dofs += elements.part->full.size();
  return likelihood_of_residual(std::make_shared<const ResidualSum>(last_sum(comparisons)), names_of(*study.inference),
                                words, dofs);
}

}  // namespace kalfem

#include "kalfem/study/driven_check.hpp"

#include <algorithm>

#include "kalfem/identification/driven_substructure.hpp"

namespace kalfem {

using Eigen::Index;

InvalidInput not_estimated(const Name& substructure, const std::string& point) {
  return InvalidInput(substructure.issue("the filter's model does not contain the motion of '" + point + "'",
                                         "this motion drives the substructure",
                                         "include the point in the filter's model or make it an interface"));
}

void check_driven(const CaseStudy& study, const CoupledModel& model, const Name& substructure) {
  constexpr Index largest_driven = 2000;  // degrees of freedom; larger ones are factored once, when they are driven
  if (model.find_substructure(substructure.value).part.model->size() > largest_driven) return;
  const DrivenSubstructure drive(*study.structure, model, substructure.value);
  const auto estimated = study.augmented_model->model->reported_points();
  for (const auto& point : drive.points())
    if (std::ranges::find(estimated, point) == estimated.end()) throw not_estimated(substructure, point);
}

}  // namespace kalfem

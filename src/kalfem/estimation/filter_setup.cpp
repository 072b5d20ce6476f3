#include "kalfem/estimation/filter_setup.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;

FilterSetup::FilterSetup(std::shared_ptr<const AugmentedModel> of, const EstimationOptions& options)
    : augmented_model(std::move(of)),
      transition(*augmented_model),
      filter(make_filter(options.filter, options.unscented, &transition, options.threads)),
      measurement(*augmented_model, sensor_outputs) {
  if (options.monitored.size() > 0)
    monitored.emplace(*augmented_model, [&](const AugmentedModel& each) {
      return each.augmented_model_form().outputs(options.monitored);
    });
}

bool LinearEstimate::outdates(const LinearEstimate& there) const {
  for (Index i = 0; i < values.size(); ++i) {
    const double scale = std::max(std::abs(values[i]), deviations[i]);
    const bool moved = std::abs(values[i] - there.values[i]) > 0.1 * std::sqrt(deviations[i] * scale);
    const bool shrunk = there.deviations[i] > 0.01 * scale && deviations[i] < 0.5 * there.deviations[i];
    if (moved || shrunk) return true;
  }
  return false;
}

std::unique_ptr<FilterSetup> relinearised(const AugmentedModel& first, const LinearEstimate& here,
                                          const FilterSetup& filter_setup, const EstimationOptions& options) {
  auto augmented_model = std::make_shared<const AugmentedModel>(first.about(here.values, here.deviations));
  const auto& before = *filter_setup.augmented_model;
  auto anew = std::make_unique<FilterSetup>(augmented_model, options);
  anew->filter->reset({augmented_model->own(before.physical(filter_setup.filter->mean())),
                       augmented_model->own_covariance(before.physical_covariance(filter_setup.filter->covariance()))});
  return anew;
}

}  // namespace kalfem

#include "kalfem/estimation/filter_apparatus.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;

FilterApparatus::FilterApparatus(std::shared_ptr<const Observer> of, const EstimationOptions& options)
    : observer(std::move(of)),
      transition(*observer),
      filter(make_filter(options.filter, options.unscented, &transition, options.threads)),
      measurement(*observer, sensor_outputs) {
  if (options.monitored.size() > 0)
    monitored.emplace(*observer, [&](const Observer& each) { return each.observer_form().outputs(options.monitored); });
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

std::unique_ptr<FilterApparatus> linearised_anew(const Observer& first, const LinearEstimate& here,
                                                 const FilterApparatus& apparatus, const EstimationOptions& options) {
  auto observer = std::make_shared<const Observer>(first.about(here.values, here.deviations));
  const auto& before = *apparatus.observer;
  auto anew = std::make_unique<FilterApparatus>(observer, options);
  anew->filter->reset({observer->own(before.physical(apparatus.filter->mean())),
                       observer->own_covariance(before.physical_covariance(apparatus.filter->covariance()))});
  return anew;
}

}  // namespace kalfem

#include "kalfem/estimation/filter_setup.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

std::optional<MeasurementModel> monitored_map(const AugmentedModel& augmented_model, const OutputMap& monitored) {
  if (monitored.size() == 0) return std::nullopt;
  return MeasurementModel(augmented_model,
                          [&](const AugmentedModel& each) { return each.augmented_model_form().outputs(monitored); });
}

}  // namespace

FilterSetup::FilterSetup(std::shared_ptr<const AugmentedModel> of, const MatrixXd& measurement_noise,
                         const EstimationOptions& options)
    : augmented_model(std::move(of)),
      transition(*augmented_model),
      measurement(*augmented_model, sensor_outputs),
      monitored(monitored_map(*augmented_model, options.monitored)),
      filter(make_filter(options.filter,
                         {.process = transition,
                          .process_noise = augmented_model->process_noise(),
                          .measurement = measurement,
                          .measurement_noise = measurement_noise,
                          .monitored = monitored ? &*monitored : nullptr},
                         options.unscented, options.threads)) {
  filter->treat_outliers(options.outliers);
}

std::optional<Index> FilterSetup::failed_connector() const {
  if (const auto failed = transition.failed_connector()) return failed;
  if (const auto failed = measurement.failed_connector()) return failed;
  return monitored ? monitored->failed_connector() : std::nullopt;
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
                                          const FilterSetup& before, const MatrixXd& measurement_noise,
                                          const EstimationOptions& options) {
  auto model = std::make_shared<const AugmentedModel>(first.about(here.values, here.deviations));
  auto setup = std::make_unique<FilterSetup>(model, measurement_noise, options);
  // The coordinates depend on where the model is linearised; the estimate goes over through the physical ones.
  const auto& old = *before.augmented_model;
  setup->filter->reset({model->own(old.physical(before.filter->mean())),
                        model->own_covariance(old.physical_covariance(before.filter->covariance()))});
  return setup;
}

}  // namespace kalfem

#include "kalfem/records/time_series.hpp"

#include <cmath>
#include <limits>

namespace kalfem {

Eigen::Index TimeSeries::find(const std::string& name) const {
  for (std::size_t j = 0; j < channels.size(); ++j)
    if (channels[j].name == name) return static_cast<Eigen::Index>(j);
  return -1;
}

double rms(const Eigen::Ref<const Eigen::VectorXd>& signal) {
  return signal.size() == 0 ? 0.0 : signal.norm() / std::sqrt(static_cast<double>(signal.size()));
}

double nrmse(const Eigen::Ref<const Eigen::VectorXd>& estimate, const Eigen::Ref<const Eigen::VectorXd>& reference) {
  const double error = rms(estimate - reference), scale = rms(reference);
  if (scale > 0.0) return error / scale;
  return error == 0.0 ? 0.0 : std::numeric_limits<double>::infinity();
}

}  // namespace kalfem

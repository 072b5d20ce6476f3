// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/result_series.hpp"

#include "kalfem/steps/reported_quantities.hpp"

namespace kalfem {
namespace {

struct QuantityName {
  const char* name;
  const char* unit;
};

QuantityName name_of(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
      return {"displacement", "m"};
    case ObservedQuantity::velocity:
      return {"velocity", "m/s"};
    case ObservedQuantity::acceleration:
      return {"acceleration", "m/s^2"};
    case ObservedQuantity::connector_deformation:
      return {"deformation", "m"};
    case ObservedQuantity::connector_rate:
      return {"rate", "m/s"};
    case ObservedQuantity::connector_force:
      return {"force", "N"};
    case ObservedQuantity::strain:
      return {"strain", "m/m"};
  }
  return {"", ""};
}

}  // namespace

void SeriesWriter::write(const std::string& name, const Eigen::VectorXd& values, const std::string& unit) {
  if (values.size() > 0) visit_({name, values, unit, sample_rate_});
}

void SeriesWriter::write_points(const std::string& group, const std::vector<PointQuantity>& points) {
  for (const auto& point : points) {
    const auto [quantity, unit] = name_of(point.quantity);
    const std::string name = group + "/" + point.point + "/" + quantity;
    write(name, point.mean, unit);
    write(name + "_std", point.deviation, unit);
  }
}

void SeriesWriter::write_column(const std::string& name, const Eigen::VectorXd& values, const std::string& unit) {
  if (values.size() > 0) visit_({name, values, unit});
}

void SeriesWriter::write_chains(const std::string& name, const Eigen::VectorXd& values, const std::string& unit,
                                Eigen::Index chains) {
  if (values.size() > 0) visit_({name, values, unit, {}, chains});
}

}  // namespace kalfem

#include "kalfem/report/resting_points.hpp"

#include <algorithm>

#include "kalfem/records/record.hpp"

namespace kalfem {
namespace {

constexpr double smallest_part = 1e-6;

}  // namespace

RestingPoints::RestingPoints(const std::vector<PointQuantity>& points, Eigen::Index settled) : settled_(settled) {
  for (const auto& point : points) {
    double& largest = largest_[point.quantity];
    largest = std::max(largest, moved(point));
  }
}

bool RestingPoints::rests(const PointQuantity& point) const {
  const auto largest = largest_.find(point.quantity);
  return point.truth.size() > 0 && largest != largest_.end() && moved(point) <= smallest_part * largest->second;
}

double RestingPoints::moved(const PointQuantity& point) const {
  return rms(point.truth.tail(std::max<Eigen::Index>(0, point.truth.size() - settled_)));
}

}  // namespace kalfem

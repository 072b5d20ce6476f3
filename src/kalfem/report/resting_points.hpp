#pragma once

#include <map>
#include <vector>

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Tells points that move from those that do not: the rms of their reference is below a millionth (120 dB) of the
/// largest of its kind (displacements, forces, ...), which is rounding of the mesh and of the solution. An error
/// relative to it says nothing.
class RestingPoints {
public:
  /// `settled`: first sample that counts, as for the errors.
  RestingPoints(const std::vector<PointQuantity>& points, Eigen::Index settled);
  [[nodiscard]] bool rests(const PointQuantity& point) const;

private:
  [[nodiscard]] double moved(const PointQuantity& point) const;

  Eigen::Index settled_;
  std::map<ObservedQuantity, double> largest_;
};

}  // namespace kalfem

#include "kalfem/formats/abaqus/axes.hpp"

namespace kalfem::abaqus {

std::optional<Eigen::Matrix3d> axes_from(const Eigen::Vector3d& x, const Eigen::Vector3d& in_plane) {
  const double scale = x.norm() * in_plane.norm();
  const Eigen::Vector3d normal = x.cross(in_plane);
  if (!(scale > 0.0) || !std::isfinite(scale) || normal.norm() < 1e-9 * scale) return {};
  Eigen::Matrix3d axes;
  axes.col(0) = x.normalized();
  axes.col(2) = normal.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

Eigen::Matrix3d LocalAxes::at(const Eigen::Vector3d& place) const {
  Eigen::Matrix3d local = axes;
  if (kind != AxesKind::rectangular) {
    const Eigen::Vector3d polar = axes.col(2), arm = place - origin;
    const Eigen::Vector3d outward = arm - polar * polar.dot(arm);
    const bool on_axis = outward.norm() <= 1e-9 * (arm.norm() + 1e-300);
    const Eigen::Vector3d radial = on_axis ? Eigen::Vector3d(axes.col(0)) : Eigen::Vector3d(outward.normalized());
    const Eigen::Vector3d tangential = polar.cross(radial);
    if (kind == AxesKind::cylindrical) {
      local << radial, tangential, polar;
    } else {
      const Eigen::Vector3d outer = arm.norm() > 0.0 ? Eigen::Vector3d(arm.normalized()) : radial;
      local << outer, tangential, outer.cross(tangential);
    }
  }
  if (angle != 0.0) local = rotation(local.col(rotated_axis), angle) * local;
  return local;
}

}  // namespace kalfem::abaqus

#include "kalfem/formats/abaqus/face_projection.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem::abaqus {

namespace {

struct Shape {
  Eigen::VectorXd values;
  Eigen::Matrix<double, Eigen::Dynamic, 2> slopes;
};

/// Triangles over r, s >= 0, r + s <= 1.
Shape triangle(double r, double s, bool quadratic) {
  const double t = 1.0 - r - s;
  Shape shape;
  if (!quadratic) {
    shape.values = Eigen::Vector3d(t, r, s);
    shape.slopes.resize(3, 2);
    shape.slopes << -1, -1, 1, 0, 0, 1;
    return shape;
  }
  shape.values.resize(6);
  shape.values << t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t;
  shape.slopes.resize(6, 2);
  shape.slopes << 1 - 4 * t, 1 - 4 * t, 4 * r - 1, 0, 0, 4 * s - 1, 4 * (t - r), -4 * r, 4 * s, 4 * r, -4 * s,
      4 * (t - s);
  return shape;
}

/// Quadrilaterals over -1 <= r, s <= 1, bilinear or of the serendipity family.
Shape quadrilateral(double r, double s, bool quadratic) {
  static constexpr std::array<std::array<double, 2>, 4> corner = {{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  Shape shape;
  shape.values.resize(quadratic ? 8 : 4);
  shape.slopes.resize(quadratic ? 8 : 4, 2);
  for (Index i = 0; i < 4; ++i) {
    const auto [a, b] = corner[static_cast<std::size_t>(i)];
    const double p = 1 + a * r, q = 1 + b * s;
    if (!quadratic) {
      shape.values[i] = p * q / 4;
      shape.slopes.row(i) << a * q / 4, b * p / 4;
    } else {
      const double sum = a * r + b * s;
      shape.values[i] = p * q * (sum - 1) / 4;
      shape.slopes.row(i) << a * q * (sum - 1 + p) / 4, b * p * (sum - 1 + q) / 4;
    }
  }
  if (!quadratic) return shape;
  const double rr = 1 - r * r, ss = 1 - s * s;
  shape.values.tail<4>() << rr * (1 - s) / 2, ss * (1 + r) / 2, rr * (1 + s) / 2, ss * (1 - r) / 2;
  shape.slopes.bottomRows<4>() << -r * (1 - s), -rr / 2, ss / 2, -s * (1 + r), -r * (1 + s), rr / 2, -ss / 2,
      -s * (1 - r);
  return shape;
}

/// Moves the parameters back into the face.
void keep_inside(Eigen::Vector2d& parameters, bool three) {
  if (!three) {
    parameters = parameters.cwiseMax(-1.0).cwiseMin(1.0);
    return;
  }
  parameters = parameters.cwiseMax(0.0);
  if (const double excess = parameters.sum() - 1.0; excess > 0.0) {
    parameters.array() -= excess / 2.0;
    parameters = parameters.cwiseMax(0.0).cwiseMin(1.0);
  }
}

}  // namespace

std::optional<Projection> project(const Mesh& mesh, const Face& face, const Eigen::Vector3d& place) {
  const bool three = face.corners == 3;
  const std::size_t count = face.nodes.size();
  if ((!three && face.corners != 4) || (count != face.corners && count != 2 * face.corners)) return {};
  const bool quadratic = count > face.corners;
  Eigen::Matrix3Xd nodes(3, static_cast<Index>(count));
  for (std::size_t i = 0; i < count; ++i) nodes.col(static_cast<Index>(i)) = mesh.nodes.col(face.nodes[i]);
  const auto shape_at = [&](const Eigen::Vector2d& p) {
    return three ? triangle(p.x(), p.y(), quadratic) : quadrilateral(p.x(), p.y(), quadratic);
  };
  Eigen::Vector2d parameters = three ? Eigen::Vector2d(1.0 / 3.0, 1.0 / 3.0) : Eigen::Vector2d(0.0, 0.0);
  Shape shape = shape_at(parameters);
  Eigen::Matrix<double, 3, 2> tangents;
  for (int iteration = 0; iteration < 20; ++iteration) {
    tangents = nodes * shape.slopes;
    const Eigen::Matrix2d metric = tangents.transpose() * tangents;
    if (!(metric.determinant() > 1e-20 * metric.trace() * metric.trace())) return {};
    const Eigen::Vector2d step = metric.inverse() * tangents.transpose() * (place - nodes * shape.values);
    const Eigen::Vector2d before = parameters;
    parameters += step;
    keep_inside(parameters, three);
    shape = shape_at(parameters);
    if ((parameters - before).norm() < 1e-12) break;
  }
  tangents = nodes * shape.slopes;
  const Eigen::Matrix2d metric = tangents.transpose() * tangents;
  if (!(metric.determinant() > 1e-20 * metric.trace() * metric.trace())) return {};
  Projection result;
  result.shares = shape.values;
  result.gradients = tangents * metric.inverse() * shape.slopes.transpose();
  result.point = nodes * shape.values;
  result.normal = tangents.col(0).cross(tangents.col(1)).normalized();
  result.distance = (place - result.point).norm();
  return result;
}

}  // namespace kalfem::abaqus

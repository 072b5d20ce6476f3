// SPDX-License-Identifier: Apache-2.0
#include "modal/ambient_record.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include "kalfem/base/random.hpp"

namespace kalfem::test {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double pi = std::numbers::pi;

VectorXd AmbientStructure::frequencies() const { return omega / (2.0 * pi); }

VectorXd AmbientStructure::participations() const {
  const VectorXd variance = (inputs.rowwise().squaredNorm().array() / (4.0 * zeta.array() * omega.array())).matrix();
  const MatrixXd parts = shapes.cwiseAbs2() * variance.asDiagonal();  // outputs x modes
  const VectorXd sums = parts.rowwise().sum();
  return (sums.cwiseInverse().asDiagonal() * parts).colwise().mean().transpose();
}

AmbientStructure shear_frame(int storeys, double highest, double zeta) {
  AmbientStructure made{VectorXd(storeys), VectorXd::Constant(storeys, zeta), MatrixXd(storeys, storeys), {}};
  for (int j = 0; j < storeys; ++j) {
    const double angle = (2 * j + 1) * pi / (2 * storeys + 1);
    made.omega[j] = std::sin(0.5 * angle);
    for (int floor = 0; floor < storeys; ++floor) made.shapes(floor, j) = std::sin((floor + 1) * angle);
    made.shapes.col(j).normalize();
  }
  made.omega *= 2.0 * pi * highest / made.omega[storeys - 1];
  made.inputs = made.shapes.transpose();
  return made;
}

AmbientStructure near_square_plate(double lowest, double side_ratio, double zeta) {
  constexpr int orders = 3, grid = 4;
  AmbientStructure made{VectorXd(orders * orders), VectorXd::Constant(orders * orders, zeta),
                        MatrixXd(grid * grid, orders * orders), MatrixXd(orders * orders, 5)};
  const auto value = [](int m, int n, double x, double y) { return std::sin(m * pi * x) * std::sin(n * pi * y); };
  const double places[5][2] = {{0.13, 0.21}, {0.37, 0.71}, {0.83, 0.31}, {0.59, 0.43}, {0.71, 0.87}};
  for (int m = 1; m <= orders; ++m)
    for (int n = 1; n <= orders; ++n) {
      const int mode = (m - 1) * orders + n - 1;
      made.omega[mode] =
          2.0 * pi * lowest * (m * m + n * n * side_ratio * side_ratio) / (1.0 + side_ratio * side_ratio);
      for (int i = 0; i < grid * grid; ++i)
        made.shapes(i, mode) = value(m, n, (i % grid + 0.8) / (grid + 0.7), (i / grid + 0.9) / (grid + 0.8));
      for (int i = 0; i < 5; ++i) made.inputs(mode, i) = value(m, n, places[i][0], places[i][1]);
    }
  return made;
}

AmbientStructure close_pair(double frequency, double apart, double zeta) {
  AmbientStructure made{VectorXd(2), VectorXd::Constant(2, zeta), MatrixXd(3, 2), MatrixXd::Identity(2, 2)};
  made.omega << 2.0 * pi * frequency, 2.0 * pi * frequency * (1.0 + apart);
  made.shapes << 1.0, 0.5, 0.7, -0.9, 0.3, 1.0;
  return made;
}

Record ambient_record(const AmbientStructure& structure, double sample_rate, Index samples, std::uint64_t seed,
                      double noise, int substeps) {
  const Index modes = structure.omega.size(), forces = structure.inputs.cols(), outputs = structure.shapes.rows();
  const double h = 1.0 / (sample_rate * substeps);
  RandomStream random(seed, "ambient forces"), of_noise(seed, "noise of the sensors");
  // q' + i..: with mu = omega (-zeta + i sqrt(1 - zeta^2)) and z = q' - conj(mu) q, z' = mu z + f exactly.
  Eigen::VectorXcd mu(modes), step(modes), gain(modes), z = Eigen::VectorXcd::Zero(modes);
  for (Index j = 0; j < modes; ++j) {
    mu[j] = structure.omega[j] *
            std::complex<double>(-structure.zeta[j], std::sqrt(1.0 - structure.zeta[j] * structure.zeta[j]));
    step[j] = std::exp(mu[j] * h);
    gain[j] = (step[j] - 1.0) / mu[j] / std::sqrt(h);
  }
  const auto warm_up =
      static_cast<Index>(8.0 * sample_rate / (structure.zeta.array() * structure.omega.array()).minCoeff());
  MatrixXd velocities(modes, samples);
  VectorXd force(forces);
  for (Index k = -warm_up; k < samples; ++k) {
    for (int part = 0; part < substeps; ++part) {
      for (Index i = 0; i < forces; ++i) force[i] = random.normal();
      z = step.cwiseProduct(z) + gain.cwiseProduct((structure.inputs * force).cast<std::complex<double>>());
    }
    if (k < 0) continue;
    for (Index j = 0; j < modes; ++j)  // q = Im z / Im mu, q' = Re z + Re mu q
      velocities(j, k) = z[j].real() + mu[j].real() * z[j].imag() / mu[j].imag();
  }
  Record record{.sample_rate = sample_rate, .values = structure.shapes * velocities};
  for (Index i = 0; i < outputs; ++i) {
    record.channels.push_back({"v" + std::to_string(i + 1), "m/s"});
    const double level = noise * rms(record.values.row(i).transpose());
    for (Index k = 0; k < samples; ++k) record.values(i, k) += level * of_noise.normal();
  }
  return record;
}

}  // namespace kalfem::test

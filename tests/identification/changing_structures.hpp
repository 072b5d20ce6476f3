// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>

#include "identification/chain_structure.hpp"
#include "kalfem/system/signals/sampled.hpp"

// Random structures of one to six masses, of which one spring may change within the record, integrated here by a
// Runge-Kutta method: what a filter says of their records rests on nothing of the library.

namespace kalfem::test {

/// How a stiffness goes along a record of duration T.
enum class Course { constant, drop, line, saturating, sine };

struct StiffnessChange {
  Course course = Course::constant;
  double size = 0.0;   ///< of the change over the stiffness: largest difference within the record
  double place = 0.0;  ///< time of a drop, time constant of a saturating drift, period of a sine; over the duration

  /// Stiffness over that at the first sample, `t` over the duration.
  [[nodiscard]] double factor(double t) const {
    switch (course) {
      case Course::drop:
        return t < place ? 1.0 : 1.0 - size;
      case Course::line:
        return 1.0 - size * t;
      case Course::saturating:
        return 1.0 - size * std::expm1(-t / place) / std::expm1(-1.0 / place);
      case Course::sine:
        return 1.0 - 0.5 * size * std::sin(2.0 * std::numbers::pi * t / place);
      case Course::constant:
        break;
    }
    return 1.0;
  }
};

/// A tree of masses on springs, every one from its parent (-1: the ground), under a force of random phases.
struct ChangingStructure {
  std::vector<int> parent;
  Eigen::VectorXd mass, stiffness, cubic, damping;  ///< [kg], [N/m], [N/m^3], [N s/m]
  int forced = 0;                                   ///< mass
  std::vector<int> sensed;                          ///< masses with an accelerometer
  double noise = 0.05;                              ///< of each channel's rms
  int changing = 0;                                 ///< spring
  StiffnessChange change;
  double sample_rate = 200.0, duration = 20.0;  ///< [Hz], [s]
  double lowest = 0.0, highest = 0.0;           ///< natural frequencies [Hz]
  double ratio = 0.0;                           ///< damping of the lowest mode

  [[nodiscard]] int size() const { return static_cast<int>(parent.size()); }
  [[nodiscard]] Eigen::Index samples() const { return static_cast<Eigen::Index>(std::lround(duration * sample_rate)); }
};

/// Samples at twice the integrator's steps of a force of 100 N rms, flat from half the lowest natural frequency to
/// beyond the highest one, or to a seventh of the sampling rate.
inline Eigen::VectorXd random_force(const ChangingStructure& structure, int per_sample, RandomStream& random) {
  constexpr int lines = 120;
  const double lower = 0.5 * structure.lowest;
  const double upper = std::clamp(1.3 * structure.highest, 2.0 * structure.lowest, structure.sample_rate / 7.0);
  const double step = 1.0 / (structure.sample_rate * per_sample);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(structure.samples() * per_sample + 1);
  for (int i = 0; i < lines; ++i) {
    // Frequencies within their own slots: a force that does not repeat.
    const double frequency = lower + (upper - lower) * (i + random.uniform()) / lines;
    const std::complex<double> turn = std::polar(1.0, 2.0 * std::numbers::pi * frequency * step);
    std::complex<double> value = std::polar(100.0 * std::sqrt(2.0 / lines), 2.0 * std::numbers::pi * random.uniform());
    for (double& sample : force) {
      sample += value.imag();
      value *= turn;
    }
  }
  const double ramp = 2.0 / structure.lowest;
  for (Eigen::Index k = 0; static_cast<double>(k) * step < ramp && k < force.size(); ++k)
    force[k] *= 0.5 - 0.5 * std::cos(std::numbers::pi * static_cast<double>(k) * step / ramp);
  return force;
}

/// The accelerations of all masses from rest, by the classical Runge-Kutta method of fourth order.
class RungeKutta {
public:
  RungeKutta(const ChangingStructure& structure, const Eigen::VectorXd& force, int steps_per_sample)
      : structure_(structure), force_(force), steps_(steps_per_sample) {}

  /// masses x samples; the deformations of the springs beside it.
  Eigen::MatrixXd run(Eigen::MatrixXd& deformations) {
    const Eigen::Index n = structure_.size(), samples = structure_.samples();
    const double h = 1.0 / (structure_.sample_rate * steps_);
    Eigen::MatrixXd accelerations(n, samples);
    deformations.resize(n, samples);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(2 * n), k1(2 * n), k2(2 * n), k3(2 * n), k4(2 * n);
    for (Eigen::Index k = 0; k < samples * steps_; ++k) {
      derivative(x, 2 * k, k1);
      if (k % steps_ == 0) {
        accelerations.col(k / steps_) = k1.tail(n);
        for (Eigen::Index i = 0; i < n; ++i) deformations(i, k / steps_) = x[i] - at_parent(x, i, 0);
      }
      derivative(x + 0.5 * h * k1, 2 * k + 1, k2);
      derivative(x + 0.5 * h * k2, 2 * k + 1, k3);
      derivative(x + h * k3, 2 * k + 2, k4);
      x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    return accelerations;
  }

private:
  [[nodiscard]] double at_parent(const Eigen::VectorXd& x, Eigen::Index i, Eigen::Index offset) const {
    const int parent = structure_.parent[static_cast<std::size_t>(i)];
    return parent < 0 ? 0.0 : x[offset + parent];
  }

  void derivative(const Eigen::VectorXd& x, Eigen::Index half_step, Eigen::VectorXd& dx) const {
    const Eigen::Index n = structure_.size();
    const double t = static_cast<double>(half_step) / (2.0 * steps_ * structure_.sample_rate * structure_.duration);
    dx.head(n) = x.tail(n);
    dx.tail(n).setZero();
    dx[n + structure_.forced] = force_[half_step];
    for (Eigen::Index i = 0; i < n; ++i) {
      const double d = x[i] - at_parent(x, i, 0), v = x[n + i] - at_parent(x, i, n);
      const double k = structure_.stiffness[i] * (i == structure_.changing ? structure_.change.factor(t) : 1.0);
      const double f = k * d + structure_.cubic[i] * d * d * d + structure_.damping[i] * v;
      dx[n + i] -= f;
      if (const int parent = structure_.parent[static_cast<std::size_t>(i)]; parent >= 0) dx[n + parent] += f;
    }
    dx.tail(n).array() /= structure_.mass.array();
  }

  const ChangingStructure& structure_;
  const Eigen::VectorXd& force_;
  int steps_;
};

/// Sets the natural frequencies of its linear part.
inline void set_frequencies(ChangingStructure& structure) {
  const Eigen::Index n = structure.size();
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    Eigen::VectorXd b = Eigen::VectorXd::Unit(n, i);
    if (const int parent = structure.parent[static_cast<std::size_t>(i)]; parent >= 0) b[parent] -= 1.0;
    K += structure.stiffness[i] * b * b.transpose();
  }
  const Eigen::MatrixXd M = structure.mass.asDiagonal();
  const Eigen::VectorXd squares = Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(K, M).eigenvalues();
  structure.lowest = std::sqrt(squares.minCoeff()) / (2.0 * std::numbers::pi);
  structure.highest = std::sqrt(squares.maxCoeff()) / (2.0 * std::numbers::pi);
}

/// Order 0 .. n - 1 at random.
inline std::vector<int> shuffled(int n, RandomStream& random) {
  std::vector<int> order(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) order[static_cast<std::size_t>(i)] = i;
  for (int i = n - 1; i > 0; --i)
    std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(random.uniform() * (i + 1))]);
  return order;
}

/// A chain or a tree of one to six masses of 5 to 15 kg, springs of 20 to 60 kN/m, damping of 1 to 7 % in its lowest
/// mode, one to four accelerometers of 1 to 10 % noise, 100 to 400 Hz. A third has a cubic spring.
inline ChangingStructure random_structure(std::uint64_t seed) {
  RandomStream random(seed, "structure");
  const auto between = [&](double lower, double upper) { return lower + (upper - lower) * random.uniform(); };
  const int n = 1 + static_cast<int>(6.0 * random.uniform());
  const bool tree = random.uniform() < 0.4;
  ChangingStructure structure;
  for (int i = 0; i < n; ++i)
    structure.parent.push_back(tree && i > 1 ? static_cast<int>(random.uniform() * i) : i - 1);
  structure.mass = Eigen::VectorXd::NullaryExpr(n, [&] { return between(5.0, 15.0); });
  structure.stiffness = Eigen::VectorXd::NullaryExpr(n, [&] { return between(20e3, 60e3); });
  structure.cubic = Eigen::VectorXd::Zero(n);
  set_frequencies(structure);
  structure.ratio = between(0.01, 0.07);
  structure.damping = 2.0 * structure.ratio / (2.0 * std::numbers::pi * structure.lowest) * structure.stiffness;
  structure.forced = static_cast<int>(random.uniform() * n);
  structure.sensed = shuffled(n, random);
  structure.sensed.resize(static_cast<std::size_t>(std::min(n, 1 + static_cast<int>(4.0 * random.uniform()))));
  structure.noise = 0.01 * std::pow(10.0, random.uniform());
  structure.changing = static_cast<int>(random.uniform() * n);
  structure.sample_rate = std::max(6.0 * structure.highest, 100.0 * std::pow(4.0, random.uniform()));
  structure.sample_rate = 20.0 * std::ceil(structure.sample_rate / 20.0);
  structure.duration = between(15.0, 40.0);
  if (random.uniform() < 0.33) {
    // The cubic part of a spring is a tenth to a third of its linear one at the rms of its deformation.
    const auto at = static_cast<Eigen::Index>(random.uniform() * n);
    ChangingStructure shorter = structure;
    shorter.duration = 5.0;
    Eigen::MatrixXd deformations;
    const Eigen::VectorXd force = random_force(shorter, 8, random);
    RungeKutta(shorter, force, 4).run(deformations);
    const double size = rms(deformations.row(at).transpose());
    structure.cubic[at] = between(0.1, 0.33) * structure.stiffness[at] / (size * size);
  }
  return structure;
}

/// A record of a structure, the problem of a model that holds every spring constant, and which unknown changes.
struct ChangingRecord {
  EstimationProblem problem;
  Record record;
  std::vector<double> truth;  ///< of the unknowns, at the first sample
  std::string changing;       ///< name of the unknown
};

/// Up to three springs are unknown, the changing one among them, from first guesses that are about 10 % off.
inline ChangingRecord changing_record(const ChangingStructure& structure, std::uint64_t seed) {
  constexpr int steps = 6;
  RandomStream random(seed, "record");
  const Eigen::VectorXd force = random_force(structure, 2 * steps, random);
  Eigen::MatrixXd deformations;
  const Eigen::MatrixXd accelerations = RungeKutta(structure, force, steps).run(deformations);

  ChangingRecord made;
  auto model = std::make_shared<StructureData>();
  LumpedSubstructure masses;
  masses.name = "m";
  for (int i = 0; i < structure.size(); ++i) masses.masses.push_back({std::to_string(i), structure.mass[i]});
  model->parts.substructures = {masses};
  for (int i = 0; i < structure.size(); ++i) {
    const int parent = structure.parent[static_cast<std::size_t>(i)];
    const std::string from = parent < 0 ? "m.ground" : "m." + std::to_string(parent), at = std::to_string(i);
    const bool cubic = structure.cubic[i] != 0.0;
    Eigen::VectorXd parameters(cubic ? 4 : 2);
    if (cubic)
      parameters << structure.stiffness[i], structure.cubic[i], structure.damping[i], 0.0;
    else
      parameters << structure.stiffness[i], structure.damping[i];
    model->parts.connectors.push_back({"s" + at, from, "m." + at, make_law(cubic ? "cubic" : "linear"), parameters});
  }
  model->parts.inputs = {{"f", InputKind::force, "m." + std::to_string(structure.forced)}};
  const Eigen::VectorXd sampled = force(Eigen::seq(0, Eigen::last, 2 * steps));
  model->signals = {make_sampled(sampled, {.sample_rate = structure.sample_rate})};

  made.problem = {.structure = model, .sample_rate = structure.sample_rate};
  made.record.sample_rate = structure.sample_rate;
  made.record.values.resize(static_cast<Eigen::Index>(structure.sensed.size()), structure.samples());
  for (std::size_t j = 0; j < structure.sensed.size(); ++j) {
    const std::string point = std::to_string(structure.sensed[j]);
    auto channel = made.record.values.row(static_cast<Eigen::Index>(j));
    channel = accelerations.row(structure.sensed[j]);
    const double noise = structure.noise * rms(channel.transpose());
    made.problem.sensors.push_back({.name = "a" + point,
                                    .output = {"a" + point, ObservedQuantity::acceleration, {{"m." + point, 1.0}}},
                                    .noise = noise,
                                    .unit = "m/s^2"});
    made.record.channels.push_back({"a" + point, "m/s^2", noise});
    for (double& sample : channel) sample += noise * random.normal();
  }
  std::vector<int> unknown = shuffled(structure.size(), random);
  std::ranges::stable_partition(unknown, [&](int i) { return i == structure.changing; });
  unknown.resize(std::min<std::size_t>(unknown.size(), 1 + static_cast<std::size_t>(3.0 * random.uniform())));
  std::ranges::sort(unknown);
  for (const int i : unknown) {
    const std::string name = "s" + std::to_string(i) + ".k";
    const double guess = structure.stiffness[i] * std::exp(0.1 * random.normal());
    made.problem.settings.unknowns.push_back(test::unknown(*model, name, guess, 0.3 * guess));
    made.truth.push_back(structure.stiffness[i]);
    if (i == structure.changing) made.changing = name;
  }
  made.problem.settings.threads = 1;
  made.problem.settings.second_thoughts = 2.0;
  return made;
}

}  // namespace kalfem::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "identification/chain_structure.hpp"
#include "kalfem/identification/record_residual.hpp"

/// The multi-stage loop on a structure that is simulated by other means than those of the library: a chain of twelve
/// masses in two regions on two cubic mounts over wheels, 15 % noise on seven accelerometers, none of which is on a
/// mount. Its motion comes from matrices that are assembled here and from the classical Runge-Kutta method.
namespace kalfem::test {

constexpr Eigen::Index loop_masses = 12;
constexpr double loop_stiffness = 3e4, loop_damping = 0.02, loop_rate = 500.0;            // [N/m], [-], [Hz]
constexpr double loop_k = 6e3, loop_k3 = 4e8, loop_c = 30.0;                              // of a mount
constexpr double loop_tyre = 2e4, loop_tyre_damping = 20.0, loop_wheel = 1.5, fine = 16;  // parts of a sample interval

inline Eigen::Vector3d loop_truth() { return {loop_stiffness, loop_stiffness, loop_damping}; }

inline StructurePtr loop_structure(double duration) {
  auto structure = std::make_shared<StructureData>();
  auto& parts = structure->parts;
  LumpedSubstructure body;
  body.name = "body";
  body.grounds = {};
  for (Eigen::Index i = 1; i <= loop_masses; ++i) {
    body.masses.push_back({std::to_string(i), 1.0});
    const auto below = std::to_string(i - 1), here = std::to_string(i);
    if (i > 1) body.springs.push_back({below + "-" + here, below, here, loop_stiffness});
  }
  body.modal_damping = {loop_damping};
  Eigen::VectorXd mount(4);
  mount << loop_k, loop_k3, loop_c, 0.0;
  for (const std::string side : {"1", "2"}) {
    LumpedSubstructure wheel;
    wheel.name = "wheel" + side;
    wheel.masses = {{"w", loop_wheel}};
    wheel.springs = {{"tyre", "ground", "w", loop_tyre, loop_tyre_damping}};
    parts.substructures.push_back(wheel);
    parts.connectors.push_back(
        {"mount" + side, wheel.name + ".w", side == "1" ? "body.1" : "body.12", make_law("cubic"), mount});
    parts.inputs.push_back({"road" + side, InputKind::base_displacement, wheel.name + ".ground"});
    structure->signals.push_back(make_random({.rms = 3e-3,
                                              .lower = 0.5,
                                              .upper = 40.0,
                                              .duration = duration,
                                              .fade_in = 0.5,
                                              .seed = side == "1" ? 8U : 9U,
                                              .name = "road" + side}));
  }
  parts.substructures.push_back(body);
  return structure;
}

/// Positions and velocities of the masses, then of the two wheels.
class LoopSimulator {
public:
  LoopSimulator(const StructurePtr& structure, double duration)
      : samples_(static_cast<Eigen::Index>(std::lround(duration * loop_rate)) + 1) {
    stiffness_ = Eigen::MatrixXd::Zero(loop_masses, loop_masses);
    for (Eigen::Index i = 0; i + 1 < loop_masses; ++i)
      stiffness_.block<2, 2>(i, i) += loop_stiffness * Eigen::Matrix2d{{1.0, -1.0}, {-1.0, 1.0}};
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(stiffness_);  // masses of 1 kg
    const Eigen::VectorXd omega = modes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    damping_ = modes.eigenvectors() * (2.0 * loop_damping * omega).asDiagonal() * modes.eigenvectors().transpose();
    const auto halves = static_cast<Eigen::Index>(2.0 * fine) * (samples_ - 1) + 1;
    for (const auto& signal : structure->signals)
      roads_.push_back(signal->sample(0.0, 0.5 / (fine * loop_rate), halves));
  }

  /// Accelerations of all masses at the samples.
  [[nodiscard]] Eigen::MatrixXd run() const {
    constexpr Eigen::Index n = loop_masses + 2;
    const double h = 1.0 / (fine * loop_rate);
    Eigen::VectorXd z = Eigen::VectorXd::Zero(n), v = z;
    Eigen::MatrixXd accelerations(loop_masses, samples_);
    const auto steps = static_cast<Eigen::Index>(fine);
    for (Eigen::Index k = 0;; ++k) {
      accelerations.col(k) = acceleration(z, v, 2 * k * steps).head(loop_masses);
      if (k + 1 == samples_) return accelerations;
      for (Eigen::Index s = 0; s < steps; ++s) {
        const Eigen::Index at = 2 * (k * steps + s);
        const Eigen::VectorXd a1 = acceleration(z, v, at), v2 = v + 0.5 * h * a1;
        const Eigen::VectorXd a2 = acceleration(z + 0.5 * h * v, v2, at + 1), v3 = v + 0.5 * h * a2;
        const Eigen::VectorXd a3 = acceleration(z + 0.5 * h * v2, v3, at + 1), v4 = v + h * a3;
        const Eigen::VectorXd a4 = acceleration(z + h * v3, v4, at + 2);
        z += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
      }
    }
  }

private:
  [[nodiscard]] Eigen::VectorXd acceleration(const Eigen::VectorXd& z, const Eigen::VectorXd& v,
                                             Eigen::Index at) const {
    Eigen::VectorXd a(loop_masses + 2);
    a.head(loop_masses) = -stiffness_ * z.head(loop_masses) - damping_ * v.head(loop_masses);
    for (Eigen::Index side = 0; side < 2; ++side) {
      const Eigen::Index foot = side == 0 ? 0 : loop_masses - 1, wheel = loop_masses + side;
      const double d = z[foot] - z[wheel];
      const double force = loop_k * d + loop_k3 * d * d * d + loop_c * (v[foot] - v[wheel]);
      const auto& road = roads_[static_cast<std::size_t>(side)];
      a[foot] -= force;
      a[wheel] =
          (force - loop_tyre * (z[wheel] - road(at, 0)) - loop_tyre_damping * (v[wheel] - road(at, 1))) / loop_wheel;
    }
    return a;
  }

  Eigen::Index samples_;
  Eigen::MatrixXd stiffness_, damping_;
  std::vector<SignalSamples> roads_;
};

/// The seven accelerometers and the mounts' six unknowns, 15 to 25 % off.
inline EstimationProblem loop_problem(double duration, double noise) {
  const auto structure = loop_structure(duration);
  EstimationProblem problem{.structure = structure, .sample_rate = loop_rate};
  for (const std::string mass : {"2", "3", "5", "7", "8", "10", "11"})
    problem.sensors.push_back(accelerometer("a" + mass, "body." + mass, noise));
  for (const std::string mount : {"mount1", "mount2"}) {
    problem.settings.unknowns.push_back(unknown(*structure, mount + ".k", 0.85 * loop_k, 0.3 * loop_k));
    problem.settings.unknowns.push_back(unknown(*structure, mount + ".k3", 1.25 * loop_k3, 0.4 * loop_k3));
    problem.settings.unknowns.push_back(unknown(*structure, mount + ".c", 0.8 * loop_c, 0.3 * loop_c));
  }
  problem.settings.threads = 1;
  problem.settings.substeps = 4;
  problem.settings.settle = 1.0;
  return problem;
}

/// Stiffness of either half of the chain, and the damping of its modes.
inline UpdatingSetup loop_setup(const StructureData& structure) {
  UpdatingSetup setup;
  setup.parameters = {{.name = "left", .unit = "N/m", .initial = 0.97 * loop_stiffness, .lower = 0.0},
                      {.name = "right", .unit = "N/m", .initial = 1.02 * loop_stiffness, .lower = 0.0},
                      {.name = "damping", .unit = "-", .initial = 1.2 * loop_damping, .lower = 0.0}};
  for (Eigen::Index i = 2; i <= loop_masses; ++i)
    setup.bindings.push_back({i <= 7 ? 0 : 1, parameter(structure, "body." + std::to_string(i - 1) + "-" +
                                                                       std::to_string(i) + ".stiffness")});
  setup.bindings.push_back({2, parameter(structure, "body.damping.modal")});
  setup.true_parameters = {loop_stiffness, loop_stiffness, loop_damping};
  return setup;
}

/// What the sensors record of these accelerations, with noise of this seed.
inline Record loop_record(const EstimationProblem& problem, const Eigen::MatrixXd& accelerations, std::uint64_t seed) {
  Record record;
  record.sample_rate = loop_rate;
  record.values.resize(std::ssize(problem.sensors), accelerations.cols());
  for (std::size_t i = 0; i < problem.sensors.size(); ++i) {
    const Sensor& sensor = problem.sensors[i];
    auto channel = record.values.row(static_cast<Eigen::Index>(i));
    channel = accelerations.row(std::stoi(sensor.name.substr(1)) - 1);
    const double noise = sensor.deviation(rms(channel.transpose()));
    record.channels.push_back({sensor.name, sensor.unit, noise});
    RandomStream random(seed, sensor.name);
    for (double& sample : channel) sample += noise * random.normal();
  }
  return record;
}

/// The comparison of the chain, driven by the estimated motion of its feet, with all seven.
inline RecordResidual loop_residual(const EstimationProblemPtr& problem, Record record) {
  const auto setup = loop_setup(*problem->structure);
  std::vector<std::string> names;
  for (const auto& sensor : problem->sensors) names.push_back(sensor.name);
  return {problem,
          std::move(record),
          std::make_shared<const ParameterisedStructure>(problem->structure, setup.bindings, 3),
          setup,
          {.name = "record", .substructure = "body", .sensors = names}};
}

}  // namespace kalfem::test

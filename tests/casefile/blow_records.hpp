// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "base/scratch_folder.hpp"
#include "kalfem/base/random.hpp"

/// Chains of masses under hammer blows or a white force, by the exact response of their modes: an integrator of the
/// tests' own.
namespace kalfem::test {

struct BlowChain {
  Eigen::VectorXd masses, stiffnesses;  ///< spring i from mass i - 1 (the ground for the first) to mass i
  double ratio = 0.01;                  ///< of every mode
  Eigen::Index struck = 0;              ///< mass that the force acts on
};

struct BlowTest {
  enum class Force { blows, white } force = Force::blows;
  int blows = 10;
  double duration = 60.0, rate = 256.0;
  int finer = 8;          ///< steps of the integration a sample
  double noise = 0.02;    ///< of each output's rms
  double rest = 0.5;      ///< before the first blow can come [s]
  double pulse = 0.02;    ///< duration of a blow, a sine squared [s]
  int derivative = 2;     ///< of the displacement that is measured
  bool from_rest = true;  ///< false: the record starts a third into a longer one
};

struct BlowRecord {
  double rate = 1.0;
  Eigen::VectorXd force;
  Eigen::MatrixXd outputs;  ///< samples x masses
};

inline Eigen::MatrixXd stiffness_of(const BlowChain& chain) {
  const Eigen::Index n = chain.masses.size();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    matrix(i, i) += chain.stiffnesses[i];
    if (i == 0) continue;
    matrix(i - 1, i - 1) += chain.stiffnesses[i];
    matrix(i, i - 1) -= chain.stiffnesses[i];
    matrix(i - 1, i) -= chain.stiffnesses[i];
  }
  return matrix;
}

/// Natural frequencies [rad/s], ascending.
inline Eigen::VectorXd frequencies_of(const BlowChain& chain) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(stiffness_of(chain),
                                                                        Eigen::MatrixXd(chain.masses.asDiagonal()));
  return modes.eigenvalues().cwiseSqrt();
}

/// The force at the fine steps. White: noise with an upper limit of a fifth of the sampling rate, by a running mean
/// that is applied four times.
inline Eigen::VectorXd fine_force(const BlowTest& test, Eigen::Index steps, RandomStream& random) {
  const double fine = test.rate * test.finer;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(steps);
  if (test.force == BlowTest::Force::white) {
    for (double& value : force) value = random.normal();
    const Eigen::Index width = 2 * test.finer;
    for (int pass = 0; pass < 4; ++pass) {
      Eigen::VectorXd mean = Eigen::VectorXd::Zero(steps);
      double sum = 0.0;
      for (Eigen::Index k = 0; k < steps; ++k) {
        sum += force[k] - (k >= width ? force[k - width] : 0.0);
        mean[k] = sum / static_cast<double>(width);
      }
      force = mean;
    }
    return 100.0 * force;
  }
  for (int blow = 0; blow < test.blows; ++blow) {
    const double at = test.rest + (static_cast<double>(steps) / fine - test.rest - 1.0) * random.uniform();
    const double peak = 150.0 + 100.0 * random.uniform();
    for (auto k = static_cast<Eigen::Index>(std::ceil(at * fine)); k < steps; ++k) {
      const double since = static_cast<double>(k) / fine - at;
      if (since > test.pulse) break;
      force[k] += peak * std::pow(std::sin(std::numbers::pi * since / test.pulse), 2);
    }
  }
  return force;
}

// Each mode x'' + 2 zeta w x' + w^2 x = p(t) from rest, with p linear between fine steps, is advanced exactly: about
// the particular solution a + b t the motion is free.
inline BlowRecord record_of(const BlowChain& chain, const BlowTest& test, std::uint64_t seed) {
  RandomStream random(seed, "force"), noise(seed, "noise");
  const double step = 1.0 / (test.rate * test.finer);
  const auto samples = static_cast<Eigen::Index>(std::llround(test.duration * test.rate));
  const Eigen::Index skipped = test.from_rest ? 0 : samples / 2;
  const Eigen::Index steps = (samples + skipped) * test.finer;
  const Eigen::VectorXd force = fine_force(test, steps, random);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(stiffness_of(chain),
                                                                        Eigen::MatrixXd(chain.masses.asDiagonal()));
  BlowRecord record{test.rate, Eigen::VectorXd(samples), Eigen::MatrixXd::Zero(samples, chain.masses.size())};
  for (Eigen::Index k = 0; k < samples; ++k) record.force[k] = force[(skipped + k) * test.finer];
  for (Eigen::Index r = 0; r < chain.masses.size(); ++r) {
    const double w = std::sqrt(modes.eigenvalues()[r]), decay = chain.ratio * w,
                 damped = std::sqrt(w * w - decay * decay);
    const double e = std::exp(-decay * step), c = std::cos(damped * step), s = std::sin(damped * step);
    const Eigen::VectorXd shape = modes.eigenvectors().col(r);
    double x = 0.0, v = 0.0;
    for (Eigen::Index k = 0; k + 1 < steps; ++k) {
      const double p = shape[chain.struck] * force[k], slope = shape[chain.struck] * (force[k + 1] - force[k]) / step;
      if (k % test.finer == 0 && k / test.finer >= skipped) {
        const double a = p - 2.0 * decay * v - w * w * x;
        record.outputs.row(k / test.finer - skipped) += (test.derivative == 2   ? a
                                                         : test.derivative == 1 ? v
                                                                                : x) *
                                                        shape.transpose();
      }
      const double b = slope / (w * w), start = p / (w * w) - 2.0 * decay * b / (w * w);
      const double x0 = x - start, v0 = v - b;
      x = e * (x0 * c + (v0 + decay * x0) / damped * s) + start + b * step;
      v = e * (v0 * c - (decay * v0 + w * w * x0) / damped * s) + b;
    }
  }
  for (Eigen::Index j = 0; j < record.outputs.cols(); ++j) {
    const double level = test.noise * std::sqrt(record.outputs.col(j).squaredNorm() / static_cast<double>(samples));
    for (Eigen::Index k = 0; k < samples; ++k) record.outputs(k, j) += level * noise.normal();
  }
  return record;
}

/// Writes t, F, and the outputs 1, 2 ... of the masses.
inline void write_csv(const std::filesystem::path& file, const BlowRecord& record) {
  std::ofstream out(file);
  out.precision(9);
  out << "t [s],F [N]";
  for (Eigen::Index j = 0; j < record.outputs.cols(); ++j) out << "," << j + 1;
  for (Eigen::Index k = 0; k < record.force.size(); ++k) {
    out << "\n" << static_cast<double>(k) / record.rate << "," << record.force[k];
    for (Eigen::Index j = 0; j < record.outputs.cols(); ++j) out << "," << record.outputs(k, j);
  }
  out << "\n";
}

/// A case that updates every stiffness and the damping from these records, with first values `wrong` times the truth
/// and `more` keys of the comparison.
inline std::string blow_case(const BlowChain& chain, const std::vector<std::string>& files,
                             const std::vector<double>& wrong, const std::string& more) {
  std::ostringstream text;
  text.precision(12);
  const Eigen::Index n = chain.masses.size();
  text << "kalfem: 1\nsubstructures:\n  s:\n    masses: {";
  for (Eigen::Index i = 0; i < n; ++i) text << (i ? ", " : "") << i + 1 << ": " << chain.masses[i] << " kg";
  text << "}\n    springs:\n";
  for (Eigen::Index i = 0; i < n; ++i)
    text << "      - {name: k" << i + 1 << ", from: " << (i == 0 ? "ground" : std::to_string(i)) << ", to: " << i + 1
         << ", stiffness: " << chain.stiffnesses[i] * wrong[static_cast<std::size_t>(i)] << " N/m}\n";
  text << "    damping: {modal: 1 %}\nupdate:\n  parameters:\n";
  for (Eigen::Index i = 0; i < n; ++i) text << "    s.k" << i + 1 << ".stiffness: {bounds: [5 kN/m, 500 kN/m]}\n";
  text << "    s.damping.modal: {bounds: [0.01 %, 20 %]}\n  compare:\n    frfs:\n      frf: s\n      inputs:\n";
  for (const auto& file : files)
    text << "        - {force: " << chain.struck + 1 << ", record: '" << file << "', input: F}\n";
  text << "      outputs: [";
  for (Eigen::Index i = 0; i < n; ++i) text << (i ? ", " : "") << i + 1;
  const Eigen::VectorXd hertz = frequencies_of(chain) / (2.0 * std::numbers::pi);
  text << "]\n      bands: [[" << 0.5 * hertz[0] << " Hz, " << 1.3 * hertz[n - 1] << " Hz]]\n" << more;
  return text.str();
}

}  // namespace kalfem::test

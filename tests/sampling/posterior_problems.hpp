// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>

#include "evidence_cases.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/sampling/evidence.hpp"

// Posteriors of two parameters with one or two modes, drawn at random, whose weights and evidence quadrature tells.

namespace kalfem {

struct PosteriorProblem {
  std::string name;
  Posterior posterior;
  std::function<bool(const Eigen::VectorXd& theta)> first_side;  ///< of two modes, which one
};

/// Natural frequencies [Hz] of two masses.
inline Eigen::Vector2d frequencies(const Eigen::Matrix2d& stiffness, double m1, double m2) {
  const double a = stiffness(0, 0) / m1, b = stiffness(1, 1) / m2;
  const double coupling = stiffness(0, 1) * stiffness(0, 1) / (m1 * m2);
  const double middle = 0.5 * (a + b), half = std::sqrt(0.25 * (a - b) * (a - b) + coupling);
  return Eigen::Vector2d(std::max(0.0, middle - half), middle + half).cwiseSqrt() / (2.0 * std::numbers::pi);
}

/// A prior about `centre` of one of three kinds.
inline MarginalPrior random_prior(double centre, RandomStream& random) {
  const double spread = 0.3 + 0.5 * random.uniform(), kind = random.uniform();
  const double at = centre * std::exp(0.5 * (random.uniform() - 0.5));
  if (kind < 0.4) return LogNormalPrior{at, spread};
  if (kind < 0.7) return NormalPrior{at, spread * at, 0.02 * centre};
  return UniformPrior{0.1 * at, (2.0 + 2.0 * random.uniform()) * at};
}

/// Two masses in series on the ground, and their two frequencies: k1, k2 and (1 + m1/m2) k2, k1 / (1 + m1/m2) fit
/// alike.
inline PosteriorProblem series_problem(RandomStream& random) {
  const double m1 = 5.0 + 10.0 * random.uniform(), m2 = 5.0 + 10.0 * random.uniform(), c = 1.0 + m1 / m2;
  const double k1 = 3e4 * (1.0 + random.uniform()), k2 = 3e4 * (1.0 + random.uniform()) / c * 0.4;
  const auto model = [=](const Eigen::VectorXd& k) {
    return frequencies((Eigen::Matrix2d() << k[0] + k[1], -k[1], -k[1], k[1]).finished(), m1, m2);
  };
  const Eigen::Vector2d measured = model(Eigen::Vector2d(k1, k2));
  const double deviation = 0.01 + 0.02 * random.uniform();
  const double middle1 = 0.5 * (k1 + c * k2), middle2 = 0.5 * (k2 + k1 / c);
  return {"two masses in series",
          {JointPrior({{"k1", random_prior(middle1, random)}, {"k2", random_prior(middle2, random)}}),
           [=](const Eigen::VectorXd& k) {
             const Eigen::Vector2d f = model(k);
             return log_normal(f[0], measured[0], deviation * measured[0]) +
                    log_normal(f[1], measured[1], deviation * measured[1]);
           }},
          [=](const Eigen::VectorXd& k) { return k[0] > c * k[1]; }};
}

/// Two equal masses between two walls with a known spring between them: the springs at the walls can change places.
inline PosteriorProblem symmetric_problem(RandomStream& random) {
  const double m = 5.0 + 10.0 * random.uniform(), middle = 1e4 * (1.0 + random.uniform());
  const double k1 = 2e4 * (1.0 + random.uniform()), k3 = k1 * (1.6 + random.uniform());
  const auto model = [=](const Eigen::VectorXd& k) {
    return frequencies((Eigen::Matrix2d() << k[0] + middle, -middle, -middle, k[1] + middle).finished(), m, m);
  };
  const Eigen::Vector2d measured = model(Eigen::Vector2d(k1, k3));
  const double deviation = 0.01 + 0.02 * random.uniform(), centre = std::sqrt(k1 * k3);
  return {"symmetric structure",
          {JointPrior({{"k1", random_prior(centre, random)}, {"k3", random_prior(centre, random)}}),
           [=](const Eigen::VectorXd& k) {
             const Eigen::Vector2d f = model(k);
             return log_normal(f[0], measured[0], deviation * measured[0]) +
                    log_normal(f[1], measured[1], deviation * measured[1]);
           }},
          [](const Eigen::VectorXd& k) { return k[0] > k[1]; }};
}

/// An eccentricity of which only the square is seen, and a stiffness.
inline PosteriorProblem sign_problem(RandomStream& random) {
  const double e = 0.5 + 0.5 * random.uniform(), k = 1.0 + random.uniform(), deviation = 0.03 + 0.05 * random.uniform();
  const double shift = 1.2 * (random.uniform() - 0.5), spread = 0.5 + 0.5 * random.uniform();
  return {"sign of an eccentricity",
          {JointPrior({{"e", NormalPrior{shift, spread}}, {"k", random_prior(k, random)}}),
           [=](const Eigen::VectorXd& x) {
             return log_normal(x[1] / (1.0 + x[0] * x[0]), k / (1.0 + e * e), deviation) +
                    log_normal(x[1], k, deviation * k);
           }},
          [](const Eigen::VectorXd& x) { return x[0] > 0.0; }};
}

inline PosteriorProblem two_mode_problem(RandomStream& random) {
  const double kind = random.uniform();
  if (kind < 0.4) return series_problem(random);
  return kind < 0.7 ? symmetric_problem(random) : sign_problem(random);
}

/// Two frequencies and the shape of the first mode, or a normal likelihood across correlated parameters.
inline PosteriorProblem one_mode_problem(RandomStream& random) {
  if (random.uniform() < 0.5) {
    const double m1 = 5.0 + 10.0 * random.uniform(), m2 = 5.0 + 10.0 * random.uniform();
    const Eigen::Vector2d k(3e4 * (1.0 + random.uniform()), 2e4 * (1.0 + random.uniform()));
    const FirstMode mode = first_mode(k, m1, m2);
    const double deviation = 0.01 + 0.05 * random.uniform();
    return {"frequency and shape",
            {JointPrior({{"k1", random_prior(k[0], random)}, {"k2", random_prior(k[1], random)}}),
             [=](const Eigen::VectorXd& x) {
               const FirstMode at = first_mode(x, m1, m2);
               return log_normal(at.eigenvalue, mode.eigenvalue, deviation * mode.eigenvalue) +
                      log_normal(at.ratio, mode.ratio, deviation * mode.ratio);
             }},
            {}};
  }
  const double correlation = 1.8 * (random.uniform() - 0.5), width = 0.03 + 0.3 * random.uniform();
  const Eigen::Vector2d at(random.normal(), random.normal());
  return {"correlated",
          {JointPrior({{"a", NormalPrior{0.0, 1.0}}, {"b", NormalPrior{0.0, 1.0}}}),
           [=](const Eigen::VectorXd& x) {
             const Eigen::Vector2d d = x - at;
             return -0.5 * (d[0] * d[0] - 2.0 * correlation * d[0] * d[1] + d[1] * d[1]) /
                    ((1.0 - correlation * correlation) * width * width);
           }},
          {}};
}

struct Quadrature {
  double log_evidence = 0.0;
  double first_weight = 1.0;  ///< of the first side
};

/// By the rectangle rule over the standard normals of the prior, where the tails end before the grid does.
inline Quadrature quadrature(const PosteriorProblem& problem) {
  constexpr int points = 401;
  constexpr double reach = 6.0, step = 2.0 * reach / (points - 1);
  Eigen::VectorXd all(points * points), first = Eigen::VectorXd::Constant(points * points, -1e300);
  for (int i = 0; i < points; ++i)
    for (int j = 0; j < points; ++j) {
      const Eigen::Vector2d z(-reach + i * step, -reach + j * step);
      const Eigen::Index k = i * points + j;
      all[k] = problem.posterior.log_likelihood_of(z) - 0.5 * z.squaredNorm();
      if (problem.first_side && problem.first_side(problem.posterior.prior.from_standard_normal(z))) first[k] = all[k];
    }
  const double total = log_sum_exp(all);
  return {total + 2.0 * std::log(step) - std::log(2.0 * std::numbers::pi), std::exp(log_sum_exp(first) - total)};
}

}  // namespace kalfem

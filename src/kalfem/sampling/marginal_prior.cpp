// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/marginal_prior.hpp"

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "kalfem/base/units.hpp"

// A truncated marginal is handled by both of its tails. With p = Phi(w), q = Phi(-w) and the bounds a, b of the parent
// normal, the value x of the normal score w has
//     Phi(x) = q Phi(a) + p Phi(b),   Phi(-x) = q Phi(-a) + p Phi(-b),
// sums of positive terms without cancellation; the smaller one is inverted.

namespace kalfem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double farthest = 37.0;  // Phi(-37) = 6e-300
constexpr double least_mass = 1e-250;

double tail(double x) { return 0.5 * std::erfc(x / std::numbers::sqrt2); }  ///< Phi(-x)

/// x with Phi(x) = lower, Phi(-x) = upper.
double from_tails(double lower, double upper) {
  const double smaller = std::min(lower, upper);
  if (!(smaller > 0.0)) return lower < upper ? -farthest : farthest;
  const double x = std::numbers::sqrt2 * boost::math::erfc_inv(2.0 * std::min(smaller, 0.5));
  return std::clamp(lower < upper ? -x : x, -farthest, farthest);
}

double log_standard_density(double x) { return -0.5 * x * x - 0.5 * std::log(2.0 * std::numbers::pi); }

/// The standard normal between a and b.
struct StandardRange {
  double a = -infinity, b = infinity;

  [[nodiscard]] bool whole() const { return a == -infinity && b == infinity; }
  [[nodiscard]] double mass() const {
    const double width = b - a;
    const double middle = 0.5 * (a + b);
    if (width * std::max(1.0, std::abs(middle)) < 1e-3)  // where the difference of the tails would cancel
      return width * std::exp(log_standard_density(middle)) * (1.0 + (middle * middle - 1.0) * width * width / 24.0);
    return a > 0.0 ? tail(a) - tail(b) : tail(-b) - tail(-a);
  }
  [[nodiscard]] double from_normal(double w) const {
    if (whole()) return w;
    const double p = tail(-w), q = tail(w);
    return std::clamp(from_tails(q * tail(-a) + p * tail(-b), q * tail(a) + p * tail(b)), a, b);
  }
  [[nodiscard]] double to_normal(double x) const {
    if (whole()) return std::clamp(x, -farthest, farthest);
    if (x <= a || x >= b) return x <= a ? -farthest : farthest;
    const double below = StandardRange{a, x}.mass(), above = StandardRange{x, b}.mass();
    return from_tails(below / (below + above), above / (below + above));
  }
};

StandardRange range_of(const NormalPrior& prior) {
  return {(prior.lower - prior.mean) / prior.deviation, (prior.upper - prior.mean) / prior.deviation};
}

StandardRange range_of(const LogNormalPrior& prior) {
  const auto score = [&](double x) { return x > 0.0 ? std::log(x / prior.median) / prior.log_deviation : -infinity; };
  return {score(prior.lower), score(prior.upper)};
}

struct Density {
  double x;
  double operator()(const NormalPrior& prior) const {
    const double score = (x - prior.mean) / prior.deviation;
    return log_standard_density(score) - std::log(prior.deviation) - std::log(range_of(prior).mass());
  }
  double operator()(const LogNormalPrior& prior) const {
    if (x <= 0.0) return -infinity;
    const double score = std::log(x / prior.median) / prior.log_deviation;
    return log_standard_density(score) - std::log(prior.log_deviation * x) - std::log(range_of(prior).mass());
  }
  double operator()(const UniformPrior& prior) const { return -std::log(prior.upper - prior.lower); }
};

struct FromNormal {
  double w;
  double operator()(const NormalPrior& prior) const {
    return std::clamp(prior.mean + prior.deviation * range_of(prior).from_normal(w), prior.lower, prior.upper);
  }
  double operator()(const LogNormalPrior& prior) const {
    const double x = prior.median * std::exp(prior.log_deviation * range_of(prior).from_normal(w));
    return std::clamp(x, prior.lower, prior.upper);
  }
  double operator()(const UniformPrior& prior) const {
    const double width = prior.upper - prior.lower;
    return w < 0.0 ? prior.lower + width * tail(-w) : prior.upper - width * tail(w);
  }
};

struct ToNormal {
  double x;
  double operator()(const NormalPrior& prior) const {
    return range_of(prior).to_normal((x - prior.mean) / prior.deviation);
  }
  double operator()(const LogNormalPrior& prior) const {
    if (x <= 0.0) return -farthest;
    return range_of(prior).to_normal(std::log(x / prior.median) / prior.log_deviation);
  }
  double operator()(const UniformPrior& prior) const {
    const double width = prior.upper - prior.lower;
    return from_tails((x - prior.lower) / width, (prior.upper - x) / width);
  }
};

/// E[g(x)] over the normal score by the trapezoidal rule, which converges exponentially for such integrands.
template <class Function>
double expectation(const MarginalPrior& marginal, const Function& g) {
  constexpr double step = 1.0 / 32.0;
  double sum = 0.0;
  for (double w = -30.0; w <= 30.0; w += step) sum += g(from_normal(marginal, w)) * std::exp(log_standard_density(w));
  return sum * step;
}

bool untruncated(const MarginalPrior& marginal) {
  if (const auto* normal = std::get_if<NormalPrior>(&marginal)) return range_of(*normal).whole();
  if (const auto* log_normal = std::get_if<LogNormalPrior>(&marginal)) return range_of(*log_normal).whole();
  return true;
}

class MarginalCheck {
public:
  MarginalCheck(std::string name, IssueList& issues) : name_(std::move(name)), issues_(issues) {}

  void operator()(const NormalPrior& prior) const {
    bool right = positive("deviation", prior.deviation);
    if (!std::isfinite(prior.mean)) right = add("mean " + text(prior.mean), "it must be finite", "give a number");
    if (ordered(prior.lower, prior.upper) && right) holds_mass(range_of(prior), prior.lower, prior.upper);
  }
  void operator()(const LogNormalPrior& prior) const {
    const bool median = positive("median", prior.median),
               right = positive("log deviation", prior.log_deviation) && median;
    if (prior.lower < 0.0)
      add("lower bound " + text(prior.lower), "a log-normal parameter is positive", "use a lower bound of 0 or above");
    else if (ordered(prior.lower, prior.upper) && right)
      holds_mass(range_of(prior), prior.lower, prior.upper);
  }
  void operator()(const UniformPrior& prior) const {
    if (!ordered(prior.lower, prior.upper)) return;
    if (!std::isfinite(prior.upper - prior.lower))
      add("uniform over [" + text(prior.lower) + ", " + text(prior.upper) + "] is improper",
          "without a finite integral there is no evidence and nothing to sample from",
          "give finite bounds, or a normal or log-normal prior");
  }

private:
  static std::string text(double value) { return shortest(value); }

  bool add(const std::string& what, std::string why, std::string fix) const {
    issues_.add({}, "prior of " + name_ + ": " + what, std::move(why), std::move(fix));
    return false;
  }
  [[nodiscard]] bool positive(const std::string& key, double value) const {
    if (value > 0.0 && std::isfinite(value)) return true;
    return add(key + " " + text(value), "it must be > 0 and finite",
               "give a positive number; to hold a parameter fixed, remove it from the unknowns");
  }
  [[nodiscard]] bool ordered(double lower, double upper) const {
    if (lower < upper) return true;
    return add("bounds [" + text(lower) + ", " + text(upper) + "]", "the lower one must be less than the upper one",
               "exchange or widen them");
  }
  void holds_mass(const StandardRange& range, double lower, double upper) const {
    if (range.mass() > least_mass) return;
    add("no probability between the bounds " + text(lower) + " and " + text(upper),
        "they are more than 30 deviations away from the centre", "move the bounds or widen the prior");
  }

  std::string name_;
  IssueList& issues_;
};

}  // namespace

Support support(const MarginalPrior& marginal) {
  return std::visit([](const auto& prior) { return Support{prior.lower, prior.upper}; }, marginal);
}

double log_density(const MarginalPrior& marginal, double x) {
  const auto [lower, upper] = support(marginal);
  if (!(x >= lower && x <= upper)) return -infinity;
  return std::visit(Density{x}, marginal);
}

double from_normal(const MarginalPrior& marginal, double w) { return std::visit(FromNormal{w}, marginal); }

double to_normal(const MarginalPrior& marginal, double x) { return std::visit(ToNormal{x}, marginal); }

double mean(const MarginalPrior& marginal) {
  if (const auto* uniform = std::get_if<UniformPrior>(&marginal)) return 0.5 * (uniform->lower + uniform->upper);
  if (!untruncated(marginal)) return expectation(marginal, [](double x) { return x; });
  if (const auto* normal = std::get_if<NormalPrior>(&marginal)) return normal->mean;
  const auto& prior = std::get<LogNormalPrior>(marginal);
  return prior.median * std::exp(0.5 * prior.log_deviation * prior.log_deviation);
}

double deviation(const MarginalPrior& marginal) {
  if (const auto* uniform = std::get_if<UniformPrior>(&marginal))
    return (uniform->upper - uniform->lower) / std::sqrt(12.0);
  if (!untruncated(marginal)) {
    const double centre = mean(marginal);
    return std::sqrt(expectation(marginal, [=](double x) { return (x - centre) * (x - centre); }));
  }
  if (const auto* normal = std::get_if<NormalPrior>(&marginal)) return normal->deviation;
  const auto& prior = std::get<LogNormalPrior>(marginal);
  return mean(marginal) * std::sqrt(std::expm1(prior.log_deviation * prior.log_deviation));
}

void check(const std::string& name, const MarginalPrior& marginal, IssueList& issues) {
  std::visit(MarginalCheck(name, issues), marginal);
}

}  // namespace kalfem

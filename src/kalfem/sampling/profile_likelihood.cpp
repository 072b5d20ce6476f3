// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/profile_likelihood.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/parallel.hpp"
#include "kalfem/sampling/laplace.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double fall = 1.92;  ///< half of 3.84

Support about(const MarginalPrior& marginal, double centre, double reach) {
  const auto [lower, upper] = support(marginal);
  return {std::max(lower, centre - reach), std::min(upper, centre + reach)};
}

VectorXd with(const VectorXd& others, Index parameter, double value) {
  VectorXd theta(others.size() + 1);
  theta << others.head(parameter), value, others.tail(others.size() - parameter);
  return theta;
}

VectorXd without(const VectorXd& theta, Index parameter) {
  VectorXd others(theta.size() - 1);
  others << theta.head(parameter), theta.tail(others.size() - parameter);
  return others;
}

/// The likelihood of the others with the same density everywhere in their ranges.
Posterior of_others(const Posterior& posterior, Index parameter, double value, const VectorXd& centre,
                    const VectorXd& reach) {
  Named<MarginalPrior> ranges;
  for (Index j = 0; j < centre.size(); ++j) {
    if (j == parameter) continue;
    const auto& [name, marginal] = posterior.prior.marginals()[static_cast<std::size_t>(j)];
    const auto [lower, upper] = about(marginal, centre[j], reach[j]);
    ranges.emplace_back(name, UniformPrior{lower, upper});
  }
  return {JointPrior(std::move(ranges)), [&posterior, parameter, value](const VectorXd& others) {
            return posterior.log_likelihood_at(with(others, parameter, value));
          }};
}

/// Where the profile crosses -1.92 between the peak and the end of the values in that direction.
std::optional<double> crossing(const Profile& profile, Index peak, Index direction) {
  for (Index k = peak; k + direction >= 0 && k + direction < profile.values.size(); k += direction) {
    const double here = profile.log_likelihood[k] + fall, next = profile.log_likelihood[k + direction] + fall;
    if (next > 0.0) continue;
    if (!std::isfinite(next)) return profile.values[k];
    return profile.values[k] + (profile.values[k + direction] - profile.values[k]) * here / (here - next);
  }
  return std::nullopt;
}

}  // namespace

Profile profile_likelihood(const Posterior& posterior, Index parameter, const VectorXd& centre,
                           const VectorXd& deviation, const ProfileOptions& options) {
  const auto& marginal = posterior.prior.marginals()[static_cast<std::size_t>(parameter)].second;
  const auto [lower, upper] = about(marginal, centre[parameter], options.reach * deviation[parameter]);
  Profile profile{VectorXd::LinSpaced(options.points, lower, upper), VectorXd(options.points), {}, {}};
  for_each_index(static_cast<std::size_t>(options.points), options.threads, [&](std::size_t k) {
    const auto at = static_cast<Index>(k);
    if (centre.size() == 1) {
      profile.log_likelihood[at] = posterior.log_likelihood_at(profile.values.segment<1>(at));
      return;
    }
    const Posterior others =
        of_others(posterior, parameter, profile.values[at], centre, 2.0 * options.reach * deviation);
    try {
      profile.log_likelihood[at] =
          laplace_approximation(others, {.decrement = 1e-4, .start = without(centre, parameter)}).log_likelihood;
    } catch (const InvalidInput&) {  // no value of the others has a likelihood
      profile.log_likelihood[at] = -std::numeric_limits<double>::infinity();
    }
  });
  Index peak = 0;
  const double largest = profile.log_likelihood.maxCoeff(&peak);
  if (!std::isfinite(largest)) return profile;
  profile.log_likelihood.array() -= largest;
  profile.lower = crossing(profile, peak, -1);
  profile.upper = crossing(profile, peak, 1);
  return profile;
}

}  // namespace kalfem

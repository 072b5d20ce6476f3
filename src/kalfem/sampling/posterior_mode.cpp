// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/posterior_mode.hpp"

#include <algorithm>
#include <functional>

namespace kalfem {

using Eigen::ArrayXd;

namespace {

bool is_apart(const PosteriorMode& one, const PosteriorMode& other) {
  constexpr double far = 2.0;  // two normal densities nearer than this have one maximum between them
  const ArrayXd deviation = one.deviation.cwiseMax(other.deviation);
  return ((one.mean - other.mean).array().abs() > far * deviation).any();
}

/// By the law of total variance.
void absorb(PosteriorMode& heavier, const PosteriorMode& other) {
  const double weight = heavier.weight + other.weight, share = other.weight / weight;
  const Eigen::VectorXd moved = other.mean - heavier.mean;
  const ArrayXd variance = (1.0 - share) * heavier.deviation.array().square() +
                           share * other.deviation.array().square() + share * (1.0 - share) * moved.array().square();
  heavier.mean += share * moved;
  heavier.deviation = variance.sqrt();
  heavier.weight = weight;
}

}  // namespace

std::vector<PosteriorMode> told_apart(std::vector<PosteriorMode> modes) {
  std::ranges::stable_sort(modes, std::greater(), &PosteriorMode::weight);
  std::vector<PosteriorMode> apart;
  for (const auto& mode : modes) {
    const auto same = std::ranges::find_if(apart, [&](const auto& each) { return !is_apart(each, mode); });
    if (same == apart.end())
      apart.push_back(mode);
    else
      absorb(*same, mode);
  }
  std::ranges::stable_sort(apart, std::greater(), &PosteriorMode::weight);
  return apart;
}

}  // namespace kalfem

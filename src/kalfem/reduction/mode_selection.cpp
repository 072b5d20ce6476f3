// SPDX-License-Identifier: Apache-2.0
#include "kalfem/reduction/mode_selection.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <utility>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index first_guess = 24;

double angular_squared(double frequency) { return std::pow(2.0 * std::numbers::pi * frequency, 2); }

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

void check(const ModeSelection& selection) {
  IssueList issues;
  if (!selection.count && !selection.cutoff && !selection.effective_mass)
    issues.add({}, "the number of fixed-interface modes is not given",
               "Craig-Bampton needs a number of modes, a frequency or a fraction of the mass", "give one of them");
  if (selection.count && *selection.count < 0)
    issues.add({}, "the reduction keeps " + std::to_string(*selection.count) + " modes",
               "the number must not be negative");
  if (selection.cutoff && !(*selection.cutoff >= 0.0 && std::isfinite(*selection.cutoff)))
    issues.add({}, "the reduction keeps modes up to " + number(*selection.cutoff) + " Hz",
               "the frequency must be finite and not negative");
  if (selection.effective_mass && !(*selection.effective_mass > 0.0 && *selection.effective_mass < 1.0))
    issues.add({}, "the reduction keeps modes for " + number(*selection.effective_mass) + " of the mass",
               "the fraction must be between 0 and 1");
  issues.raise();
}

/// The fewest leading modes that take this part of the mass in every direction; one more than there are when all of
/// them do not reach it.
Index modes_for_mass(const MatrixXd& mass_weighted_modes, const VectorXd& masses, const MatrixXd& shapes, double part) {
  VectorXd missing = part * masses;
  Index kept = 0;
  while (kept <= shapes.cols() && (missing.array() > 0.0).any()) {
    if (kept < shapes.cols()) missing -= (mass_weighted_modes.transpose() * shapes.col(kept)).cwiseAbs2();
    ++kept;
  }
  return kept;
}

// The number of fixed-interface modes that a request needs is not known before they are computed:
//   1. up to a frequency: the eigensolver itself stops there.
//   2. by number: as many as asked, at most one a degree of freedom with mass.
//   3. by effective mass: of the interior following a unit translation r, mode i takes (phi_i^T M r)^2 of the mass
//      r^T M r. Modes are computed in numbers that double until the part that is asked for is reached in each
//      direction.
//   4. rigid-body modes of a free interior are always among the kept ones.
// The largest number counts. One mode more than kept is known where there is one: the first frequency left out.
/// Computes modes in growing numbers, until what is wanted is among them or there are no more.
class Search {
public:
  Search(const Partition& parts, const StiffnessFactor& factored)
      : parts_(parts), factored_(factored), available_((parts.mass_ii.diagonal().array() > 0.0).count()) {}

  void up_to_count(Index count) { extend({.count = std::min(count, available_)}); }
  void up_to_frequency(double frequency) { extend({.below = angular_squared(frequency)}); }

  void up_to_rigid_modes() {
    if (factored_.regular()) return;
    for (Index count = 8; modes.values.size() == rigid() && (modes.next || count == 8); count *= 2) up_to_count(count);
  }

  Index up_to_mass(const MatrixXd& following, double part) {
    const MatrixXd mass_weighted_modes = parts_.mass_ii * following;
    const VectorXd masses = following.cwiseProduct(mass_weighted_modes).colwise().sum();
    for (Index count = first_guess;; count *= 2) {
      up_to_count(count);
      const Index needed = modes_for_mass(mass_weighted_modes, masses, modes.vectors, part);
      if (needed <= modes.values.size() || !modes.next) return std::min(needed, modes.values.size());
    }
  }

  [[nodiscard]] Index rigid() const { return (modes.values.array() == 0.0).count(); }

  LowestModes modes;

private:
  void extend(const LowestModesOptions& options) {
    if (options.count && *options.count <= modes.values.size() && modes.values.size() > 0) return;
    LowestModes more = lowest_modes(parts_.stiffness_ii, parts_.mass_ii, factored_, options);
    more.solves += modes.solves;
    if (more.values.size() >= modes.values.size()) modes = std::move(more);
  }

  const Partition& parts_;
  const StiffnessFactor& factored_;
  Index available_;
};

void truncate(LowestModes& modes, Index kept) {
  if (kept >= modes.values.size()) return;
  modes.next = modes.values[kept];
  modes.values.conservativeResize(kept);
  modes.vectors.conservativeResize(Eigen::NoChange, kept);
}

}  // namespace

MatrixXd rigid_body_modes(const Partition& parts, const StiffnessFactor& factored) {
  Search search(parts, factored);
  search.up_to_rigid_modes();
  return search.modes.vectors.leftCols(search.rigid());
}

SelectedModes select_modes(const Partition& parts, const MatrixXd& following, const StiffnessFactor& factored,
                           const ModeSelection& selection) {
  check(selection);
  Search search(parts, factored);
  Index kept = 0;
  std::string reason;
  const auto want = [&](Index count, const std::string& why) {
    reason += (reason.empty() ? "" : ", ") + std::to_string(count) + " " + why;
    kept = std::max(kept, count);
  };
  if (selection.cutoff) {
    search.up_to_frequency(*selection.cutoff);
    want(search.modes.values.size(), "up to " + number(*selection.cutoff) + " Hz");
  }
  if (selection.count) {
    search.up_to_count(std::max<Index>(*selection.count, 1));  // one at least, to know what is left out
    want(std::min(*selection.count, search.modes.values.size()), "by number");
  }
  if (selection.effective_mass)
    want(search.up_to_mass(following, *selection.effective_mass),
         "for " + number(100.0 * *selection.effective_mass) + " % of the interior's mass in each translation");
  search.up_to_rigid_modes();
  const Index rigid = search.rigid();
  if (rigid > 0)
    want(rigid,
         parts.boundary.empty() ? "that move the whole as a rigid body" : "that move the interior as a rigid body");
  truncate(search.modes, kept);
  if (!search.modes.next) reason += "; all modes";
  return {std::move(search.modes), rigid, reason};
}

MatrixXd translations(const std::vector<std::string>& names) {
  std::map<std::string, VectorXd> directions;
  for (std::size_t j = 0; j < names.size(); ++j) {
    const auto dot = names[j].rfind('.');
    const std::string last = dot == std::string::npos ? "" : names[j].substr(dot + 1);
    if (last == "rx" || last == "ry" || last == "rz") continue;
    const bool known = last == "x" || last == "y" || last == "z";
    VectorXd& direction =
        directions.try_emplace(known ? last : "", VectorXd::Zero(static_cast<Index>(names.size()))).first->second;
    direction[static_cast<Index>(j)] = 1.0;
  }
  MatrixXd columns(static_cast<Index>(names.size()), static_cast<Index>(directions.size()));
  Index column = 0;
  for (const auto& [name, direction] : directions) columns.col(column++) = direction;
  return columns;
}

}  // namespace kalfem

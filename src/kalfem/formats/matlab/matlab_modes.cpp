// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matlab/matlab_modes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matlab/matlab_values.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Kind = MatlabValue::Kind;

constexpr std::complex<double> not_measured = {ModeSet::unknown, ModeSet::unknown};

/// The variables, or the fields of the only one where it is a structure.
MatlabFields variables_of(const std::filesystem::path& path) {
  UnpackedBudget budget(path, {.large = true});
  auto variables = read_matlab_values(path, budget).variables;
  if (variables.size() == 1 && variables[0].value.kind == Kind::structure && variables[0].value.elements.size() == 1)
    return variables[0].value.elements[0];
  return variables;
}

/// Takes variables apart and collects what is wrong with them.
class ModeReader {
public:
  explicit ModeReader(const std::filesystem::path& path) : path_(path), variables_(variables_of(path)) {}

  ModeSet read() {
    const auto* frequencies = numbers("frequencies", true);
    const auto* shapes = numbers("shapes", true);
    issues_.raise();
    ModeSet set;
    set.modes.resize(static_cast<std::size_t>(frequencies->real.size()));
    const Index points = shapes->real.rows(), modes = std::ssize(set.modes);
    if (shapes->real.cols() != modes)
      refuse(fmt::format("shapes are {} x {}", points, shapes->real.cols()),
             fmt::format("there are {} frequencies", modes), "give each mode a column");
    set.points = names(points);
    take("frequencies", &ModeSet::Mode::frequency, set);
    take("frequency_std", &ModeSet::Mode::frequency_std, set);
    take("dampings", &ModeSet::Mode::damping, set);
    take("damping_std", &ModeSet::Mode::damping_std, set);
    const auto* deviations = numbers("shape_std", false);
    if (deviations && (deviations->real.rows() != points || deviations->real.cols() != shapes->real.cols()))
      refuse(fmt::format("shape_std is {} x {}", deviations->real.rows(), deviations->real.cols()),
             fmt::format("shapes are {} x {}", points, shapes->real.cols()), "give each entry its own");
    issues_.raise();
    for (Index i = 0; i < modes; ++i) {
      auto& mode = set.modes[static_cast<std::size_t>(i)];
      mode.shape = shape_of(*shapes, i);
      if (deviations) mode.shape_covariance = deviations->real.col(i).cwiseAbs2().replicate(2, 1).asDiagonal();
    }
    return set;
  }

private:
  void refuse(const std::string& fact, const std::string& why, const std::string& fix) {
    issues_.add({path_.string(), 0}, fact, why, fix);
  }

  [[nodiscard]] const MatlabValue* find(const std::string& name) const {
    const auto found = std::ranges::find(variables_, name, &MatlabField::name);
    return found == variables_.end() ? nullptr : &found->value;
  }

  /// Null where it is absent or no numbers; that is wrong where it is needed.
  const MatlabValue* numbers(const std::string& name, bool needed) {
    const auto* value = find(name);
    if (value && value->kind == Kind::numbers && value->lengths.empty() && value->real.size() > 0) return value;
    if (value || needed)
      refuse(value ? "the variable '" + name + "' is no matrix of numbers" : "there is no variable '" + name + "'",
             "modes are frequencies [Hz] and shapes, points x modes",
             "save frequencies, shapes, and what is known of points, dampings, frequency_std, damping_std, shape_std");
    return nullptr;
  }

  std::vector<std::string> names(Index count) {
    std::vector<std::string> all;
    const auto* given = find("points");
    if (!given) {
      for (Index i = 1; i <= count; ++i) all.push_back(std::to_string(i));
      return all;
    }
    if (given->kind == Kind::cells)
      for (const auto& cell : given->elements)
        if (cell.size() == 1 && cell[0].value.kind == Kind::text) all.push_back(cell[0].value.text);
    if (std::ssize(all) != count)
      refuse(fmt::format("points holds {} names", all.size()), fmt::format("shapes have {} rows", count),
             "give a cell with one name a row");
    return all;
  }

  /// One number a mode.
  void take(const std::string& name, double ModeSet::Mode::*member, ModeSet& set) {
    const auto* given = numbers(name, false);
    if (!given) return;
    if (given->real.size() != std::ssize(set.modes))
      return refuse(fmt::format("{} holds {} values", name, given->real.size()),
                    fmt::format("there are {} frequencies", set.modes.size()), "give one a mode");
    for (Index i = 0; i < given->real.size(); ++i)
      set.modes[static_cast<std::size_t>(i)].*member = given->real.reshaped()[i];
  }

  static Eigen::VectorXcd shape_of(const MatlabValue& shapes, Index mode) {
    Eigen::VectorXcd shape = shapes.real.col(mode).cast<std::complex<double>>();
    if (shapes.imaginary.size() > 0) shape.imag() = shapes.imaginary.col(mode);
    for (auto& entry : shape)
      if (!std::isfinite(std::abs(entry))) entry = not_measured;
    return shape;
  }

  const std::filesystem::path& path_;
  MatlabFields variables_;
  IssueList issues_;
};

}  // namespace

ModeSet read_matlab_modes(const std::filesystem::path& path) { return ModeReader(path).read(); }

}  // namespace kalfem

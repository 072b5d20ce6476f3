// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/merge_setups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/modal/shape_measures.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Rows of a set-up's shapes: the references, then the others.
struct Rows {
  std::vector<Index> references, others;
};

Index row_of(const ModalResult& result, const std::string& channel) {
  const auto found = std::ranges::find(result.channels, channel);
  return found == result.channels.end() ? -1 : found - result.channels.begin();
}

std::vector<std::string> common_channels(const std::vector<SetupModes>& setups) {
  std::vector<std::string> common;
  for (const auto& channel : setups.front().result.channels)
    if (std::ranges::all_of(setups, [&](const auto& setup) { return row_of(setup.result, channel) >= 0; }))
      common.push_back(channel);
  return common;
}

std::vector<Rows> rows_of(const std::vector<SetupModes>& setups, const std::vector<std::string>& references) {
  IssueList issues;
  std::vector<Rows> rows;
  for (const auto& setup : setups) {
    auto& own = rows.emplace_back();
    for (const auto& reference : references) {
      own.references.push_back(row_of(setup.result, reference));
      if (own.references.back() < 0)
        issues.add({setup.name, 0},
                   "there is no channel '" + reference + "'" + did_you_mean(reference, setup.result.channels),
                   "references stay in their places in all set-ups", "name channels that all records have");
    }
    for (std::size_t i = 0; i < setup.result.channels.size(); ++i)
      if (std::ranges::find(references, setup.result.channels[i]) == references.end())
        own.others.push_back(static_cast<Index>(i));
  }
  issues.raise();
  return rows;
}

VectorXcd at(const VectorXcd& shape, const std::vector<Index>& rows) { return shape(rows); }

/// The mode of a set-up that is this one: the nearest in frequency that agrees at the references.
std::optional<std::size_t> same_mode(const IdentifiedMode& mode, const Rows& of_mode, const ModalResult& result,
                                     const Rows& rows, const MergeOptions& options) {
  std::optional<std::size_t> best;
  double nearest = options.frequency;
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const auto& other = result.modes[i];
    const double apart = std::abs(other.frequency / mode.frequency - 1.0);
    const bool agrees = rows.references.size() < 2 ||
                        mac(at(other.shape, rows.references), at(mode.shape, of_mode.references)) >= options.mac;
    if (apart > nearest || !agrees) continue;
    nearest = apart;
    best = i;
  }
  return best;
}

/// Shapes of one mode in all set-ups.
using Shapes = std::vector<VectorXcd>;

// The references of all set-ups and their common shape belong to each other: a few turns settle both, as the set-ups
// differ by little more than their factors.
VectorXcd merged_shape(const Shapes& shapes, const std::vector<Rows>& rows) {
  std::vector<VectorXcd> references;
  for (std::size_t i = 0; i < shapes.size(); ++i) references.push_back(at(shapes[i], rows[i].references));
  VectorXcd common = references.front();
  std::vector<std::complex<double>> factors(shapes.size());
  for (int turn = 0; turn < 20; ++turn) {
    VectorXcd sum = VectorXcd::Zero(common.size());
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      factors[i] = references[i].dot(common) / references[i].squaredNorm();
      sum += factors[i] * references[i];
    }
    common = sum / static_cast<double>(shapes.size());
  }
  Index size = common.size();
  for (const auto& each : rows) size += std::ssize(each.others);
  VectorXcd merged(size);
  merged.head(common.size()) = common;
  Index next = common.size();
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (const auto row : rows[i].others) merged[next++] = factors[i] * shapes[i][row];
  return merged;
}

VectorXd stacked(const VectorXcd& shape) {
  VectorXd parts(2 * shape.size());
  parts << shape.real(), shape.imag();
  return parts;
}

/// With the largest entry, which stays the same one, at 1.
VectorXcd scaled(const VectorXcd& shape, Index top) { return shape / shape[top]; }

// The merged shape is smooth in the entries of the set-ups: central differences at steps of 1e-6 are exact to 1e-10.
void set_shape(IdentifiedMode& mode, Shapes shapes, const std::vector<MatrixXd>& covariances,
               const std::vector<Rows>& rows) {
  const VectorXcd whole = merged_shape(shapes, rows);
  Index top = 0;
  whole.cwiseAbs().maxCoeff(&top);
  mode.shape = scaled(whole, top);
  mode.shape_covariance = MatrixXd::Zero(2 * whole.size(), 2 * whole.size());
  constexpr double step = 1e-6;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Index size = shapes[i].size();
    MatrixXd jacobian(2 * whole.size(), 2 * size);
    for (Index k = 0; k < 2 * size; ++k) {
      const std::complex<double> change = k < size ? std::complex(step, 0.0) : std::complex(0.0, step);
      auto& entry = shapes[i][k % size];
      const auto present = entry;
      entry = present + change;
      const VectorXd above = stacked(scaled(merged_shape(shapes, rows), top));
      entry = present - change;
      jacobian.col(k) = (above - stacked(scaled(merged_shape(shapes, rows), top))) / (2.0 * step);
      entry = present;
    }
    mode.shape_covariance += jacobian * covariances[i] * jacobian.transpose();
  }
}

/// Frequency and damping: the mean weighted by the inverse covariances, and its covariance with the set-ups' scatter.
void set_pole(IdentifiedMode& mode, const std::vector<const IdentifiedMode*>& found) {
  Eigen::Matrix2d weight = Eigen::Matrix2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto* each : found) {
    const Eigen::Matrix2d inverse = each->covariance.inverse();
    weight += inverse;
    sum += inverse * Eigen::Vector2d(each->frequency, each->damping);
  }
  mode.covariance = weight.inverse();
  const Eigen::Vector2d mean = mode.covariance * sum;
  mode.frequency = mean[0];
  mode.damping = mean[1];
  Eigen::Vector2d scatter = Eigen::Vector2d::Zero();
  for (const auto* each : found) {
    const Eigen::Vector2d apart(each->frequency - mean[0], each->damping - mean[1]);
    scatter += apart.cwiseAbs2().cwiseQuotient(each->covariance.diagonal());
  }
  const Eigen::Vector2d wider = (scatter / static_cast<double>(found.size() - 1)).cwiseMax(1.0).cwiseSqrt();
  mode.covariance = wider.asDiagonal() * mode.covariance * wider.asDiagonal();
}

/// Names and units of the merged channels. Others that several set-ups call alike bear the set-up's name.
void set_channels(ModalResult& merged, const std::vector<SetupModes>& setups, const std::vector<Rows>& rows) {
  std::map<std::string, int> count;
  for (std::size_t i = 0; i < setups.size(); ++i)
    for (const auto row : rows[i].others) ++count[setups[i].result.channels[static_cast<std::size_t>(row)]];
  const auto add = [&](const SetupModes& setup, Index row, bool alone) {
    const auto& name = setup.result.channels[static_cast<std::size_t>(row)];
    merged.channels.push_back(alone ? name : setup.name + ":" + name);
    merged.units.push_back(static_cast<std::size_t>(row) < setup.result.units.size()
                               ? setup.result.units[static_cast<std::size_t>(row)]
                               : "");
  };
  for (const auto row : rows.front().references) add(setups.front(), row, true);
  for (std::size_t i = 0; i < setups.size(); ++i)
    for (const auto row : rows[i].others)
      add(setups[i], row, count[setups[i].result.channels[static_cast<std::size_t>(row)]] == 1);
}

/// A result with what the set-ups have in common, or the largest of it.
ModalResult frame_of(const std::vector<SetupModes>& setups) {
  ModalResult merged;
  merged.sample_rate = setups.front().result.sample_rate;
  for (const auto& [name, result] : setups) {
    merged.samples += result.samples;
    merged.block_rows = std::max(merged.block_rows, result.block_rows);
    merged.max_order = std::max(merged.max_order, result.max_order);
    merged.blocks = std::max(merged.blocks, result.blocks);
    for (const auto& remark : result.remarks) merged.remarks.push_back(name + ": " + remark);
    merged.diagram.insert(merged.diagram.end(), result.diagram.begin(), result.diagram.end());
  }
  return merged;
}

}  // namespace

ModalResult merge_setups(const std::vector<SetupModes>& setups, const MergeOptions& options) {
  if (setups.size() < 2)
    throw InvalidInput(fmt::format("{} set-up to merge", setups.size()), "set-ups are brought to each other",
                       "give two records or more");
  const auto references = options.references.empty() ? common_channels(setups) : options.references;
  if (references.empty())
    throw InvalidInput("the set-ups have no channel in common", "shapes are brought to each other by sensors that stay",
                       "give the sensors that stay the same names in all records");
  const auto rows = rows_of(setups, references);
  ModalResult merged = frame_of(setups);
  merged.references = references;
  set_channels(merged, setups, rows);
  for (const auto& first : setups.front().result.modes) {
    std::vector<const IdentifiedMode*> found;
    std::string lacking;
    for (std::size_t i = 0; i < setups.size(); ++i) {
      const auto index = same_mode(first, rows.front(), setups[i].result, rows[i], options);
      if (index)
        found.push_back(&setups[i].result.modes[*index]);
      else
        lacking += (lacking.empty() ? "" : ", ") + setups[i].name;
    }
    if (!lacking.empty()) {
      merged.remarks.push_back(
          fmt::format("The mode at {:.4g} Hz is left out: {} has none that agrees with it.", first.frequency, lacking));
      continue;
    }
    IdentifiedMode mode;
    set_pole(mode, found);
    Shapes shapes;
    std::vector<MatrixXd> covariances;
    mode.degrees_of_freedom = first.degrees_of_freedom;
    mode.order = first.order;
    mode.orders = first.orders;
    for (const auto* each : found) {
      shapes.push_back(each->shape);
      covariances.push_back(each->shape_covariance);
      mode.degrees_of_freedom = std::min(mode.degrees_of_freedom, each->degrees_of_freedom);
      mode.participation += each->participation / static_cast<double>(found.size());
      mode.orders = std::min(mode.orders, each->orders);
    }
    set_shape(mode, std::move(shapes), covariances, rows);
    mode.phase_collinearity = phase_collinearity(mode.shape);
    merged.modes.push_back(std::move(mode));
  }
  return merged;
}

}  // namespace kalfem

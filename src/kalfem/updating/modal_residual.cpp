// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/modal_residual.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index spare_modes = 6;

std::string number(double value) { return fmt::format("{:.4g}", value); }

void check(const std::vector<MeasuredMode>& measured, std::size_t points, const ModalResidualOptions& options) {
  IssueList issues;
  check_modes(measured, points, issues);
  if (options.skip < 0) issues.add({}, "the number of modes to skip is negative");
  issues.raise();
}

Index wanted_modes(const std::vector<MeasuredMode>& measured, const ModalResidualOptions& options) {
  if (options.modes) return *options.modes;
  auto most = static_cast<Index>(measured.size());
  for (const auto& mode : measured) most = std::max<Index>(most, mode.model_mode.value_or(0));
  return most + most / 2 + spare_modes;
}

VectorXd frequencies_of(const std::vector<MeasuredMode>& measured) {
  VectorXd frequencies(static_cast<Index>(measured.size()));
  for (std::size_t i = 0; i < measured.size(); ++i) frequencies[static_cast<Index>(i)] = measured[i].frequency;
  return frequencies;
}

/// The measured mode pairs with that model mode and no other does.
void name_pair(MatrixXd& mac, Index measured, Index model) {
  mac.row(measured).setZero();
  if (model >= mac.cols()) return;
  mac.col(model).setZero();
  mac(measured, model) = 1.0;
}

/// Modes with neither number nor shape take those that are left, lowest first.
void pair_by_order(const std::vector<MeasuredMode>& measured, const VectorXd& frequencies,
                   std::vector<ModePair>& pairs) {
  std::set<Index> taken;
  std::vector<std::size_t> waiting;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (pairs[i].model)
      taken.insert(*pairs[i].model);
    else if (!measured[i].model_mode && measured[i].shape.size() == 0)
      waiting.push_back(i);
  std::ranges::stable_sort(waiting, {}, [&](std::size_t i) { return measured[i].frequency; });
  Index next = 0;
  for (const std::size_t i : waiting) {
    while (taken.contains(next)) ++next;
    if (next >= frequencies.size()) return;
    pairs[i] = {next, 1.0, frequencies[next] / measured[i].frequency - 1.0};
    ++next;
  }
}

void add_unpaired(std::size_t i, const MeasuredMode& mode, const VectorXd& mac, const VectorXd& frequencies,
                  const ModalResidualOptions& options, IssueList& issues) {
  const std::string fact = named_mode(i, mode.frequency) + " does not pair with any mode of the model";
  const auto elastic = frequencies.size();
  if (elastic == 0 || mode.model_mode || mode.shape.size() == 0) {
    issues.add({}, fact, "there are " + std::to_string(elastic) + " elastic modes to pair with",
               "compute more modes, skip fewer of the lowest, or remove the measured mode");
    return;
  }
  Index nearest = 0, best = 0;
  (frequencies.array() - mode.frequency).abs().minCoeff(&nearest);
  mac.maxCoeff(&best);
  const auto model_mode = [&](Index j) {
    return "model mode " + std::to_string(j + 1) + " (" + number(frequencies[j]) + " Hz) with a MAC of " +
           number(mac[j]);
  };
  issues.add(
      {}, fact,
      "the nearest in frequency is " + model_mode(nearest) + ", the nearest in shape is " + model_mode(best) +
          (mac[best] < options.pairing.least_mac ? "; a pair needs a MAC of " + number(options.pairing.least_mac)
                                                 : "; that mode agrees better with another measured mode"),
      "`kalfem correlate` looks for wrong sensors; check positions, directions and signs of the points, state its "
      "model mode, or remove it");
}

/// Of the damping by modal ratios; the last one holds for all further modes.
double ratio_of(const ModalRatios& ratios, Index mode) {
  if (ratios.empty()) return 0.0;
  return ratios.values[std::min(static_cast<std::size_t>(mode), ratios.values.size() - 1)];
}

double frequency_of(double lambda) { return std::sqrt(std::max(lambda, 0.0)) / (2.0 * M_PI); }

/// Orthonormal columns that are together nearest to the given ones: U V^T of their singular value decomposition.
MatrixXd nearest_orthonormal(const MatrixXd& columns) {
  const Eigen::JacobiSVD<MatrixXd> svd(columns, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return svd.matrixU() * svd.matrixV().transpose();
}

/// d(A c) of the fit c = A^+ t that follows A: of the projector on A's columns [GP73].
VectorXd fit_derivative(const MatrixXd& A, const MatrixXd& dA, const VectorXd& coefficients, const VectorXd& misfit) {
  const auto gram = (A.transpose() * A).completeOrthogonalDecomposition();
  const VectorXd moved = dA * coefficients;
  const VectorXd change = gram.solve(VectorXd(A.transpose() * moved + dA.transpose() * misfit));
  return moved - A * change;
}

}  // namespace

// How measured modes are compared with those of the model:
//   1. solve(): the lowest modes at theta, and groups of (nearly) repeated ones, within which eigenvectors mean
//   nothing.
//   2. pairs(): a measured mode is recognised in a group by its shape, or by M phi of the mode with which it was paired
//      at the start; MAC of group and mode, then the assignment of the largest sum (pair_modes()).
//   3. places(): within a group the direction of a mode is the combination nearest to its shape; those of several
//      measured modes in one group are made orthogonal together. frequency^2 ~ sum lambda_i c_i^2.
//   4. values(): (f - f_m) / deviation, the whitened misfit of the fitted shape at the measured entries, and dampings.
//   5. jacobian(): of frequencies by [FK68], of shapes through the derivative of the group's subspace
//      ([Nel76], [Dai89] for repeated modes) and of the projector onto it [GP73]; of dampings through both.
/// The model and its modes at one point of the parameter space. The last group has only the use to end the others.
struct ModalResidual::Solution {
  LinearModel model;
  ModalRatios ratios;
  StiffnessFactor shifted;
  LowestModes modes;
  std::vector<ModeGroup> groups;
  Index end = 0;       ///< modes that may be paired come before
  MatrixXd at_points;  ///< P Phi
  MatrixXd mass_gram;  ///< Phi^T M Phi with M of the start

  [[nodiscard]] SolvedEigenproblem problem() const { return {model.stiffness, model.mass, shifted, modes}; }
  [[nodiscard]] Index elastic(Index skip) const { return std::max<Index>(end - skip, 0); }
  [[nodiscard]] VectorXd frequencies(Index skip) const {
    return modes.values.segment(std::min(skip, end), elastic(skip)).unaryExpr(&frequency_of);
  }
  [[nodiscard]] const ModeGroup& group_of(Index mode) const {
    return *std::ranges::find_if(groups, [&](const ModeGroup& group) { return group.has(mode); });
  }
};

/// Where a measured mode stands in the model: the direction in its group, and how its shape fits there.
struct ModalResidual::Place {
  ModeGroup group;
  VectorXd direction;  ///< coefficients over the group, of length 1
  double frequency = 0.0;
  Index mode = 0;         ///< number among all modes of the model, from 0
  double viscous = 0.0;   ///< phi^T C phi / (2 omega), where the damping is compared
  VectorXd misfit;        ///< L^-1 (P Phi c - phi_measured); empty without a shape
  VectorXd coefficients;  ///< c
};

ModalResidual::ModalResidual(std::shared_ptr<const ParameterisedModel> model, std::vector<MeasuredMode> measured,
                             std::vector<DofCombination> points, const VectorXd& start, ModalResidualOptions options)
    : model_(std::move(model)),
      measured_(std::move(measured)),
      points_(std::move(points)),
      options_(options),
      references_(measured_.size()) {
  check(measured_, points_.size(), options_);
  for (const auto& mode : measured_) {
    errors_.push_back(mode.shape.size() > 0 ? std::optional(shape_errors_of(mode)) : std::nullopt);
    size_ += 1 + (errors_.back() ? errors_.back()->size() : 0) + (mode.damping ? 1 : 0);
  }
  const Solution solution = solve_first(start);
  const auto pairs = first_pairs(solution);
  require_damping(solution, pairs);
  choose_references(solution, pairs, start);
}

/// The model must have a damping that can be compared.
void ModalResidual::require_damping(const Solution& solution, const std::vector<ModePair>& pairs) const {
  IssueList issues;
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    if (!measured_[i].damping) continue;
    if (solution.ratios.empty() && solution.model.damping.nonZeros() == 0)
      throw InvalidInput("the dampings of measured modes are compared, but the model has no damping", "",
                         "give the substructure dashpots or `damping`, or leave the dampings out");
    const double frequency = frequency_of(solution.modes.values[skip_ + *pairs[i].model]);
    if (frequency > solution.ratios.up_to && !solution.ratios.empty())
      issues.add({}, "the damping of " + named_mode(i, measured_[i].frequency) + " cannot be compared",
                 "the model has damping ratios up to " + number(solution.ratios.up_to) + " Hz only",
                 "raise modal_up_to, or leave the mode out");
  }
  issues.raise();
}

/// The last group may be cut by the number of computed modes, so it is not offered for pairing where more modes follow.
ModalResidual::Solution ModalResidual::solve(const VectorXd& parameters) const {
  auto [model, ratios] = model_->at(parameters);
  StiffnessFactor shifted = factor_stiffness(model.stiffness, model.mass, model.dofs);
  LowestModes modes = lowest_modes(model.stiffness, model.mass, shifted, {.count = count_});
  auto groups = group_modes(modes.values, options_.repeated);
  const Index end = modes.next && !groups.empty() ? groups.back().first : modes.values.size();
  MatrixXd at_points = rows_ * modes.vectors, mass_gram;
  if (start_mass_.rows() > 0) mass_gram = modes.vectors.transpose() * (start_mass_ * modes.vectors);
  return {std::move(model),     std::move(ratios),   std::move(shifted), std::move(modes), std::move(groups), end,
          std::move(at_points), std::move(mass_gram)};
}

/// Finds how many of the lowest modes are not elastic ones, and how many modes that makes to compute.
ModalResidual::Solution ModalResidual::solve_first(const VectorXd& start) {
  const LinearModel model = model_->at(start).model;
  rows_ = point_rows(model, points_);
  const Index massive = (model.mass.diagonal().array() > 0.0).count(), wanted = wanted_modes(measured_, options_);
  skip_ = options_.skip;
  while (true) {
    count_ = std::min(massive, skip_ + wanted);
    Solution solution = solve(start);
    const Index low = (solution.modes.values.unaryExpr(&frequency_of).array() <= options_.above).count();
    skip_ = std::max<Index>(options_.skip, low);
    if (std::min(massive, skip_ + wanted) <= count_) return solution;
  }
}

/// By number, by shape, or by order among those that are free. Throws InvalidInput where a mode pairs with nothing.
std::vector<ModePair> ModalResidual::first_pairs(const Solution& solution) const {
  const VectorXd frequencies = solution.frequencies(skip_);
  MatrixXd mac = agreement(solution, solution.groups);
  // A shape that is like no single mode may be one that close modes make together.
  const MatrixXd joined = agreement(solution, group_modes(solution.modes.values, options_.close));
  for (Index i = 0; i < mac.rows() && mac.cols() > 0; ++i)
    if (mac.row(i).maxCoeff() < options_.pairing.least_mac) mac.row(i) = joined.row(i);
  for (std::size_t i = 0; i < measured_.size(); ++i)
    if (const auto mode = measured_[i].model_mode) name_pair(mac, static_cast<Index>(i), *mode - 1);
  auto pairs = pair_modes(mac, frequencies_of(measured_), frequencies, options_.pairing);
  pair_by_order(measured_, frequencies, pairs);
  IssueList issues;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (!pairs[i].model) add_unpaired(i, measured_[i], mac.row(static_cast<Index>(i)), frequencies, options_, issues);
  issues.raise();
  return pairs;
}

/// M phi at the start for the modes that are not recognised by a measured shape.
void ModalResidual::choose_references(const Solution& solution, const std::vector<ModePair>& pairs,
                                      const VectorXd& start) {
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    if (!measured_[i].model_mode && measured_[i].shape.size() > 0) continue;
    const Index mode = skip_ + *pairs[i].model;
    const ModeGroup& group = solution.group_of(mode);
    VectorXd direction = VectorXd::Unit(group.size, mode - group.first);
    if (group.size > 1) {
      std::vector<MatrixXd> projected;
      for (const auto& derivative : model_->derivatives(start))
        projected.push_back(projected_derivative(solution.modes, group, derivative));
      if (!projected.empty()) direction = joint_eigenbasis(projected).col(mode - group.first);
    }
    start_mass_ = solution.model.mass;
    references_[i] = start_mass_ * (solution.modes.vectors.middleCols(group.first, group.size) * direction);
  }
}

SubspaceFit ModalResidual::fit_shape(std::size_t mode, const Solution& solution, const ModeGroup& group) const {
  const VectorXd shape = errors_[mode]->of_measured(measured_[mode].shape);
  const MatrixXd A = errors_[mode]->of_measured(solution.at_points.middleCols(group.first, group.size));
  return fit_in_subspace(A.transpose() * A, A.transpose() * shape, shape.squaredNorm());
}

SubspaceFit ModalResidual::fit_reference(std::size_t mode, const Solution& solution, const ModeGroup& group) const {
  const auto shapes = solution.modes.vectors.middleCols(group.first, group.size);
  return fit_in_subspace(solution.mass_gram.block(group.first, group.first, group.size, group.size),
                         shapes.transpose() * references_[mode], 1.0);
}

/// By what a measured mode is recognised in a group: nothing for one without a shape at the start.
SubspaceFit ModalResidual::recognise(std::size_t mode, const Solution& solution, const ModeGroup& group) const {
  if (references_[mode].size() > 0) return fit_reference(mode, solution, group);
  if (measured_[mode].shape.size() > 0) return fit_shape(mode, solution, group);
  return {VectorXd::Zero(group.size), 0.0};
}

/// MAC of measured modes and the groups of elastic modes, the same for all of a group.
MatrixXd ModalResidual::agreement(const Solution& solution, const std::vector<ModeGroup>& groups) const {
  MatrixXd mac(static_cast<Index>(measured_.size()), solution.elastic(skip_));
  for (std::size_t i = 0; i < measured_.size(); ++i)
    for (const ModeGroup& group : groups) {
      const Index first = std::max(group.first, skip_), end = std::min(group.first + group.size, solution.end);
      if (first >= end) continue;
      const double value = recognise(i, solution, group).mac;
      mac.row(static_cast<Index>(i)).segment(first - skip_, end - first).setConstant(value);
    }
  return mac;
}

std::vector<ModePair> ModalResidual::pairs(const Solution& solution, double least_mac) const {
  ModePairingOptions options = options_.pairing;
  options.least_mac = least_mac;
  return pair_modes(agreement(solution, solution.groups), frequencies_of(measured_), solution.frequencies(skip_),
                    options);
}

/// Nothing where a mode is lost or has no frequency.
std::optional<std::vector<ModalResidual::Place>> ModalResidual::places(const Solution& solution) const {
  std::vector<Place> places;
  for (const ModePair& pair : pairs(solution, options_.lost_mac)) {
    if (!pair.model || !(solution.modes.values[skip_ + *pair.model] > 0.0)) return {};
    places.push_back({.group = solution.group_of(skip_ + *pair.model),
                      .direction = {},
                      .mode = skip_ + *pair.model,
                      .misfit = {},
                      .coefficients = {}});
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    Place& place = places[i];
    place.direction = direction(i, places, solution);
    const auto values = solution.modes.values.segment(place.group.first, place.group.size);
    place.frequency = frequency_of(values.dot(place.direction.cwiseAbs2()));
    if (measured_[i].damping) {
      const VectorXd shape = solution.modes.vectors.middleCols(place.group.first, place.group.size) * place.direction;
      place.viscous = shape.dot(solution.model.damping * shape) / (4.0 * M_PI * place.frequency);
    }
    if (!errors_[i]) continue;
    const MatrixXd A = errors_[i]->whitened(solution.at_points.middleCols(place.group.first, place.group.size));
    const VectorXd shape = errors_[i]->whitened(measured_[i].shape);
    place.coefficients = fit_in_subspace(A.transpose() * A, A.transpose() * shape, shape.squaredNorm()).coefficients;
    place.misfit = A * place.coefficients - shape;
  }
  return places;
}

/// In a group, the combinations nearest to the shapes of its measured modes, made orthogonal together.
VectorXd ModalResidual::direction(std::size_t mode, const std::vector<Place>& places, const Solution& solution) const {
  const ModeGroup& group = places[mode].group;
  if (group.size == 1) return VectorXd::Ones(1);
  MatrixXd columns(group.size, 0);
  Index own = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].group.first != group.first) continue;
    if (i == mode) own = columns.cols();
    columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
    columns.rightCols(1) = recognise(i, solution, group).coefficients.normalized();
  }
  return nearest_orthonormal(columns).col(own);
}

std::optional<ResidualValue> ModalResidual::evaluate(const VectorXd& parameters, bool with_jacobian) const {
  try {
    const Solution solution = solve(parameters);
    const auto found = places(solution);
    if (!found) return {};
    ResidualValue result{values(*found, solution), {}};
    if (!with_jacobian) return result;
    auto slopes = jacobian(solution, *found, model_->derivatives(parameters));
    if (!slopes) return {};
    result.jacobian = std::move(*slopes);
    return result;
  } catch (const InvalidInput&) {  // the model is no structure there
    return {};
  }
}

RowLayout ModalResidual::layout() const {
  RowLayout layout{.steps = "modes"};
  const auto modes = std::ssize(measured_);
  for (Index i = 0; i < modes; ++i) layout.step.push_back(i);
  for (Index i = 0; i < modes; ++i)
    if (const auto& errors = errors_[static_cast<std::size_t>(i)])
      layout.step.insert(layout.step.end(), static_cast<std::size_t>(errors->size()), i);
  for (Index i = 0; i < modes; ++i)
    if (measured_[static_cast<std::size_t>(i)].damping) layout.step.push_back(i);
  return layout;
}

double ModalResidual::model_damping(const Place& place, const Solution& solution) {
  return place.viscous + ratio_of(solution.ratios, place.mode);
}

VectorXd ModalResidual::values(const std::vector<Place>& places, const Solution& solution) const {
  VectorXd values(size_);
  auto row = static_cast<Index>(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    values[static_cast<Index>(i)] = (places[i].frequency - measured_[i].frequency) / measured_[i].deviation;
    values.segment(row, places[i].misfit.size()) = places[i].misfit;
    row += places[i].misfit.size();
  }
  for (std::size_t i = 0; i < places.size(); ++i)
    if (const auto& measured = measured_[i]; measured.damping)
      values[row++] = (model_damping(places[i], solution) - *measured.damping) / measured.damping_deviation;
  return values;
}

/// dPhi_G of every group of which a shape or a damping is compared, by its first mode. Nothing where one has none.
std::optional<ModalResidual::Slopes> ModalResidual::slopes(const Solution& solution, const std::vector<Place>& places,
                                                           const std::vector<ModelDerivative>& derivatives) const {
  Slopes slopes;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const ModeGroup& group = places[i].group;
    if ((!errors_[i] && !measured_[i].damping) || slopes.contains(group.first)) continue;
    auto moving = subspace_derivatives(solution.problem(), group, derivatives, options_.sensitivities);
    if (!moving) return {};
    slopes.emplace(group.first, std::move(*moving));
  }
  return slopes;
}

/// dzeta = [2 phi^T C dphi + phi^T dC phi] / (2 omega) - phi^T C phi domega / (2 omega^2) + dratio, dphi within the
/// group's own combination q; domega = 2 pi df.
double ModalResidual::damping_slope(const Place& place, const Solution& solution, const ModelDerivative& derivative,
                                    const MatrixXd& dPhi, double frequency_slope) {
  const VectorXd shape = solution.modes.vectors.middleCols(place.group.first, place.group.size) * place.direction;
  double slope = 2.0 * (solution.model.damping * shape).dot(dPhi * place.direction);
  if (derivative.damping.nonZeros() > 0) slope += shape.dot(derivative.damping * shape);
  const double of_ratio = derivative.modal_ratios.empty() ? 0.0 : ratio_of({derivative.modal_ratios}, place.mode);
  return slope / (4.0 * M_PI * place.frequency) - place.viscous * frequency_slope / place.frequency + of_ratio;
}

/// df = q^T D q / (8 pi^2 f) for the frequencies; nothing where a shape has no derivative.
std::optional<MatrixXd> ModalResidual::jacobian(const Solution& solution, const std::vector<Place>& places,
                                                const std::vector<ModelDerivative>& derivatives) const {
  const auto moving = slopes(solution, places, derivatives);
  if (!moving) return {};
  MatrixXd jacobian(size_, std::ssize(derivatives));
  for (std::size_t p = 0; p < derivatives.size(); ++p) {
    auto column = jacobian.col(static_cast<Index>(p));
    auto row = static_cast<Index>(places.size());
    VectorXd frequency_slopes(row);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Place& place = places[i];
      const MatrixXd D = projected_derivative(solution.modes, place.group, derivatives[p]);
      double& slope = frequency_slopes[static_cast<Index>(i)];
      slope = place.direction.dot(D * place.direction) / (8.0 * M_PI * M_PI * place.frequency);
      column[static_cast<Index>(i)] = slope / measured_[i].deviation;
      if (!errors_[i]) continue;
      const MatrixXd A = errors_[i]->whitened(solution.at_points.middleCols(place.group.first, place.group.size)),
                     dA = errors_[i]->whitened(rows_ * moving->at(place.group.first)[p]);
      column.segment(row, place.misfit.size()) = fit_derivative(A, dA, place.coefficients, place.misfit);
      row += place.misfit.size();
    }
    for (std::size_t i = 0; i < places.size(); ++i)
      if (measured_[i].damping)
        column[row++] = damping_slope(places[i], solution, derivatives[p], moving->at(places[i].group.first)[p],
                                      frequency_slopes[static_cast<Index>(i)]) /
                        measured_[i].damping_deviation;
  }
  return jacobian;
}

std::shared_ptr<const ModalResidual> ModalResidual::with_close_modes_joined() const {
  auto joined = std::make_shared<ModalResidual>(*this);
  joined->options_.repeated = options_.close;
  return joined;
}

ModePairing ModalResidual::compare(const VectorXd& parameters) const {
  const Solution solution = solve(parameters);
  const auto found = pairs(solution, 0.0);
  const auto at = places(solution);
  ModePairing comparison{{}, solution.frequencies(skip_), agreement(solution, solution.groups)};
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double measured = measured_[i].frequency, error = found[i].frequency_difference;
    PairedMode row{i, {}, measured, measured * (1.0 + error), error, found[i].mac};
    row.measured_damping = measured_[i].damping;
    row.complexity = measured_[i].complexity;
    if (at && measured_[i].damping) row.model_damping = model_damping((*at)[i], solution);
    if (const auto mode = found[i].model) {
      row.model_mode = static_cast<int>(*mode) + 1;
      if (measured_[i].shape.size() > 0) row.mac = fit_shape(i, solution, solution.group_of(skip_ + *mode)).mac;
    }
    comparison.pairs.push_back(row);
  }
  return comparison;
}

}  // namespace kalfem

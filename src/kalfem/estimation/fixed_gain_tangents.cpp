// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/fixed_gain_tangents.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kalfem/base/interruption.hpp"
#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/filter_setup.hpp"

namespace kalfem {

using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double relative_step = 1e-6;  ///< of the central differences of connector forces
constexpr Index most_samples = 32;      ///< of a block
constexpr Index most_points = 4096;     ///< at which connector forces are evaluated at once

bool is_straight(const AugmentedModel& augmented_model, const FilterInput& input) {
  return input.input_stride(augmented_model.options().instants()) == 1;
}

OutputsOf rows_of(const OutputMap& monitored) {
  return [&monitored](const AugmentedModel& each) { return each.augmented_model_form().outputs(monitored); };
}

bool same_size(const OpenModel& a, const OpenModel& b) {
  const auto fit = [](const OpenMap& one, const OpenMap& other) {
    return one.all.rows() == other.all.rows() && one.all.cols() == other.all.cols() && one.states == other.states &&
           one.forces == other.forces;
  };
  return fit(a.process, b.process) && fit(a.measurement, b.measurement) && fit(a.monitored, b.monitored) &&
         std::ranges::equal(a.laws, b.laws, std::ranges::equal_to{}, &VectorXd::size, &VectorXd::size);
}

bool has_structure(const RunDerivative& number) { return number.process.size() > 0; }

std::pair<Index, Index> place_of(const ParameterTarget& target) { return {target.connector, target.parameter}; }

/// The parameters of laws that some number changes.
std::vector<ParameterTarget> varied_by(const std::vector<const RunDerivative*>& numbers) {
  std::vector<ParameterTarget> varied;
  for (const auto* number : numbers)
    for (const auto& [target, rate] : number->laws)
      if (std::ranges::find(varied, place_of(target), place_of) == varied.end()) varied.push_back(target);
  return varied;
}

Index in_whole_registers(Index rows) { return (rows + 7) / 8 * 8; }

// One map with its tangents, over a block of samples in three steps:
//   1. image(): the mean passes sample by sample; what the map saw, z = [x; f; u] and its nonlinear arguments w, stays;
//   2. prepare(): the numbers' own parts d[A G B; N L E] z of all samples in one product, and the Jacobians of the
//      forces at all samples in one evaluation;
//   3. tangents(): sample by sample, [A; N] T plus the numbers' own part; its lower rows through the Jacobian and G.
template <class Map>
class TangentMap {
public:
  /// `mean`, `beside`: the map twice. `derivatives`: d(OpenMap::all) / dc of the first of all numbers. `largest`: of
  /// each argument along the run. `samples`: of a block.
  TangentMap(const AugmentedModel& augmented_model, Map mean, Map beside, const OpenMap& open,
             const std::vector<const MatrixXd*>& derivatives, const std::vector<const RunDerivative*>& numbers,
             const VectorXd& largest, Index samples)
      : mean_(std::move(mean)),
        beside_(std::move(beside)),
        open_(open),
        picked_(augmented_model.layout().connector_states + augmented_model.layout().unknowns),
        first_picked_(augmented_model.layout().connector_state()),
        structural_(std::ssize(derivatives)) {
    const auto varied = varied_by(numbers);
    const Index q = mean_.selection().rows(), count = std::ssize(numbers), own = std::ssize(varied),
                motions = q - picked_, y = mean_.linear().rows();
    constant_ = MatrixXd::Zero(in_whole_registers(y + motions), mean_.linear().cols());
    constant_.topRows(y) = mean_.linear();
    constant_.middleRows(y, motions) = mean_.selection().bottomRows(motions);
    gain_ = MatrixXd::Zero(y, in_whole_registers(mean_.gain().cols()));
    gain_.leftCols(mean_.gain().cols()) = mean_.gain();
    set_stacked(derivatives);
    arguments_ = MatrixXd::Zero(q + own, count);
    set_laws(augmented_model.system(), varied, numbers);
    steps_.resize(q + own);
    steps_ << relative_step * largest, relative_step * arguments_.bottomRows(own).cwiseAbs().rowwise().maxCoeff();
    beside_.vary(varied);
    seen_ = MatrixXd::Zero(open.all.cols(), samples);
    seen_arguments_ = MatrixXd::Zero(q, samples);
    added_inputs_.assign(static_cast<std::size_t>(count), {});
    jacobians_ = MatrixXd::Zero(gain_.cols(), (q + own) * samples);
  }

  Map& mean() { return mean_; }

  /// y at sample `at` of the block, with the inputs as set.
  bool image(const VectorXd& x, const VectorXd& inputs, Index at, VectorXd& y) {
    auto w = seen_arguments_.col(at);
    w.noalias() = mean_.selection() * x;
    w += mean_.input_offset();
    in_ = w.transpose().array();
    out_.resize(1, mean_.gain().cols());
    if (!mean_.evaluate(in_, out_)) return false;
    response_ = out_.row(0).matrix().transpose();
    y = mean_.offset();
    y.noalias() += mean_.linear() * x;
    y.noalias() += mean_.gain() * response_;
    seen_.col(at) << x.head(open_.states), response_.head(open_.forces), inputs;
    return true;
  }

  /// d(inputs)/dc of a number at a sample of the block.
  void set_added(Index number, Index at, const VectorXd& inputs) {
    auto& added = added_inputs_[static_cast<std::size_t>(number)];
    added.resize(inputs.size(), seen_.cols());
    added.col(at) = inputs;
  }

  /// For the samples from `first` on, up to `end`.
  bool prepare(Index first, Index end) {
    sources_.noalias() = stacked_ * seen_(felt_, Eigen::seqN(0, end));
    const Index inputs = open_.all.cols() - open_.states - open_.forces;
    added_.resize(added_inputs_.size());
    for (std::size_t i = 0; i < added_inputs_.size(); ++i)
      if (added_inputs_[i].size() > 0) added_[i] = open_.all.rightCols(inputs) * added_inputs_[i];
    return set_jacobians(first, end);
  }

  /// dy/dc at a sample of the block from T = dx/dc before. The next call overwrites it.
  MatrixXd& tangents(Index at, const MatrixXd& T) {
    const Index q = seen_arguments_.rows(), motions = q - picked_, y = mean_.linear().rows(), rows = open_.all.rows();
    moved_.noalias() = constant_ * T;
    const Eigen::Map<const MatrixXd> own(sources_.col(at).data(), rows, structural_);
    moved_.topLeftCorner(open_.outputs, structural_) += own.topRows(open_.outputs);
    moved_.block(y, 0, motions, structural_) += own.bottomRows(motions);
    for (std::size_t i = 0; i < added_.size(); ++i) {
      if (added_[i].size() == 0) continue;
      moved_.col(static_cast<Index>(i)).head(open_.outputs) += added_[i].col(at).head(open_.outputs);
      moved_.col(static_cast<Index>(i)).segment(y, motions) += added_[i].col(at).tail(motions);
    }
    arguments_.topRows(picked_) = T.middleRows(first_picked_, picked_);
    arguments_.middleRows(picked_, motions) = moved_.middleRows(y, motions);
    responses_.noalias() = jacobians_.middleCols(at * arguments_.rows(), arguments_.rows()) * arguments_;
    result_ = moved_.topRows(y);
    result_.noalias() += gain_ * responses_;
    return result_;
  }

private:
  /// The columns that some number changes.
  void set_stacked(const std::vector<const MatrixXd*>& derivatives) {
    const Index rows = open_.all.rows();
    const auto is_felt = [&](Index column) {
      return std::ranges::any_of(derivatives, [&](const MatrixXd* each) { return !each->col(column).isZero(0.0); });
    };
    for (Index column = 0; column < open_.all.cols(); ++column)
      if (is_felt(column)) felt_.push_back(column);
    stacked_.resize(structural_ * rows, std::ssize(felt_));
    for (Index i = 0; i < structural_; ++i)
      stacked_.middleRows(i * rows, rows) = (*derivatives[static_cast<std::size_t>(i)])(Eigen::all, felt_);
  }

  /// The parameters of laws that vary, and in the last rows of the arguments their derivatives by every number.
  void set_laws(const LocallyNonlinearSystem& system, const std::vector<ParameterTarget>& varied,
                const std::vector<const RunDerivative*>& numbers) {
    const Index first = mean_.selection().rows();
    varied_values_.resize(std::ssize(varied));
    for (Index v = 0; v < varied_values_.size(); ++v) {
      const auto& target = varied[static_cast<std::size_t>(v)];
      varied_values_[v] = system.connectors[static_cast<std::size_t>(target.connector)].parameters[target.parameter];
      for (std::size_t i = 0; i < numbers.size(); ++i)
        for (const auto& [moved, rate] : numbers[i]->laws)
          if (place_of(moved) == place_of(target)) arguments_(first + v, static_cast<Index>(i)) = rate;
    }
  }

  bool set_jacobians(Index first, Index end) {
    const Index q = seen_arguments_.rows(), all = arguments_.rows(), points = 2 * all;
    if (mean_.gain().cols() == 0) return true;
    points_.resize(points * (end - first), all);
    values_.resize(points_.rows(), mean_.gain().cols());
    for (Index at = first; at < end; ++at) {
      auto block = points_.middleRows((at - first) * points, points);
      for (Index j = 0; j < all; ++j) {
        block.col(j).setConstant(j < q ? seen_arguments_(j, at) : varied_values_[j - q]);
        block(2 * j, j) -= steps_[j];
        block(2 * j + 1, j) += steps_[j];
      }
    }
    if (!beside_.evaluate(points_, values_)) return false;
    for (Index at = first; at < end; ++at)
      for (Index j = 0; j < all; ++j) {
        const Index row = (at - first) * points + 2 * j;
        const double distance = points_(row + 1, j) - points_(row, j);
        jacobians_.col(at * all + j).head(values_.cols()) =
            (values_.row(row + 1) - values_.row(row)).matrix().transpose() / distance;
      }
    return true;
  }

  Map mean_, beside_;
  OpenMap open_;
  Index picked_, first_picked_;  ///< internal states and unknowns: first arguments, and where they stand in the state
  Index structural_;             ///< numbers that change the open map: the first ones
  MatrixXd constant_;            ///< [A; N], all columns of the state, and G; products are faster in whole registers
  MatrixXd gain_;
  std::vector<Index> felt_;  ///< columns of the open map that some number changes
  MatrixXd stacked_;         ///< these of d[A G B; N L E]/dc, one number under another
  VectorXd steps_, varied_values_;
  MatrixXd seen_, seen_arguments_;  ///< z and w, a column a sample of the block
  std::vector<MatrixXd> added_inputs_, added_;
  MatrixXd sources_, jacobians_;
  ArrayXXd in_, out_, points_, values_;
  VectorXd response_;
  MatrixXd moved_, arguments_, responses_, result_;
};

/// The run, block by block.
class TangentRun {
public:
  TangentRun(const AugmentedModel& augmented_model, const FilterInput& input, const Gains& gains,
             const OutputMap& monitored, Index state_at, const VectorXd& largest,
             const std::vector<RunDerivative>& numbers)
      : model_(augmented_model),
        input_(input),
        gains_(gains),
        state_at_(state_at),
        stride_(input.input_stride(augmented_model.options().instants())),
        order_(numbers.size()),
        state_(augmented_model.prior().mean) {
    std::iota(order_.begin(), order_.end(), 0);
    std::ranges::stable_partition(order_, [&](std::size_t i) { return has_structure(numbers[i]); });
    for (const std::size_t i : order_) numbers_.push_back(&numbers[i]);
    make_maps(monitored, largest);
    const Index samples = input.measured.samples(), unknowns = augmented_model.layout().unknowns;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      found_.push_back({.monitored = MatrixXd(monitored.size(), samples),
                        .innovation = MatrixXd(input.measured.values.rows(), samples),
                        .unknowns = MatrixXd(unknowns, samples)});
    T_ = MatrixXd::Zero(augmented_model.layout().size(), std::ssize(numbers));
  }

  bool run() {
    for (Index begin = 0; begin < input_.measured.samples(); begin += block_) {
      stop_if_asked();
      const Index count = std::min(block_, input_.measured.samples() - begin);
      if (!move_mean(begin, count) || !prepare(begin, count)) return false;
      for (Index at = 0; at < count; ++at) move_tangents(begin + at, at);
    }
    return true;
  }

  std::vector<FixedGainMeans> take() && { return std::move(found_); }

private:
  void make_maps(const OutputMap& monitored, const VectorXd& largest) {
    const OpenModel open = open_model(model_, input_, monitored);
    std::vector<const MatrixXd*> of_process, of_measurement, of_monitored;
    for (const auto* number : numbers_) {
      if (!has_structure(*number)) break;
      of_process.push_back(&number->process);
      of_measurement.push_back(&number->measurement);
      of_monitored.push_back(&number->monitored);
    }
    ProcessModel process(model_), process_beside(model_);
    const Index points = 2 * (process.selection().rows() + std::ssize(varied_by(numbers_)));
    block_ = std::clamp(most_points / std::max<Index>(points, 1), Index{1}, most_samples);
    const VectorXd reach = steps_reach(largest);
    process_.emplace(model_, std::move(process), std::move(process_beside), open.process, of_process, numbers_, reach,
                     block_);
    MeasurementModel measurement(model_, sensor_outputs), measurement_beside(model_, sensor_outputs);
    const Index at_instant = measurement.selection().rows();
    measurement_.emplace(model_, std::move(measurement), std::move(measurement_beside), open.measurement,
                         of_measurement, numbers_, reach.head(at_instant), block_);
    if (monitored.size() == 0) return;
    monitored_.emplace(model_, MeasurementModel(model_, rows_of(monitored)),
                       MeasurementModel(model_, rows_of(monitored)), open.monitored, of_monitored, numbers_,
                       reach.head(at_instant), block_);
  }

  /// Arguments that stay at 0 get a length of their own; unknowns at least their prior deviation.
  [[nodiscard]] VectorXd steps_reach(const VectorXd& largest) const {
    const auto& layout = model_.layout();
    VectorXd reach = largest;
    for (Index i = 0; i < layout.unknowns; ++i) {
      const Index state = layout.unknown() + i, argument = layout.connector_states + i;
      reach[argument] = std::max(reach[argument], std::sqrt(model_.prior().covariance(state, state)));
    }
    return (reach.array() > 0.0).select(reach, 1e-3);
  }

  /// The inputs of the interval to sample k, from inputs or from what is added to them.
  [[nodiscard]] VectorXd interval_inputs(const MatrixXd& inputs, Index k) const {
    return inputs.middleCols((k - 1) * stride_, stride_ + 1).reshaped();
  }

  bool move_mean(Index begin, Index count) {
    for (Index at = 0; at < count; ++at) {
      const Index k = begin + at;
      if (k > 0) {
        set_inputs_to(k, input_, model_.options().instants(), process_->mean());
        if (!process_->image(state_, process_->mean().inputs(), at, predicted_)) return false;
        state_.swap(predicted_);
      }
      const VectorXd inputs = input_.inputs.col(k * stride_);
      measurement_->mean().set_inputs(inputs);
      if (!measurement_->image(state_, inputs, at, output_)) return false;
      input_.sample(k, innovation_);
      innovation_ -= output_;
      innovation_ = innovation_.array().isNaN().select(0.0, innovation_);
      state_.noalias() += gains_[static_cast<std::size_t>(k)] * innovation_;
      if (!monitored_) continue;
      monitored_->mean().set_inputs(inputs);
      if (!monitored_->image(state_, inputs, at, output_)) return false;
    }
    return true;
  }

  bool prepare(Index begin, Index count) {
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      const MatrixXd& added = numbers_[i]->inputs;
      for (Index at = 0; at < count && added.size() > 0; ++at) {
        const Index k = begin + at, number = static_cast<Index>(i);
        if (k > 0) process_->set_added(number, at, interval_inputs(added, k));
        measurement_->set_added(number, at, added.col(k * stride_));
        if (monitored_) monitored_->set_added(number, at, added.col(k * stride_));
      }
    }
    return process_->prepare(begin == 0 ? 1 : 0, count) && measurement_->prepare(0, count) &&
           (!monitored_ || monitored_->prepare(0, count));
  }

  void move_tangents(Index k, Index at) {
    if (k > 0) T_.swap(process_->tangents(at, T_));
    D_ = -measurement_->tangents(at, T_);
    input_.sample(k, innovation_);
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (const auto& measured = numbers_[i]->measured; measured.size() > 0)
        D_.col(static_cast<Index>(i)) += measured.col(k);
    for (Index channel = 0; channel < D_.rows(); ++channel)
      if (std::isnan(innovation_[channel])) D_.row(channel).setZero();
    T_.noalias() += gains_[static_cast<std::size_t>(k)] * D_;
    const MatrixXd* look = monitored_ ? &monitored_->tangents(at, T_) : nullptr;
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      auto& into = found_[order_[i]];
      const auto column = static_cast<Index>(i);
      into.innovation.col(k) = D_.col(column);
      into.unknowns.col(k) = T_.col(column).segment(model_.layout().unknown(), model_.layout().unknowns);
      if (look) into.monitored.col(k) = look->col(column);
      if (k == state_at_) into.state = T_.col(column);
    }
  }

  const AugmentedModel& model_;
  const FilterInput& input_;
  const Gains& gains_;
  Index state_at_, stride_, block_ = 1;
  std::vector<std::size_t> order_;             ///< numbers that change the open maps first
  std::vector<const RunDerivative*> numbers_;  ///< in this order
  std::optional<TangentMap<ProcessModel>> process_;
  std::optional<TangentMap<MeasurementModel>> measurement_, monitored_;
  VectorXd state_, predicted_, output_, innovation_;
  MatrixXd T_, D_;
  std::vector<FixedGainMeans> found_;
};

}  // namespace

OpenModel open_model(const AugmentedModel& augmented_model, const FilterInput& input, const OutputMap& monitored) {
  OpenModel open{ProcessModel(augmented_model).open(is_straight(augmented_model, input)),
                 MeasurementModel(augmented_model, sensor_outputs).open(),
                 MeasurementModel(augmented_model, rows_of(monitored)).open(),
                 {}};
  for (const auto& connector : augmented_model.system().connectors) open.laws.push_back(connector.parameters);
  return open;
}

std::optional<RunDerivative> central_difference(const OpenModel& here, const OpenModel& below, const OpenModel& above,
                                                double distance) {
  if (!same_size(here, below) || !same_size(here, above)) return std::nullopt;
  RunDerivative found{.process = (above.process.all - below.process.all) / distance,
                      .measurement = (above.measurement.all - below.measurement.all) / distance,
                      .monitored = (above.monitored.all - below.monitored.all) / distance};
  if (found.process.isZero(0.0) && found.measurement.isZero(0.0) && found.monitored.isZero(0.0))
    found.process = found.measurement = found.monitored = {};
  for (std::size_t j = 0; j < below.laws.size(); ++j)
    for (Index p = 0; p < below.laws[j].size(); ++p)
      if (const double change = above.laws[j][p] - below.laws[j][p]; change != 0.0)
        found.laws.push_back({{static_cast<Index>(j), p}, change / distance});
  return found;
}

bool has_tangents(const AugmentedModel& augmented_model) { return augmented_model.neighbours().empty(); }

std::optional<std::vector<FixedGainMeans>> run_tangents(const AugmentedModel& augmented_model, const FilterInput& input,
                                                        const Gains& gains, const OutputMap& monitored, Index state_at,
                                                        const VectorXd& largest,
                                                        const std::vector<RunDerivative>& numbers) {
  if (numbers.empty()) return std::vector<FixedGainMeans>{};
  TangentRun run(augmented_model, input, gains, monitored, state_at, largest, numbers);
  if (!run.run()) return std::nullopt;
  return std::move(run).take();
}

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/expression_law.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/system/laws/expression_lanes.hpp"
#include "kalfem/system/laws/expression_law_programs.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Columns of a thread, which grow once.
struct Workspace {
  ColumnTable table;
  AlignedColumns results;
  StageMemory stages;

  static Workspace& of_thread() {
    thread_local Workspace workspace;
    return workspace;
  }
};

/// Parts of a call of up to `points_together` points.
class LawCall {
public:
  LawCall(const LawPrograms& programs, const LawPoints& points, LawResponse& out)
      : programs_(programs), at_(programs.at), points_(points), out_(out), work_(Workspace::of_thread()) {
    grow();
    work_.table[results_base] = work_.results.data();
    set(constants_base, programs.constants.data());
  }

  /// The law at some points from `first` on.
  void respond(Index first, Index count) {
    point_to(first);
    if (programs_.of_parameters.size() > 1) run(programs_.of_parameters, work_.table, count);
    const bool moves = points_.duration != 0.0 && !at_.states.empty();
    if (moves) StateIntegration(programs_.rates, work_.table, work_.stages, count).advance(points_, first);
    run(programs_.of_force, work_.table, count);
    if (moves) add_states(first, count);
    for (std::size_t i = 0; i < at_.states.size(); ++i)
      std::copy_n(work_.table[variable(at_.states[i])], count, &out_.states(first, static_cast<Index>(i)));
    in_blocks(count, [force = &out_.force[first]]<class Points>(Index k) {
      const Points value = Block<Points>(force + k).value, zero{}, no_number = zero + none;
      const Points kept = value - value == zero ? value : no_number;  // infinity less infinity is no number
      store(kept, force + k);
    });
  }

private:
  void grow() {
    const auto size = static_cast<std::size_t>(programs_.result_count) * static_cast<std::size_t>(points_together);
    if (work_.results.size() < size) work_.results.resize(size);
    const auto columns = static_cast<std::size_t>(first_variable_base + programs_.variable_count + answer_count);
    if (work_.table.size() < columns) work_.table.resize(columns);
    if (!at_.states.empty()) work_.stages.resize(at_.states.size(), at_.signals.size());
  }

  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  static std::size_t variable(int number) { return static_cast<std::size_t>(first_variable_base + number); }

  void set(std::size_t base, const double* column) { work_.table[base] = const_cast<double*>(column); }  // only read

  /// Lets the table's variables and answers be the caller's columns from a point on.
  void point_to(Index first) {
    double** const table = work_.table.data() + first_variable_base;
    // A block's variables follow each other on the tape.
    const auto set_block = [&](const std::vector<int>& variables, const auto& block) {
      if (variables.empty()) return;
      auto* column = const_cast<double*>(block.data()) + first;  // only read
      const Index stride = block.outerStride(), count = std::ssize(variables);
      double** const entries = table + variables.front();
      for (Index i = 0; i < count; ++i) entries[i] = column + i * stride;
    };
    set(variable(at_.x), points_.deformation.data() + first);
    set(variable(at_.v), points_.rate.data() + first);
    set(variable(at_.a), points_.acceleration.data() + first);
    set_block(at_.parameters, points_.parameters);
    set_block(at_.states, points_.begin_states);
    if (points_.signals.cols() > 0) {
      set_block(at_.signals, points_.signals);
    } else {
      for (const int signal : at_.signals) set(variable(signal), zeros().data());
    }
    const std::size_t answers = variable(programs_.variable_count);
    work_.table[answers + force_answer] = out_.force.data() + first;
    work_.table[answers + stiffness_answer] = out_.stiffness.data() + first;
    work_.table[answers + damping_answer] = out_.damping.data() + first;
    work_.table[answers + inertance_answer] = out_.inertance.data() + first;
  }

  static const AlignedColumns& zeros() {
    static const AlignedColumns all(static_cast<std::size_t>(points_together), 0.0);
    return all;
  }

  /// The tangents also through the states, and no force where these have no solution.
  void add_states(Index first, Index count) {
    const auto& stages = work_.stages;
    const std::size_t states = at_.states.size();
    double *stiffness = &out_.stiffness[first], *damping = &out_.damping[first], *force = &out_.force[first];
    for (std::size_t i = 0; i < states; ++i) {
      const double *slope = column(work_.table, programs_.force_by_state[i]), *by_deformation = stages.by_motion[i],
                   *by_rate = stages.by_motion[states + i];
      for (Index k = 0; k < count; ++k) stiffness[k] += slope[k] * by_deformation[k];
      for (Index k = 0; k < count; ++k) damping[k] += slope[k] * by_rate[k];
    }
    const double* converged = stages.converged[0];
    for (Index k = 0; k < count; ++k) force[k] = converged[k] != 0.0 ? force[k] : none;
  }

  const LawPrograms& programs_;
  const CompiledExpressions& at_;
  const LawPoints& points_;
  LawResponse& out_;
  Workspace& work_;
};

class ExpressionLaw final : public ConnectorLaw {
public:
  explicit ExpressionLaw(const ExpressionLawOptions& options) : options_(options), programs_(options) {
    for (const auto& state : options.states) states_.push_back(state.quantity);
  }

  [[nodiscard]] const ExpressionLawOptions& options() const { return options_; }

  [[nodiscard]] std::string name() const override { return "expression"; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return options_.parameters; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return states_; }
  [[nodiscard]] const std::vector<LawQuantity>& signals() const override { return options_.signals; }
  [[nodiscard]] bool uses_acceleration() const override { return programs_.uses_acceleration; }
  [[nodiscard]] bool vectorised() const override { return true; }

  void respond(const LawPoints& points, LawResponse out) const override {
    const Index count = points.deformation.size();
    LawCall call(programs_, points, out);
    for (Index first = 0; first < count; first += points_together)
      call.respond(first, std::min(points_together, count - first));
  }

private:
  ExpressionLawOptions options_;
  std::vector<LawQuantity> states_;
  LawPrograms programs_;
};

}  // namespace

ConnectorLawPtr expression_law(const ExpressionLawOptions& options) {
  if (auto issues = find_issues(options); !issues.empty()) throw InvalidInput(std::move(issues));
  return std::make_shared<ExpressionLaw>(options);
}

const ExpressionLawOptions* expression_of(const ConnectorLaw& law) {
  const auto* expression = dynamic_cast<const ExpressionLaw*>(&law);
  return expression ? &expression->options() : nullptr;
}

}  // namespace kalfem

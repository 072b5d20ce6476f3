// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/system/connector_law.hpp"
#include "kalfem/system/laws/expression_program.hpp"

namespace kalfem {

/// How the rates s' = g(d, v, s) of m states and their derivatives are computed, and where they stand then: in columns
/// of `points_together` rows.
struct RatePrograms {
  ExpressionProgram of_motion;                                 ///< what depends on the motion and the signals alone
  ExpressionProgram rates;                                     ///< g and dg/ds
  ExpressionProgram tangents;                                  ///< dg/dd and dg/dv
  std::vector<Place> rate, by_deformation, by_rate, by_state;  ///< by_state: m x m, row by row
  int deformation = 0, motion_rate = 0;                        ///< numbers of the variables d and v
  std::vector<int> states, signals;                            ///< those of s and w
  bool linear = false;                                         ///< dg/ds does not depend on s
};

/// Columns of numbers at points, a row of columns for each state.
class StateColumns {
public:
  void attach(double* memory) { memory_ = memory; }
  double* operator[](std::size_t i) const { return memory_ + static_cast<Eigen::Index>(i) * points_together; }

private:
  double* memory_ = nullptr;
};

/// Memory of an integration, kept by a thread.
class StageMemory {
public:
  void resize(std::size_t states, std::size_t signals);

  StateColumns motion;                                                   ///< d, v and the signals within the interval
  StateColumns s, base, trial, residual, correction, middle, by_motion;  ///< middle, by_motion: by d, then by v
  StateColumns norm, trial_norm, ended, worse, weak, converged;          ///< one column each

private:
  AlignedColumns memory_;
};

/// Advances the states of a law over an interval at up to `points_together` points by the two-stage, second-order,
/// L-stable diagonally implicit Runge-Kutta method [Ale77] for s' = g(d, v, s), with the motion linear in between:
///     s_1 = s_0 + w h g(at w h, s_1),   s_2 = s_0 + (1 - w) h g(at w h, s_1) + w h g(at h, s_2),   w = 1 - 1/sqrt(2).
/// The derivatives by the motion at the end follow from both stages by the implicit function theorem:
///     (1 - w h dg/ds) ds_2 = (1 - w)/w ds_1 + w h (dg/dd, dg/dv).
class StateIntegration {
public:
  StateIntegration(const RatePrograms& programs, ColumnTable& table, StageMemory& memory, Eigen::Index count)
      : at_(programs),
        table_(table),
        memory_(memory),
        states_(programs.states.size()),
        count_(count),
        rows_((count + 7) / 8 * 8) {}

  /// From points.begin_states; the table's motion is that of the interval's end before and after. Leaves s,
  /// by_motion = [ds/dd, ds/dv] and converged = 1 or 0 in the memory, and the table's states there.
  void advance(const LawPoints& points, Eigen::Index first);

private:
  void set_motion_within(const LawPoints& points, Eigen::Index first);
  void set_motion_at_end(const LawPoints& points, Eigen::Index first);
  void set_states(const StateColumns& s);
  void set_column(int variable, const double* column);
  void solve_stage(double step);
  void take_tangents(double step, const StateColumns* before, double share);
  void evaluate(double step, const StateColumns& s, const StateColumns& norm);
  void correct(double step);
  [[nodiscard]] bool find_ended();
  [[nodiscard]] bool find_worse();
  void halve_where_worse();
  void finish_stage();
  template <std::size_t sides>
  void divide(double step, const StateColumns& right);
  template <std::size_t sides>
  void solve(double step, const StateColumns& right);
  template <std::size_t sides>
  void solve_weak(double step, const StateColumns& right);

  const RatePrograms& at_;
  ColumnTable& table_;
  StageMemory& memory_;
  std::size_t states_;
  Eigen::Index count_, rows_;  ///< points, and rows of the columns: in blocks of 8, the last ones without a meaning
};

}  // namespace kalfem

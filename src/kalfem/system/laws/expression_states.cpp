// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/expression_states.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "kalfem/system/laws/expression_lanes.hpp"
#include "kalfem/system/laws/expression_law.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr double weight = 0.29289321881345248;  ///< 1 - 1/sqrt(2), the L-stable choice
constexpr double reach = (1.0 - weight) / weight;
constexpr auto most_states = static_cast<std::size_t>(max_internal_states);

/// A column of a block, from a point on.
template <class Block>
const double* column_of(const Block& block, std::size_t i, Index first) {
  return block.data() + static_cast<Index>(i) * block.outerStride() + first;
}

/// Whether all flags are 1.
bool all_set(const double* flags, Index count) {
  bool all = true;
  for (Index i = 0; i < count; ++i) all &= flags[i] == 1.0;
  return all;
}

}  // namespace

void StageMemory::resize(std::size_t states, std::size_t signals) {
  const auto columns = 2 + signals + 9 * states + 6;
  const auto size = columns * static_cast<std::size_t>(points_together);
  if (memory_.size() < size) memory_.resize(size);
  double* next = memory_.data();
  const auto take = [&](StateColumns& block, std::size_t count) {
    block.attach(next);
    next += static_cast<Index>(count) * points_together;
  };
  take(motion, 2 + signals);
  for (auto* block : {&s, &base, &trial, &residual, &correction}) take(*block, states);
  for (auto* block : {&middle, &by_motion}) take(*block, 2 * states);
  for (auto* block : {&norm, &trial_norm, &ended, &worse, &weak, &converged}) take(*block, 1);
}

void StateIntegration::advance(const LawPoints& points, Index first) {
  const double step = weight * points.duration;
  for (std::size_t i = 0; i < states_; ++i)
    for (const auto* s : {&memory_.base, &memory_.s})
      std::copy_n(column_of(points.begin_states, i, first), count_, (*s)[i]);
  std::fill_n(memory_.converged[0], count_, 1.0);
  set_motion_within(points, first);
  solve_stage(step);
  take_tangents(step, nullptr, weight);
  std::swap(memory_.middle, memory_.by_motion);
  for (std::size_t i = 0; i < states_; ++i)  // the first stage's rate is its increment over w h
    for (Index k = 0; k < count_; ++k) memory_.base[i][k] += reach * (memory_.s[i][k] - memory_.base[i][k]);
  set_motion_at_end(points, first);
  solve_stage(step);
  take_tangents(step, &memory_.middle, 1.0);
}

void StateIntegration::set_column(int variable, const double* column) {
  table_[static_cast<std::size_t>(first_variable_base + variable)] = const_cast<double*>(column);  // only read
}

void StateIntegration::set_states(const StateColumns& s) {
  for (std::size_t i = 0; i < states_; ++i) set_column(at_.states[i], s[i]);
}

/// Motion and signals at the first stage's time.
void StateIntegration::set_motion_within(const LawPoints& points, Index first) {
  const auto interpolate = [&](int variable, const double* begin, const double* end, double* out) {
    for (Index i = 0; i < count_; ++i) out[i] = begin[i] + weight * (end[i] - begin[i]);
    set_column(variable, out);
  };
  interpolate(at_.deformation, points.begin_deformation.data() + first, points.deformation.data() + first,
              memory_.motion[0]);
  interpolate(at_.motion_rate, points.begin_rate.data() + first, points.rate.data() + first, memory_.motion[1]);
  if (points.signals.cols() == 0) return;
  for (std::size_t i = 0; i < at_.signals.size(); ++i)
    interpolate(at_.signals[i], column_of(points.begin_signals, i, first), column_of(points.signals, i, first),
                memory_.motion[2 + i]);
}

void StateIntegration::set_motion_at_end(const LawPoints& points, Index first) {
  set_column(at_.deformation, points.deformation.data() + first);
  set_column(at_.motion_rate, points.rate.data() + first);
  if (points.signals.cols() == 0) return;
  for (std::size_t i = 0; i < at_.signals.size(); ++i) set_column(at_.signals[i], column_of(points.signals, i, first));
}

// Newton's method at all points together. A step is halved at the points where it makes the residual larger, as laws
// with powers and kinks can send the first steps far away. The end is judged by the correction, whose square is the
// error that it leaves; a point that has ended is evaluated where it was, so that its neighbours change nothing there.
/// Damped Newton iteration on s = base + step g(s), from s and into s. The programs' columns are left where the last
/// corrections were computed.
void StateIntegration::solve_stage(double step) {
  constexpr int max_iterations = 50, max_halvings = 20;
  run(at_.of_motion, table_, count_);
  evaluate(step, memory_.s, memory_.norm);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    correct(step);
    if (find_ended()) break;
    for (int halving = 0;; ++halving) {
      evaluate(step, memory_.trial, memory_.trial_norm);
      if (halving == max_halvings || !find_worse()) break;
      halve_where_worse();
    }
    std::swap(memory_.s, memory_.trial);
    std::swap(memory_.norm, memory_.trial_norm);
  }
  finish_stage();
}

/// Rates with their derivatives, the residual s - base - step g(s) and its square.
void StateIntegration::evaluate(double step, const StateColumns& s, const StateColumns& norm) {
  set_states(s);
  run(at_.rates, table_, count_);
  in_widest_blocks(rows_, [&]<class Points>(Index k) KALFEM_INLINE {
    Points sum{};
    for (std::size_t i = 0; i < states_; ++i) {
      const Points residual = Block<Points>(s[i] + k).value - Block<Points>(memory_.base[i] + k).value -
                              step * Block<Points>(column(table_, at_.rate[i]) + k).value;
      store(residual, memory_.residual[i] + k);
      sum = sum + residual * residual;
    }
    store(sum, norm[0] + k);
  });
}

/// Newton's corrections of all points.
void StateIntegration::correct(double step) {
  for (std::size_t i = 0; i < states_; ++i) std::copy_n(memory_.residual[i], count_, memory_.correction[i]);
  solve<1>(step, memory_.correction);
}

/// Marks the points that have ended and moves the trial states of the others. True: all have.
bool StateIntegration::find_ended() {
  const bool linear = at_.linear;
  in_widest_blocks(rows_, [&]<class Points>(Index k) KALFEM_INLINE {
    const Points no{}, yes = no + 1.0;
    Points ended = yes;
    for (std::size_t i = 0; i < states_; ++i) {
      const Points s = Block<Points>(memory_.s[i] + k).value, c = Block<Points>(memory_.correction[i] + k).value;
      const Points size = c < no ? -c : c, scale = s < no ? -s : s, limit = 1e-8 * scale + 1e-300;
      ended = size <= limit ? ended : no;
    }
    const Points norm = Block<Points>(memory_.norm[0] + k).value;
    ended = norm == norm ? ended : yes;  // without a number there is no way on
    if (linear) ended = yes;
    store(ended, memory_.ended[0] + k);
    for (std::size_t i = 0; i < states_; ++i) {
      const Points s = Block<Points>(memory_.s[i] + k).value,
                   moved = s - Block<Points>(memory_.correction[i] + k).value;
      const Points trial = ended == yes ? s : moved;
      store(trial, memory_.trial[i] + k);
    }
  });
  return all_set(memory_.ended[0], count_);
}

/// Marks the points at which the trial states have a larger residual. True: some have.
bool StateIntegration::find_worse() {
  bool any = false;
  for (Index k = 0; k < count_; ++k) {
    const double before = memory_.norm[0][k];
    const bool worse = memory_.ended[0][k] == 0.0 && !(memory_.trial_norm[0][k] < before) && before > 0.0;
    memory_.worse[0][k] = worse ? 1.0 : 0.0;
    any |= worse;
  }
  return any;
}

void StateIntegration::halve_where_worse() {
  for (std::size_t i = 0; i < states_; ++i)
    for (Index k = 0; k < count_; ++k) {
      if (memory_.worse[0][k] == 0.0) continue;
      memory_.correction[i][k] *= 0.5;
      memory_.trial[i][k] = memory_.s[i][k] - memory_.correction[i][k];
    }
}

/// Applies the last corrections, and says which points are solved.
void StateIntegration::finish_stage() {
  for (Index k = 0; k < count_; ++k) {
    const bool ended = memory_.ended[0][k] == 1.0;
    double size = 0.0;
    bool finite = true;
    for (std::size_t i = 0; i < states_; ++i) {
      double& s = memory_.s[i][k];
      if (ended) s -= memory_.correction[i][k];
      finite &= std::isfinite(s);
      size += s * s;
    }
    if (!finite || !(ended || std::sqrt(memory_.norm[0][k]) <= 1e-9 * std::sqrt(size))) memory_.converged[0][k] = 0.0;
  }
}

/// by_motion: the solution of (1 - step dg/ds) by_motion = reach before + share step (dg/dd, dg/dv).
void StateIntegration::take_tangents(double step, const StateColumns* before, double share) {
  run(at_.tangents, table_, count_);
  for (std::size_t i = 0; i < 2 * states_; ++i) {
    const Place place = i < states_ ? at_.by_deformation[i] : at_.by_rate[i - states_];
    const double* slope = column(table_, place);
    double* out = memory_.by_motion[i];
    for (Index k = 0; k < count_; ++k) out[k] = share * step * slope[k];
    if (before == nullptr) continue;
    const double* middle = (*before)[i];
    for (Index k = 0; k < count_; ++k) out[k] += reach * middle[k];
  }
  solve<2>(step, memory_.by_motion);
}

/// The solution for one state.
template <std::size_t sides>
void StateIntegration::divide(double step, const StateColumns& right) {
  const double* by_state = column(table_, at_.by_state.front());
  in_widest_blocks(rows_, [&]<class Points>(Index first) KALFEM_INLINE {
    const Points slope = Block<Points>(by_state + first).value, inverse = 1.0 / (1.0 - step * slope);
    for (std::size_t side = 0; side < sides; ++side) {
      const Points x = Block<Points>(right[side] + first).value * inverse;
      store(x, right[side] + first);
    }
  });
}

// The matrix is near the identity where steps are short, so rows are exchanged only where a pivot turns out small.
/// Solves (1 - step dg/ds) x = right at each point, into `right`: `sides` right-hand sides one after the other.
template <std::size_t sides>
void StateIntegration::solve(double step, const StateColumns& right) {
  constexpr double least_pivot = 1e-3;
  const std::size_t n = states_;
  if (n == 1) return divide<sides>(step, right);
  in_widest_blocks(rows_, [&]<class Points>(Index first) KALFEM_INLINE {
    const Points zero{}, one = zero + 1.0;
    const auto magnitude = [&](const Points& x, Points& out) KALFEM_INLINE { out = x < zero ? -x : x; };
    std::array<std::array<Points, most_states>, most_states> m;
    std::array<std::array<Points, most_states>, sides> x;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j)
        m[i][j] = (i == j ? one : zero) - step * Block<Points>(column(table_, at_.by_state[i * n + j]) + first).value;
      for (std::size_t side = 0; side < sides; ++side) x[side][i] = Block<Points>(right[side * n + i] + first).value;
    }
    Points weak = zero;
    for (std::size_t k = 0; k < n; ++k) {
      Points pivot, largest, other;
      magnitude(m[k][k], pivot);
      largest = pivot;
      for (std::size_t j = k + 1; j < n; ++j) {
        magnitude(m[k][j], other);
        largest = largest < other ? other : largest;
      }
      const Points limit = least_pivot * largest;
      weak = pivot >= limit ? weak : one;
      const Points inverse = one / m[k][k];
      for (std::size_t i = k + 1; i < n; ++i) {
        const Points factor = m[i][k] * inverse;
        for (std::size_t j = k + 1; j < n; ++j) m[i][j] = m[i][j] - factor * m[k][j];
        for (auto& side : x) side[i] = side[i] - factor * side[k];
      }
      m[k][k] = inverse;
    }
    store(weak, memory_.weak[0] + first);
    for (std::size_t k = n; k-- > 0;)
      for (auto& side : x) {
        for (std::size_t j = k + 1; j < n; ++j) side[k] = side[k] - m[k][j] * side[j];
        side[k] = side[k] * m[k][k];
      }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t side = 0; side < sides; ++side) {
        const Points before = Block<Points>(right[side * n + i] + first).value;
        const Points kept = weak == zero ? x[side][i] : before;
        store(kept, right[side * n + i] + first);
      }
    }
  });
  solve_weak<sides>(step, right);
}

/// The same with row exchanges at the points that are marked weak.
template <std::size_t sides>
void StateIntegration::solve_weak(double step, const StateColumns& right) {
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_internal_states, max_internal_states>;
  using Sides = Eigen::Matrix<double, Eigen::Dynamic, sides, 0, max_internal_states, sides>;
  const auto n = static_cast<Index>(states_);
  for (Index k = 0; k < count_; ++k) {
    if (memory_.weak[0][k] == 0.0) continue;
    Square matrix(n, n);
    Sides x(n, static_cast<Index>(sides));
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j)
        matrix(i, j) =
            (i == j ? 1.0 : 0.0) - step * column(table_, at_.by_state[static_cast<std::size_t>(i * n + j)])[k];
      for (std::size_t side = 0; side < sides; ++side)
        x(i, static_cast<Index>(side)) = right[side * states_ + static_cast<std::size_t>(i)][k];
    }
    x = Eigen::PartialPivLU<Square>(matrix).solve(x).eval();
    for (Index i = 0; i < n; ++i)
      for (std::size_t side = 0; side < sides; ++side)
        right[side * states_ + static_cast<std::size_t>(i)][k] = x(i, static_cast<Index>(side));
  }
}

}  // namespace kalfem

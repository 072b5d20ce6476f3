// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/force_correction.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <limits>

#include "kalfem/base/vector_loops.hpp"

namespace kalfem {

using Eigen::ArrayXXd;
using Eigen::Index;

// Arrays hold one column a connector and quantity, one row a point; each law is called with views of its columns, made
// once. A law that works point by point is not asked for points that only repeat others (PointBlocks fills the last
// block of lanes with repeated points): it is called for the whole blocks and the rest, and its answers are copied.
ConnectorResponse::ConnectorResponse(const std::vector<Connector>& connectors, const PointBlocks& blocks,
                                     Index instants)
    : blocks_(blocks), instants_(instants) {
  std::vector<Columns> columns;
  Index parameter_count = 0, state_count = 0;
  for (const auto& connector : connectors) {
    const auto states_here = static_cast<Index>(connector.law->states().size());
    laws_.push_back(connector.law);
    columns.push_back({static_cast<Index>(columns.size()), parameter_count, connector.parameters.size(), state_count,
                       states_here, static_cast<Index>(connector.law->signals().size())});
    parameter_count += connector.parameters.size();
    state_count += states_here;
  }
  const auto m = static_cast<Index>(connectors.size());
  parameters = ArrayXXd::Zero(blocks.rows, parameter_count);
  begin_motion = ArrayXXd::Zero(blocks.rows, 2 * m);
  for (auto* array : {&motion, &tangents}) *array = ArrayXXd::Zero(blocks.rows, 3 * m);
  for (auto* array : {&begin_states, &states}) *array = ArrayXXd::Zero(blocks.rows, state_count);
  force = ArrayXXd::Zero(blocks.rows, m);
  if (instants > 1 && state_count > 0) {
    whole_force_ = force;
    whole_tangents_ = tangents;
    whole_states_ = states;
  }

  for (const auto& at : columns) {
    const auto& law = *laws_[static_cast<std::size_t>(at.connector)];
    if (law.vectorised() || blocks.repeated() == 0) {
      add_call(law, at, 0, blocks.rows);
    } else {
      const Index rest = blocks.points - blocks.whole();
      add_call(law, at, 0, blocks.whole());
      add_call(law, at, blocks.rows - rest, rest);
      repeated_.push_back(at);
    }
  }
}

void ConnectorResponse::add_call(const ConnectorLaw& law, const Columns& at, Index first_row, Index row_count) {
  const Index m = force.cols(), j = at.connector, of_instant = m / instants_;
  const auto column = [&](ArrayXXd& of, Index index) { return of.col(index).segment(first_row, row_count); };
  const auto columns = [&](ArrayXXd& of, Index index, Index count) {
    return of.block(first_row, index, row_count, count);
  };
  // The signals of a law are the deformations of the connectors that follow its own.
  const auto signals = [&](ArrayXXd& of) {
    if (at.signal_count == 0 || j % of_instant + at.signal_count >= of_instant) return no_signals();
    return LawSignals(&of(first_row, j + 1), row_count, at.signal_count, Eigen::OuterStride<>(of.rows()));
  };
  calls_.push_back({&law,
                    {0.0, columns(parameters, at.parameter, at.parameter_count), column(begin_motion, j),
                     column(begin_motion, m + j), columns(begin_states, at.state, at.state_count), column(motion, j),
                     column(motion, m + j), column(motion, 2 * m + j), signals(begin_motion), signals(motion)},
                    {column(force, j), column(tangents, j), column(tangents, m + j), column(tangents, 2 * m + j),
                     columns(states, at.state, at.state_count)}});
  if (instants_ > 1 && at.state_count > 0 && j >= of_instant) add_whole_call(calls_.back(), at, first_row, row_count);
}

/// The same with the begin of the first instant's connector.
void ConnectorResponse::add_whole_call(const Call& second, const Columns& at, Index first_row, Index row_count) {
  const Index m = force.cols(), j = at.connector, first = j - m / instants_,
              first_state = at.state - states.cols() / instants_;
  const auto column = [&](ArrayXXd& of, Index index) { return of.col(index).segment(first_row, row_count); };
  const auto columns = [&](ArrayXXd& of, Index index, Index count) {
    return of.block(first_row, index, row_count, count);
  };
  const LawPoints& end = second.points;
  const auto begin_signals = end.signals.cols() == 0
                                 ? no_signals()
                                 : LawSignals(&begin_motion(first_row, first + 1), row_count, at.signal_count,
                                              Eigen::OuterStride<>(begin_motion.rows()));
  second_calls_.push_back(second);
  whole_calls_.push_back({second.law,
                          {0.0, end.parameters, column(begin_motion, first), column(begin_motion, m + first),
                           columns(begin_states, first_state, at.state_count), end.deformation, end.rate,
                           end.acceleration, begin_signals, end.signals},
                          {column(whole_force_, j), column(whole_tangents_, j), column(whole_tangents_, m + j),
                           column(whole_tangents_, 2 * m + j), columns(whole_states_, at.state, at.state_count)}});
}

void ConnectorResponse::respond(double duration) {
  const auto of_instant = calls_.size() / static_cast<std::size_t>(instants_);
  for (std::size_t i = 0; i < calls_.size(); ++i) {
    if (i > 0 && i % of_instant == 0 && states.cols() > 0) begin_where_ended();
    auto& call = calls_[i];
    call.points.duration = duration;
    call.law->respond(call.points, call.response);
  }
  extrapolate(duration);
  for (const auto& at : repeated_) repeat_points(at);
}

void ConnectorResponse::begin_where_ended() {
  const Index all = force.cols(), m = all / 2, s = states.cols() / 2;
  for (Index derivative = 0; derivative < 2; ++derivative)
    begin_motion.middleCols(derivative * all + m, m) = motion.middleCols(derivative * all, m);
  begin_states.rightCols(s) = states.leftCols(s);
}

void ConnectorResponse::extrapolate(double duration) {
  for (std::size_t i = 0; i < whole_calls_.size(); ++i) {
    auto& [law, points, whole] = whole_calls_[i];
    points.duration = 2.0 * duration;
    law->respond(points, whole);
    LawResponse& halves = second_calls_[i].response;
    const auto improve = [](auto& of_halves, const auto& of_whole) { of_halves += (of_halves - of_whole) / 3.0; };
    improve(halves.force, whole.force);
    improve(halves.stiffness, whole.stiffness);
    improve(halves.damping, whole.damping);
    improve(halves.inertance, whole.inertance);
    improve(halves.states, whole.states);
  }
}

/// A law that goes from point to point is not asked for the repeated ones.
void ConnectorResponse::repeat_points(const Columns& at) {
  const Index m = force.cols(), count = blocks_.repeated(), to = blocks_.whole(), from = to - count;
  const auto repeat = [&](ArrayXXd& of, Index column) {
    of.col(column).segment(to, count) = of.col(column).segment(from, count);
  };
  repeat(force, at.connector);
  for (Index kind = 0; kind < 3; ++kind) repeat(tangents, kind * m + at.connector);
  for (Index i = 0; i < at.state_count; ++i) repeat(states, at.state + i);
}

namespace {

// Every operation rounds by itself: what the compiler joins depends on how it arranges a loop.
#if defined(__clang__)
#pragma clang fp contract(off)
#endif

using Eigen::Dynamic;

/// Smallest pivot without row exchanges, as a share of its row's largest entry: at worst two digits of the correction
/// are lost, which the next one makes good.
constexpr double least_pivot = 1e-2;

/// The numbers of a block of lanes, in registers; the compiler would not keep an Eigen array there.
template <int width>
struct BlockOf {
  typedef double type __attribute__((vector_size(width * sizeof(double))));
  typedef std::int64_t bits __attribute__((vector_size(width * sizeof(double))));
};
template <int width>
using Block = typename BlockOf<width>::type;

template <int width>
KALFEM_INLINE inline Block<width> read(const double* values) {
  Block<width> block;
  std::memcpy(&block, values, sizeof block);  // columns need not stand on a register's boundary
  return block;
}
template <int width>
KALFEM_INLINE inline void write(double* values, const Block<width>& block) {
  std::memcpy(values, &block, sizeof block);
}
template <int width>
KALFEM_INLINE inline Block<width> magnitude(const Block<width>& block) {
  using Bits = typename BlockOf<width>::bits;
  return (Block<width>)((Bits)block & std::numeric_limits<std::int64_t>::max());  // without the signs
}
/// The larger one; `b` where one of the two is not a number.
template <int width>
KALFEM_INLINE inline Block<width> larger(const Block<width>& a, const Block<width>& b) {
  return a > b ? a : b;
}
/// What is above zero of it, or not a number.
template <int width>
KALFEM_INLINE inline Block<width> above_zero(const Block<width>& block) {
  return larger<width>(Block<width>{}, block);
}
template <int width>
KALFEM_INLINE inline double sum_of(const Block<width>& block) {
  Lanes<width> lanes;
  write<width>(lanes.data(), block);
  return lanes.sum();
}

/// An array of blocks: in registers where its size is known.
template <int count, int width>
struct BlockArray {
  KALFEM_INLINE explicit BlockArray(double* /*storage*/) {}
  KALFEM_INLINE Block<width>& operator[](Index i) { return values[static_cast<std::size_t>(i)]; }
  std::array<Block<width>, static_cast<std::size_t>(count)> values;
};

template <int width>
struct BlockArray<Dynamic, width> {
  KALFEM_INLINE explicit BlockArray(double* storage) : values(storage) {}
  KALFEM_INLINE Block<width>& operator[](Index i) { return *reinterpret_cast<Block<width>*>(values + width * i); }
  double* values;
};

constexpr int times(int a, int b) { return a == Dynamic || b == Dynamic ? Dynamic : a * b; }

// One Newton correction of the connector forces at many points at once. At a point the motion k = k_free + H f follows
// from the forces f, and the laws give g(k), with the tangents T = dg/dk. The residual g(k) - f is brought down by
//     (1 - T H) df = g(k) - f,     f <- f + df,     k <- k_free + H f.
// One SIMD lane is one point: the m x m systems (m connectors, few) of all lanes are eliminated side by side, without
// row exchanges. Steps for a block of lanes:
//   1. assemble 1 - T H and the residual, with the largest entry of each row;
//   2. keep the residual, and note where it grew against the one before;
//   3. eliminate; where a pivot is too small for some lane, solve each lane of the block by LU with row exchanges;
//   4. apply the correction, note where it exceeds the tolerance, and move k.
/// 1 - T H and the right-hand side at a block of points.
template <int connectors, int width>
class LaneSystem {
public:
  KALFEM_INLINE LaneSystem(Index size, double* storage)
      : size_(size),
        matrix_(storage),
        right_(storage + size * size * width),
        scale_(storage + size * (size + 1) * width) {}

  [[nodiscard]] KALFEM_INLINE Index size() const { return connectors == Dynamic ? size_ : connectors; }
  /// The right-hand side: residuals, then corrections, then corrected forces.
  KALFEM_INLINE decltype(auto) right(Index i) { return right_[i]; }

  KALFEM_INLINE void assemble(const ForceIterate& at, Index first) {
    const Index m = size(), rows = at.rows;
    const double *H = at.compliance, *tangents = at.tangents + first;
#pragma GCC unroll 4
    for (Index i = 0; i < m; ++i) {
      const Block<width> by_d = read<width>(tangents + i * rows), by_v = read<width>(tangents + (m + i) * rows),
                         by_a = read<width>(tangents + (2 * m + i) * rows);
      Block<width> largest = {};
#pragma GCC unroll 4
      for (Index k = 0; k < m; ++k) {
        const double* column = H + 3 * m * k;
        Block<width> entry = (i == k ? 1.0 : 0.0) - (by_d * column[i] + by_v * column[m + i]);
        if (at.uses_acceleration) entry -= by_a * column[2 * m + i];
        largest = larger<width>(largest, magnitude<width>(entry));
        entry_(i, k) = entry;
      }
      scale_[i] = largest;
      right_[i] = read<width>(at.law_force + first + i * rows) - read<width>(at.force + first + i * rows);
    }
  }

  /// Solves in place; false when some pivot is too small to go without row exchanges.
  [[nodiscard]] KALFEM_INLINE bool eliminate() {
    const Index m = size();
    Block<width> weakness = {};
#pragma GCC unroll 4
    for (Index k = 0; k < m; ++k) {
      weakness += above_zero<width>(least_pivot * scale_[k] - magnitude<width>(entry_(k, k)));
      const Block<width> inverse = 1.0 / entry_(k, k);
      entry_(k, k) = inverse;
#pragma GCC unroll 4
      for (Index i = k + 1; i < m; ++i) {
        const Block<width> factor = entry_(i, k) * inverse;
#pragma GCC unroll 4
        for (Index j = k + 1; j < m; ++j) entry_(i, j) -= factor * entry_(k, j);
        right_[i] -= factor * right_[k];
      }
    }
#pragma GCC unroll 4
    for (Index i = m - 1; i >= 0; --i) {
      Block<width> rest = right_[i];
#pragma GCC unroll 4
      for (Index j = i + 1; j < m; ++j) rest -= entry_(i, j) * right_[j];
      right_[i] = rest * entry_(i, i);
    }
    return connectors == 1 || sum_of<width>(weakness) == 0.0;
  }

private:
  KALFEM_INLINE decltype(auto) entry_(Index i, Index k) { return matrix_[i * size() + k]; }

  Index size_;
  BlockArray<times(connectors, connectors), width> matrix_;
  BlockArray<connectors, width> right_, scale_;
};

/// Columns of k_free + H f from `column` up to `end`; force(k) is f_k at the block.
template <int connectors, int width, class Force>
KALFEM_INLINE inline void move_block(const ForceIterate& at, const Force& force, Index first, Index column, Index end) {
  const Index m = connectors == Dynamic ? at.connectors : connectors, rows = at.rows;
#pragma GCC unroll 12
  for (Index i = column; i < end; ++i) {
    Block<width> sum = read<width>(at.free_motion + first + i * rows);
#pragma GCC unroll 4
    for (Index k = 0; k < m; ++k) sum += at.compliance[i + 3 * m * k] * force(k);
    write<width>(at.next_motion + first + i * rows, sum);
  }
}

/// Sums of what exceeds its limit, lane by lane: zero where nothing does, NaN where something is not defined.
template <int width>
struct Excess {
  Block<width> growth = {}, correction = {};
  [[nodiscard]] KALFEM_INLINE CorrectionJudgement judge() const {
    return {sum_of<width>(growth) > 0.0, !(sum_of<width>(correction) > 0.0)};
  }
};

}  // namespace

template <int connectors, int width>
struct ForceCorrection::Kernels {
  static void move(const ForceIterate& iterate, Index column, Index end) {
    in_widest_registers([&]() KALFEM_INLINE { move_points(iterate, column, end); });
  }

  static CorrectionJudgement correct(const ForceIterate& iterate, ForceCorrection& self) {
    return in_widest_registers([&]() KALFEM_INLINE { return correct_points(iterate, self); });
  }

private:
  KALFEM_INLINE static void move_points(const ForceIterate& iterate, Index column, Index end) {
    const ForceIterate at = iterate;  // a copy of its own cannot alias the outputs
    for (Index first = 0; first < at.rows; first += width) {
      if constexpr (connectors == Dynamic) {
        const auto force = [&](Index k) KALFEM_INLINE { return read<width>(at.force + first + k * at.rows); };
        move_block<connectors, width>(at, force, first, column, end);
      } else {
        std::array<Block<width>, connectors> forces;
        for (std::size_t k = 0; k < connectors; ++k)
          forces[k] = read<width>(at.force + first + static_cast<Index>(k) * at.rows);
        const auto force = [&](Index k) KALFEM_INLINE -> const auto& { return forces[static_cast<std::size_t>(k)]; };
        move_block<connectors, width>(at, force, first, column, end);
      }
    }
  }

  KALFEM_INLINE static CorrectionJudgement correct_points(const ForceIterate& iterate, ForceCorrection& self) {
    const ForceIterate at = iterate;  // a copy of its own cannot alias the outputs
    LaneSystem<connectors, width> system(at.connectors, self.lane_storage_.data());
    Excess<width> excess;
    for (Index first = 0; first < at.rows; first += width) {
      system.assemble(at, first);
      keep_residuals(at, first, system, excess);
      if (!system.eliminate()) [[unlikely]]
        exchange_rows(iterate, first, system, self);
      apply_corrections(at, first, system, excess);
      const auto force = [&](Index k) KALFEM_INLINE -> decltype(auto) { return system.right(k); };
      const Index m = system.size();
      move_block<connectors, width>(at, force, first, 0, 2 * m);
      if (at.uses_acceleration) move_block<connectors, width>(at, force, first, 2 * m, 3 * m);
    }
    return excess.judge();
  }

  KALFEM_INLINE static void keep_residuals(const ForceIterate& at, Index first, LaneSystem<connectors, width>& system,
                                           Excess<width>& excess) {
    const Index m = system.size();
#pragma GCC unroll 4
    for (Index j = 0; j < m; ++j) {
      const Index offset = first + j * at.rows;
      const Block<width> residual = magnitude<width>(system.right(j));
      const Block<width> limit = 2.0 * read<width>(at.previous_residual + offset) +
                                 at.tolerance * (magnitude<width>(read<width>(at.force + offset)) + at.floor);
      excess.growth += above_zero<width>(residual - limit);
      write<width>(at.residual + offset, residual);
    }
  }

  KALFEM_INLINE static void apply_corrections(const ForceIterate& at, Index first,
                                              LaneSystem<connectors, width>& system, Excess<width>& excess) {
    const Index m = system.size();
#pragma GCC unroll 4
    for (Index j = 0; j < m; ++j) {
      const Index offset = first + j * at.rows;
      const Block<width> correction = system.right(j), force = read<width>(at.force + offset) + correction;
      excess.correction +=
          above_zero<width>(magnitude<width>(correction) - at.tolerance * (magnitude<width>(force) + at.floor));
      write<width>(at.correction + offset, correction);
      write<width>(at.next_force + offset, force);
      system.right(j) = force;
    }
  }

  static void exchange_rows(const ForceIterate& at, Index first, LaneSystem<connectors, width>& system,
                            ForceCorrection& self) {
    for (int lane = 0; lane < width; ++lane) {
      const auto& correction = self.solve_with_exchanges(at, first + lane);
      for (Index j = 0; j < system.size(); ++j) system.right(j)[lane] = correction[j];
    }
  }
};

template <int connectors>
void ForceCorrection::choose(const PointBlocks& blocks) {
  blocks.with_width([this](auto width) {
    correct_ = &Kernels<connectors, width()>::correct;
    move_ = &Kernels<connectors, width()>::move;
  });
}

ForceCorrection::ForceCorrection(Index connectors, const PointBlocks& blocks)
    : jacobian_(connectors, connectors), factor_(connectors), one_residual_(connectors), one_correction_(connectors) {
  switch (connectors) {
    case 1:
      choose<1>(blocks);
      break;
    case 2:
      choose<2>(blocks);
      break;
    case 3:
      choose<3>(blocks);
      break;
    case 4:
      choose<4>(blocks);
      break;
    default:
      choose<Dynamic>(blocks);
      lane_storage_.resize(static_cast<std::size_t>(blocks.width * connectors * (connectors + 2)));
  }
}

const Eigen::VectorXd& ForceCorrection::solve_with_exchanges(const ForceIterate& at, Index point) {
  const Index m = at.connectors;
  const Eigen::Map<const Eigen::MatrixXd> compliance(at.compliance, 3 * m, m);
  const auto tangent = [&](Index column) { return at.tangents[point + column * at.rows]; };
  for (Index i = 0; i < m; ++i) {
    jacobian_.row(i) = -(tangent(i) * compliance.row(i) + tangent(m + i) * compliance.row(m + i) +
                         tangent(2 * m + i) * compliance.row(2 * m + i));
    jacobian_(i, i) += 1.0;
    one_residual_[i] = at.law_force[point + i * at.rows] - at.force[point + i * at.rows];
  }
  factor_.compute(jacobian_);
  one_correction_ = factor_.solve(one_residual_);
  return one_correction_;
}

}  // namespace kalfem

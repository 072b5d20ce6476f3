// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <type_traits>
#include <vector>

#include "kalfem/system/locally_nonlinear_system.hpp"

namespace kalfem {

/// The same quantity at `width` neighbouring points, one point per lane of the vector registers.
template <int width>
using Lanes = Eigen::Array<double, width, 1>;

template <int width>
auto load(const double* values) {
  return Eigen::Map<const Lanes<width>>(values);
}

template <int width>
auto store(double* values) {
  return Eigen::Map<Lanes<width>>(values);
}

/// N points in whole blocks of `width`. Where the width does not divide N, the last block begins inside the one before:
/// its points stand in both, so that loops over blocks have no remainder and every lane holds a point.
struct PointBlocks {
  static constexpr Eigen::Index widest = 8;  ///< a register of 64 bytes, or several smaller ones

  explicit PointBlocks(Eigen::Index points_)
      : points(points_),
        width(points >= widest ? widest
              : points >= 4    ? 4
                               : 1),
        rows((points + width - 1) / width * width) {}

  Eigen::Index points;  ///< N
  Eigen::Index width;   ///< 8, 4 or 1
  Eigen::Index rows;    ///< rows of an array in blocks

  /// First rows that are points in their order; the `repeated()` rows after these stand before them, too.
  [[nodiscard]] Eigen::Index whole() const { return points / width * width; }
  [[nodiscard]] Eigen::Index repeated() const { return rows - points; }

  /// Calls work with the width as a constant.
  template <class Work>
  void with_width(const Work& work) const {
    if (width == widest)
      work(std::integral_constant<int, int{widest}>{});
    else if (width == 4)
      work(std::integral_constant<int, 4>{});
    else
      work(std::integral_constant<int, 1>{});
  }

  /// Columns of N rows into columns of blocks.
  void spread(const double* from, double* to, Eigen::Index columns) const {
    with_width([&](auto wide) { copy<wide()>(from, points, points - wide(), to, rows, rows, columns); });
  }
  /// The reverse.
  void collect(const double* from, double* to, Eigen::Index columns) const {
    with_width([&](auto wide) { copy<wide()>(from, rows, rows, to, points, points - wide(), columns); });
  }

private:
  template <int wide>
  void copy(const double* from, Eigen::Index from_stride, Eigen::Index from_last, double* to, Eigen::Index to_stride,
            Eigen::Index to_last, Eigen::Index columns) const {
    for (Eigen::Index column = 0; column < columns; ++column, from += from_stride, to += to_stride)
      for (Eigen::Index row = 0; row < rows; row += wide)
        store<wide>(to + std::min(row, to_last)) = load<wide>(from + std::min(row, from_last));
  }
};

/// Arrays of all connector laws in blocks of points, and the calls of the laws on them. Rows are those of the blocks.
/// The laws' arguments point into the arrays: these keep their size and place.
/// The connectors may be the same ones at two instants, those of an instant together: the second ones begin with the
/// motion and the states at which the first ones end. Laws integrate their states with an error of second order, so
/// that what a law with states answers at the second instant is Richardson's extrapolation (4 a - b) / 3 of that answer
/// a and of the answer b over the whole of both intervals.
class ConnectorResponse {
public:
  ConnectorResponse(const std::vector<Connector>& connectors, const PointBlocks& blocks, Eigen::Index instants = 1);
  ConnectorResponse(const ConnectorResponse&) = delete;
  ConnectorResponse& operator=(const ConnectorResponse&) = delete;

  Eigen::ArrayXXd parameters;    ///< of all laws one after the other, input
  Eigen::ArrayXXd begin_motion;  ///< [d, d'] at the interval's begin, 2m columns, input
  Eigen::ArrayXXd begin_states;  ///< of all laws, input
  Eigen::ArrayXXd motion;        ///< [d, d', d''] at the interval's end, 3m columns, input
  Eigen::ArrayXXd force;         ///< m columns, output
  Eigen::ArrayXXd tangents;      ///< [df/dd, df/dd', df/dd''], 3m columns, output
  Eigen::ArrayXXd states;        ///< at the interval's end, output

  /// Forces, tangents and states at the end of an interval of the given duration, which is each one's of several.
  void respond(double duration);

private:
  /// Where a connector's columns stand in the arrays.
  struct Columns {
    Eigen::Index connector, parameter, parameter_count, state, state_count, signal_count;
  };
  struct Call {
    const ConnectorLaw* law;
    LawPoints points;
    LawResponse response;
  };
  void add_call(const ConnectorLaw& law, const Columns& at, Eigen::Index first_row, Eigen::Index row_count);
  void add_whole_call(const Call& second, const Columns& at, Eigen::Index first_row, Eigen::Index row_count);
  void repeat_points(const Columns& at);
  void begin_where_ended();
  void extrapolate(double duration);

  PointBlocks blocks_;
  std::vector<ConnectorLawPtr> laws_;
  std::vector<Call> calls_;
  Eigen::Index instants_;           ///< 1 or 2
  std::vector<Call> whole_calls_;   ///< over both intervals, with answers of their own
  std::vector<Call> second_calls_;  ///< that they improve
  Eigen::ArrayXXd whole_force_, whole_tangents_, whole_states_;
  std::vector<Columns> repeated_;  ///< of laws whose answers at repeated points are copied
};

/// An iterate of f = law(k_free + H f) at m connectors, and where the next one goes. Arrays are columns of `rows`
/// points in blocks; motion and tangents have 3m columns [by d_1 .. d_m, by d'_1 .. d'_m, by d''_1 .. d''_m], all
/// others m.
struct ForceIterate {
  Eigen::Index rows, connectors;
  bool uses_acceleration;           ///< some law does; otherwise df/dd'' is zero, and d'' left out of the next motion
  const double* compliance;         ///< H, 3m x m
  const double* free_motion;        ///< k_free
  const double* law_force;          ///< law(k) at k = k_free + H f
  const double* tangents;           ///< df/dk
  const double* force;              ///< f
  const double* previous_residual;  ///< |law(k) - f| one iterate earlier
  double tolerance, floor;          ///< a force is known to tolerance (|f| + floor)
  double* residual;                 ///< |law(k) - f|, output
  double* correction;               ///< c, output
  double* next_force;               ///< f + c, output
  double* next_motion;              ///< k_free + H (f + c), output
};

/// What a correction says of the iterate. Values that are not defined neither grow nor are large.
struct CorrectionJudgement {
  bool grew = false;   ///< some residual is more than twice the previous one, beyond rounding
  bool small = false;  ///< every |c| <= tolerance (|f + c| + floor)
};

/// Newton's correction of f - law(k_free + H f) = 0 at many points at once,
///     (1 - T H) c = law(k) - f,     T = [diag(df/dd) diag(df/dd') diag(df/dd'')], m x 3m,
/// by Gaussian elimination with the points along the vector lanes. Where laws rise with the motion and H is that of a
/// passive structure (negative) each pivot is 1 or more, so rows are not exchanged; points where a pivot is small in
/// its row are solved again with row exchanges.
class ForceCorrection {
public:
  ForceCorrection(Eigen::Index connectors, const PointBlocks& blocks);

  [[nodiscard]] CorrectionJudgement correct(const ForceIterate& at) { return correct_(at, *this); }
  /// next_motion = k_free + H f, its d'' where some law uses it.
  void move(const ForceIterate& at) const { move_(at, 0, (at.uses_acceleration ? 3 : 2) * at.connectors); }
  /// The d'' of it.
  void move_acceleration(const ForceIterate& at) const { move_(at, 2 * at.connectors, 3 * at.connectors); }

private:
  template <int connectors, int width>
  struct Kernels;
  template <int connectors>
  void choose(const PointBlocks& blocks);
  const Eigen::VectorXd& solve_with_exchanges(const ForceIterate& at, Eigen::Index point);

  CorrectionJudgement (*correct_)(const ForceIterate&, ForceCorrection&) = nullptr;
  void (*move_)(const ForceIterate&, Eigen::Index, Eigen::Index) = nullptr;
  /// For a number of connectors that has no kernel of its own.
  std::vector<double, Eigen::aligned_allocator<double>> lane_storage_;
  Eigen::MatrixXd jacobian_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::VectorXd one_residual_, one_correction_;
};

}  // namespace kalfem

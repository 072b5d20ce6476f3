#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/system/locally_nonlinear_system.hpp"
#include "kalfem/system/point_lanes.hpp"

namespace kalfem {

/// Arrays of all connector laws in blocks of points, and the calls of the laws on them. Rows are those of the blocks.
/// The laws' arguments point into the arrays: these keep their size and place.
class ConnectorResponse {
public:
  ConnectorResponse(const std::vector<Connector>& connectors, const PointBlocks& blocks);
  ConnectorResponse(const ConnectorResponse&) = delete;
  ConnectorResponse& operator=(const ConnectorResponse&) = delete;

  Eigen::ArrayXXd parameters;    ///< of all laws one after the other, input
  Eigen::ArrayXXd begin_motion;  ///< [d, d'] at the interval's begin, 2m columns, input
  Eigen::ArrayXXd begin_states;  ///< of all laws, input
  Eigen::ArrayXXd motion;        ///< [d, d', d''] at the interval's end, 3m columns, input
  Eigen::ArrayXXd force;         ///< m columns, output
  Eigen::ArrayXXd tangents;      ///< [df/dd, df/dd', df/dd''], 3m columns, output
  Eigen::ArrayXXd states;        ///< at the interval's end, output

  /// Forces, tangents and states at the end of an interval of the given duration.
  void respond(double duration);

private:
  /// Where a connector's columns stand in the arrays.
  struct Columns {
    Eigen::Index connector, parameter, parameter_count, state, state_count;
  };
  struct Call {
    const ConnectorLaw* law;
    LawPoints points;
    LawResponse response;
  };
  void add_call(const ConnectorLaw& law, const Columns& at, Eigen::Index first_row, Eigen::Index row_count);
  void repeat_points(const Columns& at);

  PointBlocks blocks_;
  std::vector<ConnectorLawPtr> laws_;
  std::vector<Call> calls_;
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
  std::vector<double> lane_storage_;  ///< for a number of connectors that has no kernel of its own
  Eigen::MatrixXd jacobian_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::VectorXd one_residual_, one_correction_;
};

}  // namespace kalfem

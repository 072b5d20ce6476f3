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

}  // namespace kalfem

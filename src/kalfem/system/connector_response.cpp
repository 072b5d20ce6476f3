#include "kalfem/system/connector_response.hpp"

namespace kalfem {

using Eigen::ArrayXXd;
using Eigen::Index;

ConnectorResponse::ConnectorResponse(const std::vector<Connector>& connectors, const PointBlocks& blocks)
    : blocks_(blocks) {
  std::vector<Columns> columns;
  Index parameter_count = 0, state_count = 0;
  for (const auto& connector : connectors) {
    const auto states_here = static_cast<Index>(connector.law->states().size());
    laws_.push_back(connector.law);
    columns.push_back(
        {static_cast<Index>(columns.size()), parameter_count, connector.parameters.size(), state_count, states_here});
    parameter_count += connector.parameters.size();
    state_count += states_here;
  }
  const auto m = static_cast<Index>(connectors.size());
  parameters = ArrayXXd::Zero(blocks.rows, parameter_count);
  begin_motion = ArrayXXd::Zero(blocks.rows, 2 * m);
  for (auto* array : {&motion, &tangents}) *array = ArrayXXd::Zero(blocks.rows, 3 * m);
  for (auto* array : {&begin_states, &states}) *array = ArrayXXd::Zero(blocks.rows, state_count);
  force = ArrayXXd::Zero(blocks.rows, m);

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
  const Index m = force.cols(), j = at.connector;
  const auto column = [&](ArrayXXd& of, Index index) { return of.col(index).segment(first_row, row_count); };
  const auto columns = [&](ArrayXXd& of, Index index, Index count) {
    return of.block(first_row, index, row_count, count);
  };
  calls_.push_back({&law,
                    {0.0, columns(parameters, at.parameter, at.parameter_count), column(begin_motion, j),
                     column(begin_motion, m + j), columns(begin_states, at.state, at.state_count), column(motion, j),
                     column(motion, m + j), column(motion, 2 * m + j)},
                    {column(force, j), column(tangents, j), column(tangents, m + j), column(tangents, 2 * m + j),
                     columns(states, at.state, at.state_count)}});
}

void ConnectorResponse::respond(double duration) {
  for (auto& call : calls_) {
    call.points.duration = duration;
    call.law->respond(call.points, call.response);
  }
  for (const auto& at : repeated_) repeat_points(at);
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

}  // namespace kalfem

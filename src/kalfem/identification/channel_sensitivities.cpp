// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/channel_sensitivities.hpp"

#include <algorithm>
#include <map>

#include "kalfem/base/parallel.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<std::vector<MatrixXd>> sensitivities(const ChannelSimulation& simulation, const VectorXd& theta,
                                                   const VectorXd& step, int threads) {
  std::vector<MatrixXd> derivatives(static_cast<std::size_t>(theta.size()));
  std::vector<char> failed(derivatives.size(), 0);
  for_each_index(derivatives.size(), threads, [&](std::size_t i) {
    VectorXd above = theta, below = theta;
    above[static_cast<Index>(i)] += step[static_cast<Index>(i)];
    below[static_cast<Index>(i)] -= step[static_cast<Index>(i)];
    auto right = simulation.outputs(above);
    const auto left = right ? simulation.outputs(below) : std::nullopt;
    failed[i] = left ? 0 : 1;
    if (left) derivatives[i] = (*right - *left) / (above - below)[static_cast<Index>(i)];
  });
  if (std::ranges::count(failed, 1) > 0) return std::nullopt;
  return derivatives;
}

std::vector<char> moving(const std::vector<Sensor>& channels, const VectorXd& size) {
  constexpr double smallest_part = 1e-6;
  std::map<std::string, double> largest;
  for (std::size_t j = 0; j < channels.size(); ++j) {
    double& most = largest[channels[j].unit];
    most = std::max(most, size[static_cast<Index>(j)]);
  }
  std::vector<char> moves;
  for (std::size_t j = 0; j < channels.size(); ++j)
    moves.push_back(size[static_cast<Index>(j)] > smallest_part * largest[channels[j].unit]);
  return moves;
}

MatrixXd channel_information(const std::vector<MatrixXd>& derivatives, Index channel, double deviation) {
  MatrixXd rows(static_cast<Index>(derivatives.size()), derivatives.front().cols());
  for (Index i = 0; i < rows.rows(); ++i) rows.row(i) = derivatives[static_cast<std::size_t>(i)].row(channel);
  return rows * rows.transpose() / (deviation * deviation);
}

}  // namespace kalfem

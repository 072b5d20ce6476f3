// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "kalfem/identification/channel_simulation.hpp"

namespace kalfem {

/// dy/dtheta_i by central differences, channels x samples, one a parameter. Empty where a simulation fails.
std::optional<std::vector<Eigen::MatrixXd>> sensitivities(const ChannelSimulation& simulation,
                                                          const Eigen::VectorXd& theta, const Eigen::VectorXd& step,
                                                          int threads);

/// Which channels move by more than rounding: sizes are compared among channels of one unit.
std::vector<char> moving(const std::vector<Sensor>& channels, const Eigen::VectorXd& size);

/// sum_k (dy_k/di) (dy_k/dj) / sigma^2 of a channel.
Eigen::MatrixXd channel_information(const std::vector<Eigen::MatrixXd>& derivatives, Eigen::Index channel,
                                    double deviation);

}  // namespace kalfem

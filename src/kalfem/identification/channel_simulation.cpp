// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/channel_simulation.hpp"

#include <algorithm>

#include "kalfem/identification/open_loop.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<StructureBinding> bindings_of_unknowns(const EstimationProblem& problem,
                                                   const std::vector<std::string>& names, IssueList& issues) {
  const auto& unknowns = problem.settings.unknowns;
  std::vector<std::string> known;
  for (const auto& unknown : unknowns) known.push_back(unknown.name);
  std::vector<StructureBinding> bindings;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = std::ranges::find(unknowns, names[i], &Unknown::name);
    if (found == unknowns.end())
      issues.add({}, "'" + names[i] + "' is no unknown of the structure" + did_you_mean(names[i], known),
                 "sensors are placed for its parameters", "name unknowns of the structure");
    else if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
             names.begin() + static_cast<std::ptrdiff_t>(i))
      issues.add({}, "the unknown '" + names[i] + "' is named twice", "", "name it once");
    else
      for (const auto& target : found->targets) bindings.push_back({static_cast<Index>(i), target});
  }
  return bindings;
}

ChannelSimulation::ChannelSimulation(const EstimationProblem& problem, const Record& drive,
                                     std::vector<Sensor> channels, std::vector<StructureBinding> bindings,
                                     const VectorXd& theta)
    : channels_(std::move(channels)),
      bindings_(std::move(bindings)),
      structure_(problem.structure, bindings_, theta.size()),
      here_(structure_.at(theta)),
      time_{.sample_rate = drive.sample_rate, .start = drive.start} {
  time_.values.resize(0, drive.samples_used());
  for (const auto& signal : problem.structure->signals) signals_.push_back(delayed(signal, -drive.start));
  for (const auto& channel : channels_) (channel.chain.is_identity() ? sampled_ : stepped_).push_back(channel.output);
}

std::optional<VectorXd> ChannelSimulation::start(const StructurePtr& given, const VectorXd& theta) {
  const CoupledModel model = couple(parts_at(theta));
  const auto solution = simulate_open_loop({model.system(), model, channels_, given->signals},
                                           at_rest(model.system().size(), model.system().connector_states()), time_);
  if (solution.simulation.failure || !solution.sensors.allFinite()) return std::nullopt;
  substeps_ = std::max(fewest_substeps, solution.substeps);
  return (solution.sensors.rowwise().squaredNorm() / static_cast<double>(solution.sensors.cols())).cwiseSqrt();
}

std::optional<MatrixXd> ChannelSimulation::outputs(const VectorXd& theta) const try {
  const CoupledModel model = couple(parts_at(theta));
  const double fine_rate = time_.sample_rate * static_cast<double>(substeps_);
  SimulationOptions options;
  options.step = 1.0 / fine_rate;
  options.keep_every = substeps_;
  options.duration = static_cast<double>(time_.samples() - 1) / time_.sample_rate;
  options.keep_motion = false;
  options.every_sample = make_outputs(model, sampled_);
  options.every_step = make_outputs(model, stepped_);
  const auto result =
      simulate(model.system(), signals_, at_rest(model.system().size(), model.system().connector_states()), options);
  if (result.failure) return std::nullopt;
  MatrixXd outputs(static_cast<Index>(channels_.size()), time_.samples());
  for (Index j = 0, sampled = 0, stepped = 0; j < outputs.rows(); ++j) {
    const auto& chain = channels_[static_cast<std::size_t>(j)].chain;
    if (chain.is_identity())
      outputs.row(j) = result.every_sample.row(sampled++);
    else
      outputs.row(j) = chain.filter(result.every_step.row(stepped++).transpose(),
                                    fine_rate)(Eigen::seqN(0, outputs.cols(), substeps_));
  }
  if (!outputs.allFinite()) return std::nullopt;
  return outputs;
} catch (const InvalidInput&) {
  return std::nullopt;
}

StructureParts ChannelSimulation::parts_at(const VectorXd& theta) const {
  StructureParts parts = structure_.near(here_, theta);
  for (const auto& [index, parameter] : bindings_)
    if (parameter.of_connector()) set_parameter(parts, parameter, theta[index]);
  return parts;
}

}  // namespace kalfem

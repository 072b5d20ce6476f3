// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/unknown_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/SparseLU>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Complex = std::complex<double>;
using ComplexMatrix = Eigen::SparseMatrix<Complex>;

constexpr double rank_tolerance = 1e-9;  ///< of the singular values of H, columns of length one
/// Parts of the sampling rate at which H is evaluated: apart from each other and from anybody's resonances.
constexpr double fractions[] = {0.0031, 0.0117, 0.0373, 0.1091, 0.3137};
constexpr double slow = 1e-4;  ///< part of the sampling rate

Index index_of(const std::string& name, const LocallyNonlinearSystem& system) {
  const auto found = std::ranges::find(system.inputs, name, &Input::name);
  return found == system.inputs.end() ? -1 : found - system.inputs.begin();
}

OutputMap sensor_map(const AugmentedModelSetup& setup) {
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : setup.sensors) outputs.push_back(sensor.output);
  return make_outputs(*setup.model, outputs);
}

/// Frequency responses of sensors to inputs, of the structure with its connectors as stiff as at rest. A connector
/// without stiffness there, a dashpot or a cubic spring, still passes motion on: it has a small stiffness.
class SensorResponses {
public:
  SensorResponses(const std::vector<UnknownInput>& inputs, const AugmentedModelSetup& setup)
      : system_(setup.model->system()), sensors_(sensor_map(setup)) {
    for (const auto& input : inputs) {
      columns_.push_back(index_of(input.name, system_));
      derivative_.push_back(input.acceleration ? 2 : 0);
    }
    const double small = 1e-3 * std::max(1.0, system_.stiffness.diagonal().cwiseAbs().maxCoeff());
    stiffness_ = system_.stiffness;
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& connector : system_.connectors) {
      const double own = std::abs(stiffness_at_rest(*connector.law, connector.parameters));
      connectors_.push_back(std::isfinite(own) && own > 0.0 ? own : small);
      const SparseMatrix direction = connector.deformation.sparseView();
      stiffness_ += connectors_.back() * (direction * SparseMatrix(direction.transpose()));
    }
  }

  /// H at a frequency [Hz], sensors x inputs; empty where the structure is singular there.
  [[nodiscard]] MatrixXcd at(double frequency) const {
    const Complex s(0.0, 2.0 * std::numbers::pi * frequency);
    ComplexMatrix dynamic = stiffness_.cast<Complex>();
    dynamic += ComplexMatrix(s * system_.damping.cast<Complex>());
    dynamic += ComplexMatrix(s * s * system_.mass.cast<Complex>());
    Eigen::SparseLU<ComplexMatrix> factor(dynamic);
    if (factor.info() != Eigen::Success) return {};
    const MatrixXcd motion = factor.solve(loads(s)), shares = inputs_of(s);
    MatrixXcd responses = sensors_.displacement.cast<Complex>() * motion +
                          sensors_.velocity.cast<Complex>() * (s * motion) +
                          sensors_.acceleration.cast<Complex>() * (s * s * motion);
    responses += sensors_.input_value.cast<Complex>() * shares + sensors_.input_rate.cast<Complex>() * (s * shares) +
                 sensors_.input_acceleration.cast<Complex>() * (s * s * shares);
    for (std::size_t j = 0; j < connectors_.size(); ++j)
      responses += sensors_.force.col(static_cast<Index>(j)).cast<Complex>() * connectors_[j] *
                   (system_.connectors[j].deformation.transpose().cast<Complex>() * motion -
                    system_.connectors[j].base.transpose().cast<Complex>() * shares);
    return responses;
  }

private:
  /// Values r of the inputs per unit of their process, n_u x inputs.
  [[nodiscard]] MatrixXcd inputs_of(Complex s) const {
    MatrixXcd shares = MatrixXcd::Zero(system_.input_count(), static_cast<Index>(columns_.size()));
    for (std::size_t i = 0; i < columns_.size(); ++i)
      shares(columns_[i], static_cast<Index>(i)) = std::pow(s, -derivative_[i]);
    return shares;
  }

  [[nodiscard]] MatrixXcd loads(Complex s) const {
    MatrixXcd loads(system_.size(), system_.input_count());
    for (Index i = 0; i < loads.cols(); ++i) {
      const auto& input = system_.inputs[static_cast<std::size_t>(i)];
      loads.col(i) =
          input.value.cast<Complex>() + s * input.rate.cast<Complex>() + s * s * input.acceleration.cast<Complex>();
      for (std::size_t j = 0; j < connectors_.size(); ++j)
        loads.col(i) +=
            connectors_[j] * system_.connectors[j].base[i] * system_.connectors[j].deformation.cast<Complex>();
    }
    return loads * inputs_of(s);
  }

  const LocallyNonlinearSystem& system_;
  OutputMap sensors_;
  std::vector<Index> columns_;
  std::vector<int> derivative_;
  std::vector<double> connectors_;  ///< stiffnesses
  SparseMatrix stiffness_;
};

bool has_full_rank(MatrixXcd responses) {
  for (Index j = 0; j < responses.cols(); ++j) responses.col(j).normalize();
  if (responses.cols() == 0) return true;
  const VectorXd values = Eigen::JacobiSVD<MatrixXcd>(responses).singularValues();
  return values.size() == responses.cols() && values.tail(1)[0] > rank_tolerance * values[0];
}

std::string listed(const std::vector<UnknownInput>& inputs) {
  std::string names;
  for (const auto& input : inputs) names += (names.empty() ? "'" : ", '") + input.name + "'";
  return names;
}

void check_smoothness(const UnknownInput& input, const AugmentedModelSetup& setup, IssueList& issues) {
  const int highest = highest_acting_derivative(input.name, setup);
  if (input.acceleration || input.process.order > highest) return;
  const bool walk = input.is_random_walk();
  const std::string needed = highest == 1 ? "3/2" : "5/2";
  issues.add(
      input.location,
      "excitation." + input.name + ".unknown: " +
          (walk ? "a random walk" : "a process of smoothness " + std::to_string(2 * input.process.order - 1) + "/2") +
          (input.process.order == 1 ? " has no rate" : " has no second derivative"),
      std::string(highest == 1 ? "the rate" : "the acceleration") +
          " of this input acts on the structure or on a sensor",
      (walk ? "give std and correlation_time with smoothness: " : "write smoothness: ") + needed +
          (highest == 2 && input.process.order < 3 ? ", or make it a base_acceleration" : ""));
}

}  // namespace

double EstimatedInput::shrinkage(Index first) const {
  const double prior = input.is_random_walk() ? input.density : input.deviation;
  const VectorXd after = deviation.tail(std::max<Index>(1, deviation.size() - first));
  return after.norm() / std::sqrt(static_cast<double>(after.size())) / prior;
}

void treat_as_unknown(const std::vector<UnknownInput>& inputs, AugmentedModelSetup& setup) {
  for (const auto& input : inputs) {
    const auto place = std::ranges::find(setup.input_sources, input.name);
    if (place == setup.input_sources.end()) continue;
    place->clear();
    setup.options.inputs[static_cast<std::size_t>(place - setup.input_sources.begin())] = {
        .model = input.acceleration ? InputModel::latent_acceleration : InputModel::latent, .process = input.process};
  }
}

void set_noise_of_unknown_inputs(const std::vector<UnknownInput>& inputs, AugmentedModelSetup& setup) {
  for (const auto& input : held_by(inputs, setup)) {
    const Index place = index_of(input.name, setup.model->system());
    setup.options.prior.input_deviation[place] = input.deviation;
    setup.options.process_noise.input[place] = input.density;
  }
}

std::vector<UnknownInput> held_by(const std::vector<UnknownInput>& inputs, const AugmentedModelSetup& setup) {
  std::vector<UnknownInput> held;
  std::ranges::copy_if(inputs, std::back_inserter(held),
                       [&](const auto& input) { return index_of(input.name, setup.model->system()) >= 0; });
  return held;
}

OutputMap with_inputs(OutputMap outputs, const std::vector<UnknownInput>& inputs, const CoupledModel& model) {
  const Index before = outputs.size(), rows = before + static_cast<Index>(inputs.size());
  const Index n_u = model.system().input_count(), m = model.system().connector_count();
  for (auto* motion : {&outputs.displacement, &outputs.velocity, &outputs.acceleration})
    motion->conservativeResize(rows, model.system().size());
  for (auto* share : {&outputs.input_value, &outputs.input_rate, &outputs.input_acceleration})
    share->conservativeResizeLike(MatrixXd::Zero(rows, n_u));
  outputs.force.conservativeResizeLike(MatrixXd::Zero(rows, m));
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    outputs.names.push_back(inputs[i].name);
    outputs.units.push_back(inputs[i].unit);
    auto& share = inputs[i].acceleration ? outputs.input_acceleration : outputs.input_value;
    share(before + static_cast<Index>(i), index_of(inputs[i].name, model.system())) = 1.0;
  }
  return outputs;
}

// H of full column rank at one frequency is enough: the inputs then differ in what they do to the sensors. H ~ w or
// faster towards frequency zero means that a constant input leaves no trace.
InputObservability observability_of(const std::vector<UnknownInput>& held, const AugmentedModelSetup& setup) {
  InputObservability found;
  const SensorResponses responses(held, setup);
  const double rate = 1.0 / setup.options.step;
  std::vector<MatrixXcd> all;
  for (const double fraction : fractions)
    if (MatrixXcd at = responses.at(fraction * rate); at.size() > 0) all.push_back(std::move(at));
  if (all.empty()) return found;
  std::vector<Index> seen;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const auto column = static_cast<Index>(i);
    const bool answers = std::ranges::any_of(all, [&](const auto& h) { return h.col(column).norm() > 0.0; });
    if (answers)
      seen.push_back(column);
    else
      found.unseen.push_back(held[i].name);
  }
  found.separable = std::ranges::any_of(all, [&](const auto& h) { return has_full_rank(h(Eigen::all, seen)); });
  const MatrixXcd low = responses.at(slow * rate), lower = responses.at(0.1 * slow * rate);
  if (low.size() == 0 || lower.size() == 0) return found;
  for (const Index i : seen)
    if (lower.col(i).norm() < 0.3 * low.col(i).norm())
      found.unseen_if_slow.push_back(held[static_cast<std::size_t>(i)].name);
  return found;
}

int highest_acting_derivative(const std::string& name, const AugmentedModelSetup& setup) {
  const auto& system = setup.model->system();
  const Index i = index_of(name, system);
  const auto& input = system.inputs[static_cast<std::size_t>(i)];
  const OutputMap sensors = sensor_map(setup);
  bool rate = !input.rate.isZero(0.0) || !sensors.input_rate.col(i).isZero(0.0);
  bool acceleration = !input.acceleration.isZero(0.0) || !sensors.input_acceleration.col(i).isZero(0.0);
  for (const auto& connector : system.connectors) {
    if (connector.base[i] == 0.0) continue;
    rate = true;
    acceleration = acceleration || connector.law->uses_acceleration();
  }
  return acceleration ? 2 : rate ? 1 : 0;
}

void check_unknown_inputs(const std::vector<UnknownInput>& inputs, const AugmentedModelSetup& setup,
                          IssueList& issues) {
  const auto held = held_by(inputs, setup);
  if (held.empty()) return;
  for (const auto& input : held) check_smoothness(input, setup, issues);
  const std::size_t sensors = setup.sensors.size();
  if (held.size() > sensors) {
    issues.add(held.front().location,
               std::to_string(held.size()) + " excitations are unknown (" + listed(held) +
                   "), but the filter has only " + std::to_string(sensors) + (sensors == 1 ? " sensor" : " sensors"),
               "as many sensors as unknown inputs are needed to tell them apart",
               "add sensors, or measure an excitation");
    return;
  }
  const auto found = observability_of(held, setup);
  for (const auto& name : found.unseen)
    issues.add(std::ranges::find(held, name, &UnknownInput::name)->location,
               "excitation." + name + ".unknown: no sensor answers to this input", "nothing can be learned of it",
               "put a sensor on the part of the structure that it moves");
  if (!found.separable)
    issues.add(held.front().location, "the sensors cannot tell the unknown excitations apart: " + listed(held),
               "at every frequency, a combination of them moves no sensor",
               "put sensors where they act differently, or make one of them known");
}

}  // namespace kalfem

#include "kalfem/report/connector_charts.hpp"

#include <algorithm>

#include "kalfem/report/series_values.hpp"

namespace kalfem {
namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index curve_points = 201;

/// Force of a law without memory at given deformations and rates.
VectorXd force(const ConnectorLaw& law, const VectorXd& parameters, const VectorXd& deformation, const VectorXd& rate) {
  const Index n = deformation.size();
  const ArrayXXd p = parameters.transpose().array().replicate(n, 1), none = ArrayXXd::Zero(n, 0);
  const ArrayXd d = deformation.array(), v = rate.array(), zero = ArrayXd::Zero(n);
  ArrayXd f(n), k(n), c(n), b(n);
  ArrayXXd states(n, 0);
  law.respond({0.0, p, d, v, none, d, v, zero}, {f, k, c, b, states});
  return f.matrix();
}

/// Parameters of one connector in the augmented model as a function of the unknowns' states.
class IdentifiedConnector {
public:
  IdentifiedConnector(const EstimationOutcome& outcome, Index connector) : outcome_(outcome), connector_(connector) {
    const auto& layout = outcome.augmented_model->layout();
    last_ = outcome.result.state.mean.cols() - 1;
    state_ = outcome.result.state.mean.col(last_).segment(layout.unknown(), layout.unknowns);
    covariance_ =
        outcome.result.final_covariance.block(layout.unknown(), layout.unknown(), layout.unknowns, layout.unknowns);
  }

  [[nodiscard]] VectorXd parameters(const VectorXd& state) const {
    VectorXd values = outcome_.augmented_model->system().connectors[static_cast<std::size_t>(connector_)].parameters;
    const auto& unknowns = outcome_.augmented_model->options().unknowns;
    for (std::size_t i = 0; i < unknowns.size(); ++i)
      for (const auto& target : unknowns[i].targets)
        if (target.connector == connector_)
          values[target.parameter] = unknowns[i].transform.to_parameter(state[static_cast<Index>(i)]);
    return values;
  }

  /// Curve with the band that the parameters' covariance gives to first order.
  [[nodiscard]] Series curve(const VectorXd& deformation, const VectorXd& rate) const {
    const auto& law = *outcome_.augmented_model->system().connectors[static_cast<std::size_t>(connector_)].law;
    const VectorXd mean = force(law, parameters(state_), deformation, rate);
    MatrixXd slope(mean.size(), state_.size());
    for (Index i = 0; i < state_.size(); ++i) {
      const double step = 1e-3 * std::sqrt(std::max(covariance_(i, i), 1e-300));
      VectorXd shifted = state_;
      shifted[i] += step;
      slope.col(i) = (force(law, parameters(shifted), deformation, rate) - mean) / step;
    }
    const VectorXd width =
        normal_quantile(0.975) * ((slope * covariance_).cwiseProduct(slope)).rowwise().sum().cwiseMax(0.0).cwiseSqrt();
    return {.label = "identified, 95 %",
            .y = series_values(mean),
            .lower = series_values(mean - width),
            .upper = series_values(mean + width),
            .role = Role::estimate};
  }

private:
  const EstimationOutcome& outcome_;
  Index connector_, last_ = 0;
  VectorXd state_;
  MatrixXd covariance_;
};

const PointQuantity* find(const EstimationOutcome& outcome, const std::string& name, ObservedQuantity quantity) {
  const auto found =
      std::ranges::find_if(outcome.points, [&](const auto& p) { return p.point == name && p.quantity == quantity; });
  return found == outcome.points.end() ? nullptr : &*found;
}

const Connector* true_connector(const Study& study, const std::string& name) {
  if (!study.simulation) return nullptr;
  const auto& connectors = study.model->system().connectors;
  const auto found = std::ranges::find(connectors, name, &Connector::name);
  return found == connectors.end() ? nullptr : &*found;
}

Chart characteristic(const Study& study, const EstimationOutcome& outcome, Index index, bool over_rate) {
  const auto& connector = outcome.augmented_model->system().connectors[static_cast<std::size_t>(index)];
  const auto* range = find(outcome, connector.name,
                           over_rate ? ObservedQuantity::connector_rate : ObservedQuantity::connector_deformation);
  const double largest = std::max(1e-12, range->mean.tail(range->mean.size() - outcome.settled).cwiseAbs().maxCoeff());
  const VectorXd x = VectorXd::LinSpaced(curve_points, -largest, largest), zero = VectorXd::Zero(curve_points);
  const VectorXd &deformation = over_rate ? zero : x, &rate = over_rate ? x : zero;
  Chart chart{.id = connector.name + (over_rate ? "-damper" : "-spring"),
              .title = connector.name + (over_rate ? ": force over rate" : ": force over deformation"),
              .caption = over_rate ? "At zero deformation." : "At rest.",
              .x_label = over_rate ? "deformation rate [m/s]" : "deformation [m]",
              .y_label = "force [N]",
              .x = series_values(x),
              .series = {IdentifiedConnector(outcome, index).curve(deformation, rate)},
              .half_width = true};
  if (const auto* truth = true_connector(study, connector.name))
    chart.series.push_back({.label = "true",
                            .y = series_values(force(*truth->law, truth->parameters, deformation, rate)),
                            .role = Role::truth});
  return chart;
}

/// Force over deformation as it went, over the last part of the record.
Chart path(const EstimationOutcome& outcome, const std::string& name) {
  const auto *force_history = find(outcome, name, ObservedQuantity::connector_force),
             *deformation = find(outcome, name, ObservedQuantity::connector_deformation);
  const Index count = std::min<Index>(2000, force_history->mean.size() - outcome.settled);
  Chart chart{.id = name + "-path",
              .title = name + ": path",
              .caption = "The last part of the record.",
              .x_label = "deformation [m]",
              .y_label = "force [N]",
              .series = {{.label = "estimated",
                          .y = series_values(force_history->mean.tail(count)),
                          .role = Role::estimate,
                          .x = series_values(deformation->mean.tail(count))}},
              .scatter = true};
  if (force_history->truth.size() > 0 && deformation->truth.size() > 0)
    chart.series.push_back({.label = "true",
                            .y = series_values(force_history->truth.tail(count)),
                            .role = Role::truth,
                            .x = series_values(deformation->truth.tail(count))});
  return chart;
}

}  // namespace

Section connectors_section(const Study& study, const EstimationOutcome& outcome) {
  Section section{"Connectors", "The identified laws.", {}};
  const auto& connectors = outcome.augmented_model->system().connectors;
  for (std::size_t j = 0; j < connectors.size(); ++j) {
    const bool unknown = std::ranges::any_of(outcome.augmented_model->options().unknowns, [&](const auto& each) {
      return std::ranges::any_of(each.targets,
                                 [&](const auto& target) { return target.connector == static_cast<Index>(j); });
    });
    if (!unknown) continue;
    if (connectors[j].law->states().empty()) {
      section.items.emplace_back(characteristic(study, outcome, static_cast<Index>(j), false));
      section.items.emplace_back(characteristic(study, outcome, static_cast<Index>(j), true));
    }
    section.items.emplace_back(path(outcome, connectors[j].name));
  }
  return section;
}

}  // namespace kalfem

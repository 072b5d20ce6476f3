// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/evidence.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/diagnosis/candidates.hpp"
#include "kalfem/diagnosis/left_out_predictions.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double longest_delay = 0.15;  ///< [s]

/// What runs over a part of the record say about each sensor, excitation and connector.
class Evidence {
public:
  Evidence(const DiagnosisInput& input, const FilterRun& base, const EstimationOptions& options)
      : input_(input), base_(base), options_(options) {}

  [[nodiscard]] std::vector<Likeness> likeness_of_sensors() const {
    const auto& values = base_.input.measured.values;
    std::vector<Likeness> found;
    for (Index i = 0; i < values.rows(); ++i) {
      const MatrixXd predicted = predicted_without(input_, base_, options_, {i});
      found.push_back(predicted.size() == 0 ? Likeness{} : likeness(values.row(i), predicted.row(i), longest_lag()));
    }
    return found;
  }

  [[nodiscard]] Likeness likeness_of_all() const {
    const MatrixXd predicted = predicted_without(input_, base_, options_, all_sensors());
    return predicted.size() == 0 ? Likeness{} : likeness(base_.input.measured.values, predicted, longest_lag());
  }

  [[nodiscard]] std::vector<std::string> sources() const {
    IssueList issues;
    return make_augmented_model_setup(*input_.problem, input_.parts, {}, issues).input_sources;
  }

  /// What each excitation gives, against the record less what the others give.
  [[nodiscard]] std::vector<Likeness> likeness_of_excitations() const {
    const Index n_u = base_.input.inputs.rows() / 3;
    const auto& values = base_.input.measured.values;
    std::vector<MatrixXd> response;
    for (Index i = 0; i < n_u; ++i) {
      FilterRun alone = base_;
      for (Index j = 0; j < n_u; ++j)
        if (j != i)
          for (Index derivative = 0; derivative < 3; ++derivative)
            alone.input.inputs.row(derivative * n_u + j).setZero();
      response.push_back(predicted_without(input_, alone, options_, all_sensors()));
      if (response.back().size() == 0) return std::vector<Likeness>(static_cast<std::size_t>(n_u));
    }
    std::vector<Likeness> found;
    for (Index i = 0; i < n_u; ++i) {
      MatrixXd rest = values;
      for (Index j = 0; j < n_u; ++j)
        if (j != i) rest -= response[static_cast<std::size_t>(j)];
      found.push_back(likeness(rest, response[static_cast<std::size_t>(i)], longest_lag()));
    }
    return found;
  }

  [[nodiscard]] std::vector<ConnectorMotion> motion_of_connectors() const {
    IssueList issues;
    const auto setup = make_augmented_model_setup(*input_.problem, input_.parts, {}, issues);
    std::vector<OutputDescription> outputs;
    for (const auto& connector : input_.parts.connectors)
      for (const auto quantity : {ObservedQuantity::connector_deformation, ObservedQuantity::connector_rate,
                                  ObservedQuantity::connector_force})
        outputs.push_back({connector.name, quantity, {{connector.name, 1.0}}, false});
    EstimationOptions options = options_;
    try {
      options.monitored = make_outputs(*setup.model, outputs);
    } catch (const InvalidInput&) {
      return {};  // a part of the structure only: its connectors are not all in the model
    }
    options.deviation_stride = static_cast<int>(std::min<Index>(input_.record.samples(), 1'000'000));
    const auto result = estimate(*base_.choice.augmented_model, base_.input, options);
    std::vector<ConnectorMotion> motion;
    for (std::size_t j = 0; j < input_.parts.connectors.size(); ++j) {
      const auto row = static_cast<Index>(3 * j);
      const auto size = [&](Index r) { return rms_of_present(result.monitored.mean.row(r).transpose()); };
      const auto deformation = result.monitored.mean.row(row).array();
      motion.push_back({size(row), size(row + 1), size(row + 2),
                        deformation.isFinite().select(deformation, 0.0).minCoeff(),
                        deformation.isFinite().select(deformation, 0.0).maxCoeff()});
    }
    return motion;
  }

private:
  [[nodiscard]] Index longest_lag() const {
    const auto& record = input_.record;
    return std::min<Index>(record.samples() / 4, std::llround(longest_delay * record.sample_rate));
  }

  [[nodiscard]] std::vector<Index> all_sensors() const {
    std::vector<Index> all(static_cast<std::size_t>(base_.input.measured.values.rows()));
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
    return all;
  }

  const DiagnosisInput& input_;
  const FilterRun& base_;
  const EstimationOptions& options_;
};

}  // namespace

Index runs_for_hypotheses(const FilterRun& base) {
  const Index excitations = base.input.inputs.rows() / 3;
  return base.input.measured.values.rows() + excitations + 2;
}

Candidates all_candidates(const DiagnosisInput& input, const FilterRun& base, const EstimationOptions& options) {
  const Evidence evidence(input, base, options);
  Candidates all{sensor_hypotheses(input, base, evidence.likeness_of_sensors(), evidence.likeness_of_all()),
                 evidence.motion_of_connectors()};
  const auto append = [&](std::vector<Hypothesis> further) {
    all.hypotheses.insert(all.hypotheses.end(), std::make_move_iterator(further.begin()),
                          std::make_move_iterator(further.end()));
  };
  append(excitation_hypotheses(input.record.sample_rate, evidence.sources(), evidence.likeness_of_excitations()));
  append(model_hypotheses(input, all.motion));
  return all;
}

}  // namespace kalfem

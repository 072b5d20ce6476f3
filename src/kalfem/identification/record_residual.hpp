// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/identification/driven_substructure.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/updating_setup.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// Compares measured accelerations, velocities or displacements of a substructure with those predicted from the
/// estimated motion of its boundary. One evaluation is one pass of the loop:
///   reduce the finite elements at theta -> estimate states and unknowns from the record -> drive the substructure by
///   its boundary's motion -> r = (predicted - measured) / deviation at every sample after settling.
/// The deviation is that of the filter's innovation at the first parameters, noise and prediction together, held fixed.
///
/// The boundary's motion depends on theta too: the filter makes it from the same record by the same model. Without that
/// part of the derivative the loop stalls, as motion that was estimated with theta has its zeros where the substructure
/// at theta has its poles. So each column J_i = dr/dtheta_i is a run over the record and a prediction more, with the
/// finite elements in the basis of the pass: a filter pass, or, at a tenth of its cost, a run with the gains K_k of the
/// pass (run_with_gains()), against such a run at theta itself. The runs share the processors.
///
/// Held gains leave out the sum of dK_k/dtheta (y_k - h(x_k)). Innovations are about white where the model is right, so
/// that this is small beside the rest; nothing bounds it where the model is far off or the filter has just begun to
/// learn its unknowns. It is therefore measured. With J by filter passes and J~ by held gains at the first parameters,
///     epsilon = max over v of |(J~ - J) v| / |J v|
/// is the largest relative error of a derivative in any direction. A search by J~ reduces its errors to about epsilon
/// of them in an iteration, and ends where J~^T r = 0, about epsilon standard deviations from the minimum.
class RecordResidual final : public Residual {
public:
  enum class Derivatives {
    filter_passes,              ///< a filter pass per parameter
    held_gains,                 ///< without the measurement of epsilon
    held_gains_where_accurate,  ///< held gains where epsilon <= largest_error, otherwise filter passes
  };
  struct Options {
    std::string name;
    std::string substructure;
    std::vector<std::string> sensors;  ///< of the substructure
    Derivatives derivatives = Derivatives::filter_passes;
    double relative_step = 1e-4;    ///< of a parameter, to its scale
    double largest_error = 0.1;     ///< epsilon up to which held gains are used
    double most_gain_memory = 5e8;  ///< of held gains [byte]; filter passes where they need more
  };
  /// Runs the filter at the first parameters for the deviations of its innovations, and to measure epsilon once more
  /// per parameter. Throws InvalidInput where the substructure cannot be driven. Where the filter fails there,
  /// evaluate() gives nothing at these parameters either.
  RecordResidual(EstimationProblemPtr problem, Record record, std::shared_ptr<const ParameterisedStructure> structure,
                 UpdatingSetup updating, Options options);

  [[nodiscard]] std::string name() const override { return options_.name; }
  [[nodiscard]] Eigen::Index size() const override { return deviation_.size(); }
  [[nodiscard]] RowLayout layout() const override { return layout_of_series(deviation_.rows(), deviation_.cols()); }
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override;
  [[nodiscard]] bool holds_gains() const { return hold_gains_; }
  /// Of a sample interval in the filter's model, at all parameters.
  [[nodiscard]] int substeps() const { return substeps_ ? substeps_->substeps : 0; }
  /// Which derivatives are used, and why: "held gains: ...".
  [[nodiscard]] const std::string& derivatives() const { return explanation_; }

  /// Input of the prediction from the filter: the substructure, the motion of its boundary from half the settling time
  /// on (before that, measurement chains settle), and its initial state.
  struct Estimate {
    std::shared_ptr<const CoupledModel> model;
    std::shared_ptr<const DrivenSubstructure> drive;
    BoundaryMotion motion;
    PredictionStart start;
    Eigen::MatrixXd deviation;  ///< of the sensors' innovations, samples x sensors
    Gains gains;                ///< of the filter, where they are asked for
  };
  /// Empty if the filter fails.
  [[nodiscard]] std::optional<Estimate> estimate_at(const StructureParts& parts, const Eigen::VectorXd& parameters,
                                                    bool keep_gains) const;
  /// The same by an augmented model with these gains: without deviations.
  [[nodiscard]] std::optional<Estimate> fixed_gain_run_at(const StructureParts& parts,
                                                          const Eigen::VectorXd& parameters, const Gains& gains) const;
  /// Predicted sensors, samples x sensors; zero before the estimate's start.
  [[nodiscard]] Eigen::MatrixXd predict_from(const Estimate& estimate) const;

private:
  [[nodiscard]] AugmentedModelSetup augmented_model_at(const StructureParts& parts,
                                                       const Eigen::VectorXd& parameters) const;
  [[nodiscard]] Estimate structure_of(const StructureParts& parts) const;
  void set_start(const Eigen::VectorXd& state, Eigen::Index velocity, Estimate& estimate) const;
  /// The residual by a filter pass, or by held gains if given.
  [[nodiscard]] std::optional<Eigen::VectorXd> values_at(const StructureParts& parts, const Eigen::VectorXd& parameters,
                                                         const Gains& gains) const;
  /// Half of the settling time is left to the measurement chains; a local augmented model does not know the
  /// substructure's state then, so it starts at the first sample.
  [[nodiscard]] Eigen::Index first_predicted() const { return problem_->settings.local ? 0 : settled_ / 2; }
  /// Columns of the Jacobian against `values`, the residual at the parameters: by filter passes, or by held gains where
  /// there are some. Nothing where a run fails.
  [[nodiscard]] std::optional<Eigen::MatrixXd> jacobian_at(const StructureAtParameters& here,
                                                           const Eigen::VectorXd& parameters,
                                                           const Eigen::VectorXd& values, const Gains& gains) const;
  /// Memory of the gains of one pass [byte].
  [[nodiscard]] double gain_memory(const StructureParts& parts, const Eigen::VectorXd& parameters) const;
  void choose_substeps_and_start(const StructureAtParameters& here, const Eigen::VectorXd& start);
  void choose_derivatives(const StructureAtParameters& here, const Eigen::VectorXd& start);
  void check_held_gains(const StructureAtParameters& here, const Eigen::VectorXd& start, const Estimate& first);
  [[nodiscard]] Eigen::VectorXd weighted(const Eigen::MatrixXd& sensors) const;

  EstimationProblemPtr problem_;
  Record record_;
  std::shared_ptr<const ParameterisedStructure> structure_;
  Options options_;
  /// Decided at the first parameters, so that all evaluations are of the same model.
  std::optional<SubstepChoice> substeps_;
  std::optional<bool> starts_at_rest_;
  bool hold_gains_ = false;
  std::string explanation_;
  UpdatingSetup updating_;
  std::vector<Sensor> sensors_;
  Eigen::Index settled_ = 0;   ///< first sample that counts
  Eigen::MatrixXd measured_;   ///< samples x sensors
  Eigen::MatrixXd deviation_;  ///< counted samples x sensors; infinite for missing samples
};

}  // namespace kalfem

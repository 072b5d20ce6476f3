#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kalfem/identification/driven_substructure.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/updating_setup.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// Measured accelerations, velocities or displacements of a substructure against those that it has when the estimated
/// motion of its boundary drives it. One evaluation is one pass of the loop:
///   reduce the finite elements at theta -> estimate states and unknowns from the record -> drive the substructure by
///   its boundary's motion -> r = (predicted - measured) / deviation at every sample after settling.
/// The deviation is that of the filter's innovation at the first parameters, noise and prediction together, held fixed.
///
/// The boundary's motion depends on theta too: the filter makes it from the same record by the same model. Without that
/// part of the derivative the loop stalls, as motion that was estimated with theta has its zeros where the substructure
/// at theta has its poles. So each column of the Jacobian is a run over the record and a prediction
/// more, with the finite elements in the basis of the pass: a filter pass, or, at a tenth of its cost, an augmented
/// model with the gains of the pass's filter (run_with_gains()), against such a run at theta itself. Held gains leave
/// out that the gains depend on theta as well, so that a loop may need more iterations. The runs share the processors.
class RecordResidual final : public Residual {
public:
  struct Options {
    std::string name;
    std::string substructure;
    std::vector<std::string> sensors;  ///< of the substructure
    bool hold_gains = false;           ///< in the derivatives
    double relative_step = 1e-4;       ///< of a parameter, to its scale
  };
  /// Runs the filter once, at the first parameters, for the deviations of its innovations. Throws InvalidInput where
  /// the substructure cannot be driven. Where the filter fails there, evaluate() gives nothing at these parameters
  /// either.
  RecordResidual(EstimationProblemPtr problem, Record record, std::shared_ptr<const ParameterisedStructure> structure,
                 UpdatingSetup updating, Options options);

  [[nodiscard]] std::string name() const override { return options_.name; }
  [[nodiscard]] Eigen::Index size() const override { return deviation_.size(); }
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override;

  /// What the filter gives to the prediction: the substructure, the motion of its boundary from half the settling time
  /// on (the rest is for measurement chains to settle), and where it starts.
  struct Estimate {
    std::shared_ptr<const CoupledModel> model;
    std::shared_ptr<const DrivenSubstructure> drive;
    BoundaryMotion motion;
    PredictionStart start;
    Eigen::MatrixXd deviation;  ///< of the sensors' innovations, samples x sensors
    GainSchedule gains;         ///< of the filter, where they are asked for
  };
  /// Nothing where the filter fails.
  [[nodiscard]] std::optional<Estimate> estimate_at(const StructureParts& parts, const Eigen::VectorXd& parameters,
                                                    bool keep_gains) const;
  /// The same by an augmented model with these gains: without deviations.
  [[nodiscard]] std::optional<Estimate> fixed_gain_run_at(const StructureParts& parts,
                                                          const Eigen::VectorXd& parameters,
                                                          const GainSchedule& gains) const;
  /// Predicted sensors, samples x sensors; zero before the estimate's start.
  [[nodiscard]] Eigen::MatrixXd predict_from(const Estimate& estimate) const;

private:
  [[nodiscard]] AugmentedModelSetup augmented_model_at(const StructureParts& parts,
                                                       const Eigen::VectorXd& parameters) const;
  [[nodiscard]] Estimate structure_of(const StructureParts& parts) const;
  void set_start(const Eigen::VectorXd& state, Eigen::Index velocity, Estimate& estimate) const;
  /// The residual by a filter pass, or by held gains where there are some.
  [[nodiscard]] std::optional<Eigen::VectorXd> values_at(const StructureParts& parts, const Eigen::VectorXd& parameters,
                                                         const GainSchedule& gains) const;
  /// Half of the settling time is left to the measurement chains; a local augmented model does not know the
  /// substructure's state then, so that it starts at the beginning.
  [[nodiscard]] Eigen::Index first_predicted() const { return problem_->settings.local ? 0 : settled_ / 2; }
  [[nodiscard]] Eigen::VectorXd weighted(const Eigen::MatrixXd& sensors) const;

  EstimationProblemPtr problem_;
  Record record_;
  std::shared_ptr<const ParameterisedStructure> structure_;
  Options options_;
  UpdatingSetup updating_;
  std::vector<Sensor> sensors_;
  Eigen::Index settled_ = 0;   ///< first sample that counts
  Eigen::MatrixXd measured_;   ///< samples x sensors
  Eigen::MatrixXd deviation_;  ///< counted samples x sensors; infinite where nothing was measured
};

}  // namespace kalfem

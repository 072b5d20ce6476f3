#pragma once

#include <optional>

#include "kalfem/base/progress.hpp"
#include "kalfem/base/spectrum.hpp"
#include "kalfem/casefile/study.hpp"
#include "kalfem/dynamics/reference.hpp"
#include "kalfem/estimation/consistency.hpp"
#include "kalfem/estimation/estimate.hpp"
#include "kalfem/prediction/base_driven.hpp"

namespace kalfem {

/// One quantity of one point as the estimation or the prediction gives it, with the reference where there is one.
struct PointQuantity {
  std::string point;
  ObservedQuantity quantity = ObservedQuantity::displacement;
  Eigen::VectorXd mean;
  Eigen::VectorXd deviation;            ///< empty where not known
  Eigen::VectorXd truth;                ///< empty where not known
  std::optional<double> nrmse;          ///< against the truth, after settling
  std::optional<double> nrmse_in_band;  ///< of an acceleration: the same of the part in the excitation's band
};

/// The reference solution and the record made from it.
struct SimulationStage {
  Reference reference;
  TimeSeries measurements;            ///< with noise, one channel a sensor
  std::vector<double> noise;          ///< standard deviation per sensor
  std::vector<PointQuantity> points;  ///< the reported points and connectors, free of noise
  double seconds = 0.0;
};

/// Undamped free vibration of one substructure as the case gives it.
struct SubstructureModes {
  std::string name;
  Eigen::Index dofs = 0;
  double mass = 0.0;            ///< [kg]
  Eigen::VectorXd frequencies;  ///< [Hz]; of a finite-element model the lowest only
  Eigen::MatrixXd shapes;       ///< dofs x modes, mass-normalised
};

/// Displacement of every degree of freedom of a finite-element substructure at some times, for pictures.
struct FieldSeries {
  std::string name;  ///< "frame_simulated"
  std::string substructure;
  std::vector<double> times;     ///< [s]
  Eigen::MatrixXd displacement;  ///< dofs of the full model x times
};

struct EstimationStage {
  FilterKind filter = FilterKind::unscented;
  std::string filter_reason;  ///< why this one, in words
  std::shared_ptr<const Observer> observer;
  EstimationResult result;
  TimeSeries measurements;  ///< of the sensors that the observer uses
  std::vector<double> noise;
  ConsistencySummary consistency;
  std::vector<PointQuantity>
      points;                ///< displacement, velocity, acceleration of points; deformation, rate, force of connectors
  Eigen::Index settled = 0;  ///< first sample that counts
  std::optional<FrequencyBand> band;  ///< of the excitation, where it has one
  double seconds = 0.0;
  std::optional<SimulationResult>
      open_loop;                             ///< the record again from the estimated parameters and initial state alone
  Eigen::MatrixXd open_loop_sensors;         ///< samples x sensors
  std::vector<double> open_loop_nrmse;       ///< per sensor, about the channel's rest
  std::vector<double> open_loop_rest_error;  ///< last value against the channel's, per sensor
};

struct PredictionStage {
  std::string substructure;
  std::vector<PointQuantity> points;
  double seconds = 0.0;
};

/// What was computed; stages that did not run are empty.
struct StudyResults {
  std::vector<SubstructureModes> modes;
  std::vector<FieldSeries> fields;
  std::optional<SimulationStage> simulation;
  std::optional<EstimationStage> estimation;
  std::optional<PredictionStage> prediction;
  std::string failure;  ///< in words, where the numbers are not usable
  double total_seconds = 0.0;

  [[nodiscard]] bool usable() const { return failure.empty(); }
};

enum class Stage { modes, simulate, estimate, predict };

/// Runs the stages of the case up to the given one, each as far as the case declares it.
StudyResults run_study(const Study& study, Stage last, const Progress& progress = {});

}  // namespace kalfem

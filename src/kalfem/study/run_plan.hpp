// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/dynamics/converged_solution.hpp"
#include "kalfem/formats/matrices.hpp"
#include "kalfem/identification/record_residual.hpp"
#include "kalfem/identification/simulation_residual.hpp"
#include "kalfem/identification/stated_in_updating.hpp"
#include "kalfem/updating/cma_es.hpp"
#include "kalfem/updating/gauss_newton.hpp"

/// The plan of each step of a run, with every name looked up and every number in SI.
namespace kalfem {

namespace description {
struct Simulation;
struct Prediction;
struct Report;
}  // namespace description

/// A reference solution and the record made from it.
struct SimulationPlan {
  double duration = 0.0, sample_rate = 0.0;  ///< [s], [Hz]
  SimulationOptions integration = {};        ///< its step is set by the refinement
  ConvergenceOptions convergence = {};
  InitialMotion initial = {};
  std::uint64_t seed = 1;  ///< of the sensors' noise

  /// Whether the case gives the number of steps instead of a tolerance.
  [[nodiscard]] bool has_fixed_step() const { return !convergence.refine; }
};
SimulationPlan make_simulation_plan(const description::Simulation& given);

/// The linear substructure to drive by the estimated motion of its boundary.
struct PredictionPlan {
  Name substructure;
  int substeps = 2;  ///< of a large substructure, steps per sample
};
PredictionPlan make_prediction_plan(const description::Prediction& given);

/// One of the comparisons of an updating as a residual.
struct ComparisonResidual {
  std::string name;
  std::string kind;                             ///< for reports: "natural frequencies of 'plane'"
  std::vector<ResidualPtr> continuation_steps;  ///< the same residual from smoothed to unsmoothed; usually one only
  double weight = 1.0;
  bool of_record = false;

  [[nodiscard]] const ResidualPtr& step(std::size_t number) const {
    return continuation_steps[std::min(number, continuation_steps.size() - 1)];
  }
};

/// A comparison with the record. It becomes a residual once the record is known.
struct RecordComparison {
  struct OfSimulation {
    std::vector<Sensor> sensors;
    SimulationResidual::Options options;
  };
  std::string name, kind;
  double weight = 1.0;
  std::variant<RecordResidual::Options, OfSimulation> what;
  SourceLocation location = {};
};

struct WideUpdating;
struct AlternativeUpdating;

/// The search for the updated parameters, and the comparisons that it minimises.
struct UpdatingPlan {
  UpdatingMethod method = UpdatingMethod::least_squares;
  int starts = 1;
  std::uint64_t seed = 1;  ///< of the random further starts
  GaussNewtonOptions search = {};
  CmaEsOptions evolution = {};
  bool check_sensitivities = false;
  std::shared_ptr<const ParameterisedStructure> structure;  ///< as a function of the updated parameters
  std::vector<ComparisonResidual> comparisons;              ///< those that need no record
  std::vector<RecordComparison> record_comparisons;
  SourceLocation location = {};  ///< of the parameters
  std::map<std::string, SourceLocation> parameter_locations = {};
  std::vector<KnownTo> known_to = {};             ///< how well numbers are known that are held fixed
  std::vector<FixedNumber> stated = {};           ///< numbers that are held fixed, and not known exactly
  std::shared_ptr<const WideUpdating> wide = {};  ///< with those of the structure; null: nothing is stated
  std::vector<std::shared_ptr<const AlternativeUpdating>> alternatives = {};  ///< other parameters, same measurements
};

/// The comparisons as functions of the updated parameters and, behind them, of stated numbers of the structure.
struct WideUpdating {
  UpdatingSetup setup;
  UpdatingPlan plan;
};

struct AlternativeUpdating {
  std::string name;
  UpdatingSetup setup;
  UpdatingPlan plan;
};

/// The updated structure with some of its parameters changed, to predict its natural frequencies.
struct StructuralModification {
  Located<std::string> name;
  std::string substructure;
  std::vector<std::pair<Parameter, double>> set;
  int modes = 10;
  double above = 0.0;  ///< [Hz]: lower frequencies are left out
};

/// Displacements of a finite-element substructure for pictures.
struct PicturePlan {
  std::string substructure;
  double every = 0.02;  ///< [s]
};

/// Contents of the report beside the results of the steps.
struct ReportPlan {
  std::optional<PicturePlan> pictures = {};
  int modes = 20;                               ///< natural frequencies of each substructure
  std::vector<std::string> displacements = {};  ///< points
  int frequencies = 0;                          ///< natural ones of the whole structure, over time
  double zoom = 1.0;                            ///< [s]
  std::vector<MatrixFormat> superelements = {};
  std::vector<std::string> strains = {};  ///< gauges
};
ReportPlan make_report_plan(const description::Report& given);

}  // namespace kalfem

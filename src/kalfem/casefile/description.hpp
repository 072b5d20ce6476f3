// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/casefile/connector_description.hpp"
#include "kalfem/casefile/finite_element_description.hpp"
#include "kalfem/casefile/frequency_response_description.hpp"
#include "kalfem/casefile/inference_description.hpp"
#include "kalfem/casefile/live_description.hpp"
#include "kalfem/casefile/static_description.hpp"
#include "kalfem/casefile/update_description.hpp"
#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/formats/matrices.hpp"
#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/identification/initial_state.hpp"
#include "kalfem/records/channel_preparation.hpp"
#include "kalfem/system/sensors/measurement_chain.hpp"
#include "kalfem/system/sensors/output_map.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/ground_motion.hpp"
#include "kalfem/yaml/schema.hpp"
#include "kalfem/yaml/yaml_node.hpp"

/// A case as its file states it, with the place of every name that is looked up later. study.hpp makes the model, the
/// signals and the augmented model from it. case_schema.cpp documents the meanings and units of the keys.
namespace kalfem::description {

struct Spring {
  std::string name;
  Name from, to;
  double stiffness = 0.0, damping = 0.0;
};
struct Chain {
  int masses = 1;
  double mass = 1.0, stiffness = 0.0, damping = 0.0;
};
struct Damping {
  std::vector<double> modal;
  double mass_factor = 0.0, stiffness_factor = 0.0;
  double modal_up_to = 500.0;  ///< finite elements only: modes up to this frequency have their own ratio
};

struct GlobalModalDamping {
  std::vector<double> modal;
  double up_to = 500.0;  ///< [Hz], finite elements only: modes up to this frequency have their own ratio
};

struct Substructure {
  std::optional<FiniteElements> finite_elements;
  std::optional<Located<Reduction>> reduction;
  std::optional<Name> preload;  ///< load case of `static`
  Named<Named<double>> masses;  ///< node -> direction -> mass; a node with one mass has the direction ""
  std::optional<Chain> chain;
  std::vector<Spring> springs;
  std::vector<std::string> grounds;
  Named<Named<double>> points;
  Damping damping;
};

/// Displacement that a test machine imposes on one end of a component.
struct ImposedMotion {
  Signal signal;
  double scale = 1.0;
  std::optional<ChannelSignal> velocity;  ///< measured too, in place of the displacement's derivative
};
/// A connector law on a test machine.
struct Component {
  Connector connector;                                ///< without its ends
  Located<ImposedMotion> motion;                      ///< of its end `to`
  std::optional<Located<ImposedMotion>> base_motion;  ///< of its end `from`; if empty, it is fixed
};

struct BaseDisplacement {
  Name ground;
};
/// Measured as geophones do; the displacement that moves the ground is its integral.
struct BaseVelocity {
  Name ground;
};
struct BaseAcceleration {
  Points direction;  ///< grounds, degrees of freedom, or "all"
};
struct Force {
  Name point;
};
/// What the filter assumes of an excitation that was not measured.
struct UnknownInput {
  std::optional<Value> std;
  double correlation_time = 0.1;  ///< [s]
  std::optional<int> order;       ///< of the Matern process, its smoothness + 1/2; if empty, 2, or 3 of a displacement
  std::optional<Value> random_walk;
};
/// A signal of a law; the program makes it of connectors.NAME.signals.
struct SignalTarget {
  Name ground;
};
struct Excitation {
  std::variant<BaseDisplacement, BaseVelocity, BaseAcceleration, Force, SignalTarget> target;
  std::optional<Signal> signal;  ///< empty only if it is unknown
  std::optional<Located<UnknownInput>> unknown;
  double scale = 1.0;
  std::optional<ChannelSignal> velocity = {};  ///< of an imposed motion, if it was measured too
  std::optional<Located<Drift>> drift;         ///< of the motion of accelerated grounds

  /// The signal if it is of this kind.
  template <class S>
  [[nodiscard]] const S* signal_as() const {
    return signal ? std::get_if<S>(&*signal) : nullptr;
  }
};

/// The measured quantity of a sensor, one type per key of the case file.
template <ObservedQuantity Q>
struct Observed {
  static constexpr ObservedQuantity quantity = Q;
  Points points;
};
using ObservedPoints =
    std::variant<Observed<ObservedQuantity::displacement>, Observed<ObservedQuantity::velocity>,
                 Observed<ObservedQuantity::acceleration>, Observed<ObservedQuantity::connector_force>,
                 Observed<ObservedQuantity::connector_deformation>, Observed<ObservedQuantity::connector_rate>,
                 Observed<ObservedQuantity::strain>>;
enum class ConnectorEnd { from, to };
struct Sensor {
  ObservedPoints observed;
  bool relative = false;
  Value noise;                      ///< a percentage of the channel's rms, or in the sensor's unit
  std::vector<ChainSection> chain;  ///< measurement chain
  std::optional<std::string> channel;
  Located<std::string> unit;  ///< of the channel; if empty, that of the record or of the column's title, otherwise SI
  std::optional<Located<std::filesystem::path>> file;  ///< of the channel; if empty, that of the record
  std::optional<Located<double>> mass;                 ///< between a load cell and its connector [kg]
  ConnectorEnd mass_at = ConnectorEnd::to;             ///< the end that carries it
  bool accept_constant = false;                        ///< the channel may hold one value throughout
  double gain = 1.0;                                   ///< its channel holds gain signal + offset, late by its clock
  std::optional<Value> offset;                         ///< in the sensor's unit
  double delay = 0.0;                                  ///< of its clock [s]
  double drift = 0.0;                                  ///< of its clock [s/s], see ClockLag
};

struct FreeResponse {
  double delay = 0.0;              ///< time from the release to the start of the case [s]
  double threshold = 5e-4;         ///< the filter stops once no channel is further from rest than this ...
  double margin = 0.5;             ///< ... and this time has passed since [s]
  std::optional<double> rest_std;  ///< of each channel's rest position if the record ends before it [m]
};
struct Record {
  Located<std::filesystem::path> file;
  std::optional<double> sample_rate;
  Located<std::string> unit;  ///< of the columns; if empty, those in their titles, otherwise SI
  std::string group;          ///< dataset of an HDF5 file
  std::optional<double> start, end;
  bool skip_missing = false;
  bool repair_splice = false;
  ChannelPreparation prepare;
  std::optional<FreeResponse> free_response;
};

/// Data that the estimates are tried on: another part of the record, or another record.
struct Validation {
  std::optional<Record> record;  ///< if empty, the case's own
  std::optional<double> start, end;
  std::optional<double> lead_in;  ///< the initial state is estimated from it; if empty, a tenth of the part [s]
  bool from_rest = false;         ///< instead, the structure is at rest at first
  Named<Located<std::filesystem::path>> excitation;  ///< files of inputs that are not in the record's own file
};

struct Simulation {
  double duration = 10.0, sample_rate = 1000.0;
  Integrator integrator = Integrator::newmark;
  double hht_alpha = -0.05, spectral_radius = 0.8, tolerance = 1e-3;
  int first_substeps = 4, max_substeps = 256;
  std::optional<Located<int>> substeps;  ///< a fixed number instead of these two
  bool superelements = false;            ///< instead of full finite-element models
  double modes_up_to = 1200.0;           ///< of these superelements [Hz]
  std::uint64_t seed = 1;                ///< of the sensors' noise
  InitialMotion initial;
};

struct Unknown {
  Value initial;
  std::optional<Value> std;
  std::optional<TransformKind> transform;
  std::optional<std::array<Quantity, 2>> bounds;
  std::optional<Value> random_walk;
  std::optional<Value> truth;
  std::vector<Name> applies_to;
};
struct Estimation {
  std::optional<FilterKind> filter;  ///< if empty, the system decides
  UnscentedOptions unscented;
  Named<Unknown> unknown;
  Named<Located<PointPrior>> initial_state;
  bool initial_state_from_record = false;
  Named<Located<ConnectorStatePrior>> initial_connector_states;
  AccelerationNoise process_noise;
  AdaptiveNoiseOptions adaptive_noise;
  std::optional<double> settle;  ///< if empty, by the structure and its start
  std::optional<LocalModelOptions> local;
  bool estimate_initial_state = false;
  int passes = 1;
  std::optional<int> substeps;               ///< if empty, the estimates decide
  std::optional<Located<int>> step_order;    ///< of the step over each; if empty, 4
  int threads = 0;                           ///< 0: one per processor
  std::optional<OutlierTreatment> outliers;  ///< if empty, robust where a run shows outliers
  bool diagnose = true;
  std::optional<double> second_thoughts;  ///< filter steps, in those of the first answer; if empty, see `diagnose`
  bool smooth = false;
  Named<Value> known_to;  ///< standard deviations of numbers that are held fixed
  FreeNumbers free = FreeNumbers::ask;
  std::optional<Located<LawComparison>> alternatives;  ///< laws beside that of the case
};

struct Prediction {
  Name substructure;
  int substeps = 2;  ///< of a large substructure, steps per sample
};
struct Pictures {
  Name substructure;
  double every = 0.02;  ///< [s]
};
struct Report {
  std::optional<Pictures> fields;
  int modes = 20;
  std::vector<Name> displacements;
  int frequencies = 0;
  double zoom = 1.0;
  Located<std::vector<MatrixFormat>> superelements;
  std::vector<Name> strains;
};

struct Case {
  int version = 1;
  std::string title;
  Named<Substructure> substructures;
  Named<Connector> connectors;
  Named<Joint> joints;
  std::optional<Located<Component>> component;
  std::optional<Located<GlobalModalDamping>> damping;
  Named<Excitation> excitation;
  Named<Sensor> sensors;
  std::optional<Simulation> simulate;
  std::optional<Record> record;
  std::optional<Located<Live>> live;
  std::optional<Estimation> estimate;
  std::optional<Located<Validation>> validate;
  std::optional<Prediction> predict;
  std::optional<Updating> update;
  Named<Located<Modification>> modifications;
  std::optional<Located<Inference>> infer;
  std::optional<Located<Placement>> place;
  std::optional<Located<Statics>> statics;
  std::optional<Located<FrequencyResponses>> frequency_response;
  Report report;
  CaseSource source;  ///< places of its keys
};

/// The schema of a case file. One table reads a case, writes it with its defaults, and documents its keys.
Schema<Case> case_schema();

}  // namespace kalfem::description

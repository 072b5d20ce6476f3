#pragma once

#include <map>
#include <memory>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/finite_element_part.hpp"
#include "kalfem/study/record_source.hpp"
#include "kalfem/study/structure_parameter.hpp"
#include "kalfem/updating/updating_parameter.hpp"

namespace kalfem {

/// A sensor of the case.
struct StudySensor {
  std::string name;
  OutputDescription output;
  MeasurementChain chain;
  bool relative_noise = false;  ///< noise is a part of the channel's rms
  double noise = 0.0;           ///< standard deviation, in the sensor's unit or as that part
  std::string unit;

  /// Standard deviation of the noise on a channel of that rms.
  [[nodiscard]] double deviation(double channel_rms) const { return relative_noise ? noise * channel_rms : noise; }
};

/// The parts of a case at some theta, its finite elements reduced there.
struct StructureAtParameters {
  StructureParts parts;
  /// The finite-element substructures as functions of theta in the bases that they have been reduced to.
  std::vector<std::shared_ptr<const ParameterisedModel>> in_basis;
};

/// Unknowns of the filter on which the augmented model's linear part depends. Some are numbers of linear substructures
/// that no connector can carry. Others are carried by connectors, but the linear part's damping follows them: a
/// released spring of a substructure with modal damping.
struct LinearUnknowns {
  std::vector<std::string> names;          ///< one an unknown
  std::vector<double> initial;             ///< first guesses
  std::vector<StructureBinding> bindings;  ///< of those that no connector carries; the index is the place among all
  std::map<std::string, double> present;   ///< values that stood in for first guesses when the augmented model was made
  std::shared_ptr<const StructureParts>
      parts;                   ///< from which the augmented model was made, before anything was released
  Eigen::VectorXd reduced_at;  ///< values at which the finite elements are reduced
  /// The structure there: its bases serve for all values. Nothing where there are no bindings.
  std::shared_ptr<const StructureAtParameters> structure;

  [[nodiscard]] bool empty() const { return names.empty(); }
};

/// What the augmented model is made of: its own model, which may be a part of the structure and holds the guesses of
/// unknowns in its linear part, and the sensors that it uses.
struct AugmentedModelSetup {
  std::shared_ptr<const CoupledModel> model;
  std::vector<StudySensor> sensors;
  AugmentedModelOptions options;
  std::vector<std::string> input_sources;  ///< name of the excitation of each input, or of a sensor ("@name")
  std::vector<std::optional<double>> true_parameters;  ///< one an unknown
  LinearUnknowns linear_unknowns;
};

/// What the case's `update` refines.
struct UpdatingSetup {
  std::vector<UpdatingParameter> parameters;
  std::vector<StructureBinding> bindings;              ///< where theta stands in the substructures
  std::vector<std::optional<double>> true_parameters;  ///< one a parameter
};

/// A finite-element substructure in the orders of model that the stages use.
struct StudyElements {
  FiniteElementPartPtr part;
  std::shared_ptr<const Superelement> reduced;    ///< in the augmented model; empty where nothing is attached
  std::shared_ptr<const Superelement> reference;  ///< in the simulation; empty: the full model
};

/// A case that was read and understood: everything that the stages need. Immutable.
struct Study {
  description::Case given;
  std::string file;
  std::vector<StudyElements> finite_elements;
  StructureParts parts;  ///< with reduced finite-element substructures
  double reduce_seconds = 0.0;
  std::shared_ptr<const CoupledModel> model;  ///< the structure as the case gives it
  std::vector<StudySensor> sensors;
  std::vector<SignalPtr> signals;                      ///< one an input
  std::optional<MeasuredRecord> record;                ///< where the case reads one
  std::optional<UpdatingSetup> updating;               ///< where the case updates
  std::optional<AugmentedModelSetup> augmented_model;  ///< where the case estimates; of what the updating starts from
  std::vector<std::string> warnings;                   ///< what is allowed but probably not meant

  [[nodiscard]] double sample_rate() const;
};

/// Reads a case file. Throws InvalidInput with every problem found in it and in the files it names.
Study load_study(const std::string& file);
/// The same of a case that was read from `file`.
Study make_study(description::Case given, const std::string& file);

}  // namespace kalfem

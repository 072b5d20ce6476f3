// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/casefile/finite_element_description.hpp"
#include "kalfem/correlation/expansion_method.hpp"
#include "kalfem/formats/tables/frf_table.hpp"
#include "kalfem/identification/updating_setup.hpp"
#include "kalfem/updating/frf_scale.hpp"

/// The updating of a case as its file states it, see description.hpp.
namespace kalfem::description {

struct UpdatedParameter {
  std::optional<Value> initial;  ///< if empty, the value in the substructure
  std::optional<Value> std;      ///< of the prior; if empty, there is no prior
  std::optional<Located<std::array<Quantity, 2>>> bounds;
  std::optional<Value> truth;
  std::vector<Name> applies_to;
};

/// A column of numbers in a text table.
struct TableColumn {
  std::filesystem::path file;
  std::string column;
  std::optional<int> first;  ///< number of rows to read
};
using ListedNumbers = std::variant<std::vector<double>, TableColumn>;
/// One deviation for all, or a column with one a mode.
using Deviation = std::variant<Value, TableColumn>;
/// Mode shapes in a text table: one row per point, one column per mode; an empty cell was not measured.
struct ShapeTable {
  std::filesystem::path file;
  std::vector<Name> points;
  double deviation = 0.05;                          ///< of an entry, relative to the largest one of the shape
  std::optional<std::filesystem::path> deviations;  ///< of each entry, a table as that of the shapes
};

/// Modes as numbers and tables.
struct ListedModes {
  Located<ListedNumbers> frequencies;
  std::optional<ShapeTable> shapes;
  std::optional<Located<ListedNumbers>> dampings;
};
/// Modes of a file with all that belongs to them.
struct ModeFile {
  Located<std::filesystem::path> file;
  Named<Located<std::string>> points;  ///< of the substructure, with the file's names of them; none: they have the same
  std::vector<int> only;               ///< numbers of the modes in the file, from 1; none: all
  std::optional<double> shape_deviation;
  bool dampings = false;
  double max_complexity = 0.25;
};

/// Natural frequencies, damping ratios and mode shapes of a substructure.
struct ModalData {
  Name substructure;
  std::variant<ListedModes, ModeFile> measured;
  Deviation deviation;
  Deviation damping_deviation;
  std::vector<int> model_modes;
  double above = 0.0;
  double minimum_mac = 0.5;
  ExpansionMethod expansion = ExpansionMethod::model;
};

/// Frequency responses to one input.
struct FrfForce {
  Name point;
};
struct FrfGround {
  Name ground;
};
enum class FrfQuantity { displacement, velocity, acceleration };
/// Source of the responses: a table, or a record from which H1 is estimated.
struct FrfFile {
  Located<std::filesystem::path> file;
  FrfColumnContent values = FrfColumnContent::complex;  ///< used for columns whose names do not state it
};
struct FrfRecordSource {
  Located<std::filesystem::path> file;
  std::string input;     ///< column of the force, or of the ground's motion
  double segment = 8.0;  ///< [s]
  std::string dataset;   ///< of an HDF5 file
  std::optional<double> sample_rate;
};
struct FrfInput {
  std::variant<FrfForce, FrfGround> input;
  std::variant<FrfFile, FrfRecordSource> source;
  std::vector<std::string>
      columns;  ///< one per output; if empty, all columns in order, or for a record those named as the outputs
};
enum class FrfComparison { logarithm, log_magnitude, difference };
struct FrfData {
  Name substructure;
  std::vector<FrfInput> inputs;
  std::vector<Name> outputs;
  FrfQuantity quantity = FrfQuantity::acceleration;
  std::vector<std::array<double, 2>> bands;
  FrfComparison compare = FrfComparison::logarithm;
  FrfScale scale = FrfScale::fixed;
  double deviation = 0.05;  ///< relative to each value
  double floor = 0.05;      ///< relative to the rms of the lines in use
  double smoothing = 0.0;   ///< [Hz]
};

/// Deflections under constant loads.
struct StaticData {
  Name substructure;
  Named<Located<double>> loads;          ///< by point [N]
  Named<Located<double>> displacements;  ///< by point [m]
  double deviation = 0.01;               ///< relative to the largest displacement
};

/// How the estimated motion of a boundary is differentiated.
enum class HistoryDerivatives { automatic, filter_passes, held_gains };
/// The record against a substructure that is driven by the estimated motion of its boundary.
struct DrivenHistory {
  Name substructure;
  std::vector<Name> sensors;  ///< if empty, all on the substructure
  HistoryDerivatives derivatives = HistoryDerivatives::automatic;
};
/// The record against the simulation of the whole structure.
struct SimulatedHistory {
  std::vector<Name> sensors;  ///< "all", or some
};

struct Comparison {
  std::variant<ModalData, FrfData, StaticData, DrivenHistory, SimulatedHistory> data;
  double weight = 1.0;
};

struct Evolution {
  int generations = 200, population = 0;
  std::uint64_t seed = 1;
};
/// Other parameters of the same structure, fitted to the same measurements.
struct UpdatingAlternative {
  Named<Located<UpdatedParameter>> parameters;
};
struct Updating {
  Named<Located<UpdatedParameter>> parameters;
  Named<Located<Comparison>> comparisons;
  UpdatingMethod method = UpdatingMethod::least_squares;
  int starts = 1;
  int stages = 100;
  double tolerance = 1e-5;  ///< the updating stops once every parameter changes by less than this, relative
  Evolution evolution;
  bool check_sensitivities = false;
  std::uint64_t seed = 1;
  Named<Value> known_to;  ///< standard deviations of numbers that are held fixed
  Named<Located<UpdatingAlternative>> alternatives;
  std::optional<std::filesystem::path> write_deck;  ///< folder; if empty, updated_decks in that of the results
};

/// A change of some parameters of the updated structure, whose natural frequencies are predicted.
struct Modification {
  Name substructure;
  Named<Value> set;    ///< by the parameter's name in the substructure
  int modes = 10;      ///< natural frequencies to predict
  double above = 0.0;  ///< [Hz]: lower ones are left out
};

}  // namespace kalfem::description

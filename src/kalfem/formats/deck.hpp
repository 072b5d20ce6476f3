// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/formats/ledger.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/statics/load_case.hpp"
#include "kalfem/model/unit_system.hpp"

namespace kalfem {

/// A model out of another code's input file, in the file's own units, with what was left out of it.
struct Deck {
  FiniteElementModel model;
  std::vector<DeckNote> notes;            ///< in the order of their first places
  std::vector<LoadCase> load_cases = {};  ///< if they are asked for, see DeckOptions
  std::optional<LoadCase> preload = {};   ///< whose stresses the structure carries in the deck's own modes
  bool is_static_analysis = false;        ///< it asks for statics alone, which need no mass
  std::vector<LedgerEntry> ledger = {};   ///< if it is asked for
};

/// Notes of the kind `missing` that are not accepted become issues; accepted ones stay, as doubtful notes. Names are
/// compared without regard to case, blanks and a leading '*'. Returns the accepted names that the deck does not hold.
std::vector<std::string> accept_missing(std::vector<DeckNote>& notes, const std::vector<std::string>& accepted,
                                        IssueList& issues);

enum class DeckFormat { automatic, abaqus, nastran };

/// Whether a file's name ends as those of decks do: .inp, .bdf, .dat, .nas, .blk, in any case.
bool is_deck(const std::filesystem::path& file);

struct DeckOptions {
  DeckFormat format = DeckFormat::automatic;  ///< a name that ends in .inp is of Abaqus or CalculiX, others of Nastran
  std::optional<double> temperature = {};     ///< at which materials are taken, in the deck's unit; empty: the deck's
                                              ///< initial temperature
  std::optional<std::int64_t> subcase = {};   ///< SUBCASE of Nastran whose structure is meant; empty: the first one
                                              ///< with METHOD, or the first one
  bool load_cases = false;                    ///< read the static load cases too
  bool ledger = false;                        ///< keep what became of every field
};

/// Reads another code's input file, see abaqus.hpp and nastran.hpp.
Deck read_deck(const std::filesystem::path& file, const DeckOptions& options = {});

/// Stiffness, mass and damping in one file or several, see read_superelement().
struct MatrixSetFiles {
  std::vector<std::filesystem::path> files;
  std::string stiffness = {}, mass = {},
              damping = {};                           ///< names of the matrices; empty: by the usual ones (K, KAA ...)
  std::optional<std::filesystem::path> dof_map = {};  ///< where the files do not say what the rows are
  int directions = 0;         ///< of each node, where the map lists nodes alone, see DofMapOptions
  SourceLocation where = {};  ///< in the case, for messages
};

/// A structure of which only matrices are known.
struct MatrixDeckFiles {
  std::vector<MatrixSetFiles> sets;
  std::optional<std::filesystem::path> coordinates = {};  ///< table (CSV) with node, x, y, z
  UnitSystem units = {};                                  ///< of all numbers
};

/// Turns matrices of another code into a model without elements, in SI. Each node of that code becomes a node, at its
/// coordinates or, where none are given, at the origin; NodalMatrices join the nodes. Sets that name a degree of
/// freedom of one node number both are joined there. A generalised coordinate becomes the motion x of a node of its
/// own, numbered beyond all others; a further copy of a node does too. Throws InvalidInput with every problem.
Deck read_matrix_deck(const MatrixDeckFiles& files);

/// A matrix by its file and, where that holds several, by its name.
struct NamedMatrixFile {
  std::filesystem::path file;
  std::string name = {};
};

/// Matrices K_i, M_i, C_i that a factor multiplies; at least one.
struct FactorMatrixFiles {
  std::optional<NamedMatrixFile> stiffness = {}, mass = {}, damping = {};
  std::optional<std::filesystem::path> dof_map = {};  ///< where the files do not say what the rows are
  int directions = 0;  ///< of each node, where the map lists nodes alone, see DofMapOptions
  UnitSystem units = {};
};

/// Gives the model a factor a of matrices of files (see PartFactor), whose parameter is "<factor>.factor": K = K_0 + a
/// K_i. Rows are what the files or the map say, else those of the model's matrices where it has one set of them. Throws
/// InvalidInput where the model has a factor of that name, and with every matrix of another size, that is not symmetric
/// (to 1e-9 of its largest entry) or not finite, and where the model lacks a node.
void add_matrix_factor(FiniteElementModel& model, const std::string& factor, const FactorMatrixFiles& files,
                       double value = 1.0);

}  // namespace kalfem

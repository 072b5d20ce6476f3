// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/abaqus/deck_lines.hpp"
#include "kalfem/formats/ledger.hpp"
#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem::abaqus {

/// What becomes of an element.
enum class Family {
  shell,
  membrane,
  solid,
  beam,
  truss,
  ground_spring,     ///< SPRING1
  spring,            ///< SPRING2
  axial_spring,      ///< SPRINGA
  ground_dashpot,    ///< DASHPOT1
  dashpot,           ///< DASHPOT2
  axial_dashpot,     ///< DASHPOTA
  mass,              ///< MASS
  rotary_inertia,    ///< ROTARYI
  reference,         ///< DCOUP3D: the reference node of a distributing coupling
  rigid,             ///< R3D3, R3D4, RB3D2: shape of a rigid body
  without_stiffness  ///< surface elements and gaps
};

struct ElementType {
  Family family = Family::shell;
  CellShape shape = CellShape::point1;
  int nodes = 0;                         ///< in the deck
  SolidKind kind = SolidKind::standard;  ///< of a solid
  bool shear_rigid = false;              ///< of a beam: Euler-Bernoulli
  std::string remark = {};               ///< what is left out of the element, for a note; may be empty
  DeckNoteKind remark_kind = DeckNoteKind::changed;
};

/// The element type by its name, in any case; nothing where it cannot be read.
std::optional<ElementType> element_type(std::string_view name);

/// Whether the family becomes cells of the mesh.
inline bool is_cell(Family family) { return family <= Family::beam; }

/// The name of a set or the number of a node or element, as it stands in the deck.
struct SetReference {
  std::string text;
  Where where;
};

/// One data line, in fields.
struct DataLine {
  Where where;
  std::vector<std::string> fields;
  mutable std::uint64_t asked = 0;  ///< bit i: the reader looked at field i, the last one stands for all behind it

  /// The field, "" behind the last one. It counts as asked for, see settle_ledger().
  [[nodiscard]] const std::string& field(std::size_t index) const {
    static const std::string none;
    asked |= bit(index);
    return index < fields.size() ? fields[index] : none;
  }
  /// Takes a field back that was looked at and does not count.
  void forget(std::size_t index) const { asked &= ~bit(index); }
  [[nodiscard]] bool is_asked(std::size_t index) const { return (asked & bit(index)) != 0; }
  static std::uint64_t bit(std::size_t index) { return std::uint64_t{1} << std::min<std::size_t>(index, 63); }
};

/// A keyword with its data lines and the keywords that belong to it.
struct Block {
  Keyword keyword;
  std::vector<DataLine> lines;
  std::vector<Block> options = {};

  [[nodiscard]] const Block* option(std::string_view name) const {
    for (const auto& block : options)
      if (block.keyword.name == name) return &block;
    return nullptr;
  }
};

/// A set as its pieces were given; what they name is looked up at the end.
struct RawSet {
  struct Range {
    std::int64_t first, last, step;
  };
  struct Piece {
    std::string instance;  ///< whose numbers they are; empty: those of the set's own scope
    std::vector<std::int64_t> labels;
    std::vector<Range> ranges;
    std::vector<SetReference> names;          ///< sets, or numbers with an instance
    std::optional<SetReference> of_elements;  ///< all nodes of this element set
    Where where = {};
  };
  std::string name;  ///< as first spelled
  bool internal = false;
  std::vector<Piece> pieces;
};

/// Nodes as they stand in the deck, already in the axes of their scope.
struct RawNodes {
  std::vector<std::int64_t> labels;
  std::vector<double> coordinates;  ///< 3 a node
  std::vector<Where> places;
};

struct RawElement {
  std::int64_t label = 0;
  std::int64_t first = 0;  ///< position of its nodes
  Where where;
  int type = 0;         ///< position in RawDeck::types
  int extra_node = -1;  ///< of a beam: position of the node that shows the direction 1, behind the others
};

/// A part, an instance's own data, or the whole deck beside its parts.
struct Scope {
  std::string name;
  RawNodes nodes;
  std::vector<RawElement> elements;
  std::vector<std::int64_t> connectivity;   ///< numbers of nodes; -1 - i: named_nodes[i]
  std::vector<SetReference> named_nodes;    ///< "instance.number"
  std::map<std::string, RawSet> node_sets;  ///< by name in capitals
  std::map<std::string, RawSet> element_sets;
  std::vector<Block> blocks;  ///< everything else, in its order
};

/// A part placed in the assembly.
struct RawInstance {
  std::string name;
  std::string part;
  Where where;
  std::vector<DataLine> placement;  ///< at most a translation and a rotation
  Scope own;
};

/// A deck as it was read, before names are looked up.
struct RawDeck {
  struct Type {
    std::string name;
    ElementType type;
  };
  struct Material {
    std::string name;
    Where where;
    std::vector<Block> blocks;
  };
  struct Matrix {
    std::string name;
    Where where;
    std::string stiffness, mass;  ///< texts of its files
  };
  /// A step with what it holds and loads.
  struct Step {
    int number = 0;
    Keyword keyword = {};            ///< *STEP
    std::string procedure = {};      ///< "STATIC", "FREQUENCY", ...; empty where none was given
    double period = 1.0;             ///< of a static step, the time to which amplitudes run
    Block procedure_data = {};       ///< of *STATIC and *FREQUENCY
    std::vector<Block> blocks = {};  ///< BOUNDARY, TEMPERATURE and loads

    [[nodiscard]] bool is_static() const { return procedure == "STATIC"; }
    [[nodiscard]] bool is_perturbation() const { return keyword.has("PERTURBATION"); }
    /// Large displacements.
    [[nodiscard]] bool is_nonlinear() const { return keyword.has("NLGEOM") && keyword.word("NLGEOM") != "NO"; }
    [[nodiscard]] std::string name() const { return "step" + std::to_string(number); }  ///< of its load case
  };
  Scope root;
  std::vector<Step> steps;
  bool load_cases = false;  ///< loads of the steps are wanted
  bool expands = false;     ///< a material has *EXPANSION
  std::optional<Where> initial_stress = {};
  std::vector<Keyword> keywords;  ///< *NODE, *MATERIAL and others whose data lines are not kept
  /// Fields behind those that a line of *NODE, *ELEMENT or a set has.
  struct ExtraFields {
    std::string card, field, consequence;
    Where where;
    std::size_t count = 0;
  };
  std::vector<ExtraFields> extra_fields;
  /// A keyword of which nothing is read.
  struct PassedOver {
    std::string title;
    Where where;
    bool is_lacking = false;  ///< the model would be incomplete without it
  };
  std::vector<PassedOver> passed_over;
  std::map<std::string, Scope> parts;
  std::vector<RawInstance> instances;
  std::map<std::string, Material> materials;
  std::vector<Matrix> matrices;
  std::vector<Type> types;
  bool from_abaqus = false;                ///< it has keywords that CalculiX does not know
  std::optional<double> temperature = {};  ///< at which materials are taken, if the user states one
};

/// The field as a number, `otherwise` where it is empty; what is neither is a problem that names `what`.
double number_or(const DataLine& line, std::size_t field, double otherwise, const std::string& what,
                 Problems& problems);
/// The field as a number; an empty one is a problem too, and nothing is returned.
std::optional<double> number_at(const DataLine& line, std::size_t field, const std::string& what, Problems& problems);
/// All fields of some lines as one row; empty ones are 0.
std::vector<double> all_numbers(std::span<const DataLine> lines, const std::string& what, Problems& problems);
/// The value of a parameter as a number; nothing where it is absent, a problem where it is none.
std::optional<double> number_parameter(const Keyword& keyword, std::string_view parameter, Problems& problems);
/// The line of a block, an empty one behind the last.
const DataLine& line_of(const Block& block, std::size_t index);

/// Without blanks around it.
std::string_view trimmed_field(std::string_view text);
/// What a message can show of a field: at most 40 printable characters.
std::string to_string(std::string_view field);

/// The number that fills the whole field, exponents by E or D; nothing where it is none or not finite.
std::optional<double> to_number(std::string_view field);
std::optional<std::int64_t> to_integer(std::string_view field);
/// The number of a node or element: an integer from 1 to 10^12; nothing else.
std::optional<std::int64_t> to_label(std::string_view field);

/// Gives the fields of a data line one after the other: between commas, without blanks and quotation marks around them.
class FieldCursor {
public:
  explicit FieldCursor(std::string_view line) : rest_(line) {}
  /// False behind the last field. A comma at the end of the line has no field behind it.
  bool next(std::string_view& field);

private:
  std::string_view rest_;
};

/// All fields of a line.
std::vector<std::string> split_fields(std::string_view line);

}  // namespace kalfem::abaqus

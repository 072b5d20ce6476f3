// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/elements.hpp"

#include <cmath>

#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

/// Position in [xx yy zz xy yz xz] of the components in the deck's order 11 22 33 12 13 23.
constexpr std::array<Index, 6> component = {0, 1, 2, 3, 5, 4};

/// Stiffness from E1 E2 E3 nu12 nu13 nu23 G12 G13 G23; nothing where it is not positive definite.
std::optional<Matrix6> from_engineering_constants(const std::vector<double>& c) {
  for (const std::size_t i : {0, 1, 2, 6, 7, 8})
    if (!(c[i] > 0.0)) return {};
  Matrix6 compliance = Matrix6::Zero();
  for (Index i = 0; i < 3; ++i) compliance(i, i) = 1.0 / c[static_cast<std::size_t>(i)];
  compliance(0, 1) = compliance(1, 0) = -c[3] / c[0];
  compliance(0, 2) = compliance(2, 0) = -c[4] / c[0];
  compliance(1, 2) = compliance(2, 1) = -c[5] / c[1];
  for (std::size_t i = 0; i < 3; ++i) compliance(component[3 + i], component[3 + i]) = 1.0 / c[6 + i];
  const Eigen::LLT<Matrix6> factor(compliance);
  if (factor.info() != Eigen::Success) return {};
  return Matrix6(factor.solve(Matrix6::Identity()));
}

/// Stiffness from the deck's list of its upper triangle by columns; of an orthotropic one only the normal block and the
/// diagonal are given.
Matrix6 from_stiffnesses(const std::vector<double>& values, bool orthotropic) {
  Matrix6 stiffness = Matrix6::Zero();
  std::size_t next = 0;
  for (std::size_t column = 0; column < 6; ++column)
    for (std::size_t row = orthotropic && column >= 3 ? column : 0; row <= column; ++row)
      stiffness(component[row], component[column]) = stiffness(component[column], component[row]) = values[next++];
  return stiffness;
}

std::optional<OrthotropicSheet> sheet_from(const Matrix6& stiffness, double density) {
  const Eigen::LLT<Matrix6> factor(stiffness);
  if (factor.info() != Eigen::Success) return {};
  const Matrix6 c = factor.solve(Matrix6::Identity());
  return OrthotropicSheet{1.0 / c(0, 0), 1.0 / c(1, 1), -c(0, 1) / c(0, 0), 1.0 / c(3, 3), 1.0 / c(5, 5),
                          1.0 / c(4, 4), density};
}

}  // namespace

// A material is read when a section first asks for it. So materials that nothing uses may be incomplete, and one that
// is broken is told once.
const Elastic* Materials::find(const std::string& name, const Where& where) {
  const std::string key = upper_case(name);
  if (const auto known = known_.find(key); known != known_.end()) return &known->second;
  if (broken_.contains(key)) return nullptr;
  const auto raw = raw_.materials.find(key);
  if (raw == raw_.materials.end()) {
    std::vector<std::string> names;
    for (const auto& [other, material] : raw_.materials) names.push_back(material.name);
    deck_.problems.add(where,
                       name.empty() ? "the section has no MATERIAL"
                                    : "there is no material '" + to_string(name) + "'" + did_you_mean(name, names),
                       "", "define it by *MATERIAL, NAME=...");
    broken_.insert(key);
    return nullptr;
  }
  const Block* elastic = nullptr;
  for (const auto& block : raw->second.blocks)
    if (block.keyword.name == "ELASTIC") elastic = &block;
  if (!elastic) {
    deck_.problems.add(raw->second.where, "the material '" + to_string(raw->second.name) + "' has no *ELASTIC",
                       "a section uses it", "give Young's modulus and Poisson's ratio");
    broken_.insert(key);
    return nullptr;
  }
  Elastic& material = known_[key];
  material.name = raw->second.name;
  read(raw->second, material);
  if (material.sheet || material.solid) return &material;
  known_.erase(key);  // its constants cannot be used, which has been told
  broken_.insert(key);
  return nullptr;
}

void Materials::read(const RawDeck::Material& raw, Elastic& material) {
  for (const auto& block : raw.blocks) {
    if (block.keyword.name != "DENSITY") continue;
    if (const auto values = constants_at(temperature_, block, 1, 1, deck_); !values.empty())
      material.scalar.density = values.front();
  }
  for (const auto& block : raw.blocks)
    if (block.keyword.name == "ELASTIC") read_elastic(block, material);
}

// Values at the temperature of the model are interpolated, see constants_at(). Types of *ELASTIC: ISOTROPIC (E, nu),
// LAMINA (E1 E2 nu12 G12 G13 G23), ENGINEERING CONSTANTS (9), ORTHOTROPIC (9 stiffnesses) and ANISOTROPIC (21). Solids
// take the 6 x 6 stiffness, shells a sheet in plane stress, whose constants follow from the compliance. The scalar E
// and nu of such a material serve beams and trusses.
void Materials::read_elastic(const Block& block, Elastic& material) {
  const std::string type = block.keyword.word("TYPE");
  const auto values_of = [&](std::size_t least, std::size_t count) {
    return constants_at(temperature_, block, least, count, deck_);
  };
  if (block.keyword.has("MODULI"))
    deck_.notes.add(deck_.problems.location(block.keyword.where), "*ELASTIC, MODULI", "the moduli are used as given",
                    DeckNoteKind::unused);
  material.isotropic = false;
  if (type.empty() || type.starts_with("ISO")) {
    material.isotropic = true;
    const auto values = values_of(1, 2);
    if (values.empty()) return;
    material.scalar.youngs_modulus = values[0];
    material.scalar.poissons_ratio = values[1];
    material.sheet = sheet_of(material.scalar);
    return;
  }
  const bool is_lamina = type.starts_with("LAMINA"), is_orthotropic = type.starts_with("ORTHO"),
             is_anisotropic = type.starts_with("ANISO");
  if (!is_lamina && !is_orthotropic && !is_anisotropic && !type.starts_with("ENG"))
    return deck_.problems.add(block.keyword.where, "*ELASTIC has TYPE=" + to_string(type),
                              "supported: isotropic, engineering constants, lamina, orthotropic and anisotropic",
                              "correct it");
  const auto c = is_lamina ? values_of(4, 6) : is_anisotropic ? values_of(21, 21) : values_of(9, 9);
  if (c.empty()) return;
  if (is_lamina)
    material.sheet = OrthotropicSheet{c[0], c[1], c[2], c[3], c[4], c[5], material.scalar.density};
  else if (is_orthotropic || is_anisotropic)
    material.solid = from_stiffnesses(c, is_orthotropic);
  else
    material.solid = from_engineering_constants(c);
  if (material.solid) {
    if (Eigen::LLT<Matrix6>(*material.solid).info() != Eigen::Success)
      material.solid.reset();
    else if (!is_anisotropic)
      material.sheet = sheet_from(*material.solid, material.scalar.density);
  }
  if (!material.solid && !material.sheet)
    deck_.problems.add(block.keyword.where,
                       "the elastic constants of '" + to_string(material.name) + "' are not positive",
                       "strain energy must be positive", "check their order and values");
  material.scalar.youngs_modulus = material.sheet   ? material.sheet->youngs_modulus_1
                                   : material.solid ? material.solid->trace() / 6.0
                                                    : 1.0;
  material.scalar.poissons_ratio = 0.3;
}

std::map<std::string, IsotropicMaterial> Materials::used() const {
  std::map<std::string, IsotropicMaterial> result;
  for (const auto& [key, material] : known_) result[material.name] = material.scalar;
  return result;
}

}  // namespace kalfem::abaqus

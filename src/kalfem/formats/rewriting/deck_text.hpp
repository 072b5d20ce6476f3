// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/nastran.hpp"
#include "kalfem/formats/updated_deck.hpp"

namespace kalfem::rewriting {

/// A field in the text of a deck.
struct FieldPlace {
  std::size_t card = 0;  ///< position among the cards that are kept
  int line = 0;          ///< data line of an Abaqus keyword; -1: the keyword itself
  int field = 0;
  friend auto operator<=>(const FieldPlace&, const FieldPlace&) = default;
};

/// Why a value cannot be written, and what the user can do.
class Unwritable : public std::runtime_error {
public:
  Unwritable(const std::string& why, std::string fix) : std::runtime_error(why), fix_(std::move(fix)) {}
  [[nodiscard]] const std::string& fix() const { return fix_; }

private:
  std::string fix_;
};

/// A card that is made of a material.
struct MaterialUse {
  std::vector<FieldPlace> references = {};  ///< where it names the material
  std::vector<std::string> regions = {};    ///< of the model that it gives properties
  bool is_fixed = false;                    ///< part of the model that does not follow the material's parameters
};

/// A new number of a material.
struct MaterialNumber {
  FieldPlace place;
  double value = 0.0;
  std::string cause = {};
};
using Numbers = std::vector<MaterialNumber>;

/// Texts of a deck's files, by their paths.
using Texts = std::map<std::string, std::string>;

/// The text of a deck, field by field. Changes are asked for first; apply() makes them all.
class DeckText {
public:
  virtual ~DeckText() = default;

  /// Fields that are proportional to a thickness, a mass or a stiffness. Throws Unwritable.
  [[nodiscard]] virtual std::vector<FieldPlace> fields_of(const std::string& parameter) const = 0;
  /// Fields that are proportional to "youngs_modulus" or "density" of a material. Throws Unwritable.
  [[nodiscard]] virtual std::vector<FieldPlace> material_fields(const std::string& material,
                                                                const std::string& quantity) const = 0;
  [[nodiscard]] virtual std::vector<MaterialUse> uses_of(const std::string& material,
                                                         const FiniteElementModel& model) const = 0;
  /// The number in a field. Throws Unwritable where there is none.
  [[nodiscard]] virtual double number(const FieldPlace& place) const = 0;
  virtual void set(const FieldPlace& place, double value, const std::string& cause) = 0;
  /// Gives some users of a material a copy of it with other numbers. Throws Unwritable.
  virtual void split(const std::string& material, const Numbers& numbers, const std::vector<MaterialUse>& users,
                     const std::string& cause) = 0;
  /// The texts of the files that change; the changes are appended.
  [[nodiscard]] virtual Texts apply(std::vector<DeckFieldChange>& changes) = 0;
};

/// "steel.youngs_modulus" is ("steel", "youngs_modulus").
inline std::pair<std::string, std::string> split_name(const std::string& parameter) {
  const auto dot = parameter.rfind('.');
  if (dot == std::string::npos) return {parameter, ""};
  return {parameter.substr(0, dot), parameter.substr(dot + 1)};
}

/// Replacements in one text by place; they do not overlap.
class TextEdits {
public:
  void replace(std::size_t at, std::size_t length, const std::string& text) {
    edits_[at].first = length;
    edits_[at].second += text;
  }
  /// In front of what stands there, or of what replaces it.
  void insert(std::size_t at, const std::string& text) { edits_[at].second.insert(0, text); }
  [[nodiscard]] std::string applied(const std::string& text) const {
    std::string result;
    std::size_t from = 0;
    for (const auto& [at, edit] : edits_) {
      result.append(text, from, at - from).append(edit.second);
      from = at + edit.first;
    }
    return result.append(text, from);
  }

private:
  std::map<std::size_t, std::pair<std::size_t, std::string>> edits_;
};

/// The keywords of a deck of Abaqus or CalculiX that read_abaqus() accepts; `origins` as it found them.
std::unique_ptr<DeckText> abaqus_text(const std::string& content, const std::string& source, const DeckLoader& loader,
                                      const DeckOrigins& origins);

/// The bulk data of a deck whose texts, INCLUDEs in their places, read_nastran() accepts.
std::unique_ptr<DeckText> nastran_text(const std::string& content, const std::string& source,
                                       const NastranIncludes& includes);

}  // namespace kalfem::rewriting

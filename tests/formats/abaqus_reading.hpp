// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <sstream>

#include "formats/abaqus_decks.hpp"
#include "kalfem/model/statics/load_case.hpp"

// A deck of Abaqus or CalculiX as lines and fields, and all that kalfem makes of it as one text to compare.

namespace kalfem {

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

inline std::string joined(const std::vector<std::string>& parts, const char* by) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) text += (i > 0 ? by : "") + parts[i];
  return text;
}

inline std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    const auto first = field.find_first_not_of(' ');
    fields.push_back(first == std::string::npos ? "" : field.substr(first));
  }
  return fields;
}

/// A vector that shows the matrix without its order.
inline Eigen::VectorXd shadow(const SparseMatrix& matrix) {
  Eigen::VectorXd weights(matrix.cols());
  std::mt19937 random(1);
  for (auto& weight : weights) weight = std::uniform_real_distribution(0.5, 1.5)(random);
  return matrix * weights;
}

inline std::string text_of(const Eigen::VectorXd& values) {
  std::ostringstream stream;
  stream.precision(10);
  stream << values.transpose() << "\n";
  return stream.str();
}

inline std::string text_of(const FixedNodes& support) {
  std::string text = support.name;
  for (const auto node : support.nodes) text += " " + std::to_string(node);
  for (const bool held : support.directions) text += held ? "x" : "-";
  return text;
}

/// What a deck is for kalfem: its matrices, load cases and notes, or the problem that it has.
struct Reading {
  std::string text;
  std::vector<LedgerEntry> ledger;

  explicit Reading(const std::vector<std::string>& lines) {
    try {
      const auto deck = parse_abaqus(joined(lines, "\n") + "\n", "deck.inp", {}, {.load_cases = true, .ledger = true});
      ledger = deck.ledger;
      for (const auto& note : deck.notes) text += note_subject(note) + ": " + note.consequence + "\n";
      const auto model = assemble(deck.model);
      text += text_of(shadow(evaluate(model.stiffness, model.parameters)));
      text += text_of(shadow(evaluate(model.mass, model.parameters)));
      for (const auto& each : deck.model.constraints) text += each.name + " ";
      for (const auto& each : deck.model.links) text += each.name + " ";
      for (const auto& each : deck.model.weighted_links) text += each.name + " ";
      for (const auto& spring : deck.model.joints) text += std::to_string(spring.damping);
      for (const auto& support : deck.model.fixed) text += text_of(support);
      for (const auto& load_case : deck.load_cases) add(deck.model, load_case);
    } catch (const InvalidInput& error) {
      text = error.what();
    }
  }

  void add(const FiniteElementModel& model, const LoadCase& load_case) {
    text += text_of(nodal_forces(model, load_case)) + text_of(load_case.gravity);
    if (load_case.rotation) text += std::to_string(load_case.rotation->speed) + text_of(load_case.rotation->axis);
    for (const auto& [dof, value, of_support] : load_case.imposed)
      text += std::to_string(dof.node) + "." + std::to_string(dof.direction) + " " + std::to_string(value);
    if (load_case.supports)
      for (const auto& support : *load_case.supports) text += text_of(support);
  }

  /// Whether a field is one that the reader says not to use.
  [[nodiscard]] bool admits(const std::string& card, const std::string& field) const {
    return std::ranges::any_of(ledger, [&](const auto& entry) {
      return entry.card == card && entry.field == field && entry.fate != FieldFate::used;
    });
  }
};

}  // namespace kalfem

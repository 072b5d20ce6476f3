// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/model/statics/geometric_stiffness.hpp"
#include "kalfem/model/unit_system.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/report/model_check_section.hpp"
#include "kalfem/steps/modes/compute.hpp"
#include "kalfem/steps/modes/report.hpp"
#include "kalfem/study/finite_element_part.hpp"
#include "verbs.hpp"

// A deck alone, without a case: check and modes.
namespace kalfem::command {

UnitSystem unit_system(const std::vector<std::string>& words) {
  if (words.empty()) return {};
  if (words.size() != 3)
    throw InvalidInput("--units has " + std::to_string(words.size()) + " words",
                       "a deck needs units of length, mass and time", "write them in this order: --units mm t s");
  return {to_si("1 " + words[0], "m"), to_si("1 " + words[1], "kg"), to_si("1 " + words[2], "s")};
}

namespace {

constexpr Eigen::Index modes_in_check = 16;

/// [Hz]; of a model with fewer masses as many as it has.
Eigen::VectorXd lowest_frequencies(const SparseMatrix& stiffness, const SparseMatrix& mass,
                                   const StiffnessFactor* factor) {
  const Eigen::Index count = std::min(modes_in_check, (mass.diagonal().array() > 0.0).count());
  if (count == 0) return {};
  const auto modes = factor ? lowest_modes(stiffness, mass, *factor, {.count = count})
                            : lowest_modes(stiffness, mass, {.count = count});
  return modes.values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
}

/// The sum of a model's only term.
SparseMatrix taken(std::vector<AffineTerm>& terms) {
  SparseMatrix sum = std::move(terms.front().matrix);
  terms.clear();
  return sum;
}

Table frequency_table(const Eigen::VectorXd& frequencies) {
  Table table{"Lowest natural frequencies", {"mode", "frequency [Hz]"}, {}, {}};
  for (Eigen::Index i = 0; i < frequencies.size(); ++i)
    table.rows.push_back({std::to_string(i + 1), four_digits(frequencies[i])});
  return table;
}

/// The deck's model at full order, as a case would use it. What the deck needs and kalfem does not read is an error.
FiniteElementPart part_of(const std::string& file, const std::vector<std::string>& units,
                          std::optional<std::int64_t> subcase) {
  const Stopwatch watch;
  Deck deck = read_deck(file, {.subcase = subcase});
  const double reading = watch.seconds();
  IssueList issues;
  accept_missing(deck.notes, {}, issues);
  issues.raise();
  for (const auto& note : deck.notes)
    if (note.kind != DeckNoteKind::unused)
      print_error("warning: {}\n", to_string(Issue{note.where, note_subject(note), note.consequence, ""}));
  to_si(deck.model, unit_system(units));
  FiniteElementPart part{.name = std::filesystem::path(file).stem().string(), .elements = std::move(deck.model)};
  part.times.add("read", reading);
  if (deck.preload) {
    to_si(*deck.preload, unit_system(units));
    auto preload = preload_of(part.elements, *deck.preload);
    part.preload_stiffness = std::move(preload.stiffness);
    if (!preload.ignored.empty()) print_error("warning: {}\n", ignored_preload(deck.preload->name, preload.ignored));
  }
  assemble_part(part, {.at_present_values = true});
  for (const auto& finding : {units_finding(part.elements), coincident_elements_finding(part.elements)})
    if (finding) print_error("warning: {}\n", to_string(Issue{{file, 0}, finding->what, finding->why, finding->fix}));
  return part;
}

/// What became of each field that the deck fills.
Table ledger_table(const std::vector<LedgerEntry>& ledger) {
  Table table{"Fields of the deck", {"card", "field", "fate", "count", "first place"}, {}, {}};
  for (const auto& entry : ledger)
    table.rows.push_back({entry.card, entry.field, to_string(entry.fate), std::to_string(entry.count),
                          fmt::format("{}:{}", entry.where.file, entry.where.line)});
  return table;
}

}  // namespace

// K and M are assembled once and factored once; the factor that shows that nothing moves without strain serves the
// modes too. With a preload the modes are those of K + K_g, which has a factor of its own.
ExitCode check_deck(const CheckDeckArguments& arguments) {
  const auto& [file, units, page_file, with_ledger, subcase] = arguments;
  if (!page_file.empty()) require_writable(page_file);
  Deck deck = read_deck(file, {.subcase = subcase, .ledger = with_ledger});
  to_si(deck.model, unit_system(units));
  AssembledModel assembled = assemble(deck.model, {.at_present_values = true});
  SparseMatrix stiffness = taken(assembled.stiffness);
  const SparseMatrix mass = taken(assembled.mass);
  ModelCheckReport report =
      check_model(deck.model, assembled, stiffness, mass, {.needs_mass = !deck.is_static_analysis});
  print("{}\n\n{}", file, model_check_text(report, deck.notes));
  const bool is_complete =
      std::ranges::none_of(deck.notes, [](const DeckNote& note) { return note.kind == DeckNoteKind::missing; });
  const bool sound = is_complete && report.count(FindingSeverity::error) == 0;
  if (deck.preload && sound) {
    to_si(*deck.preload, unit_system(units));
    const SparseMatrix preload = preload_stiffness(deck.model, *deck.preload);
    stiffness += SparseMatrix(assembled.expansion.transpose() * preload * assembled.expansion);
    report.factor = nullptr;
    print("The modes below are those with the preload that the deck states, load case '{}'.\n", deck.preload->name);
  }
  const Table frequencies = sound ? frequency_table(lowest_frequencies(stiffness, mass, report.factor.get())) : Table{};
  if (!frequencies.rows.empty()) print("{}\n{}\n", frequencies.title, to_text(frequencies));
  if (with_ledger) print("{}", to_text(ledger_table(deck.ledger)));
  if (!page_file.empty()) {
    const std::string name = std::filesystem::path(file).filename().string();
    Page page{.title = name,
              .subtitle = fmt::format("{} degrees of freedom", assembled.size()),
              .status = sound ? VerdictState::consistent : VerdictState::unusable,
              .summary = "Model check of the deck.",
              .sections = {model_check_section(name, deck.model, report, deck.notes)}};
    if (!frequencies.rows.empty()) page.sections.front().items.emplace_back(frequencies);
    write_file_atomically(page_file, render_html(page));
  }
  return sound ? done : mend_the_input;
}

ExitCode modes_of_deck(const DeckModesArguments& arguments) {
  const std::filesystem::path folder = arguments.folder;
  FiniteElementPart part = part_of(arguments.file, arguments.units, arguments.subcase);
  const std::string picture = part.name + "_modes.vtu";
  if (!folder.empty()) require_writable(folder / picture);
  const auto modes = part.times.measure(
      "modes", [&] { return modes_of(part, lowest_normal_modes(part.full, {arguments.count}, part.factor.get())); });
  if (!folder.empty()) part.times.measure("write", [&] { write_modes(folder, part, modes); });
  if (arguments.as_json) {
    nlohmann::ordered_json json{{"deck", std::filesystem::path(arguments.file).filename().string()},
                                {"dofs", modes.dofs},
                                {"mass", number(modes.mass)},
                                {"frequencies_hz", numbers(modes.frequencies)}};
    for (const auto& [phase, seconds] : part.times.list()) json["timing"][phase + "_s"] = number(seconds);
    print("{}\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    return done;
  }
  const Table table = frequency_table(modes.frequencies);
  print("{}: {} degrees of freedom, {}{}\n\n{}\n{}", arguments.file, modes.dofs, mass_text(part),
        part.preload_stiffness.size() > 0 ? ", with the preload that the deck states" : "", table.title,
        to_text(table));
  if (!folder.empty()) print("\nShapes in {}\n", (folder / picture).string());
  return done;
}

}  // namespace kalfem::command

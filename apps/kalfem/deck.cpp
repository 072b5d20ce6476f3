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
#include "kalfem/model/unit_system.hpp"
#include "kalfem/pipeline/reported_quantities.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/report/sections.hpp"
#include "kalfem/report/summary_parts.hpp"
#include "kalfem/report/tables.hpp"
#include "verbs.hpp"

// A deck alone, without a case: check and modes.
namespace kalfem::command {
namespace {

/// "mm t s": one unit of each.
UnitSystem unit_system(const std::vector<std::string>& words) {
  if (words.empty()) return {};
  if (words.size() != 3)
    throw InvalidInput("--units has " + std::to_string(words.size()) + " words",
                       "a deck needs units of length, mass and time", "write them in this order: --units mm t s");
  return {to_si("1 " + words[0], "m"), to_si("1 " + words[1], "kg"), to_si("1 " + words[2], "s")};
}

constexpr Eigen::Index modes_in_check = 16;

/// [Hz]; of a model with fewer masses as many as it has.
Eigen::VectorXd lowest_frequencies(const AssembledModel& assembled, Eigen::Index count) {
  const auto mass = evaluate(assembled.mass, assembled.parameters);
  count = std::min(count, (mass.diagonal().array() > 0.0).count());
  const auto modes = lowest_modes(evaluate(assembled.stiffness, assembled.parameters), mass, {.count = count});
  return modes.values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
}

Table frequency_table(const Eigen::VectorXd& frequencies) {
  Table table{"Lowest natural frequencies", {"mode", "frequency [Hz]"}, {}, {}};
  for (Eigen::Index i = 0; i < frequencies.size(); ++i)
    table.rows.push_back({std::to_string(i + 1), four_digits(frequencies[i])});
  return table;
}

/// The deck's model at full order, as a case would use it. What the deck needs and kalfem does not read is an error.
FiniteElementPart part_of(const std::string& file, const std::vector<std::string>& units) {
  const Stopwatch watch;
  Deck deck = read_deck(file);
  const double reading = watch.seconds();
  IssueList issues;
  accept_missing(deck.notes, {}, issues);
  issues.raise();
  for (const auto& note : deck.notes)
    if (note.kind == DeckNoteKind::doubtful)
      print_error("warning: {}\n", to_string(Issue{note.where, note.what, note.consequence, ""}));
  to_si(deck.model, unit_system(units));
  FiniteElementPart part{.name = std::filesystem::path(file).stem().string(), .elements = std::move(deck.model)};
  part.times.add("read", reading);
  assemble_part(part, {.at_present_values = true});
  for (const auto& finding : {units_finding(part.elements), coincident_elements_finding(part.elements)})
    if (finding) print_error("warning: {}\n", to_string(Issue{{file, 0}, finding->what, finding->why, finding->fix}));
  return part;
}

}  // namespace

ExitCode check_deck(const std::string& file, const std::vector<std::string>& units, const std::string& page_file) {
  if (!page_file.empty()) require_writable(page_file);
  Deck deck = read_deck(file);
  to_si(deck.model, unit_system(units));
  const AssembledModel assembled = assemble(deck.model);
  const ModelCheckReport report = check_model(deck.model, assembled);
  print("{}\n\n{}", file, model_check_text(report, deck.notes));
  const bool is_complete =
      std::ranges::none_of(deck.notes, [](const DeckNote& note) { return note.kind == DeckNoteKind::missing; });
  const bool sound = is_complete && report.count(FindingSeverity::error) == 0;
  const Table frequencies = sound ? frequency_table(lowest_frequencies(assembled, modes_in_check)) : Table{};
  if (sound) print("{}\n{}\n", frequencies.title, to_text(frequencies));
  if (!page_file.empty()) {
    const std::string name = std::filesystem::path(file).filename().string();
    Page page{.title = name,
              .subtitle = fmt::format("{} degrees of freedom", assembled.size()),
              .status = sound ? VerdictState::consistent : VerdictState::unusable,
              .summary = "Model check of the deck.",
              .sections = {model_check_section(name, deck.model, report, deck.notes)}};
    if (sound) page.sections.front().items.emplace_back(frequencies);
    write_file_atomically(page_file, render_html(page));
  }
  return sound ? done : mend_the_input;
}

ExitCode modes_of_deck(const DeckModesArguments& arguments) {
  const std::filesystem::path folder = arguments.folder;
  FiniteElementPart part = part_of(arguments.file, arguments.units);
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
  print("{}: {} degrees of freedom, {}\n\n{}\n{}", arguments.file, modes.dofs, mass_text(part), table.title,
        to_text(table));
  if (!folder.empty()) print("\nShapes in {}\n", (folder / picture).string());
  return done;
}

}  // namespace kalfem::command

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numbers>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/deck.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/unit_system.hpp"
#include "kalfem/report/sections.hpp"
#include "kalfem/report/tables.hpp"
#include "verbs.hpp"

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

Table frequency_table(const AssembledModel& assembled, Eigen::Index count) {
  Table table{"Lowest natural frequencies", {"mode", "frequency [Hz]"}, {}, {}};
  const auto mass = evaluate(assembled.mass, assembled.parameters);
  count = std::min(count, (mass.diagonal().array() > 0.0).count());
  const auto modes = lowest_modes(evaluate(assembled.stiffness, assembled.parameters), mass, {.count = count});
  for (Eigen::Index i = 0; i < modes.values.size(); ++i)
    table.rows.push_back(
        {std::to_string(i + 1), four_digits(std::sqrt(std::max(0.0, modes.values[i])) / (2.0 * std::numbers::pi))});
  return table;
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
  const Table frequencies = sound ? frequency_table(assembled, 16) : Table{};
  if (sound) print("{}\n{}\n", frequencies.title, to_text(frequencies));
  if (!page_file.empty()) {
    const std::string name = std::filesystem::path(file).filename().string();
    Page page{.title = name,
              .subtitle = fmt::format("{} degrees of freedom", assembled.size()),
              .status = sound ? PageStatus::ok : PageStatus::unusable,
              .summary = "Model check of the deck.",
              .sections = {model_check_section(name, deck.model, report, deck.notes)}};
    if (sound) page.sections.front().items.emplace_back(frequencies);
    write_file_atomically(page_file, render_html(page));
  }
  return sound ? done : mend_the_input;
}

}  // namespace kalfem::command

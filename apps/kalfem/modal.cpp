// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/modal/identify_modes.hpp"
#include "kalfem/modal/merge_setups.hpp"
#include "kalfem/report/modal_report.hpp"
#include "kalfem/report/output_record.hpp"
#include "verbs.hpp"

namespace kalfem::command {

namespace {

/// A record's modes, and where its channels sit.
struct Identified {
  ModalResult result;
  std::vector<MeasuredPlace> places;
};

Identified identify(const std::string& file, const ModalArguments& arguments) {
  const auto outputs = read_outputs(file, arguments.options.channels, arguments.sample_rate);
  ModalOptions options = arguments.options;
  options.channels.clear();  // they are all there is
  if (arguments.band.size() == 2) options.band = FrequencyBand{arguments.band[0], arguments.band[1]};
  Identified found{identify_modes(outputs.record, options), outputs.places};
  if (!outputs.left_out.empty())
    found.result.remarks.push_back(fmt::format("Forces are left out: {}.", fmt::join(outputs.left_out, ", ")));
  return found;
}

std::string stem_of(const std::string& file) { return std::filesystem::path(file).stem().string(); }

/// Several set-ups as one. Channels keep the places that their files state.
Identified merged(const ModalArguments& arguments) {
  std::vector<SetupModes> setups;
  std::map<std::string, MeasuredPlace> place_of;
  for (const auto& file : arguments.files) {
    auto found = identify(file, arguments);
    for (std::size_t i = 0; i < found.places.size(); ++i) {
      place_of.try_emplace(found.result.channels[i], found.places[i]);
      place_of.try_emplace(stem_of(file) + ":" + found.result.channels[i], found.places[i]);
    }
    setups.push_back({stem_of(file), std::move(found.result)});
  }
  Identified all{merge_setups(setups, {.references = arguments.options.references}), {}};
  for (const auto& channel : all.result.channels) all.places.push_back(place_of[channel]);
  return all;
}

}  // namespace

ExitCode modal(const ModalArguments& arguments) {
  const std::filesystem::path folder = arguments.folder;
  if (!folder.empty()) require_writable(folder / "modes.json");
  if (!arguments.page.empty()) require_writable(arguments.page);
  const auto [result, places] =
      arguments.files.size() == 1 ? identify(arguments.files.front(), arguments) : merged(arguments);
  std::string source;
  for (const auto& file : arguments.files)
    source += (source.empty() ? "" : ", ") + std::filesystem::path(file).filename().string();
  if (!folder.empty()) write_modal_files(folder, source, result, places);
  if (!arguments.page.empty()) write_file_atomically(arguments.page, render_html(modal_page(source, result)));
  if (arguments.as_json)
    print("{}\n", modal_json(source, result).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  else
    print("{}{}", modal_text(source, result),
          folder.empty() ? "" : fmt::format("\nTables and shapes in {}\n", folder.string()));
  return result.modes.empty() ? not_usable : done;
}

}  // namespace kalfem::command

// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "console.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/formats/frequency_response_file.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/formats/tables/csv.hpp"
#include "kalfem/modal/identify_modes.hpp"
#include "kalfem/modal/merge_setups.hpp"
#include "kalfem/report/modal_report.hpp"
#include "kalfem/report/output_record.hpp"
#include "kalfem/report/tracks_report.hpp"
#include "verbs.hpp"

namespace kalfem::command {

namespace {

/// A record's modes, and where its channels sit.
struct Identified {
  ModalResult result;
  std::vector<MeasuredPlace> places;
};

/// The file, where it holds frequency responses and no time record.
std::optional<MeasuredFile> responses_in(const std::string& file, const ModalArguments& arguments) {
  if (!arguments.options.inputs.empty() || measured_format(file) == nullptr) return {};
  MeasuredFile measured = read_measured_file(file);
  if (!measured.channels.empty() || std::ranges::find(measured.functions, MeasuredFunctionKind::frequency_response,
                                                      &MeasuredFunction::kind) == measured.functions.end())
    return {};
  return measured;
}

Identified identify_from_responses(const std::string& file, const MeasuredFile& measured, const ModalOptions& options) {
  const FrfFileMatrix read = frf_matrix_of(measured, file);
  Identified found{identify_modes(read.responses, options), {}};
  for (const auto& channel : found.result.channels)
    found.places.push_back(read.places[static_cast<std::size_t>(
        std::ranges::find(read.responses.outputs, channel, &Channel::name) - read.responses.outputs.begin())]);
  found.result.remarks.insert(found.result.remarks.begin(), read.remarks.begin(), read.remarks.end());
  return found;
}

/// "3.7" or "3.7:24".
ChosenPole chosen_pole(const std::string& text) {
  ChosenPole pole;
  const char* const end = text.data() + text.size();
  const auto frequency = std::from_chars(text.data(), end, pole.frequency);
  bool is_pole = frequency.ec == std::errc() && pole.frequency > 0.0;
  if (is_pole && frequency.ptr != end) {
    const auto order = std::from_chars(frequency.ptr + 1, end, pole.order);
    is_pole = *frequency.ptr == ':' && order.ec == std::errc() && order.ptr == end && pole.order > 0;
  }
  if (!is_pole)
    throw InvalidInput("--pole '" + text + "'", "a pole is named by its frequency in Hz, and its order",
                       "write HZ or HZ:ORDER, such as 3.7:24");
  return pole;
}

Identified identify(const std::string& file, const ModalArguments& arguments) {
  ModalOptions options = arguments.options;
  for (const auto& pole : arguments.poles) options.poles.push_back(chosen_pole(pole));
  if (arguments.band.size() == 2) options.band = FrequencyBand{arguments.band[0], arguments.band[1]};
  if (const auto measured = responses_in(file, arguments)) return identify_from_responses(file, *measured, options);
  const auto outputs = read_outputs(file, options.channels, arguments.sample_rate, options.inputs);
  options.channels.clear();  // they are all there is, beside the inputs
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

TrackedRecords tracked(const ModalArguments& arguments) {
  TrackedRecords all;
  if (!arguments.covariates.empty()) {
    const CsvTable table = read_csv_table(arguments.covariates);
    all.values = table.values;
    for (const auto& column : table.columns)
      all.covariates.push_back(column.unit.empty() ? column.name : fmt::format("{} [{}]", column.name, column.unit));
  }
  for (const auto& file : arguments.files) {
    all.names.push_back(std::filesystem::path(file).filename().string());
    all.results.push_back(identify(file, arguments).result);
  }
  all.tracks = track_modes(all.results, all.values);
  return all;
}

ExitCode track(const ModalArguments& arguments) {
  const std::filesystem::path folder = arguments.folder;
  if (!folder.empty()) require_writable(folder / "tracks.json");
  const TrackedRecords all = tracked(arguments);
  if (!folder.empty()) write_tracks(folder, all);
  if (!arguments.page.empty()) write_file_atomically(arguments.page, render_html(tracks_page(all)));
  if (arguments.as_json)
    print("{}\n", tracks_json(all).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  else
    print("{}{}", tracks_text(all), folder.empty() ? "" : fmt::format("\nTables in {}\n", folder.string()));
  return all.tracks.empty() ? not_usable : done;
}

}  // namespace

ExitCode modal(const ModalArguments& arguments) {
  if (!arguments.covariates.empty() && !arguments.track)
    throw InvalidInput("--covariates: frequencies follow them over several records", "only --track takes them",
                       "give --track and the records");
  if (!arguments.page.empty()) require_writable(arguments.page);
  if (arguments.track) return track(arguments);
  const std::filesystem::path folder = arguments.folder;
  if (!folder.empty()) require_writable(folder / "modes.json");
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

// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/output_record.hpp"

#include <algorithm>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/formats/measured_selection.hpp"
#include "kalfem/formats/unit_labels.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {
namespace {

/// The SI unit of what a channel holds: of an acceleration where it is in g, of which a mass would be in grams. Where
/// the unit is not understood, nothing: the numbers stay.
std::optional<std::string> unit_in_si(const MeasuredChannel& channel) {
  const std::string unit = understood_unit(channel.unit);
  try {
    const auto dimension = parse_unit(unit).dimension;
    return dimension == parse_unit("kg").dimension ? "m/s^2" : si_unit(dimension);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

bool is_force(const MeasuredChannel& channel) {
  return channel.quantity == "force" || unit_in_si(channel) == si_unit(parse_unit("N").dimension);
}

WantedChannel wanted(const std::string& name, const MeasuredFile& file) {
  WantedChannel channel{.column = name, .owner = "the outputs", .unit = "-"};
  const auto at = std::ranges::find(file.channels, name, &MeasuredChannel::name);
  if (at == file.channels.end()) return channel;  // it may be asked for by its place
  if (const auto unit = unit_in_si(*at))
    channel.unit = *unit;
  else
    channel.unit_given.value = "-";
  return channel;
}

bool is_case(const std::filesystem::path& file) { return file.extension() == ".yaml" || file.extension() == ".yml"; }

OutputRecord outputs_of_case(const std::filesystem::path& file, const std::vector<std::string>& channels) {
  const Study study = load_study(file.string());
  if (!study.record)
    throw InvalidInput(Issue{{file.string(), 1},
                             "the case has no `record`",
                             "modes are identified from measured responses",
                             "name a case with a record, or the record's file itself"});
  OutputRecord outputs{study.record->record, {}, {}};
  if (!channels.empty()) outputs.record = select_channels(outputs.record, channels);
  outputs.places.resize(outputs.record.channels.size());
  return outputs;
}

}  // namespace

OutputRecord read_outputs(const std::filesystem::path& file, const std::vector<std::string>& channels,
                          std::optional<double> sample_rate, const std::vector<std::string>& inputs) {
  if (is_case(file)) {
    if (inputs.empty()) return outputs_of_case(file, channels);
    throw InvalidInput(Issue{{file.string(), 1},
                             "inputs of a case are asked for",
                             "frequency responses are measured from a record with its forces",
                             "name the record's file itself"});
  }
  std::vector<std::string> wanted_names = channels;
  if (!channels.empty()) wanted_names.insert(wanted_names.begin(), inputs.begin(), inputs.end());
  const MeasuredFile measured = read_measured_file(file, {.channels = wanted_names});
  OutputRecord outputs;
  std::vector<std::string> names = channels;
  if (names.empty())
    for (const auto& channel : measured.channels)
      if (std::ranges::find(inputs, channel.name) == inputs.end())
        (is_force(channel) ? outputs.left_out : names).push_back(channel.name);
  if (names.empty())
    throw InvalidInput(Issue{{file.string(), 0},
                             "the file has no channel of a response",
                             "modes are identified from time records of motions or strains",
                             "look at what it holds: kalfem inspect " + file.string()});
  std::vector<WantedChannel> chosen;
  for (const auto& name : inputs) chosen.push_back(wanted(name, measured));
  for (const auto& name : names) {
    chosen.push_back(wanted(name, measured));
    const auto at = std::ranges::find(measured.channels, name, &MeasuredChannel::name);
    outputs.places.push_back(at == measured.channels.end() ? parse_freedom(name).value_or(MeasuredPlace{}) : at->place);
  }
  outputs.record = select_record(measured, chosen, {.sample_rate = sample_rate}, file);
  return outputs;
}

}  // namespace kalfem

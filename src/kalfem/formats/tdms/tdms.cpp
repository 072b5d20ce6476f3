// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tdms/tdms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/formats/mapped_file.hpp"
#include "kalfem/formats/tables/table_titles.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/formats/tdms/tdms_segments.hpp"
#include "kalfem/records/time_stamps.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using tdms::Object;
using tdms::Properties;

/// "/'group'/'channel'" as its parts; a quotation mark inside of a name is written twice.
std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  bool quoted = false;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (path[i] != '\'') {
      if (quoted) parts.back() += path[i];
    } else if (quoted && i + 1 < path.size() && path[i + 1] == '\'') {
      parts.back() += path[i++];
    } else {
      quoted = !quoted;
      if (quoted) parts.emplace_back();
    }
  }
  return parts;
}

std::string text_of(const Properties& properties, const char* name) {
  const auto found = properties.find(name);
  const auto* text = found == properties.end() ? nullptr : std::get_if<std::string>(&found->second);
  return text == nullptr ? "" : to_utf8(*text);
}

std::optional<double> number_of(const Properties& properties, const char* name) {
  const auto found = properties.find(name);
  const auto* number = found == properties.end() ? nullptr : std::get_if<double>(&found->second);
  return number == nullptr || !std::isfinite(*number) ? std::nullopt : std::optional(*number);
}

std::optional<tdms::Time> time_of(const Properties& properties) {
  const auto found = properties.find("wf_start_time");
  const auto* time = found == properties.end() ? nullptr : std::get_if<tdms::Time>(&found->second);
  return time == nullptr || (time->seconds == 0 && time->fraction == 0) ? std::nullopt : std::optional(*time);
}

VectorXd as_vector(const std::vector<double>& values) {
  return VectorXd::Map(values.data(), static_cast<Index>(values.size()));
}

/// A channel on its way from the file's objects.
struct Found {
  const Object* object = nullptr;
  std::string group, name;
  VectorXd values = {};
  [[nodiscard]] bool has_axis() const { return number_of(object->properties, "wf_increment").value_or(0.0) > 0.0; }
};

class Channels {
public:
  Channels(tdms::Content& content, MeasuredFile& file) : content_(content), file_(file) {
    for (auto& object : content.objects) sort(object);
    find_earliest();
    for (const auto& channel : found_) add(channel);
    for (std::size_t i = 0; i < file_.channels.size(); ++i)
      file_.channels[i].values = std::move(found_[sources_[i]].values);
  }

private:
  /// Large files leave no room for numbers as they are stored beside those that are scaled.
  void sort(Object& object) {
    take(object);
    object.numbers.clear();
    object.numbers.shrink_to_fit();
  }

  void take(const Object& object) {
    const auto parts = parts_of(object.path);
    if (parts.size() < 2) return;
    Found channel{&object, parts[0], parts[1]};
    if (object.texts > 0) return skip(channel, "holds " + std::to_string(object.texts) + " texts");
    if (object.numbers.empty()) return;
    if (!object.imaginary.empty() && !is_spectrum(object))
      return skip(channel, "holds complex numbers that are no function of frequency");
    std::string problem;
    channel.values = as_vector(tdms::scaled(object, levels(object, channel.group), problem));
    if (!problem.empty()) return skip(channel, "is left out: " + problem);
    found_.push_back(std::move(channel));
  }

  void skip(const Found& channel, const std::string& why) {
    file_.skipped.push_back("channel '" + to_utf8(channel.group + "/" + channel.name) + "' " + to_utf8(why));
  }

  /// Scales stand at the channel, its group or the file.
  [[nodiscard]] std::vector<const Properties*> levels(const Object& object, const std::string& group) const {
    std::vector<const Properties*> all{&object.properties};
    for (const bool of_group : {true, false})
      for (const auto& other : content_.objects) {
        const auto parts = parts_of(other.path);
        if (of_group ? parts.size() == 1 && parts[0] == group : parts.empty()) all.push_back(&other.properties);
      }
    return all;
  }

  static bool is_spectrum(const Object& object) {
    const auto unit = lower_case(text_of(object.properties, "wf_xunit_string")),
               name = lower_case(text_of(object.properties, "wf_xname"));
    return unit == "hz" || name.starts_with("freq");
  }

  void find_earliest() {
    for (const auto& channel : found_)
      if (const auto time = time_of(channel.object->properties); time && channel.has_axis())
        if (!earliest_ || tdms::difference(*time, *earliest_) < 0.0) earliest_ = time;
  }

  [[nodiscard]] std::string unique_name(const Found& channel) const {
    const auto alike = std::ranges::count(found_, channel.name, &Found::name);
    return to_utf8(alike > 1 ? channel.group + "/" + channel.name : channel.name);
  }

  /// Whether a channel holds the times of others.
  static bool is_time(const Found& channel) {
    if (channel.has_axis()) return false;
    const std::string name = channel_of(channel.name).name;
    return channel.object->type == tdms::Type::time || is_time_name(name) ||
           (may_be_time_name(name) && increases(channel.values));
  }

  /// Of the unit of a channel of times.
  static double seconds_a_unit(const Found& times) {
    const Channel title = channel_of(times.name);
    std::string unit = text_of(times.object->properties, "unit_string");
    if (unit.empty()) unit = title.unit.empty() ? unit_in_time_name(title.name) : title.unit;
    return times.object->type == tdms::Type::time ? 1.0 : seconds_in(unit).value_or(1.0);
  }

  /// The times of a channel that states none: of the same group and length.
  [[nodiscard]] const Found* times_for(const Found& channel) const {
    const auto serves = [&](const Found& other) {
      return &other != &channel && other.group == channel.group && is_time(other) &&
             other.values.size() == channel.values.size() && other.values.size() > 1;
    };
    const auto found = std::ranges::find_if(found_, serves);
    return found == found_.end() ? nullptr : &*found;
  }

  void add(const Found& channel) {
    const auto& properties = channel.object->properties;
    if (is_spectrum(*channel.object) && channel.has_axis()) return add_function(channel);
    MeasuredChannel measured{.name = unique_name(channel),
                             .unit = text_of(properties, "unit_string"),
                             .description = text_of(properties, "description")};
    if (channel.object->type == tdms::Type::time) measured.unit = "s";
    if (measured.unit.empty())
      if (const auto apart = channel_of(measured.name); !apart.unit.empty()) {
        measured.name = apart.name;
        measured.unit = apart.unit;
      }
    if (channel.has_axis())
      set_axis(measured, properties);
    else if (const Found* times = times_for(channel); times != nullptr && !is_time(channel))
      set_times(measured, seconds_a_unit(*times) * times->values);
    sources_.push_back(static_cast<std::size_t>(&channel - found_.data()));
    file_.channels.push_back(std::move(measured));
  }

  void set_axis(MeasuredChannel& measured, const Properties& properties) const {
    measured.interval = *number_of(properties, "wf_increment");
    measured.start = number_of(properties, "wf_start_offset").value_or(0.0);
    if (const auto time = time_of(properties)) measured.start += tdms::difference(*time, *earliest_);
  }

  void add_function(const Found& channel) {
    const auto& properties = channel.object->properties;
    MeasuredFunction function{.name = unique_name(channel),
                              .unit = text_of(properties, "unit_string"),
                              .description = text_of(properties, "description")};
    const double first = number_of(properties, "wf_start_offset").value_or(0.0),
                 step = *number_of(properties, "wf_increment");
    function.lines = VectorXd::LinSpaced(channel.values.size(), first,
                                         first + step * static_cast<double>(channel.values.size() - 1));
    function.values = channel.values.cast<std::complex<double>>();
    const auto& imaginary = channel.object->imaginary;
    for (Index k = 0; k < std::min<Index>(std::ssize(imaginary), function.values.size()); ++k)
      function.values[k].imag(imaginary[static_cast<std::size_t>(k)]);
    file_.functions.push_back(std::move(function));
  }

  const tdms::Content& content_;
  MeasuredFile& file_;
  std::vector<Found> found_;
  std::vector<std::size_t> sources_;  ///< of the file's channels among those that were found; others may serve as times
  std::optional<tdms::Time> earliest_;
};

}  // namespace

bool begins_tdms(std::string_view head) { return head.starts_with("TDSm") || head.starts_with("TDSh"); }

MeasuredFile parse_tdms(std::string_view bytes, const std::string& source) {
  MeasuredFile file{.format = "TDMS file"};
  auto content = tdms::read_segments(bytes, source);
  file.skipped = std::move(content.skipped);
  Channels(content, file);
  if (file.channels.empty() && file.functions.empty())
    throw InvalidInput(Issue{{source, 0},
                             "the file holds no samples",
                             file.skipped.empty() ? "none of its objects has data" : file.skipped.front(),
                             "record or export it again"});
  return file;
}

MeasuredFile read_tdms(const std::filesystem::path& path) {
  const MappedFile file(path);
  return parse_tdms(file.bytes(), path.string());
}

}  // namespace kalfem

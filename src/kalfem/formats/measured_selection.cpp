// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/measured_selection.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/stated_times.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr std::size_t most_named = 12;    ///< names that a message lists
constexpr double rate_agreement = 1e-3;   ///< relative, between a stated rate and that of the file
constexpr double clock_agreement = 0.05;  ///< of a sampling interval, between the samples of two channels
constexpr double longest_record = 1e9;    ///< samples
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// A channel or a function with the sign that turns it into the wanted direction.
template <typename Measured>
struct Match {
  const Measured* measured = nullptr;
  double sign = 1.0;
};

/// Sign between two directions of one axis; 0: they are of different axes or places.
double sign_between(const MeasuredPlace& wanted, const MeasuredPlace& found) {
  if (!found.node || wanted.node != found.node || std::abs(wanted.direction) != std::abs(found.direction)) return 0.0;
  return wanted.direction == found.direction ? 1.0 : -1.0;
}

template <typename Measured>
std::string names_in_words(const std::vector<const Measured*>& all) {
  std::string text;
  for (std::size_t i = 0; i < std::min(all.size(), most_named); ++i) {
    text += (i > 0 ? ", " : "") + std::string("'") + all[i]->name + "'";
    if (!all[i]->unit.empty()) text += " [" + all[i]->unit + "]";
  }
  if (all.size() > most_named) text += " and " + std::to_string(all.size() - most_named) + " more";
  return text;
}

template <typename Measured>
std::vector<const Measured*> pointers(const std::vector<Measured>& all) {
  std::vector<const Measured*> pointers;
  for (const auto& each : all) pointers.push_back(&each);
  return pointers;
}

/// Those that the name asks for: of that name alone, otherwise of that other name, otherwise at that place.
template <typename Measured, typename AtPlace>
std::vector<Match<Measured>> matches(const std::vector<Measured>& all, const std::string& name,
                                     const AtPlace& at_place) {
  std::vector<Match<Measured>> found;
  const Channel apart = channel_of(name);
  const auto collect = [&](const auto& sign) {
    if (!found.empty()) return;
    for (const auto& each : all)
      if (const double s = sign(each); s != 0.0) found.push_back({&each, s});
  };
  collect([&](const Measured& each) { return each.name == name ? 1.0 : 0.0; });
  collect([&](const Measured& each) {
    return !apart.unit.empty() && each.name == apart.name && each.unit == apart.unit ? 1.0 : 0.0;
  });
  collect([&](const Measured& each) {
    return std::ranges::find(each.other_names, name) != each.other_names.end() ? 1.0 : 0.0;
  });
  collect(at_place);
  return found;
}

bool has_quantity(const WantedChannel& wanted, const std::string& unit) {
  for (const std::string& si : {wanted.unit, wanted.rotational_unit}) {
    if (si.empty()) continue;
    try {
      parse_unit_as(unit, si);
      return true;
    } catch (const InvalidInput&) {
      continue;
    }
  }
  return false;
}

/// Why a channel is not there, with those that are.
void add_absent(const std::string& name, const std::string& kind, const std::vector<std::string>& known,
                const std::string& all, const MeasuredFile& measured, const std::filesystem::path& file,
                IssueList& issues) {
  std::string why;
  if (!measured.skipped.empty()) why = "not read from the file: " + measured.skipped.front();
  issues.add({file.string(), 0}, "there is no " + kind + " '" + name + "'" + did_you_mean(name, known), why,
             all.empty() ? "the file has none" : "the file has: " + all);
}

std::optional<Match<MeasuredChannel>> find_channel(const MeasuredFile& measured, const WantedChannel& wanted,
                                                   const std::filesystem::path& file, IssueList& issues) {
  const auto place = parse_freedom(wanted.column);
  auto found = matches(measured.channels, wanted.column, [&](const MeasuredChannel& channel) {
    return place ? sign_between(*place, channel.place) : 0.0;
  });
  if (found.size() > 1) {
    auto fitting = found;
    std::erase_if(fitting, [&](const auto& match) { return !has_quantity(wanted, match.measured->unit); });
    if (!fitting.empty()) found = fitting;
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) {
    std::vector<std::string> known;
    for (const auto& channel : measured.channels) known.push_back(channel.name);
    add_absent(wanted.column, "channel", known, names_in_words(pointers(measured.channels)), measured, file, issues);
    return std::nullopt;
  }
  std::vector<const MeasuredChannel*> candidates;
  for (const auto& match : found) candidates.push_back(match.measured);
  issues.add({file.string(), 0},
             "'" + wanted.column + "' (" + wanted.owner + ") names " + std::to_string(found.size()) + " channels", "",
             "give one of their names: " + names_in_words(candidates));
  return std::nullopt;
}

/// Times of a channel's samples. Adds an issue where they are not known or contradict a rate that is given.
std::optional<StatedTimes> times_of(const MeasuredChannel& channel, const RecordFileOptions& options,
                                    const std::filesystem::path& file, IssueList& issues) {
  if (channel.times.size() > 1) {
    FileProblems problems(file.string());
    const std::vector<int> lines(static_cast<std::size_t>(channel.times.size()), 0);
    auto stated = stated_times(channel.times, lines,
                               {.column = "times of '" + channel.name + "'", .sample_rate = options.sample_rate},
                               options.missing, problems, options.notes);
    try {
      problems.raise();
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues()) issues.add(issue.location, issue.what, issue.why, issue.fix);
      return std::nullopt;
    }
    return stated;
  }
  double rate = channel.interval > 0.0 ? 1.0 / channel.interval : 0.0;
  const auto given = options.sample_rate;
  if (rate == 0.0 && given) rate = *given;
  if (rate == 0.0)
    issues.add({file.string(), 0}, "the channel '" + channel.name + "' does not state its sampling rate", "",
               "give it (sample_rate)");
  else if (given && !(std::abs(rate / *given - 1.0) <= rate_agreement))
    issues.add({file.string(), 0},
               "the channel '" + channel.name + "' is sampled at " + shortest(rate) + " Hz, but " + shortest(*given) +
                   " Hz was given",
               "both must agree", "remove or correct the sampling rate");
  if (rate == 0.0) return std::nullopt;
  return StatedTimes{{.start = channel.start, .interval = 1.0 / rate, .count = channel.values.size()}, {}};
}

/// A time or a rate with the digits that a reader wants.
std::string rounded(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 7).ptr};
}

std::string span_in_words(const MeasuredChannel& channel, const SampleTimes& times) {
  return "'" + channel.name + "' has " + std::to_string(times.count) + " samples from " + rounded(times.at(0)) +
         " s to " + rounded(times.end()) + " s";
}

/// Requires that the channels begin and end together, as far as their sampling intervals let them.
void check_spans(const std::vector<Match<MeasuredChannel>>& channels, const std::vector<StatedTimes>& times,
                 const std::filesystem::path& file, IssueList& issues) {
  const SampleTimes& first = times.front().times;
  for (std::size_t j = 1; j < times.size(); ++j) {
    const SampleTimes& own = times[j].times;
    const double allowed = (1.0 - clock_agreement) * std::max(first.usual_interval(), own.usual_interval());
    if (std::max(std::abs(own.at(0) - first.at(0)), std::abs(own.end() - first.end())) <= allowed) continue;
    issues.add({file.string(), 0},
               span_in_words(*channels[0].measured, first) + ", " + span_in_words(*channels[j].measured, own),
               "the channels of a record cover the same time",
               "set skip_missing: true (record.skip_missing), and samples that a channel lacks count as missing");
  }
}

/// Infinite numbers are no samples.
void check_samples(const MeasuredChannel& channel, const StatedTimes& stated, const std::filesystem::path& file,
                   IssueList& issues) {
  const auto finite = stated.in_order(channel.values).array().isFinite().eval();
  if (finite.all()) return;
  Index first = 0;
  while (finite[first]) ++first;
  issues.add({file.string(), 0},
             "channel '" + channel.name + "' is not a number at " + rounded(stated.times.at(first)) + " s (" +
                 std::to_string((!finite).count()) + " samples in all)",
             "every sample must be a finite number",
             "cut the record there, set record.skip_missing: true, or bridge_gaps of an input");
}

CommonGrid grid_of(const std::vector<StatedTimes>& times, const std::filesystem::path& file) try {
  std::vector<SampleTimes> all;
  for (const auto& each : times) all.push_back(each.times);
  const CommonGrid grid = common_grid(all);
  if (!(grid.last < longest_record))
    throw InvalidInput(Issue{{},
                             "the channels would make a record of more than " + rounded(longest_record) + " samples",
                             "from their first to their last sample it is " + rounded(grid.last / grid.sample_rate) +
                                 " s at " + rounded(grid.sample_rate) + " Hz",
                             "use channels of one measurement"});
  return grid;
} catch (const InvalidInput& error) {
  IssueList issues;
  for (const auto& issue : error.issues()) issues.add({file.string(), 0}, issue.what, issue.why, issue.fix);
  issues.raise();
  throw;
}

/// Whether a channel has fewer samples than the grid has times.
bool is_spread(const CommonGrid& grid, const std::vector<StatedTimes>& times) {
  return std::ranges::any_of(times,
                             [&](const auto& each) { return static_cast<double>(each.times.count) < grid.last + 1.0; });
}

/// How the samples stand on a grid that is not simply theirs.
void tell_grid(const CommonGrid& grid, const std::vector<Match<MeasuredChannel>>& channels,
               const std::vector<StatedTimes>& times, const RecordFileOptions& options) {
  std::string slower;
  for (std::size_t j = 0; j < times.size(); ++j) {
    const double rate = 1.0 / times[j].times.usual_interval();
    if (grid.sample_rate < (1.0 + rate_agreement) * rate) continue;
    slower += (slower.empty() ? "'" : ", '") + channels[j].measured->name + "' at " + rounded(rate) + " Hz" +
              (times[j].times.times.size() > 0 ? " at uneven times" : "");
  }
  if (options.notes == nullptr || slower.empty()) return;
  std::string note = "the channels have sampling rates of their own: the filter runs at " + rounded(grid.sample_rate) +
                     " Hz, and uses each sample at its time (" + slower + ")";
  if (grid.largest_shift * grid.sample_rate > 1e-3)
    note += "; samples are moved by at most " + rounded(1e3 * grid.largest_shift) + " ms";
  options.notes->push_back(note);
}

/// Sets the channels side by side; what one of them does not have is NaN.
Record side_by_side(const std::vector<Match<MeasuredChannel>>& channels, const std::vector<StatedTimes>& times,
                    const Eigen::VectorXd& factors, const CommonGrid& grid) {
  Record record{.sample_rate = grid.sample_rate, .start = grid.start};
  record.values.setConstant(static_cast<Index>(channels.size()), static_cast<Index>(grid.last) + 1, not_a_number);
  for (std::size_t j = 0; j < channels.size(); ++j) {
    const Eigen::VectorXd values = times[j].in_order(channels[j].measured->values);
    const auto places = places_on(grid, times[j].times);
    const auto row = static_cast<Index>(j);
    for (Index k = 0; k < values.size(); ++k)
      if (std::isfinite(values[k])) record.values(row, places[static_cast<std::size_t>(k)]) = values[k] * factors[row];
  }
  return record;
}

/// A channel of uneven times at even ones.
Record interpolated(const MeasuredChannel& channel, const StatedTimes& stated, double factor) {
  const double rate = common_grid({stated.times}).sample_rate;
  Record record{.sample_rate = rate, .start = stated.times.at(0)};
  record.values = factor * evenly_interpolated(stated.times, stated.in_order(channel.values), rate).transpose();
  return record;
}

std::string axis_name(std::string_view text, int& direction) {
  constexpr std::array<std::string_view, 6> names = {"X", "Y", "Z", "RX", "RY", "RZ"};
  const std::string upper = upper_case(text);
  const auto found = std::ranges::find(names, upper);
  direction = found == names.end() ? 0 : static_cast<int>(found - names.begin()) + 1;
  return upper;
}

/// Response and reference that a name such as "12:+Z/3:+X" asks for.
struct WantedFunction {
  std::optional<MeasuredPlace> response, reference;
};

WantedFunction parse_function(const std::string& name) {
  const std::size_t slash = name.find('/');
  if (slash == std::string::npos) return {parse_freedom(name), std::nullopt};
  return {parse_freedom(std::string_view(name).substr(0, slash)),
          parse_freedom(std::string_view(name).substr(slash + 1))};
}

double sign_of(const WantedFunction& wanted, const MeasuredFunction& function) {
  if (!wanted.response) return 0.0;
  const double response = sign_between(*wanted.response, function.response);
  return wanted.reference ? response * sign_between(*wanted.reference, function.reference) : response;
}

using FunctionMatch = Match<MeasuredFunction>;

std::vector<FunctionMatch> find_functions(const MeasuredFile& measured, const std::vector<MeasuredFunction>& all,
                                          const std::vector<std::string>& names, const std::filesystem::path& file) {
  std::vector<FunctionMatch> chosen;
  IssueList issues;
  for (const auto& name : names) {
    const WantedFunction wanted = parse_function(name);
    const auto found = matches(all, name, [&](const MeasuredFunction& function) { return sign_of(wanted, function); });
    std::vector<const MeasuredFunction*> candidates;
    std::vector<std::string> known;
    for (const auto& match : found) candidates.push_back(match.measured);
    for (const auto& function : all) known.push_back(function.name);
    if (found.empty())
      add_absent(name, "frequency response", known, names_in_words(pointers(all)), measured, file, issues);
    else if (found.size() > 1)
      issues.add({file.string(), 0}, "'" + name + "' names " + std::to_string(found.size()) + " frequency responses",
                 "", "give one of their names: " + names_in_words(candidates));
    else
      chosen.push_back(found.front());
  }
  issues.raise();
  return chosen;
}

/// All of the file. They must be those of one input.
std::vector<FunctionMatch> all_functions(const std::vector<MeasuredFunction>& all, const std::filesystem::path& file) {
  std::vector<FunctionMatch> chosen;
  std::set<std::pair<long, int>> references;
  for (const auto& function : all) {
    chosen.push_back({&function});
    references.insert({function.reference.node.value_or(0), std::abs(function.reference.direction)});
  }
  if (all.empty())
    throw InvalidInput(Issue{{file.string(), 0}, "the file has no frequency response", "", "give another file"});
  if (references.size() > 1)
    throw InvalidInput(
        Issue{{file.string(), 0},
              "the frequency responses of the file are those of " + std::to_string(references.size()) + " inputs",
              "those of one input are compared at a time",
              "list them (columns): " + names_in_words(pointers(all))});
  return chosen;
}

void check_lines(const std::vector<FunctionMatch>& chosen, const std::filesystem::path& file) {
  IssueList issues;
  const Eigen::VectorXd& lines = chosen.front().measured->lines;
  for (const auto& [function, sign] : chosen) {
    const SourceLocation place{file.string(), 0};
    const std::string name = "the frequency response '" + function->name + "'";
    const Index count = function->lines.size();
    const bool ascending =
        count < 2 || (function->lines.tail(count - 1) - function->lines.head(count - 1)).minCoeff() > 0.0;
    if (!function->lines.allFinite() || !function->values.allFinite())
      issues.add(place, name + " holds values that are no numbers", "every value must be a finite number",
                 "export it again");
    else if (!ascending || function->lines[0] < 0.0)
      issues.add(place, name + " has frequencies that are negative or not ascending", "", "export it again");
    else if (count != lines.size() ||
             (function->lines - lines).cwiseAbs().maxCoeff() > 1e-6 * lines.cwiseAbs().maxCoeff())
      issues.add(place, name + " has other frequencies than '" + chosen.front().measured->name + "'",
                 "those of one input share their frequencies", "compare them separately");
  }
  issues.raise();
}

}  // namespace

// A sign may stand before the node, before the axis or behind it: "-12Z", "12-Z", "12Z-".
std::optional<MeasuredPlace> parse_freedom(std::string_view text) {
  text = trimmed(text);
  bool against = false;
  const auto sign = [&] {
    if (text.empty() || (text.front() != '+' && text.front() != '-')) return;
    against = against != (text.front() == '-');
    text.remove_prefix(1);
  };
  sign();
  MeasuredPlace place{.node = 0};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *place.node);
  if (error != std::errc() || *place.node < 0) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.empty() && std::string_view(":. _").find(text.front()) != std::string_view::npos) text.remove_prefix(1);
  sign();
  if (text.ends_with('+') || text.ends_with('-')) {
    against = against != text.ends_with('-');
    text.remove_suffix(1);
  }
  axis_name(text, place.direction);
  if (place.direction == 0) return std::nullopt;
  if (against) place.direction = -place.direction;
  return place;
}

Record select_record(const MeasuredFile& measured, const std::vector<WantedChannel>& wanted,
                     const RecordFileOptions& options, const std::filesystem::path& file) {
  IssueList issues;
  std::vector<Match<MeasuredChannel>> channels;
  for (const auto& each : wanted)
    if (const auto match = find_channel(measured, each, file, issues)) channels.push_back(*match);
  issues.raise();
  Eigen::VectorXd factors(static_cast<Index>(wanted.size()));
  std::vector<StatedTimes> times;
  for (std::size_t j = 0; j < wanted.size(); ++j) {
    const MeasuredChannel& channel = *channels[j].measured;
    factors[static_cast<Index>(j)] =
        channels[j].sign * factor_to_si(wanted[j], {channel.name, channel.unit}, {file.string(), 0}, issues);
    if (channel.values.size() < 1)
      issues.add({file.string(), 0}, "the channel '" + channel.name + "' has no samples");
    else if (auto stated = times_of(channel, options, file, issues))
      times.push_back(*std::move(stated));
  }
  issues.raise();
  if (!options.missing) {
    check_spans(channels, times, file, issues);
    for (std::size_t j = 0; j < wanted.size(); ++j) check_samples(*channels[j].measured, times[j], file, issues);
  }
  issues.raise();
  const bool input = options.interpolate && wanted.size() == 1 && times.front().times.times.size() > 0;
  Record record;
  if (input) {
    record = interpolated(*channels.front().measured, times.front(), factors[0]);
  } else {
    const CommonGrid grid = grid_of(times, file);
    tell_grid(grid, channels, times, options);
    if (options.spread != nullptr) *options.spread = is_spread(grid, times);
    record = side_by_side(channels, times, factors, grid);
  }
  for (const auto& each : wanted) record.channels.push_back({each.column, each.unit});
  return record;
}

FrequencyResponse select_frequency_responses(const MeasuredFile& measured, const std::vector<std::string>& names,
                                             const std::filesystem::path& file) {
  std::vector<MeasuredFunction> all;
  for (const auto& function : measured.functions)
    if (function.kind == MeasuredFunctionKind::frequency_response) all.push_back(function);
  const auto chosen = names.empty() ? all_functions(all, file) : find_functions(measured, all, names, file);
  check_lines(chosen, file);
  FrequencyResponse response{.lines = chosen.front().measured->lines};
  response.values.resize(response.lines.size(), static_cast<Index>(chosen.size()));
  for (std::size_t j = 0; j < chosen.size(); ++j) {
    const auto& [function, sign] = chosen[j];
    response.outputs.push_back({names.empty() ? function->name : names[j], function->unit});
    response.values.col(static_cast<Index>(j)) = sign * function->values;
  }
  response.magnitudes_only = response.values.imag().isZero(0.0) && response.values.real().minCoeff() >= 0.0;
  return response;
}

}  // namespace kalfem

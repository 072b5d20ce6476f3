#include "kalfem/formats/measured_selection.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
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

/// Clock of a channel: the time of its first sample and its rate.
struct Clock {
  double start = 0.0;
  double rate = 0.0;
  Index samples = 0;
  [[nodiscard]] double end() const { return start + static_cast<double>(samples - 1) / rate; }
};

std::optional<Clock> clock_of(const MeasuredChannel& channel, const RecordFileOptions& options,
                              const std::filesystem::path& file, IssueList& issues) {
  Clock clock{channel.start, 0.0, channel.values.size()};
  if (channel.times.size() > 1) {
    FileProblems problems(file.string());
    const std::vector<int> lines(static_cast<std::size_t>(channel.times.size()), 0);
    const TimeAxis axis =
        time_axis(channel.times, lines,
                  {.column = "times of '" + channel.name + "'", .sample_rate = options.sample_rate}, problems);
    try {
      problems.raise();
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues()) issues.add(issue.location, issue.what, issue.why, issue.fix);
      return std::nullopt;
    }
    return Clock{axis.start, axis.sample_rate, clock.samples};
  }
  if (channel.interval > 0.0) clock.rate = 1.0 / channel.interval;
  const auto given = options.sample_rate;
  if (clock.rate == 0.0 && given) clock.rate = *given;
  if (clock.rate == 0.0)
    issues.add({file.string(), 0}, "the channel '" + channel.name + "' does not state its sampling rate", "",
               "give it (sample_rate)");
  else if (given && !(std::abs(clock.rate / *given - 1.0) <= rate_agreement))
    issues.add({file.string(), 0},
               "the channel '" + channel.name + "' is sampled at " + shortest(clock.rate) + " Hz, but " +
                   shortest(*given) + " Hz was given",
               "both must agree", "remove or correct the sampling rate");
  return clock.rate > 0.0 ? std::optional(clock) : std::nullopt;
}

/// A time or a rate with the digits that a reader wants.
std::string rounded(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 7).ptr};
}

std::string span_in_words(const MeasuredChannel& channel, const Clock& clock) {
  return "'" + channel.name + "' has " + std::to_string(clock.samples) + " samples from " + rounded(clock.start) +
         " s to " + rounded(clock.end()) + " s";
}

/// Requires one rate, and samples at the same times up to whole intervals; without `missing` the same first and last
/// one.
void check_clocks(const std::vector<Match<MeasuredChannel>>& channels, const std::vector<Clock>& clocks, bool missing,
                  const std::filesystem::path& file, IssueList& issues) {
  const Clock& first = clocks.front();
  for (std::size_t j = 1; j < clocks.size(); ++j) {
    const Clock& clock = clocks[j];
    const std::string &name = channels[0].measured->name, &other = channels[j].measured->name;
    const double samples = static_cast<double>(std::max(first.samples, clock.samples));
    const double shift = (clock.start - first.start) * first.rate;
    if (std::abs(clock.rate / first.rate - 1.0) * samples > clock_agreement)
      issues.add({file.string(), 0},
                 "'" + name + "' is sampled at " + rounded(first.rate) + " Hz, '" + other + "' at " +
                     rounded(clock.rate) + " Hz",
                 "the channels of a record have one sampling rate",
                 "use channels of one rate, or export them at one rate");
    else if (!(std::abs(shift - std::round(shift)) <= clock_agreement))
      issues.add({file.string(), 0},
                 "the samples of '" + other + "' lie between those of '" + name + "' (first ones at " +
                     rounded(clock.start) + " s and " + rounded(first.start) + " s)",
                 "the channels of a record are sampled at the same times", "export them with one clock");
    else if (!missing && (std::round(shift) != 0.0 || clock.samples != first.samples))
      issues.add({file.string(), 0},
                 span_in_words(*channels[0].measured, first) + ", " + span_in_words(*channels[j].measured, clock),
                 "the channels of a record have the same samples",
                 "set skip_missing: true (record.skip_missing), and samples that a channel lacks count as missing");
  }
}

/// Infinite numbers are no samples.
void check_samples(const MeasuredChannel& channel, const Clock& clock, const std::filesystem::path& file,
                   IssueList& issues) {
  const auto finite = channel.values.array().isFinite();
  if (finite.all()) return;
  Index first = 0;
  while (finite[first]) ++first;
  issues.add({file.string(), 0},
             "channel '" + channel.name + "' is not a number at " +
                 rounded(clock.start + static_cast<double>(first) / clock.rate) + " s (" +
                 std::to_string((!finite).count()) + " samples in all)",
             "every sample must be a finite number", "cut the record there, or set record.skip_missing: true");
}

/// Sets the channels side by side; what one of them does not have is NaN.
Record side_by_side(const std::vector<Match<MeasuredChannel>>& channels, const std::vector<Clock>& clocks,
                    const Eigen::VectorXd& factors, const std::filesystem::path& file) {
  const double rate = clocks.front().rate;
  double start = clocks.front().start;
  for (const auto& clock : clocks)
    if (clock.start < start - 0.5 / rate) start = clock.start;
  std::vector<Index> shifts;
  Index samples = 0;
  for (const auto& clock : clocks) {
    const double shift = std::round((clock.start - start) * rate);
    if (!(shift + static_cast<double>(clock.samples) <= longest_record))
      throw InvalidInput(Issue{{file.string(), 0},
                               "the channels begin " + rounded(clock.start - start) + " s apart",
                               "the record would have more than " + rounded(longest_record) + " samples",
                               "use channels of one measurement"});
    shifts.push_back(static_cast<Index>(shift));
    samples = std::max(samples, shifts.back() + clock.samples);
  }
  Record record{.sample_rate = rate, .start = start};
  record.values.setConstant(static_cast<Index>(channels.size()), samples, not_a_number);
  for (std::size_t j = 0; j < channels.size(); ++j) {
    const auto& values = channels[j].measured->values;
    const auto row = static_cast<Index>(j);
    record.values.row(row).segment(shifts[j], values.size()) =
        (values.array().isFinite().select(values.array(), not_a_number) * factors[row]).transpose();
  }
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
  std::vector<Clock> clocks;
  for (std::size_t j = 0; j < wanted.size(); ++j) {
    const MeasuredChannel& channel = *channels[j].measured;
    factors[static_cast<Index>(j)] =
        channels[j].sign * factor_to_si(wanted[j], {channel.name, channel.unit}, {file.string(), 0}, issues);
    if (channel.values.size() < 1)
      issues.add({file.string(), 0}, "the channel '" + channel.name + "' has no samples");
    else if (const auto clock = clock_of(channel, options, file, issues))
      clocks.push_back(*clock);
  }
  issues.raise();
  check_clocks(channels, clocks, options.missing, file, issues);
  if (!options.missing)
    for (std::size_t j = 0; j < wanted.size(); ++j) check_samples(*channels[j].measured, clocks[j], file, issues);
  issues.raise();
  Record record = side_by_side(channels, clocks, factors, file);
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

#include "kalfem/formats/tables/channel_title.hpp"

#include <algorithm>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {

namespace {

bool is_known_unit(std::string_view text) {
  if (text == "G") return true;  // of accelerations
  try {
    parse_unit(text);
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

/// A unit that kalfem knows, or at least a quotient or a power: "m/sec^2" must not pass for a part of the name.
bool is_written_like_a_unit(std::string_view text) {
  const bool only_numbers = text.find_first_not_of("0123456789.,-+ ") == std::string_view::npos;
  if (only_numbers) return false;
  const bool composed = text.find_first_of("/^") != std::string_view::npos || text.find("²") != std::string_view::npos;
  return composed || lower_case(text) == "db" || is_known_unit(text);
}

/// The title split at the last `open`, or with the unit left empty where it does not end with `close`.
Channel split_title(std::string_view title, char open, char close) {
  const std::size_t place = title.rfind(open);
  if (place == std::string_view::npos || place == 0 || !title.ends_with(close)) return {std::string(title), ""};
  const std::string_view unit = trimmed(title.substr(place + 1, title.size() - place - 2));
  return {std::string(trimmed(title.substr(0, place))), std::string(unit)};
}

}  // namespace

Channel channel_of(std::string_view title) {
  if (Channel bracketed = split_title(title, '[', ']'); bracketed.name.size() < title.size()) return bracketed;
  Channel channel = split_title(title, '(', ')');
  if (is_written_like_a_unit(channel.unit)) return channel;
  return {std::string(title), ""};
}

Eigen::Index find_channel(const std::vector<Channel>& channels, std::string_view wanted) {
  const auto place = [&](const auto& matches) {
    const auto found = std::ranges::find_if(channels, matches);
    return found == channels.end() ? Eigen::Index{-1} : static_cast<Eigen::Index>(found - channels.begin());
  };
  const Eigen::Index exact = place([&](const Channel& channel) { return channel.name == wanted; });
  if (exact >= 0) return exact;
  const Channel apart = channel_of(wanted);
  return place([&](const Channel& channel) {
    return !apart.unit.empty() && channel.name == apart.name && channel.unit == apart.unit;
  });
}

}  // namespace kalfem

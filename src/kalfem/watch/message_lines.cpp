// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/message_lines.hpp"

#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/watch/stream_line.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view magic = "KFB1";
constexpr std::size_t header = 4 + 4 + 8 + 8;  ///< bytes: magic, counter, t0, dt
constexpr std::size_t most_topics = 10'000;    ///< whose counters are kept
constexpr int deepest = 2;                     ///< level of JSON: an object of lists

static_assert(std::endian::native == std::endian::little, "binary blocks are read as they stand");

template <class T>
T at(std::string_view bytes, std::size_t place) {
  T value;
  std::memcpy(&value, bytes.data() + place, sizeof value);
  return value;
}

std::string channel_of(const std::string& topic) { return valid_utf8(topic.substr(topic.rfind('/') + 1)); }

/// An object; what is nested deeper than lists in it is refused before it is built.
Json object_of(const std::string& topic, std::string_view payload) {
  bool too_deep = false;
  const auto goes_on = [&](int depth, Json::parse_event_t, const Json&) {
    too_deep = too_deep || depth > deepest;
    return !too_deep;
  };
  Json object = Json::parse(payload, goes_on, false);
  if (too_deep || !object.is_object())
    throw InvalidInput("a message on '" + valid_utf8(topic) + "' is neither a JSON object nor a binary block",
                       "an object holds numbers and lists of them", "");
  return object;
}

std::string text_of(const Json& line) { return line.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

/// Counters run through 2^32. One that has fallen by much is that of a sender that has begun anew.
bool MessageLines::is_new(const std::string& topic, std::uint32_t counter) {
  constexpr std::uint32_t recent = 1000;
  if (counters_.size() >= most_topics && !counters_.contains(topic))
    throw InvalidInput("a counter on '" + valid_utf8(topic) + "'",
                       "those of " + std::to_string(most_topics) + " topics are kept, and so many have sent one",
                       "name the topics of the sensors in live.mqtt.topics");
  const auto [last, first] = counters_.try_emplace(topic, counter);
  if (first) return true;
  const std::uint32_t behind = last->second - counter, ahead = counter - last->second;
  if (behind < recent) {
    ++repeated_;
    return false;
  }
  if (ahead < recent) lost_ += ahead - 1;
  last->second = counter;
  return true;
}

std::optional<std::string> MessageLines::line_of(const std::string& topic, std::string_view payload) {
  if (payload.size() > StreamLines::longest_line)
    throw InvalidInput("a message of " + std::to_string(payload.size()) + " bytes on '" + valid_utf8(topic) + "'", "",
                       "write fewer samples in a message");
  if (payload.starts_with(magic)) {
    if (payload.size() <= header || (payload.size() - header) % sizeof(double) != 0)
      throw InvalidInput("a binary block of " + std::to_string(payload.size()) + " bytes on '" + topic + "'",
                         "it has 24 bytes before its values, and 8 for each", "");
    if (!is_new(topic, at<std::uint32_t>(payload, 4))) return {};
    Json values = Json::array();
    for (std::size_t place = header; place < payload.size(); place += sizeof(double)) {
      const double value = at<double>(payload, place);
      values.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
    }
    return text_of({{"t", at<double>(payload, 8)}, {"dt", at<double>(payload, 16)}, {channel_of(topic), values}});
  }
  Json object = object_of(topic, payload);
  if (const auto counter = object.find("counter"); counter != object.end()) {
    if (!counter->is_number_unsigned() || counter->get<std::uint64_t>() > UINT32_MAX)
      throw InvalidInput("a message on '" + topic + "' has a counter that is no whole number below 2^32", "", "");
    const bool fresh = is_new(topic, counter->get<std::uint32_t>());
    object.erase("counter");
    if (!fresh) return {};
  }
  if (const auto values = object.find("values"); values != object.end()) {
    Json line = Json::object();
    if (object.contains("t0")) line["t"] = object["t0"];
    for (const char* key : {"dt", "unit"})
      if (object.contains(key)) line[key] = object[key];
    line[channel_of(topic)] = *values;
    return text_of(line);
  }
  return text_of(object);
}

std::string binary_block(std::uint32_t counter, double start, double interval, const std::vector<double>& values) {
  std::string bytes(magic);
  const auto add = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  add(counter);
  add(start);
  add(interval);
  for (const double value : values) add(value);
  return bytes;
}

}  // namespace kalfem

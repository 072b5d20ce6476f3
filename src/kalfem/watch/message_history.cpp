// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/message_history.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace kalfem {
namespace {

std::string word_of(MessageKind kind) {
  switch (kind) {
    case MessageKind::alarm:
      return "alarm";
    case MessageKind::trend:
      return "trend";
    case MessageKind::estimates:
      break;
  }
  return "estimates";
}

}  // namespace

void MessageHistory::add(MessageKind kind, const std::string& name, const std::string& line) {
  using Json = nlohmann::json;
  std::string event = "data: {\"case\":" + Json(name).dump(-1, ' ', false, Json::error_handler_t::replace) +
                      ",\"kind\":\"" + word_of(kind) + "\",\"line\":" + line + "}\n\n";
  const std::scoped_lock lock(lock_);
  bytes_ += event.size();
  events_.push_back(std::move(event));
  ++added_;
  for (; bytes_ > most_bytes_ && events_.size() > 1; events_.pop_front()) bytes_ -= events_.front().size();
}

std::string MessageHistory::events_after(std::int64_t& seen, std::size_t most_bytes) const {
  const std::scoped_lock lock(lock_);
  const auto dropped = added_ - std::ssize(events_);
  seen = std::max(seen, dropped);
  std::string text;
  for (auto event = events_.begin() + (seen - dropped); event != events_.end() && text.size() < most_bytes; ++event) {
    text += *event;
    ++seen;
  }
  return text;
}

}  // namespace kalfem

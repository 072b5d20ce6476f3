#include "kalfem/yaml/environment.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <string_view>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

constexpr int deepest_default = 20;

class Expander {
public:
  Expander(std::string_view text, const Environment& environment) : text_(text), environment_(environment) {}

  std::string expand() { return until_brace(0); }

private:
  /// Copies up to the closing brace of the enclosing ${ (depth > 0) or the end of the text.
  std::string until_brace(int depth) {
    if (depth > deepest_default) fail("the defaults are nested too deeply", "use fewer ${...} inside one another");
    std::string out;
    while (position_ < text_.size() && !(depth > 0 && text_[position_] == '}')) {
      if (take("$${")) {
        out += "${";
      } else if (take("${")) {
        out += variable(depth);
      } else {
        out += text_[position_++];
      }
    }
    return out;
  }

  /// The text after ${; a default that is not used is still read to its brace, but may name variables that are not set.
  std::string variable(int depth) {
    const std::string name = variable_name();
    const std::optional<std::string> value = environment_(name);
    std::optional<std::string> fallback;
    if (take(":-")) {
      const bool is_used = !value || value->empty();
      unused_ += is_used ? 0 : 1;
      fallback = until_brace(depth + 1);
      unused_ -= is_used ? 0 : 1;
    }
    if (!take("}")) {
      fail("a '}' is missing or the name is not one of letters, digits and _", "write ${NAME} or ${NAME:-default}");
    }
    if (value && !(value->empty() && fallback)) return *value;
    if (!fallback && unused_ == 0) {
      fail("the environment variable " + name + " is not set", "set it or write ${" + name + ":-default}");
    }
    return fallback.value_or("");
  }

  std::string variable_name() {
    const std::size_t begin = position_;
    while (position_ < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[position_])) || text_[position_] == '_'))
      ++position_;
    if (position_ == begin)
      fail("${ is not followed by a name", "write ${NAME} or ${NAME:-default}; $${ for a literal ${");
    return std::string(text_.substr(begin, position_ - begin));
  }

  bool take(std::string_view token) {
    if (text_.substr(position_, token.size()) != token) return false;
    position_ += token.size();
    return true;
  }

  [[noreturn]] void fail(const std::string& why, const std::string& fix) const {
    throw InvalidInput("'" + std::string(text_.substr(0, 200)) + "'", why, fix);
  }

  std::string_view text_;
  const Environment& environment_;
  std::size_t position_ = 0;
  int unused_ = 0;  ///< defaults around this place that are not used
};

}  // namespace

Environment process_environment() {
  return [](const std::string& name) -> std::optional<std::string> {
    const char* value = std::getenv(name.c_str());
    if (!value) return std::nullopt;
    return value;
  };
}

std::string expand_environment(const std::string& text, const Environment& environment) {
  return text.find("${") == std::string::npos ? text : Expander(text, environment).expand();
}

}  // namespace kalfem

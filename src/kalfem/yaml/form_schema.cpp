#include "kalfem/yaml/form_schema.hpp"

#include <limits>
#include <nlohmann/json.hpp>

namespace kalfem {

namespace {
using Json = nlohmann::ordered_json;
}

FormSchema::FormSchema() : FormSchema(Json::object()) {}
FormSchema::FormSchema(Json json) : json_(std::make_shared<const Json>(std::move(json))) {}

std::string FormSchema::written() const { return json_->value("x-written", ""); }
std::string FormSchema::unit() const { return json_->value("x-unit", ""); }

FormSchema FormSchema::written_as(const std::string& written) const {
  Json json = *json_;
  json["x-written"] = written;
  return FormSchema(std::move(json));
}

FormSchema scalar_schema(const std::string& written) {
  return FormSchema(Json{{"type", {"string", "number"}}, {"x-written", written}});
}

FormSchema choice_schema(const std::vector<std::string>& words, const std::vector<std::string>& meanings) {
  std::string joined;
  Json alternatives = Json::array();
  for (std::size_t i = 0; i < words.size(); ++i) {
    joined += (joined.empty() ? "" : " | ") + words[i];
    alternatives.push_back({{"const", words[i]}, {"description", meanings[i]}});
  }
  return FormSchema(Json{{"oneOf", alternatives}, {"x-written", joined}});
}

FormSchema list_schema(const FormSchema& item, std::size_t least, std::size_t most) {
  Json json{{"type", "array"}, {"items", item.json()}, {"x-written", "[" + item.written() + ", ...]"}};
  if (least > 0) json["minItems"] = least;
  if (most != std::numeric_limits<std::size_t>::max()) json["maxItems"] = most;
  return FormSchema(std::move(json));
}

FormSchema either_schema(const FormSchema& one, const FormSchema& other) {
  return FormSchema(
      Json{{"anyOf", {one.json(), other.json()}}, {"x-written", one.written() + " or " + other.written()}});
}

FormSchema named_schema(const FormSchema& item) {
  return FormSchema(Json{
      {"type", "object"}, {"additionalProperties", item.json()}, {"x-written", "{name: " + item.written() + ", ...}"}});
}

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "casefile/case_sections.hpp"
#include "kalfem/casefile/case_schema.hpp"

/// Every key of the case file is set once, and what is built from it is compared with the right number. The list of
/// keys is the schema's own: a key without a check fails, and so does a check without a key.
namespace kalfem::wiring {
namespace {

using Json = nlohmann::ordered_json;

/// Paths of the keys below a schema that have no further keys: "simulate.initial.*.velocity", "[]" for items of a list.
void collect(const Json& schema, const std::string& path, std::vector<std::string>& keys) {
  const std::size_t before = keys.size();
  if (schema.contains("properties"))
    for (const auto& [key, property] : schema["properties"].items())
      collect(property, path.empty() ? key : path + "." + key, keys);
  if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object()) {
    std::vector<std::string> inner;
    collect(schema["additionalProperties"], path + ".*", inner);
    if (inner.size() > 1 || inner.front() != path + ".*") keys.insert(keys.end(), inner.begin(), inner.end());
  }
  if (schema.contains("items")) {
    std::vector<std::string> inner;
    collect(schema["items"], path + "[]", inner);
    if (inner.size() > 1 || inner.front() != path + "[]") keys.insert(keys.end(), inner.begin(), inner.end());
  }
  for (const auto& alternative : schema.value("anyOf", Json::array())) {
    std::vector<std::string> inner;
    collect(alternative, path, inner);
    if (inner.size() > 1 || inner.front() != path) keys.insert(keys.end(), inner.begin(), inner.end());
  }
  if (keys.size() == before) keys.push_back(path);
}

std::vector<std::string> schema_keys() {
  std::vector<std::string> keys;
  collect(description::case_schema().json_schema().json(), "", keys);
  std::ranges::sort(keys);
  const auto same = std::ranges::unique(keys);
  keys.erase(same.begin(), same.end());
  return keys;
}

const KeyChecks& checks() {
  static const KeyChecks all = [] {
    KeyChecks merged;
    for (auto* table : {structure_keys, finite_element_keys, component_keys, excitation_keys, sensor_and_record_keys,
                        simulation_keys, estimation_keys, updating_keys, compared_response_keys, report_keys,
                        inference_keys, placement_keys, static_keys, frequency_response_keys, live_keys})
      for (auto& [key, check] : table()) {
        EXPECT_FALSE(merged.contains(key)) << key << " stands in two tables";
        merged[key] = check;
      }
    return merged;
  }();
  return all;
}

class EveryKey : public testing::TestWithParam<std::string> {};

TEST_P(EveryKey, ReachesWhatIsBuiltFromIt) {
  const auto check = checks().find(GetParam());
  ASSERT_NE(check, checks().end()) << "no test sets the key '" << GetParam()
                                   << "': add to the tables what is built from it";
  // Keys that are checked together are checked once.
  static std::set<void (*)()> passed;
  const auto* function = check->second.target<void (*)()>();
  if (function && passed.contains(*function)) return;
  check->second();
  if (function && !HasFailure()) passed.insert(*function);
}

INSTANTIATE_TEST_SUITE_P(Schema, EveryKey, testing::ValuesIn(schema_keys()), [](const auto& each) {
  std::string name = each.param;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name + "_" + std::to_string(each.index);
});

TEST(EveryCheck, IsOfAKeyOfTheSchema) {
  const auto keys = schema_keys();
  for (const auto& [key, check] : checks())
    EXPECT_TRUE(std::ranges::find(keys, key) != keys.end()) << "the schema has no key '" << key << "'";
  EXPECT_GT(keys.size(), 200u);
}

}  // namespace
}  // namespace kalfem::wiring

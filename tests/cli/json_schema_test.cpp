// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/absent.hpp"
#include "command.hpp"

namespace kalfem::test {
namespace {

/// Exit codes of Python's jsonschema over a case: 0 valid, 1 not, 2 it is absent.
constexpr const char* validator = R"(
import json, sys
try:
    import jsonschema, yaml
except ImportError:
    sys.exit(2)
schema = json.load(open(sys.argv[1]))
jsonschema.Draft202012Validator.check_schema(schema)
class Loader(yaml.SafeLoader):
    pass
Loader.yaml_implicit_resolvers = {
    key: [each for each in value if each[0] != "tag:yaml.org,2002:timestamp"]
    for key, value in yaml.SafeLoader.yaml_implicit_resolvers.items()}
def with_text_keys(node):
    if isinstance(node, dict):
        return {str(key): with_text_keys(value) for key, value in node.items()}
    return [with_text_keys(each) for each in node] if isinstance(node, list) else node
case = with_text_keys(yaml.load(open(sys.argv[2]), Loader))
errors = list(jsonschema.Draft202012Validator(schema).iter_errors(case))
for error in errors:
    print("/".join(map(str, error.absolute_path)), error.message[:300])
sys.exit(1 if errors else 0)
)";

class JsonSchema : public testing::Test {
protected:
  JsonSchema() {
    std::ofstream(folder_ / "validate.py") << validator;
    std::ofstream(folder_ / "schema.json") << run_command("schema --json", folder_).output;
  }

  /// Whether the schema takes the case, with what it says against it.
  std::pair<bool, std::string> verdict(const std::string& file) {
    const std::string words = (folder_ / "words.txt").string();
    const int status = std::system(("/usr/bin/python3 " + (folder_ / "validate.py").string() + " " +
                                    (folder_ / "schema.json").string() + " " + file + " >" + words + " 2>&1")
                                       .c_str());
    is_absent_ = WEXITSTATUS(status) == 2;
    return {WEXITSTATUS(status) == 0, read(words)};
  }
  std::pair<bool, std::string> verdict_of_text(const std::string& text) {
    std::ofstream(folder_ / "case.yaml") << text;
    return verdict((folder_ / "case.yaml").string());
  }

  ScratchFolder folder_{"json-schema"};
  bool is_absent_ = false;
};

TEST_F(JsonSchema, TakesEveryExample) {
  int cases = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(example(""))) {
    const std::string folder = entry.path().parent_path().filename().string();
    if (entry.path().extension() != ".yaml" || folder.ends_with(".kalfem-out")) continue;
    const auto [valid, words] = verdict(entry.path().string());
    if (is_absent_) KALFEM_ABSENT("python3-jsonschema or python3-yaml is absent");
    EXPECT_TRUE(valid) << entry.path() << "\n" << words;
    ++cases;
  }
  EXPECT_GT(cases, 20);
}

const std::string small = R"(kalfem: 1
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{from: ground, to: w, stiffness: 20 kN/m}]}
  body: {chain: {masses: 2, mass: 1 kg, stiffness: 30 kN/m}}
connectors:
  strut: {from: wheel.w, to: body.1, law: saturating, parameters: {k: 5e3, mu_k1: 20}}
sensors:
  a: {acceleration: body.2, noise: 15 %}
simulate: {duration: 20 s, sample_rate: 1000, integrator: newmark}
)";

TEST_F(JsonSchema, RefusesWhatIsWrong) {
  ASSERT_TRUE(verdict_of_text(small).first || is_absent_) << verdict_of_text(small).second;
  if (is_absent_) KALFEM_ABSENT("python3-jsonschema or python3-yaml is absent");
  const auto with = [](const std::string& old_text, const std::string& new_text) {
    std::string text = small;
    return text.replace(text.find(old_text), old_text.size(), new_text);
  };
  for (const auto& [old_text, new_text] : {std::pair<std::string, std::string>{"saturating", "saturated"},
                                           {"mu_k1", "mu_k3"},
                                           {"newmark", "euler"},
                                           {"duration", "durations"},
                                           {"20 s", "-1"},
                                           {"20 s", "long"},
                                           {"masses: 2", "masses: two"},
                                           {"a: {", "a b: {"},
                                           {"kalfem: 1\n", ""}})
    EXPECT_FALSE(verdict_of_text(with(old_text, new_text)).first) << old_text << " -> " << new_text;
  for (const auto& [old_text, new_text] : {std::pair<std::string, std::string>{"saturating", "'${LAW:-saturating}'"},
                                           {"newmark", "'${HOW:-newmark}'"},
                                           {"20 s", "'${LONG:-20 s}'"},
                                           {"masses: 2", "masses: '${COUNT:-2}'"},
                                           {"15 %", "1e-3 m/s^2"}})
    EXPECT_TRUE(verdict_of_text(with(old_text, new_text)).first) << old_text << " -> " << new_text;
}

}  // namespace
}  // namespace kalfem::test

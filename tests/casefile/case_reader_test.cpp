// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/case_reader.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "casefile/sample_case.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::sample {
namespace {

const std::string sub = "substructures: {a: {masses: {m: 1}}}\n";  // the least that a study needs, line 1

TEST(CaseReader, ReadsEveryKindOfField) {
  const Study study = read(valid_text);
  EXPECT_EQ(study.title, "Chain: 2 DOF with a suspension");
  ASSERT_EQ(study.substructures.size(), 3U);
  EXPECT_EQ(study.substructures[0].first, "wheel");
  EXPECT_EQ(study.substructures[0].second.masses, (Named<double>{{"w", 1.5}, {"2", 1.5}}));
  EXPECT_EQ(study.substructures[0].second.springs, (std::vector<Spring>{{"ground", "w", 2e4}}));
  EXPECT_EQ(study.substructures[0].second.modal_damping, (std::vector<double>{0.01}));
  EXPECT_EQ(study.substructures[2].second.masses, study.substructures[1].second.masses);
  EXPECT_TRUE(study.substructures[2].second.modal_damping.empty());
  const auto& suspension = study.connectors[0].second;
  EXPECT_EQ(suspension.from.location.line, 13);
  EXPECT_EQ(suspension.from.path, "connectors.suspension.from");
  EXPECT_EQ(checked_number(suspension.parameters[1].second, "N"), 20.0);
  EXPECT_EQ(checked_number(suspension.parameters[0].second, "N/m"), 5e3);
  const auto& random = std::get<RandomRoad>(study.excitation[0].second.signal);
  EXPECT_EQ(random.band, (std::array{0.5, 30.0}));
  EXPECT_EQ(random.seed, 18446744073709551615ULL);
  EXPECT_EQ(std::get<RecordedRoad>(study.excitation[1].second.signal).channel, "r1");
  EXPECT_EQ(study.simulation->sample_rate, 1000.0);
  EXPECT_EQ(study.simulation->method, Method::exact);
  EXPECT_EQ(study.simulation->settling, 0.1);
}

TEST(CaseReader, ASectionThatIsLeftOutStaysEmpty) {
  const Study study = read(sub);
  EXPECT_FALSE(study.simulation);
  EXPECT_TRUE(study.connectors.empty());
}

struct Mistake {
  const char* name;
  std::string text;
  std::vector<std::string> expected;  ///< parts of the message
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.text; }

class Mistakes : public testing::TestWithParam<Mistake> {};

TEST_P(Mistakes, AreReportedWithLineAndFix) {
  const std::string message = problems(GetParam().text);
  for (const auto& part : GetParam().expected)
    EXPECT_NE(message.find(part), std::string::npos) << part << "\nin\n" << message;
}

INSTANTIATE_TEST_SUITE_P(
    CaseReader, Mistakes,
    testing::Values(
        Mistake{"unknown_key",
                sub + "simulate:\n  duration: 1\n  sample_rat: 5\n",
                {"case.yaml:4: simulate.sample_rat: unknown key (did you mean 'sample_rate'?)",
                 "allowed here: duration, sample_rate"}},
        Mistake{"duplicate_key",
                sub + "title: a\ntitle: b\n",
                {"case.yaml:3: 'title' is given twice: first on line 2; remove one of them"}},
        Mistake{
            "missing_key",
            sub + "simulate: {method: exact}\n",
            {"case.yaml:2: simulate: 'duration' is missing (length of the record); add 'duration: number [s] > 0'"}},
        Mistake{"empty_section", sub + "simulate:\n", {"case.yaml:2: simulate: 'duration' is missing"}},
        Mistake{"list_for_map", sub + "simulate: [1]\n", {"case.yaml:2: simulate: a list given; write {duration,"}},
        Mistake{"scalar_for_list",
                "substructures:\n  a:\n    masses: {m: 1}\n    springs: 3\n",
                {"case.yaml:4: substructures.a.springs: '3' given; write [{from, to, stiffness}, ...]"}},
        Mistake{"map_for_number",
                sub + "simulate: {duration: {a: 1}}\n",
                {"simulate.duration: a map given; write number [s] > 0"}},
        Mistake{"nothing_for_number",
                sub + "simulate: {duration: }\n",
                {"simulate.duration: nothing given; write number [s] > 0"}},
        Mistake{"wrong_unit",
                sub + "simulate: {duration: 3 kg}\n",
                {"case.yaml:2: simulate.duration: 3 kg given where s is required"}},
        Mistake{"nan", sub + "simulate: {duration: nan}\n", {"'nan' is not a finite number"}},
        Mistake{"yaml_infinity", sub + "simulate: {duration: .inf}\n", {"'.inf' is not a number"}},
        Mistake{"text_for_number", sub + "simulate: {duration: long}\n", {"'long' is not a number", "like 3 mm"}},
        Mistake{"out_of_range",
                sub + "simulate: {duration: -3 s}\n",
                {"case.yaml:2: simulate.duration: -3 s given: it must be > 0"}},
        Mistake{"out_of_interval",
                "substructures: {a: {masses: {m: 1}, modal: 150 %}}",
                {"a.modal: 150 % given: it must be in [0, 1]"}},
        Mistake{"choice",
                sub + "simulate: {duration: 1, method: newmrk}\n",
                {"'newmrk' is not known (did you mean 'newmark'?); write one of newmark | exact"}},
        Mistake{"integer",
                sub + "simulate: {duration: 1, iterations: 2.5}\n",
                {"'2.5' given; write a whole number from 1 to 100"}},
        Mistake{"integer_range",
                sub + "simulate: {duration: 1, iterations: 101}\n",
                {"'101' given; write a whole number from 1 to 100"}},
        Mistake{"negative_seed",
                sub + "excitation: {r: {base_displacement: a.m, random: {rms: 1, band: [0, 1], seed: -1}}}",
                {"'-1' given"}},
        Mistake{"boolean", sub + "simulate: {duration: 1, keep_states: yes}\n", {"'yes' given; write true or false"}},
        Mistake{"list_length",
                sub + "excitation: {r: {base_displacement: a.m, random: {rms: 1, band: [1]}}}",
                {"band: 1 values given; give 2"}},
        Mistake{"list_item",
                sub + "excitation:\n  r:\n    base_displacement: a.m\n    random:\n      rms: 1\n      band:\n        "
                      "- 1\n        - 3 m\n",
                {"case.yaml:9: excitation.r.random.band[1]: 3 m given where Hz is required"}},
        Mistake{"check_of_struct",
                sub + "excitation:\n  r: {base_displacement: a.m, random: {rms: 1, band: [3, 1]}}",
                {"case.yaml:3: excitation.r.random: the band is empty: its first frequency must be below the second; "
                 "write [low, high]"}},
        Mistake{"no_alternative",
                sub + "excitation:\n  r: {base_displacement: a.m}",
                {"case.yaml:3: excitation.r: one of random, file is missing"}},
        Mistake{"two_alternatives",
                sub + "excitation:\n  r: {base_displacement: a.m, file: a, channel: b, random: {}}",
                {"case.yaml:3: excitation.r.file: given together with 'random'", "keep one of random, file"}},
        Mistake{"key_without_effect",
                sub + "excitation:\n  r: {base_displacement: a.m, random: {rms: 1, band: [0, 1]}, channel: b}",
                {"excitation.r.channel: applies only with 'file' but 'random' is given"}},
        Mistake{"second_key_of_alternative",
                sub + "excitation: {r: {base_displacement: a.m, file: a.csv}}",
                {"excitation.r: 'channel' is missing"}},
        Mistake{"bad_name",
                "substructures: {a.b: {masses: {m: 1}}}",
                {"the name cannot be used; use letters, digits, _ and -"}},
        Mistake{"unset_variable",
                sub + "title: ${NOT_SET}/x",
                {"case.yaml:2: '${NOT_SET}/x': the environment variable NOT_SET is not set; set it or write "
                 "${NOT_SET:-default}"}},
        Mistake{"open_variable", sub + "title: ${A:-b", {"case.yaml:2: '${A:-b'", "'}' is missing"}},
        Mistake{"syntax", sub + "title: [a, b\n", {"this is not YAML"}},
        Mistake{"indentation",
                "substructures:\n  a: 1\n b: 2\n",
                {"case.yaml:3: the line begins with 1 blank, line 1 above it with 0", "in the same column"}},
        Mistake{"blank_too_many",
                "title: x\nsubstructures:\n  a: 1\n   b: 2\n  c: 3\n",
                {"case.yaml:4: the line begins with 3 blanks, line 3 above it with 2"}},
        Mistake{"tab", "substructures:\n\ta: 1\n", {"case.yaml:2: the line is indented with a tab"}},
        Mistake{"tab_among_blanks",
                "substructures:\n  a: {b: 1}\n  \tc: 1\n",
                {"case.yaml:3: the line is indented with a tab", "by blanks only"}},
        Mistake{
            "decimal_comma",
            sub + "title: x\nsimulate: {duration: 1,5 s}\n",
            {"case.yaml:3: 'duration: 1,5 s' has a decimal comma", "write the decimals with a point: duration: 1.5 s"}},
        Mistake{"empty_file", "", {"case.yaml:1: the file is empty"}},
        Mistake{"only_comments", "# nothing\n", {"case.yaml:1: the file is empty"}},
        Mistake{"scalar_file", "hello", {"case.yaml:1: 'hello' given; write {title, substructures"}},
        Mistake{"two_documents", sub + "---\ntitle: b\n", {"a second document starts with ---"}},
        Mistake{"not_utf8", sub + "title: \xFF\n", {"case.yaml:2: not a text file in UTF-8"}},
        Mistake{"binary", std::string("a\0b", 3), {"case.yaml:1: not a text file in UTF-8"}},
        Mistake{"key_is_a_map", "{a: 1}: 2", {"a key must be a word or a number"}},
        Mistake{"unknown_alias", sub + "title: *nowhere", {"case.yaml:2: this is not YAML"}},
        Mistake{"alias_of_itself", "substructures: &a {b: *a}", {"the alias is inside the value that it refers to"}},
        Mistake{"merge_of_text",
                "substructures: {a: {<<: x, masses: {m: 1}}}",
                {"<< is used on 'x'", "only maps can be merged"}}),
    [](const auto& each) { return each.param.name; });

TEST(CaseReader, SeveralMistakesAreReportedInOrderOfLines) {
  const std::string message =
      problems("titel: x\nsubstructures:\n  a: {masses: {m: -1, n: 2 s}}\nsimulate: {}\ntitle: a\ntitle: b\n");
  std::size_t at = 0;
  for (const char* part :
       {":1: titel: unknown key", ":3: substructures.a.masses.m: -1 given", ":3: substructures.a.masses.n: 2 s given",
        ":4: simulate: 'duration' is missing", ":6: 'title' is given twice"}) {
    const std::size_t found = message.find(part, at);
    EXPECT_NE(found, std::string::npos) << part << "\nin order in\n" << message;
    if (found != std::string::npos) at = found;
  }
}

TEST(CaseReader, AProblemFoundLaterKnowsItsPlace) {
  const Study study = read(valid_text);
  try {
    checked_number(study.connectors[0].second.parameters[1].second, "kg");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what())
                  .find("case.yaml:13: connectors.suspension.parameters.mu: 20 N given where kg is required"),
              std::string::npos)
        << error.what();
  }
}

TEST(CaseReader, FilesThatCannotBeRead) {
  EXPECT_THROW(read_case("/no/such/file.yaml", study_schema()), InvalidInput);
  EXPECT_THROW(read_case(std::filesystem::temp_directory_path().string(), study_schema()), InvalidInput);
}

TEST(CaseReader, PathsAreRelativeToTheCaseFile) {
  const ScratchFolder folder("case-paths");
  std::ofstream(folder / "road.csv") << "x";
  const auto form = schema::list(schema::path());
  EXPECT_EQ(read_case_text("[./road.csv]", (folder / "case.yaml").string(), form).front(), folder / "road.csv");
  EXPECT_THROW(read_case_text("[rod.csv]", (folder / "case.yaml").string(), form), InvalidInput);
  EXPECT_THROW(read_case_text("['']", (folder / "case.yaml").string(), form), InvalidInput);
}

TEST(Environment, ExpandsVariablesAndNestedDefaults) {
  const Environment environment = [](const std::string& name) -> std::optional<std::string> {
    if (name == "DATA") return "/data ${DATA}";
    if (name == "EMPTY") return "";
    return std::nullopt;
  };
  EXPECT_EQ(expand_environment("x", environment), "x");
  EXPECT_EQ(expand_environment("${DATA}/a", environment), "/data ${DATA}/a");
  EXPECT_EQ(expand_environment("${NO:-${NOT:-b}}c", environment), "bc");
  EXPECT_EQ(expand_environment("${DATA:-${NOT_SET}}", environment), "/data ${DATA}");
  EXPECT_EQ(expand_environment("${EMPTY:-b}|${EMPTY}", environment), "b|");
  EXPECT_EQ(expand_environment("$${DATA} $x }", environment), "${DATA} $x }");
  for (const char* text : {"${", "${}", "${A B}", "${NOT}", "${NOT:-${ALSO_NOT}}", "${A:-"})
    EXPECT_THROW(expand_environment(text, environment), InvalidInput) << text;
}

}  // namespace
}  // namespace kalfem::sample

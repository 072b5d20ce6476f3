// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "casefile/sample_case.hpp"
#include "kalfem/yaml/json_schema.hpp"

namespace kalfem::sample {
namespace {

TEST(Echo, ReadsBackAsTheSameStudy) {
  const Study study = read(valid_text);
  const std::string echoed = to_yaml(*study_schema().write(study));
  EXPECT_TRUE(read(echoed) == study) << echoed;
  EXPECT_EQ(to_yaml(*study_schema().write(read(echoed))), echoed);
}

TEST(Echo, ShowsDefaultsAndUnits) {
  const std::string echoed = to_yaml(*study_schema().write(read(valid_text)));
  for (const char* line :
       {"  sample_rate: 1000  # Hz\n", "  iterations: 10\n", "    stiffness: 20000  # N/m\n",
        "      band: [0.5, 30]  # Hz\n", "    modal: [0.01]\n", "      - from: ground\n", "      mu: 20 N\n"})
    EXPECT_NE(echoed.find(line), std::string::npos) << line << "in\n" << echoed;
}

TEST(Echo, TextThatLooksLikeSomethingElseSurvives) {
  for (const std::string text :
       {"",     " ",     "null",           "~",       "true", "1.5", "a: b",   "# c", "\"q\" \\ 'r'",
        "${A}", "$${A}", "two\nlines\t\r", "- x",     "é µ",  "a ",  "*alias", "[x]", "{x}",
        "@",    "`",     "a #b",           "\x01\x7F"}) {
    Study study = read(valid_text);
    study.title = text;
    EXPECT_EQ(read(to_yaml(*study_schema().write(study))).title, text);
  }
}

TEST(Echo, NumbersKeepEveryBit) {
  for (const double value : {0.1, 1.0 / 3.0, 1.0000000000000002e-100, 9.999999999999999e99, 123456789.0, 1e22}) {
    Study study = read(valid_text);
    study.simulation->duration = value;
    EXPECT_EQ(read(to_yaml(*study_schema().write(study))).simulation->duration, value);
  }
}

TEST(Schema, IsAJsonSchemaOfTheTable) {
  const auto schema =
      nlohmann::ordered_json::parse(whole_json_schema(study_schema().json_schema(), "kalfem case").dump());
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  EXPECT_EQ(schema["required"], nlohmann::ordered_json({"substructures"}));
  EXPECT_EQ(schema["additionalProperties"], false);
  const auto& simulate = schema["properties"]["simulate"];
  EXPECT_EQ(simulate["description"], "the reference");
  EXPECT_EQ(simulate["properties"]["sample_rate"]["default"], 1000);
  EXPECT_EQ(simulate["properties"]["sample_rate"]["x-unit"], "Hz");
  EXPECT_EQ(simulate["properties"]["sample_rate"]["exclusiveMinimum"], 0.0);
  EXPECT_EQ(simulate["properties"]["method"]["oneOf"][1]["const"], "exact");
  EXPECT_EQ(simulate["properties"]["method"]["default"], "newmark");
  EXPECT_FALSE(simulate["properties"]["settling"].contains("default"));
  const auto& road = schema["properties"]["excitation"]["additionalProperties"];
  EXPECT_EQ(road["allOf"][0]["oneOf"][0]["required"], nlohmann::ordered_json({"random"}));
  EXPECT_EQ(road["allOf"][0]["oneOf"][1]["required"], nlohmann::ordered_json({"file", "channel"}));
  EXPECT_EQ(road["required"], nlohmann::ordered_json({"base_displacement"}));
  const auto& band = road["properties"]["random"]["properties"]["band"];
  EXPECT_EQ(band["minItems"], 2);
  EXPECT_EQ(band["maxItems"], 2);
}

TEST(Schema, ReferenceTextNamesEveryKeyWithItsMeaning) {
  const std::string text = reference_text(study_schema().json_schema().json());
  for (const char* part : {"simulate:", "  duration: number [s] > 0 (required)", "length of the record",
                           "(default 1000)", "<name>:", "random: (one of random | file)", "channel: text (with file)",
                           "iterations: whole number in [1, 100] (default 10)", "list of 2: number [Hz]", "= newmark",
                           "average acceleration", "- each:"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nin\n" << text;
}

}  // namespace
}  // namespace kalfem::sample

// SPDX-License-Identifier: Apache-2.0
// Decks with other values: only the fields meant change, and the modes are those of the model that is meant.
#include "kalfem/formats/updated_deck.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/scratch_folder.hpp"
#include "formats/nastran_decks.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/formats/nastran/card.hpp"
#include "kalfem/formats/rewriting/nastran_line.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using rewriting::nastran_real;
using rewriting::rewritten_line;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Lines of one text that the other has not.
std::multiset<std::string> without(const std::string& text, const std::string& other) {
  const auto lines = lines_of(text);
  std::multiset<std::string> left(lines.begin(), lines.end());
  for (const auto& line : lines_of(other))
    if (const auto found = left.find(line); found != left.end()) left.erase(found);
  return left;
}

fs::path file_with(const ScratchFolder& folder, const std::string& name, const std::string& text) {
  fs::create_directories((folder.path() / name).parent_path());
  std::ofstream(folder.path() / name, std::ios::binary) << text;
  return folder.path() / name;
}

TEST(NastranReal, FillsItsFieldBest) {
  EXPECT_EQ(nastran_real(7850.0, 8), "7850.");
  EXPECT_EQ(nastran_real(0.0012346, 8), ".0012346");
  EXPECT_EQ(nastran_real(2.1e11, 8), "2.1+11");
  EXPECT_EQ(nastran_real(2.05123456e11, 8), "20512.+7");
  EXPECT_EQ(nastran_real(-2.5e-9, 8), "-2.5-9");
  EXPECT_EQ(nastran_real(0.0, 8), "0.");
  for (const double value : {2.05123456789e11, 7.8312345e-9, 0.00123456789012, 1.0 / 3.0, 6.25e-12, 123456.789})
    for (const std::size_t width : {8u, 16u}) {
      const auto text = nastran_real(value, width);
      EXPECT_LE(text.size(), width) << text;
      // five digits and an exponent, or twelve
      EXPECT_NEAR(*nastran::parse_real(text) / value, 1.0, width == 8 ? 5e-5 : 5e-12) << text;
    }
}

TEST(RewrittenLine, KeepsTheOtherFields) {
  const std::string small = "MAT1           7  2.1+11              .3   7850.  1.2-5          +A    $ steel";
  const auto changed = rewritten_line(small, {{16, 8, 2.05e11}});
  EXPECT_EQ(changed.text, "MAT1           7 2.05+11              .3   7850.  1.2-5          +A    $ steel");
  EXPECT_FALSE(changed.became_large);
  const auto left = rewritten_line("PSHELL  3       7       2.5-3   7", {{24, 5, 2.6e-3}});
  EXPECT_EQ(left.text, "PSHELL  3       7       .0026   7");
  const auto free = rewritten_line("MAT1, 7, 2.1+11,, .3, 7850.  $ steel", {{9, 6, 2.0512345678e11}, {22, 5, 7801.25}});
  EXPECT_EQ(free.text, "MAT1, 7, 2.0512345678+11,, .3, 7801.25  $ steel");
}

TEST(RewrittenLine, BecomesLargeWhereEightColumnsRound) {
  // 1.0234567e11 has five digits in 8 columns: 10235.+7 is off by 3e-5
  const auto changed = rewritten_line("MAT1    7       2.1+11          .3      7850.   1.2-5                   +A",
                                      {{16, 6, 1.0234567e11}});
  EXPECT_TRUE(changed.became_large);
  EXPECT_EQ(changed.text,
            "MAT1*   7               1.0234567+11                    .3\n"
            "*       7850.           1.2-5                                           +A");
}

constexpr const char* plate = R"(CEND
SPC = 1
BEGIN BULK
$ two plates of one material, one of them layered
MAT1    7       2.1+11          .3      7850.
PSHELL  1       7       .01     7               7
PCOMP   2                                                       
        7       .005    0.              7       .005    0.
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
GRID,5,,2.,0.,0.
GRID,6,,2.,1.,0.
CQUAD4,1,1,1,2,3,4
CQUAD4,2,2,2,5,6,3
CONM2,9,6,,2.5
CELAS2,8,1000.,6,3
SPC1,1,123456,1,4
ENDDATA
)";

const FiniteElementModel& updated_model(const UpdatedDeck& deck, Deck& read) {
  read = parse_nastran(deck.texts.at(deck.file), "deck.bdf");
  return read.model;
}

TEST(UpdatedDeck, ChangesTheFieldsThatAreMeant) {
  const ScratchFolder folder("updated-deck-meant");
  const auto file = file_with(folder, "plate.bdf", plate);
  const auto result = updated_deck(
      file, {{"pshell1.thickness", 0.0125, "plate.t"}, {"conm2_9.mass", 2.75}, {"celas8.stiffness", 1234.5}});
  EXPECT_TRUE(result.unwritten.empty());
  ASSERT_EQ(result.changes.size(), 3u);
  EXPECT_EQ(result.file, "plate.bdf");
  EXPECT_EQ(without(plate, result.texts.at("plate.bdf")),
            (std::multiset<std::string>{"PSHELL  1       7       .01     7               7", "CONM2,9,6,,2.5",
                                        "CELAS2,8,1000.,6,3"}));
  EXPECT_EQ(without(result.texts.at("plate.bdf"), plate),
            (std::multiset<std::string>{"PSHELL  1       7       .0125   7               7", "CONM2,9,6,,2.75",
                                        "CELAS2,8,1234.5,6,3"}));
  const auto& first = result.changes.front();
  EXPECT_EQ(first.parameter, "plate.t");
  EXPECT_EQ(first.card, "PSHELL 1");
  EXPECT_EQ(first.before, ".01");
  EXPECT_EQ(first.after, ".0125");
  EXPECT_EQ(first.where.line, 6);
}

TEST(UpdatedDeck, SplitsAMaterialThatOthersShare) {
  const ScratchFolder folder("updated-deck-split");
  const auto file = file_with(folder, "plate.bdf", plate);
  const auto result = updated_deck(file, {{"mat7.youngs_modulus", 2.0e11}, {"mat7.density", 7900.0}});
  ASSERT_TRUE(result.unwritten.empty()) << result.unwritten.front().why;
  Deck deck;
  const auto& model = updated_model(result, deck);
  const auto& shell = std::get<ShellProperty>(model.properties.at("pshell1"));
  EXPECT_EQ(shell.material, "mat8");
  EXPECT_EQ(model.materials.at("mat8").youngs_modulus, 2.0e11);
  EXPECT_EQ(model.materials.at("mat8").density, 7900.0);
  // The laminate's plies keep the card, which is not a parameter of theirs.
  Deck original;
  const auto& before = std::get<LaminateProperty>((original = read_nastran(file)).model.properties.at("pcomp2"));
  EXPECT_EQ(std::get<LaminateProperty>(model.properties.at("pcomp2")).stiffness.bending, before.stiffness.bending);
  EXPECT_TRUE(std::ranges::any_of(result.changes, [](const auto& change) {
    return change.card == "MAT1 8" && change.field == "new card" && change.remark.find("split") != std::string::npos;
  }));
}

TEST(UpdatedDeck, SaysWhatNoFieldStates) {
  const ScratchFolder folder("updated-deck-left");
  std::string text = plate;
  text.replace(text.find("CQUAD4,2,2,"), 0, "CQUAD4,3,1,1,2,3,4,,.02\n");
  const auto file = file_with(folder, "plate.bdf", text);
  const auto result = updated_deck(
      file, {{"tip.mass", 1.0}, {"conm2_9.offset_x", 0.1}, {"damping.modal", 0.02}, {"pshell1.thickness", 0.02}});
  EXPECT_TRUE(result.changes.empty());
  EXPECT_TRUE(result.texts.empty());
  ASSERT_EQ(result.unwritten.size(), 4u);
  for (const auto& each : result.unwritten) EXPECT_FALSE(each.why.empty() || each.fix.empty()) << each.parameter;
  // Another element of the property stands on an offset: its region has the same thickness, and keeps it.
  EXPECT_EQ(result.unwritten.back().parameter, "pshell1.thickness");
  EXPECT_NE(result.unwritten.back().why.find("does not change alike"), std::string::npos);
}

TEST(UpdatedDeck, WritesIncludedFilesBesideIt) {
  const ScratchFolder folder("updated-deck-included");
  std::string main = plate;
  const std::string material = "MAT1    7       2.1+11          .3      7850.\n";
  main.replace(main.find(material), material.size(), "INCLUDE '../shared/material.inc'\n");
  main.replace(main.find("PCOMP   2"), main.find("GRID,1") - main.find("PCOMP   2"),
               "PSHELL,2,7,.02,7\nINCLUDE 'empty.inc'\n");
  const auto file = file_with(folder, "in/deck/plate.bdf", main);
  file_with(folder, "in/shared/material.inc", material);
  file_with(folder, "in/deck/empty.inc", "$ nothing\r\n");
  const auto result = updated_deck(file, {{"mat7.youngs_modulus", 2.0e11}});
  ASSERT_TRUE(result.unwritten.empty()) << result.unwritten.front().why;
  const auto written = write_deck(result, folder.path() / "out");
  EXPECT_EQ(written, folder.path() / "out/deck/plate.bdf");
  EXPECT_EQ(text_of(written), main);
  EXPECT_EQ(text_of(folder.path() / "out/deck/empty.inc"), "$ nothing\r\n");
  EXPECT_EQ(text_of(folder.path() / "out/shared/material.inc"), "MAT1    7       2.+11           .3      7850.\n");
  EXPECT_EQ(read_nastran(written).model.materials.at("mat7").youngs_modulus, 2.0e11);
}

/// Every parameter of a model's cards.
std::vector<std::string> card_parameters(const FiniteElementModel& model) {
  std::vector<std::string> names;
  for (const auto& [name, value] : assemble(model, {.at_present_values = true}).parameters)
    if (value != 0.0) names.push_back(name);
  return names;
}

/// Scales a parameter of the model, or sets it, whatever a text says.
void scale(FiniteElementModel& model, const std::string& parameter, double ratio, bool set = false) {
  const auto change = [&](double& number) { number = set ? ratio : number * ratio; };
  const auto dot = parameter.rfind('.');
  const std::string name = parameter.substr(0, dot), quantity = parameter.substr(dot + 1);
  if (quantity == "youngs_modulus") change(model.materials.at(name).youngs_modulus);
  if (quantity == "density") change(model.materials.at(name).density);
  if (quantity == "thickness") change(std::get<ShellProperty>(model.properties.at(name)).thickness);
  for (auto& mass : model.masses)
    if (mass.name == name && quantity == "mass") change(mass.mass);
  for (auto& spring : model.springs)
    if (spring.name == name && quantity == "stiffness") change(spring.stiffness);
  for (auto& joint : model.joints)
    if (joint.name == name && quantity == "stiffness") change(joint.stiffness);
}

struct Rounding {
  double at_written = 0.0;  ///< largest difference of a frequency from that of the model at the written values
  double at_wanted = 0.0;   ///< from that of the model at the wanted values
  std::size_t changes = 0;
};

/// Changes every parameter of a deck, each by a ratio of its own with many digits.
Rounding rounding_of(const fs::path& file, Eigen::Index modes = 8) {
  const ScratchFolder folder("updated-deck-rounding");
  const Deck original = read_deck(file);
  auto wanted = original.model, at_written = original.model;
  std::vector<DeckValue> values;
  double ratio = 1.0123456789;
  for (const auto& parameter : card_parameters(original.model)) {
    ratio += 0.00714285714;
    const auto before = assemble(original.model, {.at_present_values = true}).parameters.at(parameter);
    values.push_back({parameter, before * ratio});
  }
  const auto result = updated_deck(file, values);
  std::set<std::string> left;
  for (const auto& each : result.unwritten) {
    left.insert(each.parameter);
    if (std::getenv("KALFEM_SHOW"))
      std::printf("  %s: %s; %s\n", each.parameter.c_str(), each.why.c_str(), each.fix.c_str());
  }
  Rounding found{.changes = result.changes.size()};
  if (result.changes.empty()) return found;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (left.contains(values[i].parameter)) continue;
    const auto before = assemble(original.model, {.at_present_values = true}).parameters.at(values[i].parameter);
    scale(wanted, values[i].parameter, values[i].value / before);
    const auto change = std::ranges::find(result.changes, values[i].parameter, &DeckFieldChange::parameter);
    EXPECT_NE(change, result.changes.end()) << values[i].parameter;
    const auto number = [](const std::string& text) { return nastran::parse_real(upper_case(text)).value_or(0.0); };
    // In the deck's own units: exactly the number that the field states, but for rows by temperature.
    const bool is_stated = number(change->before) == before;
    scale(at_written, values[i].parameter,
          is_stated ? number(change->after) : number(change->after) / number(change->before), is_stated);
  }
  const auto written = write_deck(result, folder.path());
  const auto again = read_deck(written).model;
  // What shells have against turns about their normal (K6ROT) follows their material in the deck.
  for (auto* model : {&wanted, &at_written})
    for (std::size_t i = 0; i < again.matrices.size(); ++i)
      if (again.matrices[i].name == "drilling") model->matrices[i] = again.matrices[i];
  const auto apart = [](const Eigen::VectorXd& one, const Eigen::VectorXd& other) {
    double largest = 0.0;
    for (Eigen::Index i = 0; i < one.size(); ++i)
      if (one[i] > 1e-3 * one.maxCoeff()) largest = std::max(largest, std::abs(other[i] / one[i] - 1.0));
    return largest;
  };
  const auto frequencies = test::frequencies(again, modes);
  found.at_written = apart(test::frequencies(at_written, modes), frequencies);
  found.at_wanted = apart(test::frequencies(wanted, modes), frequencies);
  // Lines of all files that changed hold a changed field, or stand for one line of such.
  EXPECT_LE(without(text_of(file), text_of(written)).size(), result.changes.size()) << file;
  return found;
}

// The modes of the written deck are those of the model at the written values to the precision of the solution, which is
// that of the condition of K times the rounding of double.
void expect_modes_of(const std::vector<fs::path>& files) {
  for (const auto& file : files) {
    const auto found = rounding_of(file);
    EXPECT_GT(found.changes, 0u) << file;
    EXPECT_LT(found.at_written, 1e-12) << file;
    EXPECT_LT(found.at_wanted, 1e-5) << file;
    std::printf("%s: %zu fields, %.1e from the written, %.1e from the wanted values\n", file.filename().c_str(),
                found.changes, found.at_written, found.at_wanted);
  }
}

TEST(UpdatedDeck, HasTheModesOfTheModel) {
  const fs::path examples = fs::path(test::source_folder()) / "examples";
  expect_modes_of({examples / "start/plate/plate.bdf", examples / "cpp/frame.bdf"});
}

TEST(UpdatedDeck, HasTheModesOfTheModelOfPublishedDecks) {
  const auto data = data_folder();
  if (!fs::exists(data / "calculix-decks")) KALFEM_ABSENT("measured data");
  std::vector<fs::path> files = {data / "pazy-wing/sol103_noskin.dat"};
  for (const char* name : {"shellf", "beam8f", "beamf", "mass2"})
    files.push_back(data / "calculix-decks" / (std::string(name) + ".inp"));
  expect_modes_of(files);
}

// Decks that reports of mistakes brought: some are no structures by themselves, or have no parameter that a field
// states.
TEST(UpdatedDeck, HasTheModesOfTheModelOfSmallDecks) {
  const auto folder = data_folder("instances/decks");
  if (!fs::exists(folder)) KALFEM_ABSENT("measured data");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (!is_deck(entry.path())) continue;
    try {
      const auto model = read_deck(entry.path()).model;
      if (!card_parameters(model).empty() && test::frequencies(model, 1).size() > 0) files.push_back(entry.path());
    } catch (const std::exception&) {
      continue;
    }
  }
  EXPECT_GE(files.size(), 5u);
  std::ranges::sort(files);
  std::size_t changed = 0;
  for (const auto& file : files) {
    const auto found = rounding_of(file, 1);
    changed += found.changes > 0 ? 1 : 0;
    EXPECT_LT(found.at_written, 1e-12) << file;
    EXPECT_LT(found.at_wanted, 1e-5) << file;
    std::printf("%s: %zu fields, %.1e from the written, %.1e from the wanted values\n", file.filename().c_str(),
                found.changes, found.at_written, found.at_wanted);
  }
  EXPECT_GE(changed, 4u);
}

constexpr const char* frame = R"(*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 2, 0, 0
6, 2, 1, 0
7, 2, 0, 1
*ELEMENT, TYPE=S4, ELSET=Skin
1, 1, 2, 3, 4
*ELEMENT, TYPE=S4, ELSET=Layered
2, 2, 5, 6, 3
*ELEMENT, TYPE=MASS, ELSET=tip
3, 6
*ELEMENT, TYPE=SPRING1, ELSET=mounts
4, 5
5, 6
*MATERIAL, NAME=Steel
*ELASTIC
 2.1E11 , 0.3, 20.
 2.0E11 , 0.3, 100.
*EXPANSION
1.2e-5
*DENSITY
7850.,
*SHELL SECTION, ELSET=Skin,
   MATERIAL=Steel
0.01, 5
*SHELL SECTION, ELSET=Layered, COMPOSITE
0.005, 3, steel, 0.
0.005, 3, steel, 90.
*MASS, ELSET=tip
2.5
*SPRING, ELSET=mounts
3
1000.
*BOUNDARY
1, 1, 6
4, 1, 6
*STEP
*FREQUENCY
3
*END STEP
)";

TEST(UpdatedDeck, SplitsAMaterialOfAbaqus) {
  const ScratchFolder folder("updated-deck-abaqus");
  const auto file = file_with(folder, "frame.inp", frame);
  const auto before = read_deck(file, {.temperature = 60.0}).model;
  const double modulus = before.materials.at("Steel").youngs_modulus;  // half way between the rows
  EXPECT_NEAR(modulus, 2.05e11, 1.0);
  const auto result = updated_deck(file,
                                   {{"Steel.youngs_modulus", 0.9 * modulus},
                                    {"Skin.thickness", 0.012},
                                    {"tip.3.mass", 2.75},
                                    {"mounts.4.stiffness", 900.0},
                                    {"mounts.5.stiffness", 900.0}},
                                   {.temperature = 60.0});
  ASSERT_TRUE(result.unwritten.empty()) << result.unwritten.front().why;
  const auto written = write_deck(result, folder / "out");
  const auto after = read_deck(written, {.temperature = 60.0}).model;
  EXPECT_EQ(material_of(after.properties.at("Skin")), "Steel_2");
  EXPECT_NEAR(after.materials.at("Steel_2").youngs_modulus, 0.9 * modulus, 1e-3);
  EXPECT_EQ(std::get<ShellProperty>(after.properties.at("Skin")).thickness, 0.012);
  EXPECT_EQ(after.masses.front().mass, 2.75);
  EXPECT_EQ(std::get<LaminateProperty>(after.properties.at("Layered")).stiffness.bending,
            std::get<LaminateProperty>(before.properties.at("Layered")).stiffness.bending);
  const std::string text = text_of(written);
  EXPECT_NE(
      text.find("*MATERIAL, NAME=Steel_2\n*ELASTIC\n 189000000000 , 0.3, 20.\n 180000000000 , 0.3, 100.\n"
                "*EXPANSION\n1.2e-5\n*DENSITY\n7850.,\n*SHELL SECTION, ELSET=Skin,\n   MATERIAL=Steel_2\n0.012, 5\n"),
      std::string::npos)
      << text;
  EXPECT_NE(text.find("*SPRING, ELSET=mounts\n3\n900\n"), std::string::npos);
  // Springs of one keyword that change apart cannot be written.
  const auto apart = updated_deck(file, {{"mounts.4.stiffness", 900.0}}, {.temperature = 60.0});
  ASSERT_EQ(apart.unwritten.size(), 1u);
  EXPECT_TRUE(apart.texts.empty());
}

TEST(UpdatedDeck, KeepsItsUnits) {
  const ScratchFolder folder("updated-deck-units");
  const auto file =
      file_with(folder, "plate.bdf",
                "PARAM,WTMASS,.00259\nMAT1,7,1.+7,,.3,.1\nPSHELL,1,7,.5,7\nGRID,1,,0.,0.,0.\nGRID,2,,9.,0.,0.\n"
                "GRID,3,,0.,9.,0.\nCTRIA3,1,1,1,2,3\nENDDATA\n");
  const UnitSystem inch{.length = 0.0254, .mass = 175.126835, .time = 1.0};
  auto model = read_nastran(file).model;
  to_si(model, inch);
  const auto result = updated_deck(file,
                                   {{"mat7.density", 1.25 * model.materials.at("mat7").density},
                                    {"mat7.youngs_modulus", 1.1 * model.materials.at("mat7").youngs_modulus}},
                                   {}, inch);
  ASSERT_TRUE(result.unwritten.empty());
  EXPECT_EQ(lines_of(result.texts.at("plate.bdf"))[1], "MAT1,7,1.1+7,,.3,.125");
}

}  // namespace
}  // namespace kalfem

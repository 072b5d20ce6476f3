// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/updating/outcome.hpp"

// Segments of one measurement, and measurements of one structure, are estimated one by one. Where the model is not the
// truth, std is many times smaller than the scatter between their estimates; std_robust should be at least half of it.
// The noise is stated once for all segments of a structure, about as large as the innovations.
namespace kalfem::test {
namespace {

using Eigen::Index;

/// A table of numbers under a line of titles.
struct Table {
  std::vector<std::string> titles;
  std::vector<std::vector<double>> rows;
};

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  if (!cells.empty() && cells.back().ends_with('\r')) cells.back().pop_back();
  return cells;
}

Table read_table(const std::filesystem::path& file) {
  std::ifstream in(file);
  Table table;
  std::string line;
  std::getline(in, line);
  table.titles = split(line);
  while (std::getline(in, line)) {
    std::vector<double> row;
    for (const auto& cell : split(line)) row.push_back(std::stod(cell));  // also "nan"
    if (row.size() == table.titles.size()) table.rows.push_back(std::move(row));
  }
  return table;
}

/// Offsets belong to the transducers, and a lost packet to the link: the mean goes, lost samples are interpolated.
void prepare(Table& table, std::size_t first_channel) {
  for (std::size_t j = first_channel; j < table.titles.size(); ++j) {
    for (std::size_t k = 1; k + 1 < table.rows.size(); ++k)
      if (std::isnan(table.rows[k][j])) table.rows[k][j] = 0.5 * (table.rows[k - 1][j] + table.rows[k + 1][j]);
    double mean = 0.0;
    for (const auto& row : table.rows) mean += row[j] / static_cast<double>(table.rows.size());
    for (auto& row : table.rows) row[j] -= mean;
  }
}

void write_table(const Table& table, const std::filesystem::path& file) {
  std::ofstream out(file);
  out << fmt::format("{}\n", fmt::join(table.titles, ","));
  for (const auto& row : table.rows) out << fmt::format("{:.9g}\n", fmt::join(row, ","));
}

/// Part of a file that is estimated by itself.
struct Segment {
  std::string file;
  double start = 0.0, end = 0.0;  // [s]
};

struct Estimate {
  std::string name;
  double value = 0.0, deviation = 0.0, robust_deviation = 0.0;
};

void replace(std::string& text, const std::string& from, const std::string& to) {
  ASSERT_NE(text.find(from), std::string::npos) << from;
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from)) text.replace(at, from.size(), to);
}

std::vector<Estimate> estimate(std::string text, const Segment& segment, const std::filesystem::path& folder) {
  replace(text, "FILE", segment.file);
  replace(text, "START", fmt::format("{} s", segment.start));
  replace(text, "END", fmt::format("{} s", segment.end));
  std::ofstream(folder / "case.yaml") << text;
  const auto results = run_study(load_study((folder / "case.yaml").string()), "estimate");
  EXPECT_TRUE(results.has<EstimationOutcome>() && !results.get<EstimationOutcome>().result.failure);
  if (!results.has<EstimationOutcome>() || results.get<EstimationOutcome>().result.failure) return {};
  const auto& outcome = results.get<EstimationOutcome>();
  const auto& unknowns = outcome.augmented_model->options().unknowns;
  std::vector<Estimate> found;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto row = static_cast<Index>(i), last = outcome.result.unknowns.mean.cols() - 1;
    found.push_back({unknowns[i].name, outcome.result.unknowns.mean(row, last),
                     outcome.result.unknowns.deviation(row, last), outcome.robust_deviation[row]});
  }
  std::cout << fmt::format("{} {:.2f} to {:.2f} s: mean NIS {:.2f} of {:.0f}\n", segment.file, segment.start,
                           segment.end, outcome.consistency.mean_nis, outcome.consistency.expected_nis);
  return found;
}

/// What the segments say of one parameter.
struct Scatter {
  std::string name;
  double between = 0.0;               // standard deviation between the segments
  double stated = 0.0, robust = 0.0;  // root mean square of theirs
};

std::vector<Scatter> scatter_of(const std::vector<std::vector<Estimate>>& all) {
  const auto n = static_cast<double>(all.size());
  std::vector<Scatter> found;
  std::cout << fmt::format("{:20}{:>11}{:>11}{:>11}{:>11}{:>9}{:>9}  estimates\n", "parameter", "mean", "scatter",
                           "std", "robust", "by std", "robust");
  for (std::size_t i = 0; i < all.front().size(); ++i) {
    Scatter of{all.front()[i].name};
    double mean = 0.0;
    for (const auto& estimates : all) mean += estimates.at(i).value / n;
    std::string values;
    for (const auto& estimates : all) {
      of.between += std::pow(estimates[i].value - mean, 2) / (n - 1.0);
      of.stated += std::pow(estimates[i].deviation, 2) / n;
      of.robust += std::pow(estimates[i].robust_deviation, 2) / n;
      values += fmt::format(" {:.5g} +- {:.2g}", estimates[i].value, estimates[i].robust_deviation);
    }
    for (double* square : {&of.between, &of.stated, &of.robust}) *square = std::sqrt(*square);
    std::cout << fmt::format("{:20}{:11.4g}{:11.3g}{:11.3g}{:11.3g}{:9.2f}{:9.2f} {}\n", of.name, mean, of.between,
                             of.stated, of.robust, of.between / of.stated, of.between / of.robust, values);
    found.push_back(std::move(of));
  }
  return found;
}

std::vector<Scatter> scatter_between(const std::string& text, const std::vector<Segment>& segments,
                                     const std::filesystem::path& folder) {
  std::vector<std::vector<Estimate>> all;
  for (const auto& segment : segments) all.push_back(estimate(text, segment, folder));
  return scatter_of(all);
}

/// The figure is 2. Two segments have a scatter of one degree of freedom, which alone is above twice its expectation
/// once in twenty times.
void expect_covered(const std::vector<Scatter>& found) {
  for (const auto& of : found) EXPECT_LE(of.between, 2.0 * of.robust) << of.name;
}

/// Prepares files of a folder of the data in `folder`; false where they are absent.
bool prepare_files(const std::string& of, const std::vector<std::string>& files, std::size_t first_channel,
                   const std::filesystem::path& folder) {
  for (const auto& file : files) {
    if (!std::filesystem::exists(data_folder(of) / file)) return false;
    Table table = read_table(data_folder(of) / file);
    prepare(table, first_channel);
    write_table(table, folder / file);
  }
  return true;
}

const std::string southampton = R"(kalfem: 1
substructures:
  frame:
    masses: {1: 5.201 kg, 2: 5.201 kg, 3: 5.201 kg}
    springs:
      - {name: storey_1, from: ground, to: 1, stiffness: 52.5 kN/m}
      - {name: storey_2, from: 1, to: 2, stiffness: 52.5 kN/m}
      - {name: storey_3, from: 2, to: 3, stiffness: 52.5 kN/m}
    damping: {modal: 0.2 %}
update:
  parameters:
    frame.storey_1.stiffness: {bounds: [20 kN/m, 100 kN/m]}
    frame.storey_2.stiffness: {bounds: [20 kN/m, 100 kN/m]}
    frame.storey_3.stiffness: {bounds: [20 kN/m, 100 kN/m]}
    frame.damping.modal: {bounds: [0.02 %, 2 %]}
  compare:
    accelerance:
      frf: frame
      inputs: [{force: FLOOR, file: "FILE"}]
      outputs: [1, 2, 3]
      bands: [[4 Hz, 32 Hz]]
      smoothing: 2 Hz
)";

/// Updates from one file, that of the responses to a force on one floor.
std::vector<Estimate> update(std::string text, const std::string& floor, const std::filesystem::path& file,
                             const std::filesystem::path& folder) {
  replace(text, "FLOOR", floor);
  replace(text, "FILE", file.string());
  std::ofstream(folder / "case.yaml") << text;
  const auto study = load_study((folder / "case.yaml").string());
  const auto results = run_study(study, "update");
  EXPECT_TRUE(results.has<UpdatingOutcome>() && results.get<UpdatingOutcome>().converged);
  if (!results.has<UpdatingOutcome>()) return {};
  const auto& outcome = results.get<UpdatingOutcome>();
  std::vector<Estimate> found;
  for (Index i = 0; i < outcome.values.size(); ++i)
    found.push_back({study.updating->parameters[static_cast<std::size_t>(i)].name, outcome.values[i],
                     outcome.statistics.deviations[i], outcome.robust.deviations[i]});
  return found;
}

TEST(MeasuredSegments, OfTheSouthamptonFrameByForceScatterAsStated) {
  const ScratchFolder folder("southampton");
  const auto data = data_folder("southampton-3storey");
  std::vector<std::vector<Estimate>> all;
  for (const auto& [floor, file] :
       {std::pair{"1", "frf_Experimental.csv"}, {"2", "frf_test_2.csv"}, {"3", "frf_test_3.csv"}}) {
    if (!std::filesystem::exists(data / file)) KALFEM_ABSENT("the frame's frequency responses are absent");
    all.push_back(update(southampton, floor, data / file, folder));
  }
  expect_covered(scatter_of(all));
}

const std::string mr_damper = R"(kalfem: 1
substructures:
  rod:
    masses: {m: 1}
    springs: [{name: k, from: ground, to: m, stiffness: 1e6, damping: 200}]
  wall:
    masses: {m: 1}
    springs: [{name: k, from: ground, to: m, stiffness: 1e6, damping: 200}]
connectors:
  damper:
    from: wall.ground
    to: rod.ground
    law: bouc_wen
    parameters: {k: 1.4e7, alpha: 0.001, beta: 3e4, gamma: 300, c: 2800}
excitation:
  piston: {base_displacement: rod.ground, file: FILE, channel: displacement_cm, unit: cm}
sensors:
  force_N: {force: damper, noise: 330 N}
record: {file: FILE, start: START, end: END}
estimate:
  diagnose: false
  settle: 0.2 s
  unknown:
    damper.k: {initial: 1.4e7, std: 50 %, transform: log}
    damper.beta: {initial: 3e4, std: 50 %, transform: log}
    damper.c: {initial: 2800, std: 50 %, transform: log}
)";

// The voltage of the coil varies along the record, and a Bouc-Wen element knows none.
TEST(MeasuredSegments, OfTheDamperByHalvesScatterAsStated) {
  const ScratchFolder folder("mr-damper");
  const std::string file = "ranran_50_first12s.csv";
  if (!std::filesystem::exists(data_folder("mr-damper") / file)) KALFEM_ABSENT("the damper's record is absent");
  Table table = read_table(data_folder("mr-damper") / file);
  constexpr double sample_rate = 3004.8;
  constexpr std::size_t every = 6;
  Table fewer{table.titles, {}};
  for (std::size_t k = 0; k < table.rows.size(); k += every) {
    fewer.rows.push_back(table.rows[k]);
    fewer.rows.back()[0] = static_cast<double>(k) / sample_rate;  // the file's times are rounded
  }
  write_table(fewer, folder / file);
  expect_covered(scatter_between(mr_damper, {{file, 0.0, 6.0}, {file, 6.0, 11.9}}, folder));
}

const std::string silverbox = R"(kalfem: 1
substructures:
  box:
    masses: {m: 5.2e-6}
    springs: [{name: k, from: ground, to: m, stiffness: 1, damping: 2.4e-4}]
connectors:
  cubic: {from: box.ground, to: box.m, law: cubic, parameters: {k3: 4}}
excitation:
  V1: {force: box.m, file: FILE, channel: V1_volt, sample_rate: 610.3515625}
sensors:
  V2: {displacement: box.m, noise: 0.33 mm, channel: V2_volt, unit: m}
record: {file: FILE, sample_rate: 610.3515625, start: START, end: END}
estimate:
  substeps: 16
  diagnose: false
  settle: 0.5 s
  initial_state: {all: {displacement_std: 0.1, velocity_std: 30}}
  unknown:
    box.m.mass: {initial: 5.2e-6, std: 10 %}
    box.k.stiffness: {initial: 1, std: 10 %}
    box.k.damping: {initial: 2.4e-4, std: 40 %}
    cubic.k3: {initial: 4, std: 40 %}
)";

TEST(MeasuredSegments, OfTheSilverboxScatterAsStated) {
  const ScratchFolder folder("silverbox");
  const std::string file = "silverbox_estimation.csv";
  if (!prepare_files("sysid-benchmarks", {file}, 0, folder)) KALFEM_ABSENT("the Silverbox record is absent");
  constexpr double realisation = 8692.0 / 610.3515625;
  std::vector<Segment> segments;
  for (int i = 0; i < 10; ++i) segments.push_back({file, i * realisation, (i + 1) * realisation - 0.3});
  expect_covered(scatter_between(silverbox, segments, folder));
}

const std::string one_storey = R"(kalfem: 1
substructures:
  frame:
    masses: {top: 0.179}
    springs: [{name: k, from: ground, to: top, stiffness: 3450, damping: 0.2}]
excitation:
  quake: {base_acceleration: all, file: FILE, channel: ground_ax}
sensors:
  top_ax: {acceleration: frame.top, noise: 0.6 m/s^2, chain: [{delay: 22.9 ms}]}
record: {file: FILE, start: START, end: END}
estimate:
  diagnose: false
  settle: 0.5 s
  initial_state: {all: {displacement_std: 1 mm, velocity_std: 0.1}}
  unknown:
    frame.k.stiffness: {initial: 3450, std: 20 %}
    frame.k.damping: {initial: 0.2, std: 60 %}
)";

TEST(MeasuredSegments, OfTheOneStoreyFrameScatterAsStated) {
  const ScratchFolder folder("one-storey");
  const std::string first = "stiff_1_story_el_centro_trial_1.csv", second = "stiff_1_story_northridge_trial_2.csv";
  if (!prepare_files("shake-table-frames", {first, second}, 1, folder)) KALFEM_ABSENT("the frame's records are absent");
  const std::vector<Segment> runs{{first, 0.0, 21.3}, {second, 0.0, 23.5}};
  expect_covered(scatter_between(one_storey, runs, folder));
  // The same with the model's error as noise of the process, which lets the filter follow the record.
  std::string followed = one_storey;
  replace(followed, "  settle: 0.5 s", "  settle: 1 s\n  process_noise: {acceleration: 0.03 m/s^2/sqrt(Hz)}");
  replace(followed, "0.6 m/s^2", "0.1 m/s^2");
  expect_covered(scatter_between(followed, runs, folder));
}

const std::string three_storeys = R"(kalfem: 1
substructures:
  frame:
    masses: {f1: 0.2336, f2: 0.2336, f3: 0.1788}
    springs:
      - {name: k1, from: ground, to: f1, stiffness: 2700, damping: 0.1}
      - {name: k2, from: f1, to: f2, stiffness: 2700, damping: 0.1}
      - {name: k3, from: f2, to: f3, stiffness: 2700, damping: 0.1}
excitation:
  quake: {base_acceleration: all, file: FILE, channel: ground_ax}
sensors:
  1st_ax: {acceleration: frame.f1, noise: 0.3 m/s^2}
  2nd_ax: {acceleration: frame.f2, noise: 0.3 m/s^2, chain: [{delay: 1.2 ms}]}
  3rd_ax: {acceleration: frame.f3, noise: 0.3 m/s^2, chain: [{delay: 2.2 ms}]}
record: {file: FILE, start: START, end: END}
estimate:
  diagnose: false
  settle: 0.5 s
  process_noise: {acceleration: 0.03 m/s^2/sqrt(Hz)}
  initial_state: {all: {displacement_std: 1 mm, velocity_std: 0.1}}
  unknown:
    frame.k1.stiffness: {initial: 2700, std: 20 %}
    frame.k2.stiffness: {initial: 2700, std: 20 %}
    frame.k3.stiffness: {initial: 2700, std: 20 %}
    damping: {initial: 0.1, std: 60 %, applies_to: [frame.k1.damping, frame.k2.damping, frame.k3.damping]}
)";

TEST(MeasuredSegments, OfTheThreeStoreyFrameScatterAsStated) {
  const ScratchFolder folder("three-storeys");
  const std::string earthquake = "stiff_3_story_northridge.csv", sine = "stiff_3_story_sine_1.5.csv";
  if (!prepare_files("shake-table-frames", {earthquake, sine}, 1, folder))
    KALFEM_ABSENT("the frame's records are absent");
  // The table repeats the earthquake.
  const std::vector<Segment> parts{{earthquake, 0.0, 35.0}, {earthquake, 35.0, 70.0}, {earthquake, 70.0, 104.9}};
  expect_covered(scatter_between(three_storeys, parts, folder));
  // A chain of lumped masses cannot have the frequencies and shapes of this frame together, so its best parameters
  // depend on which modes an input excites: here those of an earthquake and those of a sine of 1.5 Hz.
  expect_covered(scatter_between(three_storeys, {{earthquake, 0.0, 104.9}, {sine, 0.0, 69.9}}, folder));
}

}  // namespace
}  // namespace kalfem::test

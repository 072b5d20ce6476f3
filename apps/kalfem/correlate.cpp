// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "console.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/description.hpp"
#include "kalfem/correlation/correlate.hpp"
#include "kalfem/formats/mode_file.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/study/updating_setup.hpp"
#include "kalfem/updating/modes_of_set.hpp"
#include "kalfem/yaml/case_reader.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

/// The largest of the others: which mode the sensors confuse this one with.
Index most_alike(const Eigen::MatrixXd& auto_mac, Index mode) {
  Eigen::VectorXd others = auto_mac.row(mode).transpose();
  others[mode] = -1.0;
  Index other = 0;
  others.maxCoeff(&other);
  return other;
}

std::string text_of(const std::string& file, const ModeSet& set, const std::vector<MeasuredMode>& modes,
                    const Eigen::MatrixXd& auto_mac) {
  Table table{"Modes", {"mode", "frequency [Hz]", "damping [%]", "out of phase", "AutoMAC", "with mode"}, {}, {}};
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const auto at = static_cast<Index>(i);
    const Index other = most_alike(auto_mac, at);
    const bool alone = modes.size() < 2;
    table.rows.push_back({std::to_string(i + 1), four_digits(modes[i].frequency),
                          std::isfinite(set.modes[i].damping) ? four_digits(100.0 * set.modes[i].damping) : "-",
                          fmt::format("{:.1f} %", 100.0 * modes[i].complexity),
                          alone ? "-" : fmt::format("{:.3f}", auto_mac(at, other)),
                          alone ? "-" : std::to_string(other + 1)});
  }
  return fmt::format("{}: {} at {}\n\n{}", file, counted(std::ssize(modes), "mode"),
                     counted(std::ssize(set.points), "point"), to_text(table));
}

}  // namespace

// The residual of the updating, which correlate does not use, is made for any agreement; the study then says again what
// the case gives.
Study load_for_correlation(const std::string& case_file, const std::vector<std::string>& changes,
                           const Progress& progress) {
  IssueList told_later;
  const auto given = read_case_text(read_text_file(case_file), case_file, description::case_schema(), told_later,
                                    process_environment(), changes_of(changes));
  auto lowered = changes;
  std::map<std::string, double> agreement;
  const auto comparisons = given.update ? given.update->comparisons : Named<Located<description::Comparison>>{};
  for (const auto& [name, comparison] : comparisons)
    if (const auto* modes = std::get_if<description::ModalData>(&comparison.value.data); modes && has_shapes(*modes)) {
      agreement[name] = modes->minimum_mac;
      lowered.push_back("update.compare." + name + ".minimum_mac=0");
    }
  Study study = load_study(case_file, changes_of(lowered), progress);
  if (agreement.empty()) return study;
  auto as_given = std::make_shared<description::Case>(*study.description);
  for (auto& [name, comparison] : as_given->update->comparisons)
    if (const auto found = agreement.find(name); found != agreement.end())
      std::get<description::ModalData>(comparison.value.data).minimum_mac = found->second;
  study.resolved_case = to_yaml(*description::case_schema().write(*as_given));
  study.description = std::move(as_given);
  return study;
}

ExitCode correlate_file(const std::string& file, bool as_json) {
  const ModeSet set = read_modes(file);
  const auto modes = modes_of_set(set, {.max_complexity = 1.0});
  Eigen::MatrixXd shapes = Eigen::MatrixXd::Constant(std::ssize(set.points), std::ssize(modes), ModeSet::unknown);
  for (std::size_t i = 0; i < modes.size(); ++i)
    if (modes[i].shape.size() > 0) shapes.col(static_cast<Index>(i)) = modes[i].shape;
  const Eigen::MatrixXd auto_mac = mac_of_measured(shapes, shapes);
  if (!as_json) {
    print("{}", text_of(std::filesystem::path(file).filename().string(), set, modes, auto_mac));
    return done;
  }
  Json all{{"file", file}, {"points", set.points}, {"modes", Json::array()}, {"auto_mac", Json::array()}};
  for (std::size_t i = 0; i < modes.size(); ++i) {
    all["modes"].push_back({{"frequency_hz", number(modes[i].frequency)},
                            {"damping", number(set.modes[i].damping)},
                            {"complexity", number(modes[i].complexity)}});
    all["auto_mac"].push_back(numbers(auto_mac.row(static_cast<Index>(i)).transpose()));
  }
  print("{}\n", all.dump(2, ' ', false, Json::error_handler_t::replace));
  return done;
}

}  // namespace kalfem::command

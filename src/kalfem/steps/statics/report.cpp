// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/statics/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/statics/outcome.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Index;

std::int64_t node_id(const StaticsPlan& plan, Index node) {
  return plan.part->elements.mesh.node_ids[static_cast<std::size_t>(node)];
}
std::int64_t cell_id(const StaticsPlan& plan, Index cell) {
  return plan.part->elements.mesh.cells[static_cast<std::size_t>(cell)].id;
}

Json resultant_json(const Resultant& resultant) {
  return {
      {"force", numbers(resultant.force)}, {"moment", numbers(resultant.moment)}, {"about", numbers(resultant.centre)}};
}

Json point_json(const StaticsPlan& plan, const PointResponse& point) {
  Json json = {{"node", node_id(plan, point.node)}};
  for (std::size_t i = 0; i < direction_names.size(); ++i)
    json[direction_names[i]] = number(point.displacement[static_cast<Index>(i)]);
  if (point.stress)
    json["stress"] = {{"von_mises", number(von_mises(point.stress->stress))},
                      {"principal", numbers(principal_stresses(point.stress->stress))},
                      {"tensor", numbers(point.stress->stress)},
                      {"layer", to_string(point.stress->layer)}};
  return json;
}

Json peak_json(const StaticsPlan& plan, const StressPeak& peak) {
  return {{"region", peak.region},
          {peak.of_beam ? "axial" : "von_mises", number(peak.value)},
          {"element", cell_id(plan, peak.cell)},
          {"node", node_id(plan, peak.node)},
          {"layer", to_string(peak.layer)}};
}

Eigen::Vector3d translation(const SolvedLoadCase& each, Index node) {
  return each.solution.displacements.segment<3>(6 * node);
}

Json case_json(const StaticsPlan& plan, const SolvedLoadCase& each) {
  Json points = Json::object(), reactions = Json::object(), stresses = Json::object();
  for (const auto& point : each.points) points[point.name] = point_json(plan, point);
  for (const auto& reaction : each.solution.reactions) reactions[reaction.name] = resultant_json(reaction.sum);
  for (const auto& peak : each.peaks) stresses[peak.region] = peak_json(plan, peak);
  const Index farthest = farthest_node(each.solution);
  Json result = {
      {"displacements", points},
      {"displacement_max", {{"node", node_id(plan, farthest)}, {"displacement", numbers(translation(each, farthest))}}},
      {"applied", resultant_json(each.solution.applied)},
      {"reactions", reactions},
      {"reaction_sum", resultant_json(each.solution.reaction_sum)},
      {"imbalance", number(each.solution.imbalance)},
      {"stress_max", each.peaks.empty() ? Json() : peak_json(plan, each.peaks.front())},
      {"stress_by_region", stresses}};
  if (!each.solution.preload.empty()) result["preload"] = each.solution.preload;
  return result;
}

/// Unit in which displacements of that size are read, with its factor on metres.
std::pair<std::string, double> length_unit(double largest) {
  return largest < 0.5 ? std::pair("mm", 1e3) : std::pair("m", 1.0);
}

/// "301.2 MPa".
std::string pressure_text(double value) { return four_digits(1e-6 * value) + " MPa"; }

/// What is below `rounding` is 0.
std::vector<std::string> digits(const Eigen::Ref<const Eigen::VectorXd>& values, double rounding = 0.0) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(four_digits(std::abs(value) <= rounding ? 0.0 : value));
  return texts;
}

std::vector<std::string> joined(std::vector<std::string> first, const std::vector<std::string>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// Rows of a load case: loads, reactions and their sum, without the rounding of the largest of them.
class ResultantRows {
public:
  explicit ResultantRows(const StaticSolution& solution) {
    add(solution.load_case, "loads", solution.applied);
    for (const auto& reaction : solution.reactions) add(solution.load_case, reaction.name, reaction.sum);
    add(solution.load_case, "sum of reactions", solution.reaction_sum);
  }

  void append_to(Table& table) const {
    constexpr double rounding = 1e-9;
    for (const auto& [names, resultant] : rows_)
      table.rows.push_back(joined(joined(names, digits(resultant.force, rounding * force_)),
                                  digits(resultant.moment, rounding * moment_)));
  }

private:
  void add(const std::string& load_case, const std::string& of, const Resultant& resultant) {
    rows_.push_back({{load_case, of}, resultant});
    force_ = std::max(force_, resultant.force.norm());
    moment_ = std::max({moment_, resultant.moment.norm(), resultant.centre.norm() * resultant.force.norm()});
  }

  std::vector<std::pair<std::vector<std::string>, Resultant>> rows_;
  double force_ = 0.0, moment_ = 0.0;  ///< the largest
};

}  // namespace

Json statics_summary(const StaticsPlan& plan, const StaticsOutcome& outcome) {
  Json cases = Json::object();
  for (const auto& each : outcome.cases) cases[each.solution.load_case] = case_json(plan, each);
  return cases;
}

namespace {

/// " Solved with the stresses of another load case in the stiffness: step2 (step1)."; empty where there are none.
std::string preloads_in_words(const StaticsOutcome& outcome) {
  std::string names;
  for (const auto& each : outcome.cases)
    if (const auto& solution = each.solution; !solution.preload.empty())
      names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", solution.load_case, solution.preload);
  return names.empty() ? "" : " Solved with the stresses of another load case in the stiffness: " + names + ".";
}

}  // namespace

std::string statics_answer(const StaticsOutcome& outcome) {
  const std::string count =
      fmt::format("{} static load case{}", outcome.cases.size(), outcome.cases.size() == 1 ? "" : "s");
  const SolvedLoadCase* worst = nullptr;
  for (const auto& each : outcome.cases)
    if (!each.peaks.empty() && (!worst || std::abs(each.peaks.front().value) > std::abs(worst->peaks.front().value)))
      worst = &each;
  const std::string stiffened = preloads_in_words(outcome);
  if (!worst) return count + " solved." + stiffened;
  const auto& peak = worst->peaks.front();
  return fmt::format("{}; the largest stress is {} ({}) in '{}', load case {}.", count, pressure_text(peak.value),
                     peak.of_beam ? "axial stress of beams" : "von Mises", peak.region, worst->solution.load_case) +
         stiffened;
}

Table static_points_table(const StaticsOutcome& outcome) {
  double farthest = 0.0;
  for (const auto& each : outcome.cases)
    for (const auto& point : each.points)
      farthest = std::fmax(farthest, point.displacement.head<3>().cwiseAbs().maxCoeff());
  const auto [unit, factor] = length_unit(farthest);
  const auto along = [&unit = unit](const char* axis) { return fmt::format("{} [{}]", axis, unit); };
  Table table{"Displacements and stresses of points",
              {"load case", "point", along("x"), along("y"), along("z"), "rx [rad]", "ry [rad]", "rz [rad]",
               "von Mises", "layer"},
              {},
              {}};
  for (const auto& each : outcome.cases)
    for (const auto& point : each.points) {
      const double largest = each.solution.displacements.cwiseAbs().maxCoeff();
      auto row = joined({each.solution.load_case, point.name},
                        joined(digits(factor * point.displacement.head<3>(), 1e-9 * factor * largest),
                               digits(point.displacement.tail<3>(), 1e-9 * largest)));
      row.push_back(point.stress ? pressure_text(von_mises(point.stress->stress)) : "-");
      row.emplace_back(point.stress && point.stress->layer != Layer::solid ? to_string(point.stress->layer) : "-");
      table.rows.push_back(std::move(row));
    }
  return without_empty_columns(std::move(table));
}

Table reactions_table(const StaticsOutcome& outcome) {
  Table table{"Loads and reactions; moments about the middle of the nodes of each, of sums about that of the model",
              {"load case", "of", "F_x [N]", "F_y [N]", "F_z [N]", "M_x [N m]", "M_y [N m]", "M_z [N m]"},
              {},
              {}};
  for (const auto& each : outcome.cases) ResultantRows(each.solution).append_to(table);
  return table;
}

Table stresses_table(const StaticsPlan& plan, const StaticsOutcome& outcome) {
  Table table{"Largest stresses: von Mises of the mean at a node; of beams the axial stress",
              {"load case", "region", "stress", "element", "node", "layer", "at [mm]"},
              {},
              {}};
  for (const auto& each : outcome.cases)
    for (const auto& peak : each.peaks) {
      const Eigen::Vector3d place = 1e3 * plan.part->elements.mesh.nodes.col(peak.node);
      table.rows.push_back(
          {each.solution.load_case, peak.region, pressure_text(peak.value), std::to_string(cell_id(plan, peak.cell)),
           std::to_string(node_id(plan, peak.node)), peak.layer == Layer::solid ? "-" : to_string(peak.layer),
           fmt::format("{}, {}, {}", four_digits(place.x()), four_digits(place.y()), four_digits(place.z()))});
    }
  return without_empty_columns(std::move(table));
}

std::string console_statics(const StaticsPlan& plan, const StaticsOutcome& outcome) {
  std::string text = statics_answer(outcome) + "\n";
  for (const auto& table : {static_points_table(outcome), reactions_table(outcome), stresses_table(plan, outcome)})
    if (!table.rows.empty()) text += "\n" + table.title + "\n" + to_text(table);
  return text + fmt::format("\nsolved in {:.1f} s\n\n", outcome.seconds);
}

}  // namespace kalfem

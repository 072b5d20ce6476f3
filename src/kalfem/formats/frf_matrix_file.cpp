// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/frequency_response_file.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// A node and a direction, without its sign.
using Freedom = std::pair<long, int>;

Freedom freedom_of(const MeasuredPlace& place) { return {place.node.value_or(0), std::abs(place.direction)}; }

double sign_of(const MeasuredPlace& place) { return place.direction < 0 ? -1.0 : 1.0; }

/// "12:+Z".
std::string name_of(const Freedom& freedom) {
  static constexpr std::array<const char*, 7> axes = {"", ":+X", ":+Y", ":+Z", ":+RX", ":+RY", ":+RZ"};
  return std::to_string(freedom.first) + axes[static_cast<std::size_t>(std::min(freedom.second, 6))];
}

/// Functions by response and reference.
using Table = std::map<std::pair<Freedom, Freedom>, const MeasuredFunction*>;

std::vector<Freedom> sides(const Table& table, bool of_responses) {
  std::vector<Freedom> all;
  for (const auto& [key, function] : table) all.push_back(of_responses ? key.first : key.second);
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

void check(const MeasuredFunction& function, const Eigen::VectorXd& lines, const std::filesystem::path& file,
           IssueList& issues) {
  const std::string name = "the frequency response '" + function.name + "'";
  const SourceLocation place{file.string(), 0};
  if (!function.lines.allFinite() || !function.values.allFinite())
    issues.add(place, name + " holds values that are no numbers", "every value must be a finite number",
               "export it again");
  else if (function.lines.size() != lines.size() ||
           (function.lines - lines).cwiseAbs().maxCoeff() > 1e-6 * lines.cwiseAbs().maxCoeff())
    issues.add(place, name + " has other frequencies than the first one",
               "one fit is made of responses at the same frequencies", "export them with the same lines");
  else if (function.values.imag().isZero(0.0))
    issues.add(place, name + " has no imaginary part", "magnitudes alone have no phase to fit a mode to",
               "export complex values");
}

Table table_of(const MeasuredFile& measured, const std::filesystem::path& file) {
  Table table;
  IssueList issues;
  const Eigen::VectorXd* lines = nullptr;
  for (const auto& function : measured.functions) {
    if (function.kind != MeasuredFunctionKind::frequency_response) continue;
    if (!lines) lines = &function.lines;
    check(function, *lines, file, issues);
    if (!table.emplace(std::pair{freedom_of(function.response), freedom_of(function.reference)}, &function).second)
      issues.add({file.string(), 0},
                 "the response at " + name_of(freedom_of(function.response)) + " to " +
                     name_of(freedom_of(function.reference)) + " is there twice",
                 "it is unclear which one counts", "remove one of them");
  }
  issues.raise();
  if (table.empty())
    throw InvalidInput(Issue{{file.string(), 0},
                             "the file has no frequency response",
                             "modes are identified from responses over frequency, or from a time record",
                             "look at what it holds: kalfem inspect " + file.string()});
  return table;
}

}  // namespace

FrfFileMatrix frf_matrix_of(const MeasuredFile& measured, const std::filesystem::path& file) {
  const Table table = table_of(measured, file);
  const auto responses = sides(table, true), references = sides(table, false);
  const bool exchanged = references.size() > responses.size();
  const auto& outputs = exchanged ? references : responses;
  const auto& inputs = exchanged ? responses : references;
  FrfFileMatrix read{.responses = {.lines = table.begin()->second->lines, .outputs = {}, .inputs = {}, .values = {}},
                     .places = {}};
  IssueList issues;
  for (const auto& output : outputs) {
    read.responses.outputs.push_back({name_of(output)});
    read.places.push_back({output.first, output.second});
  }
  for (const auto& input : inputs) {
    read.responses.inputs.push_back(name_of(input));
    Eigen::MatrixXcd values(read.responses.lines.size(), std::ssize(outputs));
    for (Index column = 0; column < values.cols(); ++column) {
      const Freedom& output = outputs[static_cast<std::size_t>(column)];
      const auto found = table.find(exchanged ? std::pair{input, output} : std::pair{output, input});
      if (found == table.end()) {
        issues.add({file.string(), 0}, "there is no response between " + name_of(output) + " and " + name_of(input),
                   "every output needs a response to every input", "export it, or make a file of one input");
        continue;
      }
      const auto& function = *found->second;
      values.col(column) = sign_of(function.response) * sign_of(function.reference) * function.values;
      read.responses.outputs[static_cast<std::size_t>(column)].unit = function.unit;
    }
    read.responses.values.push_back(std::move(values));
  }
  issues.raise();
  if (exchanged)
    read.remarks.push_back("By reciprocity, shapes are those at the points of the " + std::to_string(outputs.size()) +
                           " forces.");
  return read;
}

}  // namespace kalfem

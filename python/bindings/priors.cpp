// SPDX-License-Identifier: Apache-2.0
#include "priors.hpp"

#include <algorithm>
#include <cmath>

#include "sensors.hpp"

namespace kalfem::python {
namespace {

/// Reads the prior of one parameter.
class ShapeReader {
public:
  ShapeReader(std::string unit, std::string argument) : unit_(std::move(unit)), argument_(std::move(argument)) {}

  MarginalPrior read(const py::dict& given) const {
    const std::string shape = shape_of(given);
    const auto [first, second] = pair_of(given[py::str(shape)]);
    if (shape == "uniform") {
      if (given.contains("bounds"))
        throw InvalidInput(argument_ + ": a uniform prior has bounds of its own", "", "leave `bounds` out");
      return UniformPrior{value(first), value(second)};
    }
    MarginalPrior prior = NormalPrior{};
    if (shape == "normal")
      prior = NormalPrior{.mean = value(first), .deviation = deviation(second, value(first))};
    else
      prior = LogNormalPrior{.median = value(first), .log_deviation = deviation(second, 1.0, "")};
    if (given.contains("bounds")) cut(pair_of(given["bounds"]), prior);
    return prior;
  }

private:
  using Pair = std::pair<py::object, py::object>;

  /// The one key beside `bounds`.
  [[nodiscard]] std::string shape_of(const py::dict& given) const {
    const std::vector<std::string> known{"normal", "lognormal", "uniform", "bounds"};
    std::string shape;
    for (const auto& [key, value] : given) {
      const auto name = py::str(key).cast<std::string>();
      if (std::ranges::find(known, name) == known.end())
        throw InvalidInput(argument_ + ": there is no entry '" + name + "'" + did_you_mean(name, known), "", "");
      if (name == "bounds") continue;
      if (!shape.empty())
        throw InvalidInput(argument_ + ": it is " + shape + " and " + name, "a prior has one shape",
                           "give one of both");
      shape = name;
    }
    if (shape.empty())
      throw InvalidInput(argument_ + ": its shape is missing", "", "give one of normal, lognormal and uniform");
    return shape;
  }

  [[nodiscard]] Pair pair_of(const py::object& given) const {
    if (!py::isinstance<py::sequence>(given) || py::isinstance<py::str>(given) || py::len(given) != 2)
      throw InvalidInput(argument_ + ": " + std::string(py::str(py::repr(given))) + " is given",
                         "two numbers are needed", "write [first, second]");
    const auto pair = given.cast<py::sequence>();
    return {py::object(pair[0]), py::object(pair[1])};
  }

  [[nodiscard]] double value(const py::object& given) const { return number_of(given, unit_, argument_); }
  [[nodiscard]] double deviation(const py::object& given, double mean) const { return deviation(given, mean, unit_); }
  [[nodiscard]] double deviation(const py::object& given, double mean, const std::string& unit) const {
    const auto part = percentage_of(given);
    return part ? *part * std::abs(mean) : number_of(given, unit, argument_);
  }

  void cut(const Pair& bounds, MarginalPrior& prior) const {
    std::visit(
        [&](auto& marginal) {
          marginal.lower = value(bounds.first);
          marginal.upper = value(bounds.second);
        },
        prior);
  }

  std::string unit_, argument_;
};

}  // namespace

std::vector<std::pair<std::string, MarginalPrior>> priors_of(const Structure& structure, const py::dict& given) {
  const auto known = structure.parameters();
  std::vector<std::pair<std::string, MarginalPrior>> all;
  for (const auto& [key, prior] : given) {
    const auto name = py::str(key).cast<std::string>();
    const std::string argument = entry_of("priors", name);
    if (!py::isinstance<py::dict>(prior))
      throw InvalidInput(argument + ": " + std::string(py::str(py::repr(prior))) + " is given",
                         "a prior is a dictionary", "write {\"normal\": [mean, std]}");
    const bool has_unit = std::ranges::find(known, name) != known.end();
    all.emplace_back(name, ShapeReader(has_unit ? structure.unit(name) : "", argument).read(prior.cast<py::dict>()));
  }
  return all;
}

}  // namespace kalfem::python

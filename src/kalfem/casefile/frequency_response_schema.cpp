// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

Schema<double> line() { return number("Hz", Bounds::between(0, plausible::frequency().high)); }

std::vector<Issue> check_band(const FrequencyBandLines& given) {
  std::vector<Issue> issues;
  if (!(given.to > given.from))
    issues.push_back({{}, "the band is empty", "`to` must be above `from`", "give from < to"});
  else if (given.logarithmic && given.from == 0.0)
    issues.push_back({{}, "logarithmic lines cannot begin at 0 Hz", "", "give `from` above 0 Hz"});
  return issues;
}

// Lines stand in the case as a list, or as a map that spans a band. The kind of the node decides.
Schema<FrequencyLines> frequency_lines() {
  const auto band = mapping(
      Fields<FrequencyBandLines>()
          .required("from", &FrequencyBandLines::from, line(), "first line")
          .required("to", &FrequencyBandLines::to, line(), "last line")
          .optional("lines", &FrequencyBandLines::lines, integer(2, 1000000), "number of lines, both ends included")
          .optional("spacing", &FrequencyBandLines::logarithmic,
                    choice<bool>({{"linear", false, "equal differences"}, {"logarithmic", true, "equal ratios"}}),
                    "how they are spaced")
          .check(check_band));
  const auto ascending = convert<std::vector<double>>(
      list(line(), 1),
      [](const std::vector<double>& given) {
        if (std::ranges::adjacent_find(given, std::greater_equal()) != given.end())
          throw InvalidInput("the frequencies do not ascend", "each line is asked for once", "sort them");
        return given;
      },
      [](const std::vector<double>& given) { return given; });
  const auto read = [=](const CaseNode& node, FrequencyLines& given) {
    return node.yaml().kind == YamlNode::Kind::list ? ascending.read(node, given.emplace<std::vector<double>>())
                                                    : band.read(node, given.emplace<FrequencyBandLines>());
  };
  const auto write = [=](const FrequencyLines& given) {
    const auto* listed = std::get_if<std::vector<double>>(&given);
    return listed ? ascending.write(*listed) : band.write(std::get<FrequencyBandLines>(given));
  };
  return make_schema<FrequencyLines>(read, write, either_schema(ascending.json_schema(), band.json_schema()));
}

/// What the map of an output holds under one of its keys.
template <ResponseQuantity Q>
struct OutputOf {
  Name point;
};
struct WrittenOutput {
  std::variant<OutputOf<ResponseQuantity::displacement>, OutputOf<ResponseQuantity::velocity>,
               OutputOf<ResponseQuantity::acceleration>, OutputOf<ResponseQuantity::strain>>
      observed;
};

template <ResponseQuantity Q>
kalfem::Case<OutputOf<Q>> output_of(std::string_view key, std::string_view meaning) {
  return when(key,
              convert<OutputOf<Q>>(
                  name(), [](const Name& point) { return OutputOf<Q>{point}; },
                  [](const OutputOf<Q>& given) { return given.point; }),
              meaning);
}

Schema<ResponseOutput> output() {
  using enum ResponseQuantity;
  const auto written = mapping(Fields<WrittenOutput>().one_of(
      &WrittenOutput::observed, output_of<displacement>("displacement", "point: receptance, m/N"),
      output_of<velocity>("velocity", "point: mobility, (m/s)/N"),
      output_of<acceleration>("acceleration", "point: accelerance, (m/s^2)/N"),
      output_of<strain>("strain", "strain gauge: (m/m)/N")));
  return convert<ResponseOutput>(
      written,
      [](const WrittenOutput& given) {
        return std::visit(
            []<ResponseQuantity Q>(const OutputOf<Q>& each) {
              return ResponseOutput{Q, each.point};
            },
            given.observed);
      },
      [](const ResponseOutput& given) {
        switch (given.quantity) {
          case displacement:
            return WrittenOutput{OutputOf<displacement>{given.point}};
          case velocity:
            return WrittenOutput{OutputOf<velocity>{given.point}};
          case strain:
            return WrittenOutput{OutputOf<strain>{given.point}};
          case acceleration:
            break;
        }
        return WrittenOutput{OutputOf<acceleration>{given.point}};
      });
}

/// Each response is computed and written once.
std::vector<Issue> check_doubled(const FrequencyResponses& given) {
  std::vector<Issue> issues;
  const auto refuse_second = [&](const auto& values, const std::string& what, const auto& key_of) {
    for (auto each = values.begin(); each != values.end(); ++each)
      if (std::ranges::find(values.begin(), each, key_of(*each), key_of) != each)
        issues.push_back(
            {{}, "the " + what + " '" + key_of(*each).second + "' stands twice", "", "remove one of them"});
  };
  refuse_second(given.inputs, "input", [](const Name& input) { return std::pair(0, input.value); });
  refuse_second(given.outputs, "output",
                [](const ResponseOutput& output) { return std::pair(output.quantity, output.point.value); });
  return issues;
}

}  // namespace

Schema<FrequencyResponses> frequency_responses() {
  return mapping(
      Fields<FrequencyResponses>()
          .required("frequencies", &FrequencyResponses::frequencies, located(frequency_lines()),
                    "the lines: a list, or so many of them in a band")
          .required("inputs", &FrequencyResponses::inputs, list(name(), 1),
                    "points at which a unit force acts, and grounds that move by a unit displacement")
          .required("outputs", &FrequencyResponses::outputs, list(output(), 1), "motions and strains that answer")
          .optional("model", &FrequencyResponses::model,
                    located(choice<ResponseModel>(
                        {{"full", ResponseModel::full, "finite elements with all their degrees of freedom"},
                         {"reduced", ResponseModel::reduced,
                          "superelements as `reduction` asks for, and the constraint modes of the points at which "
                          "forces act, as residual vectors"},
                         {"both", ResponseModel::both, "and how far they are apart"}})),
                    "model of the finite-element substructures")
          .optional("method", &FrequencyResponses::method,
                    choice<ResponseMethod>(
                        {{"modal", ResponseMethod::modal,
                          "modes up to three times the highest line, and residual vectors for the rest"},
                         {"direct", ResponseMethod::direct, "one factorisation a line; nothing is neglected"}}),
                    "how the equations are solved")
          .optional("substructure", &FrequencyResponses::substructure, name(),
                    "this substructure alone, without connectors; default: the whole structure, its connectors linear "
                    "about rest")
          .check(check_doubled));
}

}  // namespace kalfem::description

// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/report.hpp"

#include <fmt/format.h>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

Json frequencies_summary(const FrequencyCourse& course) {
  Json modes = Json::array();
  for (Index m = 0; m < course.frequency.rows(); ++m)
    modes.push_back(
        {{"unit", "Hz"},
         {"range", {number(course.frequency.row(m).minCoeff()), number(course.frequency.row(m).maxCoeff())}},
         {"estimate", number(course.frequency(m, course.time.size() - 1))},
         {"std", number(course.deviation(m, course.time.size() - 1))}});
  return modes;
}

Table frequencies_table(const FrequencyCourse& course) {
  Table table{"Natural frequencies over the record [Hz]", {"mode", "least", "greatest", "at the end", "std"}, {}, {}};
  const Index last = course.time.size() - 1;
  for (Index m = 0; m < course.frequency.rows(); ++m)
    table.rows.push_back({std::to_string(m + 1), four_digits(course.frequency.row(m).minCoeff()),
                          four_digits(course.frequency.row(m).maxCoeff()), four_digits(course.frequency(m, last)),
                          four_digits(course.deviation(m, last))});
  return table;
}

Section frequencies_section(const FrequencyCourse& course) {
  Section section{
      "Natural frequencies over the record",
      "Undamped, of the structure with the parameters estimated until then, connectors as stiff as at rest.",
      {frequencies_table(course)}};
  const double width = normal_quantile(0.975);
  for (Index m = 0; m < course.frequency.rows(); ++m) {
    const VectorXd frequency = course.frequency.row(m), reach = width * course.deviation.row(m).transpose();
    section.items.emplace_back(Chart{.id = fmt::format("frequency-{}", m + 1),
                                     .title = fmt::format("Mode {}", m + 1),
                                     .x_label = "time [s]",
                                     .y_label = "natural frequency [Hz]",
                                     .x = series_values(course.time),
                                     .series = {{.label = "estimate",
                                                 .y = series_values(frequency),
                                                 .lower = series_values(frequency - reach),
                                                 .upper = series_values(frequency + reach),
                                                 .role = Role::estimate}},
                                     .half_width = true});
  }
  return section;
}

}  // namespace kalfem

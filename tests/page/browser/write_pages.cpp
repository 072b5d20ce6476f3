// SPDX-License-Identifier: Apache-2.0
// write_pages FOLDER: the pages that the browser's tests open.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "kalfem/page/page.hpp"
#include "page/sample_page.hpp"
#include "pictures/sample_scene.hpp"

namespace kalfem {
namespace {

Page structure_page() {
  Page page = sample_page();
  page.sections.insert(page.sections.begin(), {"Structure", "Its modes and its motion.", {sample_scene()}});
  page.sections.push_back({"Again", "", {sample_scene()}});
  return page;
}

/// What a run of many parameters shows first.
Page overview_page() {
  const std::string bar = R"(<svg width="120" height="22" viewBox="0 0 120 22"></svg>)";
  Table found{.title = "What was found",
              .columns = {"parameter", "value ± std", "z"},
              .graphics_title = "prior → posterior",
              .caption = "Bars: 95 % intervals.",
              .half_width = true};
  for (int i = 1; i <= 19; ++i) {
    found.rows.push_back({"car.strut_" + std::to_string(i) + ".stiffness", "17.586 ± 0.070 kN/m", "+0.3"});
    found.graphics.push_back(bar);
  }
  const Picture structure{.title = "The structure",
                          .caption = "Triangles: sensors.",
                          .svg = R"(<svg viewBox="0 0 300 600"><rect width="300" height="600"/></svg>)",
                          .half_width = true};
  Page page = sample_page();
  page.sections.insert(page.sections.begin(), {"Overview", "", {found, structure}});
  return page;
}

/// One chart in sight, the same twice folded away.
Page folded_page() {
  Chart chart{.id = "open", .title = "open", .x_label = "time [s]", .y_label = "y", .series = {{.label = "a"}}};
  for (int k = 0; k <= 2000; ++k) {
    chart.x.push_back(0.01 * k);
    chart.series[0].y.push_back(std::sin(0.01 * k));
  }
  Page page{.title = "Folded", .sections = {{"Charts", "", {chart}}}};
  chart.fold = "more";
  for (const char* name : {"first", "second"}) {
    chart.id = chart.title = name;
    page.sections[0].items.emplace_back(chart);
  }
  return page;
}

/// Charts of one value, of none, and of a gap alone.
Page meagre_page() {
  const Series gap{.label = "gap", .y = {std::nan("")}}, none{.label = "none"},
      point{.label = "point", .y = {0}, .x = {0}};
  return {
      .title = "Meagre",
      .sections = {{"Charts",
                    "",
                    {Chart{.title = "one", .x_label = "x", .y_label = "y", .x = {1.0}, .series = {gap}},
                     Chart{.title = "none", .x_label = "x", .y_label = "y", .series = {none}},
                     Chart{.title = "loop", .x_label = "x", .y_label = "y", .series = {point}, .scatter = true},
                     Chart{.title = "no loop", .x_label = "x", .y_label = "y", .series = {none}, .scatter = true}}}}};
}

}  // namespace
}  // namespace kalfem

int main(int count, char** arguments) {
  if (count != 2) return std::cerr << "usage: write_pages FOLDER\n", 2;
  const std::filesystem::path folder = arguments[1];
  std::filesystem::create_directories(folder);
  for (const auto& [name, page] : {std::pair{"charts.html", kalfem::sample_page()},
                                   {"structure.html", kalfem::structure_page()},
                                   {"folded.html", kalfem::folded_page()},
                                   {"overview.html", kalfem::overview_page()},
                                   {"meagre.html", kalfem::meagre_page()}})
    std::ofstream(folder / name) << kalfem::render_html(page);
}

// SPDX-License-Identifier: Apache-2.0
#include "casefile/probes.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/modes/outcome.hpp"

/// Keys of the report: what is computed for it, and what stands on its page.
namespace kalfem::wiring {
namespace {

void titles() {
  const auto study = study_of(lumped_case({{"title", "A chain of two"}}));
  const auto results = run(study, "simulate");
  EXPECT_EQ(make_page(study, results).title, "A chain of two");
  EXPECT_EQ(summarise(study, results).at("title"), "A chain of two");
}

void frequencies_over_time() {
  const auto course = [](const std::string& report) {
    return run(study_of(estimated_case({{"report", report}})), "estimate").get<EstimationOutcome>().frequencies;
  };
  EXPECT_FALSE(course("").has_value());
  ASSERT_TRUE(course("{frequencies: 1}").has_value());
  EXPECT_EQ(course("{frequencies: 1}")->frequency.rows(), 1);
}

void numbers_of_modes() {
  const auto count = [](const std::string& report) {
    return run(study_of(beam_case({{"report", report}})), "modes")
        .get<ModesOutcome>()
        .substructures.at(0)
        .frequencies.size();
  };
  EXPECT_EQ(count("{modes: 3}"), 3);
  EXPECT_EQ(count("{modes: 5}"), 5);
  EXPECT_EQ(count(""), 12);  // up to 20
}

/// Charts whose title says "Displacement of ...".
std::vector<Chart> displacement_charts(const std::string& report) {
  const auto study = study_of(estimated_case({{"report", report}}));
  std::vector<Chart> charts;
  for (const auto& section : make_page(study, run(study, "estimate")).sections)
    for (const auto& item : section.items)
      if (const auto* chart = std::get_if<Chart>(&item); chart && chart->title.starts_with("Displacement of"))
        charts.push_back(*chart);
  return charts;
}

void displacements() {
  const auto shown = [](const std::string& report) {
    std::vector<std::string> titles;
    for (const auto& chart : displacement_charts(report))
      if (!chart.x_window) titles.push_back(chart.title);
    return titles;
  };
  using Titles = std::vector<std::string>;
  EXPECT_EQ(shown("{displacements: [s.b]}"), (Titles{"Displacement of s.b"}));
  EXPECT_EQ(shown("{displacements: [s.b, s.a]}"), (Titles{"Displacement of s.b", "Displacement of s.a"}));
  EXPECT_EQ(shown(""), (Titles{"Displacement of s.a", "Displacement of s.b"}));
}

/// Strains that are not measured are shown if the case names none.
void strains() {
  const auto shown = [](const std::string& report) {
    const std::string gauges = "gauges: {g: {element: 1, fibre: [0, 4 mm]}, h: {element: 2, fibre: [0, 4 mm]}}";
    const auto study =
        study_of(beam_case({{"substructures", "{b: {finite_elements: {" + beam_elements(gauges) + "}}}"},
                            {"sensors", "{y: {strain: b.g, noise: 5 %}, a: {acceleration: b.tip.z, noise: 5 %}}"},
                            {"estimate", "{settle: 0 s}"},
                            {"report", report}}));
    std::vector<std::string> titles;
    for (const auto& section : make_page(study, run(study, "estimate")).sections)
      for (const auto& item : section.items)
        if (const auto* chart = std::get_if<Chart>(&item);
            chart && chart->title.starts_with("Strain at") && !chart->x_window)
          titles.push_back(chart->title);
    return titles;
  };
  using Titles = std::vector<std::string>;
  EXPECT_EQ(shown("{strains: b.g}"), (Titles{"Strain at b.g"}));
  EXPECT_EQ(shown("{strains: [b.h, b.g]}"), (Titles{"Strain at b.h", "Strain at b.g"}));
  EXPECT_EQ(shown(""), (Titles{"Strain at b.h"}));
}

void zooms() {
  for (const auto& chart : displacement_charts("{displacements: s.a, zoom: 0.2 s}"))
    if (chart.x_window) {
      near((*chart.x_window)[0], 0.1);
      near((*chart.x_window)[1], 0.3, many_roundings);
    }
  for (const auto& chart : displacement_charts("{displacements: s.a}"))
    if (chart.x_window) near((*chart.x_window)[1], 0.5);  // a second, or up to the end
  EXPECT_EQ(displacement_charts("{displacements: s.a}").size(), 2u);
}

void pictures() {
  const std::string two =
      "{b: {finite_elements: {" + beam_elements() + "}}, c: {finite_elements: {" + beam_elements() + "}}}";
  const auto series = [&](const std::string& text) {
    return run(study_of(beam_case({{"substructures", two}, {"report", "{fields: {" + text + "}}"}})), "simulate")
        .get<SimulationOutcome>()
        .fields.at(0);
  };
  EXPECT_EQ(series("substructure: b").substructure, "b");
  EXPECT_EQ(series("substructure: c").substructure, "c");
  EXPECT_EQ(series("substructure: b, every: 5 ms").times.size(), 5u);
  near(series("substructure: b, every: 5 ms").times[1], 5e-3);
  EXPECT_EQ(series("substructure: b").times.size(), 2u);  // 20 ms
}

void superelement_files() {
  const auto study = [](const std::string& formats) {
    return study_of(beam_case({{"report", "{superelements: " + formats + "}"}}));
  };
  const auto folder = write_file("here", "").parent_path();
  const auto writes = [&](const std::string& formats, const std::vector<std::string>& endings) {
    for (const auto& ending : {".mtx", ".dmig", ".op4", ".h5"})
      for (const auto& name : {"b_reduced", "b_reduced_stiffness", "b_reduced_K"})
        std::filesystem::remove(folder / (name + std::string(ending)));
    write_superelements(folder, study(formats));
    for (const std::string ending : {".mtx", ".dmig", ".op4", ".h5"}) {
      bool found = false;
      for (const auto& file : std::filesystem::directory_iterator(folder))
        found =
            found || (file.path().filename().string().starts_with("b_reduced") && file.path().extension() == ending);
      EXPECT_EQ(found, std::ranges::find(endings, ending) != endings.end()) << formats << " " << ending;
      for (const auto& file : std::filesystem::directory_iterator(folder))
        if (file.path().filename().string().starts_with("b_reduced") && file.path().extension() == ending)
          std::filesystem::remove(file.path());
    }
  };
  writes("dmig", {".dmig"});
  writes("op4", {".op4"});
  writes("hdf5", {".h5"});
  writes("matrix_market", {".mtx"});
  writes("[op4, dmig]", {".op4", ".dmig"});
}

}  // namespace

KeyChecks report_keys() {
  return {{"title", titles},
          {"report.modes", numbers_of_modes},
          {"report.displacements", displacements},
          {"report.strains", strains},
          {"report.frequencies", frequencies_over_time},
          {"report.zoom", zooms},
          {"report.fields.substructure", pictures},
          {"report.fields.every", pictures},
          {"report.superelements", superelement_files}};
}

}  // namespace kalfem::wiring

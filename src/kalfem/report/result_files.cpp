// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/result_set.hpp"

#include <algorithm>
#include <array>

#include "kalfem/base/version.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/matrices/write.hpp"
#include "kalfem/steps/table.hpp"

namespace kalfem {
namespace {

constexpr std::array<std::string_view, 8> series_order{"update", "validate", "infer",    "frf",
                                                       "record", "simulate", "estimate", "predict"};

/// Whether a step that computes something has series. The record is none: a case that only reads one has no file.
bool has_series(const StudyResults& results) {
  return std::ranges::any_of(steps_that_ran(results),
                             [](const RunStep* step) { return step->run != nullptr && step->visit != nullptr; });
}

/// The time over which a series stands, if it has as many instants: its group's, or that of a group around it.
std::optional<std::string> time_of(const Hdf5File& file, const ResultSeries& series) {
  for (auto slash = series.path.rfind('/'); slash != std::string::npos; slash = series.path.rfind('/', slash - 1)) {
    const std::string time = series.path.substr(0, slash) + "/time";
    if (file.contains(time)) return file.shape(time)[0] == series.values.size() ? std::optional(time) : std::nullopt;
    if (slash == 0) break;
  }
  return std::nullopt;
}

/// Draws of Markov chains over the chains and draws of their group.
void write_draws(Hdf5File& file, const ResultSeries& series) {
  const std::string group = series.path.substr(0, series.path.rfind('/'));
  const std::vector<std::string> axes{group + "/chain", group + "/draw"};
  if (!file.contains(axes.front())) {
    file.write_axis(axes.front(), *series.chains);
    file.write_axis(axes.back(), series.values.size() / *series.chains);
  }
  file.write_rows(series.path, series.values, *series.chains);
  file.set_axes(series.path, axes);
}

/// Dimensions get the names that netCDF-4 asks for: time, chain and draw.
void write_dataset(Hdf5File& file, const ResultSeries& series) {
  if (series.chains) {
    write_draws(file, series);
    return;
  }
  const auto time = time_of(file, series);
  file.write(series.path, series.values);
  if (series.path.ends_with("/time"))
    file.make_axis(series.path);
  else if (time)
    file.set_axes(series.path, {*time});
}

}  // namespace

void visit_results(const Study& study, const StudyResults& results, const SeriesVisitor& visit) {
  SeriesWriter file(study.sample_rate(), visit);
  for (const auto* step : steps_that_ran(results, series_order))
    if (step->visit) step->visit(study, results, file);
}

void write_results(const std::string& path, const Study& study, const StudyResults& results, const std::string& run) {
  if (!has_series(results)) return;
  Hdf5File file = Hdf5File::create(path);
  file.set_attribute("/", "kalfem", version);
  file.set_attribute("/", "run", run);
  file.set_attribute("/", "sample_rate", study.sample_rate());
  visit_results(study, results, [&](const ResultSeries& series) {
    write_dataset(file, series);
    file.set_attribute(series.path, "unit", series.unit);
    if (series.sample_rate) file.set_attribute(series.path, "sample_rate", *series.sample_rate);
  });
  file.close();
}

namespace {

const char* ending(MatrixFormat format) {
  switch (format) {
    case MatrixFormat::dmig:
      return ".dmig";
    case MatrixFormat::op4:
      return ".op4";
    case MatrixFormat::hdf5:
      return ".h5";
    default:
      return ".mtx";
  }
}

}  // namespace

void write_superelements(const std::filesystem::path& folder, const Study& study) {
  for (const auto& elements : study.structure->finite_elements)
    for (const auto format : study.report.superelements)
      if (elements.reduced)
        write_superelement(folder / (elements.part->name + "_reduced" + ending(format)), elements.reduced->model,
                           format, elements.reduced->basis);
}

}  // namespace kalfem

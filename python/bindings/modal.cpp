// SPDX-License-Identifier: Apache-2.0
#include "calls.hpp"
#include "kalfem/modal/identify_modes.hpp"
#include "kalfem/modal/merge_setups.hpp"
#include "kalfem/modal/mode_tracks.hpp"
#include "records.hpp"
#include "results.hpp"

namespace kalfem::python {
namespace {

/// Limits by name: {"mac": 0.9}.
StabilisationOptions stabilisation_of(const py::dict& given) {
  using Options = StabilisationOptions;
  const std::vector<std::pair<std::string, double Options::*>> members = {
      {"frequency", &Options::frequency},
      {"damping", &Options::damping},
      {"mac", &Options::mac},
      {"largest_damping", &Options::largest_damping},
      {"frequency_std", &Options::frequency_std},
      {"damping_std", &Options::damping_std},
      {"least_share", &Options::least_share},
      {"least_participation", &Options::least_participation}};
  Options options;
  IssueList issues;
  for (const auto& [key, value] : given) {
    const auto name = py::str(key).cast<std::string>();
    std::vector<std::string> names;
    for (const auto& [each, member] : members) names.push_back(each);
    if (const auto at = std::ranges::find(names, name); at == names.end())
      issues.add({}, "stabilisation: there is no '" + name + "'" + did_you_mean(name, names), "", "");
    else
      options.*members[static_cast<std::size_t>(at - names.begin())].second = value.cast<double>();
  }
  issues.raise();
  return options;
}

ForcedRecordOptions forced_of(const py::dict& given) {
  ForcedRecordOptions forced{.segment = given["segment"].cast<double>()};
  const auto estimator = given["estimator"].cast<std::string>(), window = given["window"].cast<std::string>();
  if (estimator == "h2")
    forced.estimator = FrfEstimator::h2;
  else if (estimator == "hv")
    forced.estimator = FrfEstimator::hv;
  else if (estimator != "h1")
    throw InvalidInput("estimator: '" + estimator + "' is given", "", "give h1, h2 or hv");
  if (window == "rectangular")
    forced.window = SpectralWindow::rectangular;
  else if (window != "hann")
    throw InvalidInput("window: '" + window + "' is given", "", "give hann or rectangular");
  return forced;
}

SubspaceMethod subspace_of(const std::string& name) {
  if (name == "covariance") return SubspaceMethod::covariance;
  if (name == "data") return SubspaceMethod::data;
  throw InvalidInput("subspace: '" + name + "' is given", "", "give covariance or data");
}

ModalOptions options_of(const py::dict& given) {
  ModalOptions options{.channels = given["channels"].cast<std::vector<std::string>>(),
                       .references = given["references"].cast<std::vector<std::string>>(),
                       .inputs = given["inputs"].cast<std::vector<std::string>>(),
                       .forced = forced_of(given),
                       .subspace = subspace_of(given["subspace"].cast<std::string>()),
                       .block_rows = given["block_rows"].cast<int>(),
                       .max_order = given["max_order"].cast<int>(),
                       .blocks = given["blocks"].cast<int>(),
                       .stabilisation = stabilisation_of(given["stabilisation"].cast<py::dict>()),
                       .threads = given["threads"].cast<int>()};
  for (const auto& [frequency, order] : given["poles"].cast<std::vector<std::pair<double, int>>>())
    options.poles.push_back({frequency, order});
  if (!given["band"].is_none()) {
    const auto [from, to] = given["band"].cast<std::pair<double, double>>();
    options.band = FrequencyBand{from, to};
  }
  return options;
}

py::dict entry_of(const IdentifiedMode& mode) {
  const double factor = mode.coverage_factor();
  const auto interval = [&](double value, double deviation) {
    return py::make_tuple(value - factor * deviation, value + factor * deviation);
  };
  py::dict entry;
  entry["frequency"] = mode.frequency;
  entry["frequency_std"] = mode.frequency_std();
  entry["frequency_interval"] = interval(mode.frequency, mode.frequency_std());
  entry["damping"] = mode.damping;
  entry["damping_std"] = mode.damping_std();
  entry["damping_interval"] = interval(mode.damping, mode.damping_std());
  entry["covariance"] = array_of(Eigen::MatrixXd(mode.covariance));
  entry["degrees_of_freedom"] = mode.degrees_of_freedom;
  entry["shape"] = array_of(mode.shape);
  entry["shape_std"] = array_of(mode.shape_std());
  entry["shape_covariance"] = array_of(mode.shape_covariance);
  entry["phase_collinearity"] = mode.phase_collinearity;
  entry["participation"] = mode.participation;
  entry["order"] = mode.order;
  entry["orders"] = mode.orders;
  entry["peak"] = mode.spectral ? py::object(py::make_tuple(mode.spectral->frequency, mode.spectral->mac)) : py::none();
  return entry;
}

py::dict diagram_of(const ModalResult& result) {
  const auto column = [&](auto value) {
    Eigen::VectorXd values(std::ssize(result.diagram));
    for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = value(result.diagram[static_cast<std::size_t>(i)]);
    return array_of(std::move(values));
  };
  py::dict diagram;
  diagram["order"] = column([](const DiagramPole& pole) { return static_cast<double>(pole.order); });
  diagram["frequency"] = column([](const DiagramPole& pole) { return pole.frequency; });
  diagram["frequency_std"] = column([](const DiagramPole& pole) { return pole.frequency_std; });
  diagram["damping"] = column([](const DiagramPole& pole) { return pole.damping; });
  diagram["stable"] = column([](const DiagramPole& pole) { return pole.stable ? 1.0 : 0.0; });
  return diagram;
}

py::dict in_python(const ModalResult& result) {
  py::list modes;
  for (const auto& mode : result.modes) modes.append(entry_of(mode));
  py::dict found;
  found["modes"] = modes;
  found["channels"] = result.channels;
  found["references"] = result.references;
  found["sample_rate"] = result.sample_rate;
  found["block_rows"] = result.block_rows;
  found["max_order"] = result.max_order;
  found["diagram"] = diagram_of(result);
  found["remarks"] = result.remarks;
  return found;
}

/// What kalfem.IdentifiedModes hold of one set-up.
SetupModes setup_of(const py::dict& given) {
  SetupModes setup{.name = given["name"].cast<std::string>()};
  setup.result.channels = given["channels"].cast<std::vector<std::string>>();
  setup.result.sample_rate = given["sample_rate"].cast<double>();
  for (const auto& item : given["modes"].cast<py::list>()) {
    const auto entry = item.cast<py::dict>();
    IdentifiedMode mode;
    mode.frequency = entry["frequency"].cast<double>();
    mode.damping = entry["damping"].cast<double>();
    mode.covariance = entry["covariance"].cast<Eigen::Matrix2d>();
    mode.degrees_of_freedom = entry["degrees_of_freedom"].cast<double>();
    mode.shape = entry["shape"].cast<Eigen::VectorXcd>();
    mode.shape_covariance = entry["shape_covariance"].cast<Eigen::MatrixXd>();
    mode.participation = entry["participation"].cast<double>();
    mode.order = entry["order"].cast<int>();
    mode.orders = entry["orders"].cast<int>();
    setup.result.modes.push_back(std::move(mode));
  }
  return setup;
}

py::dict merged(const py::list& given, const std::vector<std::string>& references, double frequency, double mac) {
  std::vector<SetupModes> setups;
  for (const auto& item : given) setups.push_back(setup_of(item.cast<py::dict>()));
  return in_python(merge_setups(setups, {.references = references, .frequency = frequency, .mac = mac}));
}

py::tuple told_of(const PopulationEstimate& told) {
  return py::make_tuple(told.median, py::make_tuple(told.interval[0], told.interval[1]));
}

py::object trend_of(const TrackTrend& trend) {
  if (!trend) return py::none();
  py::list slopes;
  for (const auto& slope : trend->slopes) slopes.append(told_of(slope));
  py::dict found;
  found["mean"] = told_of(trend->mean);
  found["spread"] = told_of(trend->spread);
  found["slopes"] = slopes;
  return found;
}

py::list tracked(const py::list& given, const Eigen::MatrixXd& covariates, double frequency, double mac) {
  std::vector<ModalResult> records;
  for (const auto& item : given) records.push_back(setup_of(item.cast<py::dict>()).result);
  py::list tracks;
  for (const auto& track : track_modes(records, covariates, {.frequency = frequency, .mac = mac})) {
    py::dict entry;
    entry["modes"] = track.modes;
    entry["frequency"] = trend_of(track.frequency);
    entry["damping"] = trend_of(track.damping);
    tracks.append(entry);
  }
  return tracks;
}

py::dict modal(const py::object& t, const py::object& y, const std::vector<std::string>& names,
               const std::vector<std::string>& units, const py::dict& given, const py::object& progress) {
  ModalOptions options = options_of(given);
  Record record = record_of(grid_of(t), y, names);
  for (std::size_t i = 0; i < units.size(); ++i) record.channels[i].unit = units[i];
  const auto result = LongCall(progress).run([&](const Progress& report) {
    options.progress = report;
    return identify_modes(record, options);
  });
  return in_python(result);
}

/// Frequency responses by input: {"F1": array (lines, outputs)}.
py::dict modal_of_responses(const Eigen::VectorXd& lines, const py::dict& values,
                            const std::vector<std::string>& outputs, const py::dict& deviations, const py::dict& given,
                            const py::object& progress) {
  FrfMatrix responses{.lines = lines, .outputs = {}, .inputs = {}, .values = {}};
  for (const auto& name : outputs) responses.outputs.push_back({name});
  for (const auto& [input, matrix] : values) {
    responses.inputs.push_back(input.cast<std::string>());
    responses.values.push_back(matrix.cast<Eigen::MatrixXcd>());
    if (deviations.contains(input)) responses.deviations.push_back(deviations[input].cast<Eigen::MatrixXd>());
  }
  ModalOptions options = options_of(given);
  const auto result = LongCall(progress).run([&](const Progress& report) {
    options.progress = report;
    return identify_modes(responses, options);
  });
  return in_python(result);
}

}  // namespace

void bind_modal(py::module_& module) {
  module.def("modal", &modal, py::arg("t"), py::arg("y"), py::arg("names"), py::arg("units"), py::arg("options"),
             py::arg("progress") = py::none(), "Modes of a record alone: see kalfem.modal.");
  module.def("modal_of_responses", &modal_of_responses, py::arg("lines"), py::arg("values"), py::arg("outputs"),
             py::arg("deviations"), py::arg("options"), py::arg("progress") = py::none(),
             "Modes of frequency responses: see kalfem.modal_of_responses.");
  module.def("merge_setups", &merged, py::arg("setups"), py::arg("references"), py::arg("frequency"), py::arg("mac"),
             "Modes of several set-ups as one: see kalfem.merge_setups.");
  module.def("track_modes", &tracked, py::arg("records"), py::arg("covariates"), py::arg("frequency"), py::arg("mac"),
             "Modes from record to record: see kalfem.track_modes.");
}

}  // namespace kalfem::python

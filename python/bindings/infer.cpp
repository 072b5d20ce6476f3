// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/infer.hpp"

#include "calls.hpp"
#include "kalfem/api/compare.hpp"
#include "options.hpp"
#include "priors.hpp"
#include "records.hpp"
#include "results.hpp"
#include "sensors.hpp"
#include "structure.hpp"

namespace kalfem::python {

namespace {

py::object number_or_none(const std::optional<double>& value) {
  return value ? py::object(py::float_(*value)) : py::object(py::none());
}

py::tuple pair_of(const PosteriorParameter::Interval& interval) {
  return py::make_tuple(interval.lower, interval.upper);
}

py::list parameters_of(const std::vector<PosteriorParameter>& parameters) {
  py::list all;
  for (const auto& each : parameters) {
    py::dict entry;
    entry["name"] = each.name;
    entry["unit"] = each.unit;
    entry["estimate"] = each.mean;
    entry["std"] = each.std;
    entry["median"] = each.median;
    entry["interval_68"] = pair_of(each.interval_68);
    entry["interval_95"] = pair_of(each.interval_95);
    entry["most_probable"] = each.most_probable;
    entry["initial"] = each.prior_mean;
    entry["prior_std"] = each.prior_std;
    entry["r_hat"] = number_or_none(each.r_hat);
    entry["effective_samples"] = number_or_none(each.effective_samples);
    all.append(entry);
  }
  return all;
}

py::dict profiles_of(const InferResult& result) {
  py::dict all;
  for (const auto& each : result.profiles) {
    py::dict entry;
    entry["values"] = array_of(each.values);
    entry["log_likelihood"] = array_of(each.log_likelihood);
    entry["lower"] = number_or_none(each.lower);
    entry["upper"] = number_or_none(each.upper);
    entry["unit"] = each.unit;
    all[py::str(each.name)] = entry;
  }
  return all;
}

py::dict bands_of(const InferResult& result) {
  py::dict all;
  for (const auto& each : result.bands) {
    py::dict entry;
    entry["mean"] = array_of(each.mean);
    entry["lower"] = array_of(each.lower);
    entry["upper"] = array_of(each.upper);
    entry["coverage"] = each.coverage;
    entry["unit"] = each.unit;
    all[py::str(each.sensor)] = entry;
  }
  return all;
}

py::dict dict_of(const InferResult& result) {
  py::dict all;
  all["entries"] = parameters_of(result.parameters);
  all["values"] = Eigen::MatrixXd(result.samples.transpose());
  all["weights"] = result.weights;
  all["log_likelihood"] = result.log_likelihood;
  all["log_prior"] = result.log_prior;
  all["chains"] = result.chains;
  all["log_evidence"] = number_or_none(result.log_evidence);
  all["log_evidence_std"] = number_or_none(result.log_evidence_std);
  all["method"] = result.method;
  all["likelihood"] = result.likelihood;
  all["effective_samples"] = number_or_none(result.effective_samples);
  all["pareto_k"] = number_or_none(result.pareto_k);
  all["evaluations"] = result.evaluations;
  all["identifiability"] = result.identifiability;
  all["profiles"] = profiles_of(result);
  all["bands"] = bands_of(result);
  all["warnings"] = result.warnings;
  return all;
}

InferOptions infer_options(const Structure& structure, const py::dict& arguments, const py::dict& question) {
  const EstimateOptions filter = options_of(structure, arguments);
  return {.sensors = filter.sensors,
          .unknowns = filter.unknowns,
          .priors = priors_of(structure, question["priors"]),
          .parameters = cast_of<std::vector<std::string>>(question["parameters"], "parameters"),
          .likelihood = choice_of<LikelihoodKind>(
              "likelihood", question["likelihood"],
              {{"filter", LikelihoodKind::filter}, {"simulation", LikelihoodKind::simulation}}),
          .correlation_time = number_of(question["correlation_time"], "s", "correlation_time"),
          .method = choice_of<PosteriorMethod>("method", question["method"],
                                               {{"importance", PosteriorMethod::importance},
                                                {"laplace", PosteriorMethod::laplace},
                                                {"tempered", PosteriorMethod::tempered},
                                                {"metropolis", PosteriorMethod::metropolis},
                                                {"filter", PosteriorMethod::filter}}),
          .samples = cast_of<int>(question["samples"], "samples"),
          .seed = cast_of<std::uint64_t>(question["seed"], "seed"),
          .profile = cast_of<std::vector<std::string>>(question["profile"], "profile"),
          .predictions = cast_of<int>(question["predictions"], "predictions"),
          .initial_state = filter.initial_state,
          .initial_state_from_record = filter.initial_state_from_record,
          .process_noise = filter.process_noise,
          .filter = filter.filter,
          .known_to = filter.known_to,
          .substeps = filter.substeps,
          .threads = filter.threads};
}

/// The record of the sensors, whose noise may be a part of their channels' rms.
Record measured(const TimeGrid& grid, const py::object& y, const py::dict& arguments, InferOptions& options) {
  std::vector<std::string> names;
  for (const auto& sensor : options.sensors) names.push_back(sensor.name);
  Record record = record_of(grid, y, names);
  set_relative_noise(arguments["sensors"], record, options.sensors);
  return record;
}

py::dict infer_record(const Structure& structure, const py::object& t, const py::object& y, const py::dict& inputs,
                      const py::dict& arguments, const py::dict& question, const py::object& progress) {
  InferOptions options = infer_options(structure, arguments, question);
  const TimeGrid grid = grid_of(t);
  const Record record = measured(grid, y, arguments, options);
  const Structure moved = driven(structure, inputs, grid.start, grid.sample_rate, grid.samples);
  return dict_of(long_call(structure, progress, [&](const Progress& report) {
    options.progress = report;
    return infer(moved, record, options);
  }));
}

py::dict infer_comparisons(const Structure& structure, const py::dict& compared, const py::dict& question,
                           const py::object& progress) {
  Structure moved = structure;
  const UpdateOptions comparisons = update_options_of(moved, compared);
  InferOptions options{.sensors = {},
                       .unknowns = {},
                       .priors = priors_of(structure, question["priors"]),
                       .likelihood = LikelihoodKind::comparisons,
                       .method = choice_of<PosteriorMethod>("method", question["method"],
                                                            {{"importance", PosteriorMethod::importance},
                                                             {"laplace", PosteriorMethod::laplace},
                                                             {"tempered", PosteriorMethod::tempered},
                                                             {"metropolis", PosteriorMethod::metropolis}}),
                       .samples = cast_of<int>(question["samples"], "samples"),
                       .seed = cast_of<std::uint64_t>(question["seed"], "seed"),
                       .profile = cast_of<std::vector<std::string>>(question["profile"], "profile")};
  return dict_of(long_call(structure, progress, [&](const Progress& report) {
    options.progress = report;
    return infer(moved, comparisons, options);
  }));
}

py::list compare_structures(const py::dict& structures, const py::object& t, const py::object& y,
                            const py::dict& inputs, const py::dict& arguments, const py::dict& unknown,
                            const py::dict& question, const py::object& progress) {
  const TimeGrid grid = grid_of(t);
  std::vector<CandidateStructure> candidates;
  std::vector<Structure> given;
  InferOptions options;
  for (const auto& [key, structure] : structures) {
    const auto name = py::str(key).cast<std::string>();
    given.push_back(structure.cast<Structure>());
    const py::dict own(**arguments, py::arg("unknown") = unknown[key]);
    py::dict asked = question.attr("copy")();
    asked["priors"] = question["priors"][key];
    options = infer_options(given.back(), own, asked);
    candidates.push_back({name, driven(given.back(), inputs, grid.start, grid.sample_rate, grid.samples),
                          std::move(options.unknowns), std::move(options.priors)});
  }
  options.unknowns.clear();
  options.priors.clear();
  const Record record = measured(grid, y, arguments, options);
  const auto found = long_call(given, progress, [&](const Progress& report) {
    options.progress = report;
    return compare(candidates, record, options);
  });
  py::list all;
  for (const auto& each : found) {
    py::dict entry;
    entry["name"] = each.name;
    entry["probability"] = each.probability;
    const bool known = each.failure.empty();
    entry["log_evidence"] = known ? number(each.log_evidence) : py::none();
    entry["log_evidence_std"] = known ? number(each.log_evidence_std) : py::none();
    entry["occam"] = known ? number(each.occam) : py::none();
    entry["words"] = each.words;
    entry["entries"] = parameters_of(each.parameters);
    entry["warnings"] = each.warnings;
    entry["failure"] = each.failure;
    all.append(entry);
  }
  return all;
}

}  // namespace

void bind_infer(py::module_& module) {
  module.def("infer", &infer_record, py::arg("structure"), py::arg("t"), py::arg("y"), py::arg("inputs"),
             py::arg("arguments"), py::arg("question"), py::arg("progress") = py::none(),
             "The posterior of a record: see kalfem.infer.");
  module.def("infer_comparisons", &infer_comparisons, py::arg("structure"), py::arg("compared"), py::arg("question"),
             py::arg("progress") = py::none(), "The posterior of comparisons: see kalfem.infer_comparisons.");
  module.def("compare", &compare_structures, py::arg("structures"), py::arg("t"), py::arg("y"), py::arg("inputs"),
             py::arg("arguments"), py::arg("unknown"), py::arg("question"), py::arg("progress") = py::none(),
             "Which structure a record comes from: see kalfem.compare.");
}

}  // namespace kalfem::python

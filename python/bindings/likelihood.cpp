// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "calls.hpp"
#include "kalfem/inference/posterior_search.hpp"
#include "kalfem/inference/sample_posterior.hpp"
#include "kalfem/steps/inference/comparisons_likelihood.hpp"
#include "kalfem/steps/run_study.hpp"
#include "options.hpp"

namespace kalfem::python {
namespace {

/// A case with `infer`, its record, and the likelihood of its parameters.
struct OpenedLikelihood {
  Study study;
  StudyResults results;
  PosteriorSearch search;
};

std::shared_ptr<OpenedLikelihood> open_likelihood(const std::string& file, const std::vector<CaseChange>& set) {
  auto opened = std::make_shared<OpenedLikelihood>(OpenedLikelihood{load_study(file, set), {}, {}});
  const Study& study = opened->study;
  if (!study.inference)
    throw InvalidInput(Issue{
        {file, 0}, "the case has no `infer`", "it says which parameters have a likelihood", "add a section infer: {}"});
  if (study.inference->likelihood == LikelihoodKind::comparisons) {
    opened->search = {likelihood_of_comparisons(study, {}), start_of(*study.inference)};
    return opened;
  }
  opened->results = run_study(study, "simulate");
  if (!opened->results.complete()) throw InvalidInput(Issue{{file, 0}, opened->results.failure, "", ""});
  opened->search = begin_search(*study.inference, record_of(study, opened->results), nullptr);
  return opened;
}

/// The likelihood as a function of Python, which may ask a worker elsewhere: it waits without the GIL of others.
LogLikelihood evaluated_by(const py::function& evaluate) {
  return [&evaluate](const Eigen::VectorXd& theta) {
    const py::gil_scoped_acquire acquired;
    try {
      return evaluate(theta).cast<double>();
    } catch (const py::error_already_set& error) {
      throw std::runtime_error(error.what());  // of a thread that Python does not know
    }
  };
}

py::dict sample(const OpenedLikelihood& self, const std::string& method, int samples, std::uint64_t seed, int threads,
                const std::optional<py::function>& evaluate, const py::object& progress) {
  InferenceProblem problem = *self.study.inference;
  problem.method = choice_of<PosteriorMethod>("method", py::str(method),
                                              {{"importance", PosteriorMethod::importance},
                                               {"laplace", PosteriorMethod::laplace},
                                               {"tempered", PosteriorMethod::tempered},
                                               {"metropolis", PosteriorMethod::metropolis}});
  problem.samples = samples;
  problem.seed = seed;
  const Posterior posterior{problem.prior, evaluate ? evaluated_by(*evaluate) : self.search.likelihood.log_likelihood};
  const auto outcome = LongCall(progress).run([&](const Progress& report) {
    InferenceResult found;
    sample_posterior(problem, posterior, self.search.start,
                     {threads, search_likelihoods(self.search.likelihood, problem.samples)}, report, found);
    return found;
  });
  const auto count = outcome.samples.values.cols();
  const bool equal = outcome.samples.weights.size() == 0;
  py::dict result;
  result["values"] = Eigen::MatrixXd(outcome.samples.values.transpose());
  result["weights"] =
      equal ? Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count)).eval() : outcome.samples.weights;
  result["log_likelihood"] = outcome.samples.log_likelihood;
  result["log_prior"] = outcome.samples.log_prior;
  result["log_evidence"] = outcome.log_evidence;
  result["log_evidence_std"] = outcome.log_evidence_deviation;
  result["evaluations"] = outcome.evaluations;
  result["warnings"] = outcome.warnings;
  return result;
}

/// A value of every parameter.
void require_size(const OpenedLikelihood& self, const Eigen::VectorXd& values, const char* argument) {
  const auto size = self.study.inference->prior.size();
  if (values.size() != size)
    throw InvalidInput(std::string(argument) + ": " + std::to_string(values.size()) + " values for " +
                           std::to_string(size) + " parameters",
                       "", "give one each, in the order of `names`");
}

}  // namespace

void bind_likelihood(py::module_& module) {
  using Self = OpenedLikelihood;
  py::class_<Self, std::shared_ptr<Self>>(module, "CaseLikelihood", "See kalfem.Likelihood.")
      .def(py::init([](const std::string& file, const std::vector<std::pair<std::string, std::optional<std::string>>>& set,
                       const py::object& progress) {
             std::vector<CaseChange> changes;
             for (const auto& [key, value] : set) changes.push_back({key, value});
             return LongCall(progress).run([&](const Progress&) { return open_likelihood(file, changes); });
           }),
           py::arg("case"), py::arg("set"), py::arg("progress") = py::none())
      .def_property_readonly("names", [](const Self& self) { return self.search.likelihood.names; })
      .def_property_readonly("units",
                             [](const Self& self) {
                               std::vector<std::string> units;
                               for (const auto& parameter : self.study.inference->parameters)
                                 units.push_back(parameter.unit);
                               return units;
                             })
      .def_property_readonly("start", [](const Self& self) { return self.search.start; })
      .def_property_readonly("words", [](const Self& self) { return self.search.likelihood.words; })
      .def(
          "log_likelihood",
          [](const Self& self, const Eigen::VectorXd& theta) {
            require_size(self, theta, "theta");
            const py::gil_scoped_release released;
            return Posterior{self.study.inference->prior, self.search.likelihood.log_likelihood}.log_likelihood_at(
                theta);
          },
          py::arg("theta"))
      .def(
          "log_prior",
          [](const Self& self, const Eigen::VectorXd& theta) {
            require_size(self, theta, "theta");
            return self.study.inference->prior.log_density(theta);
          },
          py::arg("theta"))
      .def(
          "from_standard_normal",
          [](const Self& self, const Eigen::VectorXd& z) {
            require_size(self, z, "z");
            return self.study.inference->prior.from_standard_normal(z);
          },
          py::arg("z"))
      .def("sample", &sample, py::arg("method"), py::arg("samples"), py::arg("seed"), py::arg("threads"),
           py::arg("evaluate"), py::arg("progress") = py::none());
}

}  // namespace kalfem::python

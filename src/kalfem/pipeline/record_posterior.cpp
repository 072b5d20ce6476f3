#include "kalfem/pipeline/record_posterior.hpp"

#include "kalfem/pipeline/filter_posterior.hpp"
#include "kalfem/pipeline/sample_posterior.hpp"
#include "kalfem/pipeline/search_start.hpp"

namespace kalfem {

CaseLikelihood posterior_of_record(const Study& study, const Record& record, const RecordEstimate* estimate,
                                   int threads, const Progress& progress, InferenceOutcome& outcome) {
  const auto& plan = *study.inference;
  auto [likelihood, start] = begin_search(study, record, estimate);
  if (plan.method == PosteriorMethod::filter)
    take_filter_posterior(study, record, *estimate, likelihood, outcome);
  else
    sample_posterior(plan, {plan.prior, likelihood.log_likelihood}, start, threads, progress, outcome);
  return likelihood;
}

}  // namespace kalfem

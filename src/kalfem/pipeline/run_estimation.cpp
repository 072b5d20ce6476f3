#include <cmath>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/pipeline/reported_quantities.hpp"
#include "kalfem/pipeline/run_steps.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Standard deviations of the motion change slowly, so a hundred values per second suffice.
int samples_between_deviations(double sample_rate) {
  return std::max(1, static_cast<int>(std::lround(sample_rate / 100.0)));
}

/// What was computed before a failure: the rest would be drawn as nothing and averaged as zero. At least one sample
/// stays, which holds no number where none was computed.
void keep_computed(EstimationOutcome& outcome) {
  auto& result = outcome.result;
  if (!result.failure) return;
  const Index count = std::max<Index>(1, result.failure->computed);
  const auto cut = [&](MatrixXd& series) { series = series.leftCols(std::min(count, series.cols())).eval(); };
  for (auto* series : {&result.state, &result.unknowns, &result.monitored}) {
    cut(series->mean);
    cut(series->deviation);
  }
  for (auto* series : {&result.innovation, &result.innovation_deviation, &outcome.measurements.values}) cut(*series);
  result.nis = result.nis.head(count).eval();
  result.measured = result.measured.head(count).eval();
  if (outcome.measurements.used) outcome.measurements.used = std::min(*outcome.measurements.used, count);
}

}  // namespace

// Estimates, then compares each monitored quantity with the reference if the record was simulated.
EstimationOutcome run_estimation(const Study& study, AugmentedModelSetup& setup, const StudyResults& results,
                                 const Progress& progress) {
  const Stopwatch watch;
  const auto monitored = reported_quantities(*setup.model);
  EstimationOutcome outcome{
      estimate_record_in_bases_of_estimates(study.problem, setup, record_of(study, results),
                                            {monitored, samples_between_deviations(study.sample_rate()), progress}),
      {},
      study.excitation_band,
      {},
      0.0};
  keep_computed(outcome);
  for (std::size_t i = 0; i < monitored.size(); ++i) {
    const auto row = static_cast<Index>(i);
    PointQuantity quantity{monitored[i].name,
                           monitored[i].quantity,
                           outcome.result.monitored.mean.row(row).transpose(),
                           outcome.result.monitored.deviation.row(row).transpose(),
                           {},
                           {},
                           {}};
    if (results.simulation)
      if (const auto* truth = find_quantity(results.simulation->points, quantity.point, quantity.quantity))
        compare(quantity, truth->mean.head(outcome.measurements.samples()),
                {outcome.settled, study.sample_rate(), outcome.band});
    outcome.points.push_back(std::move(quantity));
  }
  outcome.seconds = watch.seconds();
  return outcome;
}

}  // namespace kalfem

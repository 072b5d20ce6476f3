// Time of one filter step (predict + update) beside the bare dense kernels of its size, interleaved in one run.
//     filter_benchmark [--json=FILE] [Google Benchmark's own flags]
#include <benchmark/benchmark.h>

#include <random>

#include "allocations.hpp"
#include "chain_case.hpp"
#include "dense_kernels.hpp"
#include "kalfem/estimation/filter.hpp"
#include "kalfem/estimation/observer_maps.hpp"
#include "table.hpp"

namespace {

using namespace kalfem;
using namespace kalfem::benchmarks;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int sizes[] = {24, 64, 128, 256};
constexpr Index samples = 1001;

/// A filter that walks through the record again and again, from the prior each time.
class Walk {
public:
  Walk(const ChainCase& chain, FilterKind kind)
      : chain_(&chain),
        filter_(make_filter(kind)),
        transition_(*chain.observer),
        measurement_(*chain.observer, chain.observer->form().outputs()) {
    filter_->reset(chain.observer->prior());
  }

  bool step() {
    const auto& record = chain_->record;
    if (++sample_ == samples) {
      filter_->reset(chain_->observer->prior());
      sample_ = 1;
    }
    transition_.set_inputs(record.inputs.col(sample_ - 1), record.inputs.col(sample_));
    if (filter_->predict(transition_, chain_->observer->process_noise()) != FilterOutcome::usable) return false;
    measurement_.set_inputs(record.inputs.col(sample_));
    measured_ = record.measurements.col(sample_);
    return filter_->update(measurement_, record.noise, measured_, innovation_) == FilterOutcome::usable;
  }

private:
  const ChainCase* chain_;
  std::unique_ptr<Filter> filter_;
  TransitionMap transition_;
  InstantMap measurement_;
  Innovation innovation_;
  VectorXd measured_;
  Index sample_ = 0;
};

void run_filter(benchmark::State& state, const ChainCase& chain, FilterKind kind) {
  Walk walk(chain, kind);
  for (int i = 0; i < 100; ++i)
    if (!walk.step()) return state.SkipWithError("the filter failed");
  const long before = allocations();
  for (auto _ : state)
    if (!walk.step()) return state.SkipWithError("the filter failed");
  state.counters["allocations"] = static_cast<double>(allocations() - before) / static_cast<double>(state.iterations());
}

void run_kernel(benchmark::State& state, const Kernel& kernel, const MatrixXd& in) {
  MatrixXd out(in.rows(), in.rows());
  for (auto _ : state) {
    kernel.run(in, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
}

MatrixXd random_columns(int states) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(states, 2 * states + 1, [&] { return normal(random); });
}

void add_benchmarks(int states) {
  const std::string size = "/" + std::to_string(states);
  const auto chain = std::make_shared<ChainCase>(chain_case(states, samples));
  for (const auto& [name, kind] :
       {std::pair{"ukf", FilterKind::unscented}, std::pair{"ukf_square_root", FilterKind::unscented_square_root},
        std::pair{"ekf", FilterKind::extended}})
    benchmark::RegisterBenchmark((name + size).c_str(),
                                 [chain, kind = kind](benchmark::State& state) { run_filter(state, *chain, kind); });
  const MatrixXd columns = random_columns(states), covariance = columns * columns.transpose();
  for (const auto& kernel : cholesky_kernels())
    benchmark::RegisterBenchmark(("cholesky/" + kernel.name + size).c_str(),
                                 [kernel, covariance](auto& state) { run_kernel(state, kernel, covariance); });
  for (const auto& kernel : rank_update_kernels())
    benchmark::RegisterBenchmark(("rank_update/" + kernel.name + size).c_str(),
                                 [kernel, columns](auto& state) { run_kernel(state, kernel, columns); });
}

}  // namespace

int main(int argc, char** argv) {
  // Defaults first, so that flags of the user win.
  std::string interleave = "--benchmark_enable_random_interleaving=true", repeat = "--benchmark_repetitions=15",
              time = "--benchmark_min_time=0.02", json;
  std::vector<char*> arguments = {argv[0], interleave.data(), repeat.data(), time.data()};
  for (int i = 1; i < argc; ++i)
    if (const std::string argument = argv[i]; argument.starts_with("--json="))
      json = argument.substr(7);
    else
      arguments.push_back(argv[i]);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;

  use_one_blas_thread();
  for (const int states : sizes) add_benchmarks(states);
  MedianReporter medians;
  benchmark::RunSpecifiedBenchmarks(&medians);
  std::vector<Row> rows;
  for (const int states : sizes) rows.emplace_back(medians, states);
  print_table(rows);
  if (!json.empty()) write_json(rows, json);
  return 0;
}

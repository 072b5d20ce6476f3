// SPDX-License-Identifier: Apache-2.0
// Time of one filter step (predict + update) beside the bare dense kernels of its size and beside a pass through half
// of a covariance, interleaved in one run.
//     filter_benchmark [--json=FILE] [Google Benchmark's own flags]
#include <benchmark/benchmark.h>

#include <cstdio>
#include <random>

#include "allocations.hpp"
#include "blas_copy.hpp"
#include "chain_case.hpp"
#include "dense_kernels.hpp"
#include "filter_walk.hpp"
#include "table.hpp"

namespace {

using namespace kalfem;
using namespace kalfem::benchmarks;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Warm-up, length of the record and repetitions for one size: a step costs 60,000 times more at 1024 states than
/// at 24.
struct Size {
  int states;
  Index samples;
  int warm_up;
  int repetitions;  ///< 0: as the command line says
  bool all_filters = true;
};
constexpr Size sizes[] = {{24, 1001, 100, 0},  {64, 1001, 100, 0},       {128, 1001, 100, 0},
                          {256, 1001, 100, 0}, {512, 101, 10, 9, false}, {1024, 101, 3, 7, false}};

constexpr std::pair<const char*, FilterKind> filters[] = {{"ukf", FilterKind::unscented},
                                                          {"partially_linear_ukf", FilterKind::partially_linear},
                                                          {"ukf_square_root", FilterKind::unscented_square_root},
                                                          {"ekf", FilterKind::extended}};
constexpr std::size_t filters_at_every_size = 2;

/// A filter that is made and warmed up once, when it is first timed, and goes on from repetition to repetition.
class TimedFilter {
public:
  TimedFilter(std::shared_ptr<const ChainCase> chain, FilterKind kind, int warm_up)
      : chain_(std::move(chain)), kind_(kind), warm_up_(warm_up) {}

  void run(benchmark::State& state) {
    if (!walk_) {
      const auto& augmented_model =
          kind_ == FilterKind::partially_linear ? chain_->modal_augmented_model : chain_->augmented_model;
      walk_ = std::make_unique<FilterWalk>(*augmented_model, chain_->record, kind_);
      for (int i = 0; i < warm_up_; ++i)
        if (!walk_->step()) return state.SkipWithError("the filter failed");
    }
    long allocated = 0, before = allocations();
    for (auto _ : state) {
      if (!walk_->step()) return state.SkipWithError("the filter failed");
      if (!walk_->at_end()) continue;
      state.PauseTiming();  // a record is walked many times; starting again is no step
      allocated += allocations() - before;
      walk_->restart();
      if (!walk_->step()) return state.SkipWithError("the filter failed");
      before = allocations();
      state.ResumeTiming();
    }
    allocated += allocations() - before;
    state.counters["allocations"] = static_cast<double>(allocated) / static_cast<double>(state.iterations());
  }

private:
  std::shared_ptr<const ChainCase> chain_;
  FilterKind kind_;
  int warm_up_;
  std::unique_ptr<FilterWalk> walk_;
};

void run_kernel(benchmark::State& state, const Kernel& kernel, const MatrixXd& in) {
  MatrixXd out = MatrixXd::Zero(in.rows(), in.rows());
  for (auto _ : state) {
    kernel.run(in, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
}

void run_stream(benchmark::State& state, const StreamLoop& loop) {
  VectorXd buffer = VectorXd::Ones(stream_states * (stream_states + 1) / 2);
  for (auto _ : state) {
    loop.run(buffer);
    benchmark::DoNotOptimize(buffer.data());
    benchmark::ClobberMemory();
  }
}

MatrixXd random_columns(int states) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(states, 2 * states + 1, [&] { return normal(random); });
}

template <class Work>
void add(const std::string& name, const Size& size, Work work) {
  auto* const added = benchmark::RegisterBenchmark((name + "/" + std::to_string(size.states)).c_str(), work);
  if (size.repetitions > 0) added->Repetitions(size.repetitions);
}

void add_filters(const Size& size) {
  const auto chain = std::make_shared<const ChainCase>(chain_case(size.states, size.samples));
  for (std::size_t i = 0; i < (size.all_filters ? std::size(filters) : filters_at_every_size); ++i)
    add(filters[i].first, size,
        [filter = std::make_shared<TimedFilter>(chain, filters[i].second, size.warm_up)](auto& state) {
          filter->run(state);
        });
}

void add_kernels(const Size& size) {
  const auto columns = std::make_shared<const MatrixXd>(random_columns(size.states));
  const auto covariance = std::make_shared<const MatrixXd>(*columns * columns->transpose());
  for (const auto& kernel : cholesky_kernels())
    if (size.states <= kernel.largest)
      add("cholesky/" + kernel.name, size,
          [kernel, covariance](auto& state) { run_kernel(state, kernel, *covariance); });
  for (const auto& kernel : rank_update_kernels())
    if (size.states <= kernel.largest)
      add("rank_update/" + kernel.name, size, [kernel, columns](auto& state) { run_kernel(state, kernel, *columns); });
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
  for (const auto& size : sizes) {
    add_filters(size);
    add_kernels(size);
    if (size.states != stream_states) continue;
    for (const auto& loop : stream_loops())
      add("stream/" + loop.name, size, [loop](auto& state) { run_stream(state, loop); });
  }
  MedianReporter medians;
  benchmark::RunSpecifiedBenchmarks(&medians);
  FilterTable table(medians);
  for (const auto& size : sizes) table.rows.emplace_back(medians, size.states);
  table.compare();
  print_table(table);
  if (!json.empty()) write_json(table, json);
  for (const auto& failure : medians.failures) std::fprintf(stderr, "%s\n", failure.c_str());
  return medians.failures.empty() ? 0 : 1;
}

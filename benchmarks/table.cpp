// SPDX-License-Identifier: Apache-2.0
#include "table.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "blas_copy.hpp"
#include "dense_kernels.hpp"
#include "kalfem/linalg/blas.hpp"

namespace kalfem::benchmarks {

namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

std::string processor_kernel() { return blas_kernels().empty() ? "unknown" : blas_kernels(); }

/// A median, or infinity where it was not run.
double or_infinity(double time) { return std::isnan(time) ? std::numeric_limits<double>::infinity() : time; }

double fastest(const MedianReporter& medians, const std::string& kind, const std::vector<Kernel>& kernels, int states,
               bool with_own, std::string& name) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& kernel : kernels) {
    if (kernel.own && !with_own) continue;
    const double time = or_infinity(medians.microseconds(kind + "/" + kernel.name + "/" + std::to_string(states)));
    if (time >= best) continue;
    best = time;
    name = kernel.name;
  }
  return best;
}

nlohmann::json describe(const FilterTime& filter, const Row& row) {
  return {{"us", filter.microseconds},
          {"limit_us", row.limit},
          {"ratio_to_limit", filter.microseconds / row.limit},
          {"public_limit_us", row.public_limit},
          {"ratio_to_public_limit", filter.microseconds / row.public_limit},
          {"allocations_per_step", filter.allocations}};
}

void print_row(const Row& row) {
  const double ukf = row.unscented.microseconds, fast = row.partially_linear.microseconds;
  std::printf(
      "%4d %10.2f %10.2f %5.2f | %10.2f %5.2f | %10.2f %6.3f %6.3f | %5.2f %5.2f | %9.2f %9.2f | %9.2f %10.2f | %s, "
      "%s\n",
      row.states, ukf, row.limit, ukf / row.limit, row.public_limit, ukf / row.public_limit, fast, fast / row.limit,
      fast / row.public_limit, row.unscented.allocations, row.partially_linear.allocations,
      row.square_root.microseconds, row.extended.microseconds, row.cholesky, row.rank_update, row.cholesky_name.c_str(),
      row.rank_update_name.c_str());
}

}  // namespace

void MedianReporter::ReportRuns(const std::vector<Run>& runs) {
  for (const auto& run : runs) {
    if (run.error_occurred) failures.insert(run.run_name.function_name + ": " + run.error_message);
    if (run.error_occurred || run.run_type != Run::RT_Aggregate || run.aggregate_name != "median") continue;
    const std::string& name = run.run_name.function_name;
    microseconds_[name] = 1e-3 * run.GetAdjustedCPUTime();  // in the default unit, ns
    if (const auto counter = run.counters.find("allocations"); counter != run.counters.end())
      allocations_[name] = counter->second;
  }
}

double MedianReporter::microseconds(const std::string& name) const {
  const auto found = microseconds_.find(name);
  return found == microseconds_.end() ? not_run : found->second;
}

double MedianReporter::allocations(const std::string& name) const {
  const auto found = allocations_.find(name);
  return found == allocations_.end() ? not_run : found->second;
}

Row::Row(const MedianReporter& medians, int states_) : states(states_) {
  const auto time_of = [&](const std::string& filter) {
    const std::string name = filter + "/" + std::to_string(states);
    return FilterTime{medians.microseconds(name), medians.allocations(name)};
  };
  unscented = time_of("ukf");
  partially_linear = time_of("partially_linear_ukf");
  square_root = time_of("ukf_square_root");
  extended = time_of("ekf");
  const auto limit_of = [&](bool with_own) {
    cholesky = fastest(medians, "cholesky", cholesky_kernels(), states, with_own, cholesky_name);
    rank_update = fastest(medians, "rank_update", rank_update_kernels(), states, with_own, rank_update_name);
    return 2.0 * cholesky + rank_update;
  };
  public_limit = limit_of(false);
  limit = limit_of(true);
}

FilterTable::FilterTable(const MedianReporter& medians) {
  for (const auto& loop : stream_loops()) {
    const double time = medians.microseconds("stream/" + loop.name + "/" + std::to_string(stream_states));
    if (!(time < or_infinity(stream))) continue;
    stream = time;
    stream_name = loop.name;
  }
}

void FilterTable::compare() {
  const auto step = [&](int states) {
    for (const auto& row : rows)
      if (row.states == states) return row.partially_linear.microseconds;
    return not_run;
  };
  growth = std::log(step(growth_to) / step(growth_from)) / std::log(double(growth_to) / growth_from);
  steps_in_streams = step(stream_states) / stream;
}

void print_table(const FilterTable& table) {
  std::printf("machine: %s\nBLAS:    %s (kernel %s)\n", processor_name().c_str(), blas_name().c_str(),
              processor_kernel().c_str());
  if (const auto warning = blas_warning()) std::printf("         %s\n", warning->c_str());
  for (const auto& copy : other_blas_kernels())
    std::printf("         also timed with kernel %s\n", copy.kernel.c_str());
  std::printf(
      "\npredict + update per step, one thread, medians in microseconds\n"
      "limit: 2 Cholesky + 1 rank update by the fastest kernels; library: by those of Eigen and BLAS alone\n");
  std::printf("%4s %10s %10s %5s | %10s %5s | %10s %6s %6s | %11s | %9s %9s | %9s %10s | %s\n", "n", "ukf", "limit",
              "ratio", "library", "ratio", "part_lin", "/limit", "/libr.", "allocations", "ukf_sqrt", "ekf", "cholesky",
              "rank_upd", "fastest kernels");
  for (const auto& row : table.rows) print_row(row);
  std::printf("\npartially linear step from n = %d to %d: grows with n^%.2f\n", growth_from, growth_to, table.growth);
  std::printf("partially linear step at n = %d: %.2f times reading and writing n (n + 1) / 2 numbers (%.2f us, %s)\n",
              stream_states, table.steps_in_streams, table.stream, table.stream_name.c_str());
}

void write_json(const FilterTable& table, const std::string& path) {
  nlohmann::json json = {{"machine", processor_name()}, {"blas", blas_name()}, {"blas_kernel", processor_kernel()}};
  for (const auto& row : table.rows) {
    const std::string size = "." + std::to_string(row.states);
    json["ukf" + size] = describe(row.unscented, row);
    json["partially_linear_ukf" + size] = describe(row.partially_linear, row);
    if (!std::isnan(row.square_root.microseconds)) json["ukf_square_root" + size] = describe(row.square_root, row);
    if (!std::isnan(row.extended.microseconds)) json["ekf" + size] = describe(row.extended, row);
    json["cholesky" + size] = {{"us", row.cholesky}, {"kernel", row.cholesky_name}};
    json["rank_update" + size] = {{"us", row.rank_update}, {"kernel", row.rank_update_name}};
  }
  json["partially_linear_growth"] = {{"from", growth_from}, {"to", growth_to}, {"exponent", table.growth}};
  json["stream." + std::to_string(stream_states)] = {
      {"us", table.stream}, {"loop", table.stream_name}, {"partially_linear_step", table.steps_in_streams}};
  std::ofstream file(path);
  file << json.dump(2) << '\n';
  if (!file) throw std::runtime_error("cannot write " + path);
}

}  // namespace kalfem::benchmarks

#include "table.hpp"

#include <cstdio>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "dense_kernels.hpp"

namespace kalfem::benchmarks {

namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

double fastest(const MedianReporter& medians, const std::string& kind, const std::vector<Kernel>& kernels, int states,
               bool with_own, std::string& name) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& kernel : kernels) {
    if (kernel.own && !with_own) continue;
    const double time = medians.microseconds.at(kind + "/" + kernel.name + "/" + std::to_string(states));
    if (time >= best) continue;
    best = time;
    name = kernel.name;
  }
  return best;
}

}  // namespace

void MedianReporter::ReportRuns(const std::vector<Run>& runs) {
  for (const auto& run : runs) {
    if (run.error_occurred) throw std::runtime_error(run.benchmark_name() + ": " + run.error_message);
    if (run.run_type != Run::RT_Aggregate || run.aggregate_name != "median") continue;
    const std::string& name = run.run_name.function_name;
    microseconds[name] = 1e-3 * run.GetAdjustedCPUTime();  // in the default unit, ns
    if (const auto counter = run.counters.find("allocations"); counter != run.counters.end())
      allocations[name] = counter->second;
  }
}

Row::Row(const MedianReporter& medians, int states_) : states(states_) {
  const std::string size = "/" + std::to_string(states);
  unscented = medians.microseconds.at("ukf" + size);
  square_root = medians.microseconds.at("ukf_square_root" + size);
  extended = medians.microseconds.at("ekf" + size);
  allocations = medians.allocations.at("ukf" + size);
  const auto limit_of = [&](bool with_own) {
    cholesky = fastest(medians, "cholesky", cholesky_kernels(), states, with_own, cholesky_name);
    rank_update = fastest(medians, "rank_update", rank_update_kernels(), states, with_own, rank_update_name);
    return 2.0 * cholesky + rank_update;
  };
  public_limit = limit_of(false);
  limit = limit_of(true);
}

void print_table(const std::vector<Row>& rows) {
  std::printf("machine: %s\nBLAS:    %s (kernel %s)\n", processor_name().c_str(), blas_name().c_str(),
              blas_kernel().c_str());
  if (blas_kernel() == "Prescott")
    std::printf("         OpenBLAS does not know this processor and took its oldest kernel: set OPENBLAS_CORETYPE\n");
  std::printf(
      "\npredict + update per step, one thread, medians in microseconds\n"
      "limit: 2 Cholesky + 1 rank update by the fastest kernels; library: by those of Eigen and BLAS alone\n");
  std::printf("%4s %9s %9s %6s | %9s %6s | %9s %9s | %8s %8s | %6s | %s\n", "n", "ukf", "limit", "ratio", "library",
              "ratio", "ukf_sqrt", "ekf", "cholesky", "rank_upd", "allocs", "fastest kernels");
  for (const auto& row : rows)
    std::printf("%4d %9.2f %9.2f %6.2f | %9.2f %6.2f | %9.2f %9.2f | %8.2f %8.2f | %6.2f | %s, %s\n", row.states,
                row.unscented, row.limit, row.unscented / row.limit, row.public_limit, row.unscented / row.public_limit,
                row.square_root, row.extended, row.cholesky, row.rank_update, row.allocations,
                row.cholesky_name.c_str(), row.rank_update_name.c_str());
}

void write_json(const std::vector<Row>& rows, const std::string& path) {
  nlohmann::json json = {{"machine", processor_name()}, {"blas", blas_name()}, {"blas_kernel", blas_kernel()}};
  for (const auto& row : rows) {
    const std::string size = "." + std::to_string(row.states);
    json["ukf" + size] = {{"us", row.unscented},
                          {"limit_us", row.limit},
                          {"ratio_to_limit", row.unscented / row.limit},
                          {"public_limit_us", row.public_limit},
                          {"ratio_to_public_limit", row.unscented / row.public_limit},
                          {"allocations_per_step", row.allocations}};
    json["ukf_square_root" + size] = {{"us", row.square_root}, {"ratio_to_limit", row.square_root / row.limit}};
    json["ekf" + size] = {{"us", row.extended}, {"ratio_to_limit", row.extended / row.limit}};
    json["cholesky" + size] = {{"us", row.cholesky}, {"kernel", row.cholesky_name}};
    json["rank_update" + size] = {{"us", row.rank_update}, {"kernel", row.rank_update_name}};
  }
  std::ofstream file(path);
  file << json.dump(2) << '\n';
  if (!file) throw std::runtime_error("cannot write " + path);
}

}  // namespace kalfem::benchmarks

#pragma once

#include <benchmark/benchmark.h>

#include <map>
#include <string>

namespace kalfem::benchmarks {

/// Keeps the median of every benchmark, by its name, and prints nothing.
class MedianReporter final : public benchmark::BenchmarkReporter {
public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override;

  std::map<std::string, double> microseconds;
  std::map<std::string, double> allocations;  ///< per step, of those that count them
};

/// What was measured at one size, in microseconds; limit = 2 Cholesky + 1 rank update, each the fastest there is,
/// kalfem's own among them; public_limit is the same of the public libraries alone.
struct Row {
  Row(const MedianReporter& medians, int states);
  int states;
  double unscented, square_root, extended;
  double cholesky, rank_update, limit, public_limit;
  double allocations;
  std::string cholesky_name, rank_update_name;
};

/// Prints the table for people and writes the same figures as JSON.
void print_table(const std::vector<Row>& rows);
void write_json(const std::vector<Row>& rows, const std::string& path);

}  // namespace kalfem::benchmarks

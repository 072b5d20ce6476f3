// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <benchmark/benchmark.h>

#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace kalfem::benchmarks {

/// Keeps the median of every benchmark, by its name, and prints nothing.
class MedianReporter final : public benchmark::BenchmarkReporter {
public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override;

  /// Not a number where it was not run.
  [[nodiscard]] double microseconds(const std::string& name) const;
  [[nodiscard]] double allocations(const std::string& name) const;  ///< per step, of those that count them

  std::set<std::string> failures;  ///< name and reason

private:
  std::map<std::string, double> microseconds_, allocations_;
};

constexpr double not_run = std::numeric_limits<double>::quiet_NaN();

/// Time of a step and its calls of malloc.
struct FilterTime {
  double microseconds = not_run;
  double allocations = not_run;
};

/// What was measured at one size, in microseconds; limit = 2 Cholesky + 1 rank update, each the fastest there is,
/// kalfem's own among them; public_limit is the same of the public libraries alone.
struct Row {
  Row(const MedianReporter& medians, int states);
  int states;
  FilterTime unscented, partially_linear, square_root, extended;
  double cholesky, rank_update, limit, public_limit;
  std::string cholesky_name, rank_update_name;
};

constexpr int growth_from = 256, growth_to = 1024;  ///< states between which the growth of a step is measured
constexpr int stream_states = 1024;                 ///< states of the covariance of which half is streamed

/// All sizes, and what the partially linear filter's step has in common with O(n^2).
struct FilterTable {
  explicit FilterTable(const MedianReporter& medians);
  /// Growth and step over stream, from the rows.
  void compare();

  std::vector<Row> rows;
  double growth = not_run;  ///< exponent g of a step ~ n^g
  double stream = not_run;  ///< reading and writing n (n + 1) / 2 numbers, by the fastest loop [us]
  double steps_in_streams = not_run;
  std::string stream_name;
};

/// Prints the table for people and writes the same figures as JSON.
void print_table(const FilterTable& table);
void write_json(const FilterTable& table, const std::string& path);

}  // namespace kalfem::benchmarks

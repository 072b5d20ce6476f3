// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/run_series.hpp"

#include "kalfem/base/natural_order.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"

namespace kalfem {

using Eigen::VectorXd;

namespace {

constexpr double band = 1.96;  ///< standard deviations to either side: 95 % of a normal distribution

}  // namespace

RunSeries::RunSeries(const FinishedRun& run) {
  const auto path = run.folder / "results.h5";
  if (std::error_code error; !std::filesystem::exists(path, error)) return;
  file_ = std::make_shared<const Hdf5File>(Hdf5File::open(path.string()));
  if (!file_->has_attribute("/", "run") || file_->text_attribute("/", "run") != run.identity)
    throw InvalidInput(Issue{{path.string(), 0},
                             "it does not belong to summary.json beside it",
                             "the two carry the identities of different runs",
                             "run the case again"});
}

std::vector<std::string> RunSeries::below(const std::string& group) const {
  return file_ && file_->contains(group) ? in_natural_order(file_->datasets(group)) : std::vector<std::string>{};
}

std::optional<VectorXd> RunSeries::read(const std::string& path) const {
  return file_ && file_->contains(path) ? std::optional(file_->read(path)) : std::nullopt;
}

std::string RunSeries::unit(const std::string& path) const {
  return file_ && file_->has_attribute(path, "unit") ? file_->text_attribute(path, "unit") : "";
}

std::optional<ParameterCourse> RunSeries::filter_course(const std::string& parameter) const {
  const std::string path = "/estimate/parameters/" + parameter;
  const auto time = read("/time"), mean = read(path), deviation = read(path + "_std");
  if (!time || !mean || mean->size() == 0 || time->size() < mean->size()) return std::nullopt;
  ParameterCourse course{time->head(mean->size()), *mean, {}, {}};
  if (deviation && deviation->size() == mean->size()) {
    course.lower = *mean - band * *deviation;
    course.upper = *mean + band * *deviation;
  }
  return course;
}

std::optional<ParameterCourse> RunSeries::updating_course(const std::string& parameter) const {
  const auto values = read("/updating/parameters/" + parameter);
  if (!values || values->size() == 0) return std::nullopt;
  const auto count = values->size();
  return ParameterCourse{VectorXd::LinSpaced(count, 1.0, static_cast<double>(count)), *values, {}, {}};
}

}  // namespace kalfem

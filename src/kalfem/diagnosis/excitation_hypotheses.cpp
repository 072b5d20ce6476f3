// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "kalfem/diagnosis/candidates.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double like_a_unit = 0.3, roughly_a_unit = 1.5, worth_a_gain = 0.03, worth_a_delay = 0.1;
/// Recorded seconds over true ones: other rates of the file, powers of two for a thousand.
constexpr double time_scales[] = {0.1, 0.2, 0.5, 0.8, 1.0 / 1.024, 1.024, 1.25, 2.0, 5.0, 10.0};

/// An input is a drive by a measured acceleration ("@a1") or an excitation of the case.
std::string name_of(const std::string& source) { return source.front() == '@' ? source.substr(1) : source; }

/// Value, rate and acceleration of one input are the rows i, n_u + i and 2 n_u + i.
Eigen::Map<MatrixXd, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>> rows_of(MatrixXd& inputs, Index i) {
  const Index count = inputs.rows() / 3;
  return {inputs.data() + i, 3, inputs.cols(), {inputs.rows(), count}};
}

/// The input with a further change of what the filter receives.
Correction with(const DiagnosisInput& input, std::function<void(FilterRun&)> change) {
  Correction made{input};
  made.input.on_run.push_back(std::move(change));
  return made;
}

class ExcitationHypotheses {
public:
  ExcitationHypotheses(double sample_rate, Index input, const std::string& source, const Likeness& likeness)
      : sample_rate_(sample_rate), i_(input), name_(name_of(source)), likeness_(likeness) {}

  std::vector<Hypothesis> all() {
    add_sign();
    add_gain();
    add_delay();
    return std::move(found_);
  }

private:
  [[nodiscard]] Correction scaled(const DiagnosisInput& input, double factor) const {
    return with(input, [i = i_, factor](FilterRun& run) { rows_of(run.input.inputs, i) *= factor; });
  }

  void add_sign() {
    found_.push_back(
        {.code = "excitation_sign",
         .subject = name_,
         .correct = [*this](const DiagnosisInput& input, double) { return scaled(input, -1.0); },
         .words = [name = name_](double,
                                 const auto&) { return fmt::format("the excitation '{}' has the wrong sign", name); },
         .remedy = "turn the direction of '" + name_ + "'"});
  }

  /// The gain of the response is that of the excitation's true size over the given one.
  void add_gain() {
    const double gain = std::abs(likeness_.gain), turned = likeness_.known && likeness_.gain < 0.0 ? -1.0 : 1.0;
    const auto correct = [*this, turned](const DiagnosisInput& input, double factor) {
      return scaled(input, turned / factor);
    };
    const bool known = likeness_.known && gain > 0.0;
    const double tolerance = std::abs(std::log(gain)) > 1.0 ? roughly_a_unit : like_a_unit;
    for (const double unit : unit_factors_near(known ? std::optional(1.0 / gain) : std::nullopt, tolerance))
      found_.push_back({.code = "excitation_unit",
                        .subject = name_,
                        .starts = {unit},
                        .correct = correct,
                        .words =
                            [name = name_](double factor, const auto&) {
                              return fmt::format("the unit of the excitation '{}' is wrong by {}: {}", name,
                                                 in_words(factor), unit_mistake(factor).value_or(""));
                            },
                        .remedy = "correct the unit of '" + name_ + "'"});
    if (known && std::abs(std::log(gain)) > worth_a_gain)
      found_.push_back({.code = "excitation_gain",
                        .subject = name_,
                        .starts = {1.0 / gain, 0.8, 1.25},
                        .search = Search::factor,
                        .step = 0.05,
                        .fitted = 1,
                        .correct = correct,
                        .words =
                            [name = name_](double factor, const auto&) {
                              return fmt::format("the excitation '{}' is {} times as large as it was", name,
                                                 in_words(factor));
                            },
                        .remedy = "check the sensitivity and the unit of '" + name_ + "'"});
  }

  void add_delay() {
    if (!likeness_.known || likeness_.lag == 0 || std::abs(likeness_.correlation) < worth_a_delay) return;
    const double rate = sample_rate_;
    found_.push_back({.code = "excitation_delay",
                      .subject = name_,
                      .starts = {static_cast<double>(-likeness_.lag)},
                      .search = Search::samples,
                      .step = 1.0,
                      .fitted = 1,
                      .correct = [*this](const DiagnosisInput& input, double late) { return earlier(input, late); },
                      .words =
                          [name = name_, rate](double late, const auto&) {
                            return fmt::format("the excitation '{}' is {} ms {} against the sensors", name,
                                               in_words(1e3 * std::abs(late) / rate), late > 0.0 ? "late" : "early");
                          },
                      .remedy = "align the clocks of the excitation and of the sensors"});
  }

  /// The input moved to earlier times by so many samples, interpolated between instants; its ends are held.
  [[nodiscard]] Correction earlier(const DiagnosisInput& input, double samples) const {
    return with(input, [i = i_, samples](FilterRun& run) {
      const Index stride = run.input.input_stride(run.choice.augmented_model->options().instants());
      auto moved = rows_of(run.input.inputs, i);
      const MatrixXd given = moved;
      const double shift = samples * static_cast<double>(stride);
      const auto whole = static_cast<Index>(std::floor(shift));
      const double part = shift - static_cast<double>(whole);
      const auto at = [&](Index k) { return given.col(std::clamp<Index>(k, 0, given.cols() - 1)); };
      for (Index k = 0; k < given.cols(); ++k) moved.col(k) = (1.0 - part) * at(k + whole) + part * at(k + whole + 1);
    });
  }

  double sample_rate_;
  Index i_;
  std::string name_;
  Likeness likeness_;
  std::vector<Hypothesis> found_;
};

/// All inputs with their time running `scale` times as fast: r(t) becomes r(scale t), and so its derivatives' sizes.
void run_at_another_rate(MatrixXd& inputs, double scale) {
  const MatrixXd given = inputs;
  const Index n_u = given.rows() / 3, last = given.cols() - 1;
  VectorXd factor(given.rows());
  factor << VectorXd::Ones(n_u), VectorXd::Constant(n_u, scale), VectorXd::Constant(n_u, scale * scale);
  for (Index k = 0; k <= last; ++k) {
    const double at = std::min(scale * static_cast<double>(k), static_cast<double>(last));
    const Index before = std::min(static_cast<Index>(at), last - 1);
    const double weight = at - static_cast<double>(before);
    inputs.col(k) = factor.cwiseProduct((1.0 - weight) * given.col(before) + weight * given.col(before + 1));
  }
}

Hypothesis other_rate(const std::string& names, double scale) {
  return {.code = "excitation_rate",
          .subject = names,
          .starts = {scale},
          .correct =
              [](const DiagnosisInput& input, double value) {
                return with(input, [value](FilterRun& run) { run_at_another_rate(run.input.inputs, value); });
              },
          .words =
              [names](double value, const auto&) {
                return fmt::format("the time of the excitation '{}' runs {} times as {} as the record's", names,
                                   in_words(value > 1.0 ? value : 1.0 / value), value > 1.0 ? "slow" : "fast");
              },
          .remedy = "check the sample rates of the excitation's file and of the record"};
}

}  // namespace

std::vector<Hypothesis> excitation_hypotheses(double sample_rate, const std::vector<std::string>& sources,
                                              const std::vector<Likeness>& likeness) {
  std::vector<Hypothesis> found;
  std::string names;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (sources[i].empty()) continue;
    auto own = ExcitationHypotheses(sample_rate, static_cast<Index>(i), sources[i], likeness[i]).all();
    found.insert(found.end(), std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()));
    names += (names.empty() ? "" : ", ") + name_of(sources[i]);
  }
  if (!names.empty())
    for (const double scale : time_scales) found.push_back(other_rate(names, scale));
  return found;
}

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

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

class ExcitationHypotheses {
public:
  ExcitationHypotheses(const FilterRun& base, Index input, const std::string& source, const Likeness& likeness)
      : base_(base), i_(input), name_(name_of(source)), likeness_(likeness) {}

  std::vector<Hypothesis> all() {
    add_sign();
    add_gain();
    add_delay();
    return std::move(found_);
  }

private:
  [[nodiscard]] CorrectedRun scaled(double factor) const {
    CorrectedRun corrected{base_, 0.0};
    rows_of(corrected.run.input.inputs, i_) *= factor;
    return corrected;
  }

  void add_sign() {
    found_.push_back(
        {.code = "excitation_sign",
         .subject = name_,
         .correct = [*this](double) { return scaled(-1.0); },
         .words = [name = name_](double,
                                 const auto&) { return fmt::format("the excitation '{}' has the wrong sign", name); },
         .remedy = "turn the direction of '" + name_ + "'"});
  }

  /// The gain of the response is that of the excitation's true size over the given one.
  void add_gain() {
    const double gain = std::abs(likeness_.gain), turned = likeness_.known && likeness_.gain < 0.0 ? -1.0 : 1.0;
    const auto correct = [*this, turned](double given) { return scaled(turned / given); };
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
                        .starts = {1.0 / gain},
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
    const double rate = base_.input.measured.sample_rate;
    found_.push_back({.code = "excitation_delay",
                      .subject = name_,
                      .starts = {static_cast<double>(-likeness_.lag)},
                      .search = Search::samples,
                      .step = 1.0,
                      .fitted = 1,
                      .correct = [*this](double late) { return earlier(static_cast<Index>(std::lround(late))); },
                      .words =
                          [name = name_, rate](double late, const auto&) {
                            return fmt::format("the excitation '{}' is {} ms {} against the sensors", name,
                                               in_words(1e3 * std::abs(late) / rate), late > 0.0 ? "late" : "early");
                          },
                      .remedy = "align the clocks of the excitation and of the sensors"});
  }

  /// The input moved to earlier times by so many samples; its ends are held.
  [[nodiscard]] CorrectedRun earlier(Index samples) const {
    CorrectedRun corrected{base_, 0.0};
    MatrixXd& inputs = corrected.run.input.inputs;
    const Index stride = base_.input.input_stride(base_.choice.augmented_model->options().instants());
    auto moved = rows_of(inputs, i_);
    const MatrixXd given = moved;
    for (Index k = 0; k < given.cols(); ++k)
      moved.col(k) = given.col(std::clamp<Index>(k + samples * stride, 0, given.cols() - 1));
    return corrected;
  }

  const FilterRun& base_;
  Index i_;
  std::string name_;
  Likeness likeness_;
  std::vector<Hypothesis> found_;
};

/// All inputs with their time running `scale` times as fast: r(t) becomes r(scale t), and so its derivatives' sizes.
CorrectedRun at_another_rate(const FilterRun& base, double scale) {
  CorrectedRun corrected{base, 0.0};
  const MatrixXd& given = base.input.inputs;
  MatrixXd& inputs = corrected.run.input.inputs;
  const Index n_u = given.rows() / 3, last = given.cols() - 1;
  VectorXd factor(given.rows());
  factor << VectorXd::Ones(n_u), VectorXd::Constant(n_u, scale), VectorXd::Constant(n_u, scale * scale);
  for (Index k = 0; k <= last; ++k) {
    const double at = std::min(scale * static_cast<double>(k), static_cast<double>(last));
    const Index before = std::min(static_cast<Index>(at), last - 1);
    const double weight = at - static_cast<double>(before);
    inputs.col(k) = factor.cwiseProduct((1.0 - weight) * given.col(before) + weight * given.col(before + 1));
  }
  return corrected;
}

Hypothesis other_rate(const FilterRun& base, const std::string& names, double scale) {
  return {.code = "excitation_rate",
          .subject = names,
          .starts = {scale},
          .correct = [&base](double value) { return at_another_rate(base, value); },
          .words =
              [names](double value, const auto&) {
                return fmt::format("the time of the excitation '{}' runs {} times as {} as the record's", names,
                                   in_words(value > 1.0 ? value : 1.0 / value), value > 1.0 ? "slow" : "fast");
              },
          .remedy = "check the sample rates of the excitation's file and of the record"};
}

}  // namespace

std::vector<Hypothesis> excitation_hypotheses(const FilterRun& base, const std::vector<std::string>& sources,
                                              const std::vector<Likeness>& likeness) {
  std::vector<Hypothesis> found;
  std::string names;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (sources[i].empty()) continue;
    auto own = ExcitationHypotheses(base, static_cast<Index>(i), sources[i], likeness[i]).all();
    found.insert(found.end(), std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()));
    names += (names.empty() ? "" : ", ") + name_of(sources[i]);
  }
  if (!names.empty())
    for (const double scale : time_scales) found.push_back(other_rate(base, names, scale));
  return found;
}

}  // namespace kalfem

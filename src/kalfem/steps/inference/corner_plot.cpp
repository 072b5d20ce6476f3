// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kalfem/base/text.hpp"
#include "kalfem/page/chart_svg.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/pictures/density_contour.hpp"
#include "kalfem/steps/inference/outcome.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_parameters = 8;
constexpr Index most_points = 600;
constexpr int least_bins = 10, most_bins = 28;

/// A parameter as it is drawn.
struct Axis {
  InferredValues values;
  VectorXd samples;
  double low = 0.0, high = 1.0;
  int exponent = 0;  ///< of the power of ten that its labels are divided by

  [[nodiscard]] double part(double value) const { return (value - low) / (high - low); }
  [[nodiscard]] bool shows(double value) const { return value >= low && value <= high; }
};

double weighted_quantile(const VectorXd& values, const VectorXd& weights, double probability) {
  std::vector<Index> order(static_cast<std::size_t>(values.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::sort(order, {}, [&](Index k) { return values[k]; });
  double sum = 0.0;
  for (const Index k : order)
    if ((sum += weights[k]) >= probability) return values[k];
  return values[order.back()];
}

/// Nearly all samples, and the truth where it is not far from them.
void set_range(Axis& axis, const VectorXd& weights) {
  const double low = weighted_quantile(axis.samples, weights, 0.002),
               high = weighted_quantile(axis.samples, weights, 0.998);
  const double size = std::max(std::abs(low), std::abs(high));
  const double width = std::max({high - low, 1e-6 * size, 1e-300});
  axis.low = 0.5 * (low + high - width) - 0.08 * width;
  axis.high = 0.5 * (low + high + width) + 0.08 * width;
  if (const auto& truth = axis.values.truth; truth && *truth > axis.low - width && *truth < axis.high + width) {
    axis.low = std::min(axis.low, *truth - 0.05 * width);
    axis.high = std::max(axis.high, *truth + 0.05 * width);
  }
  const double largest = std::max(std::abs(axis.low), std::abs(axis.high));
  if (largest >= 1e4 || largest < 1e-2) axis.exponent = 3 * static_cast<int>(std::floor(std::log10(largest) / 3.0));
}

std::string raised(int exponent) {
  static const std::array digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char c : std::to_string(exponent)) text += c == '-' ? "⁻" : digits[static_cast<std::size_t>(c - '0')];
  return text;
}

/// "10³ N/m", "N/m", or nothing.
std::string unit_of(const Axis& axis) {
  const std::string unit = axis.values.unit == "-" ? "" : axis.values.unit;
  if (axis.exponent == 0) return unit;
  return "10" + raised(axis.exponent) + (unit.empty() ? "" : " " + unit);
}

/// At most so many bytes, the end kept: it tells parameters of one connector apart.
std::string shortened(const std::string& name, std::size_t most) {
  if (name.size() <= most) return name;
  std::size_t begin = name.size() - most + 3;
  while (begin < name.size() && (static_cast<unsigned char>(name[begin]) & 0xC0U) == 0x80U) ++begin;
  return "..." + name.substr(begin);
}

class CornerPlot {
public:
  CornerPlot(std::vector<Axis> axes, VectorXd weights, std::vector<Index> cloud, MatrixXd correlation,
             std::vector<std::optional<MarginalPrior>> priors)
      : axes_(std::move(axes)),
        weights_(std::move(weights)),
        cloud_(std::move(cloud)),
        correlation_(std::move(correlation)),
        priors_(std::move(priors)),
        bins_(std::clamp(static_cast<int>(1.2 / weights_.norm()), least_bins, most_bins)),
        panel_(std::clamp(880.0 / static_cast<double>(axes_.size()), 112.0, 300.0)) {}

  std::string svg() {
    const auto count = axes_.size();
    const double width = x(count) - gap + right, height = y(count) - row_gap + bottom;
    out_ = fmt::format(
        "<svg class=\"corner\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\" "
        "aria-label=\"Posterior of every pair of parameters\" font-family=\"system-ui, sans-serif\" font-size=\"11\" "
        "style=\"max-width:{0:.0f}px;max-height:none;margin-top:0.6rem\">\n<style>.corner "
        "text{{fill:var(--text,#1b2129)}}.corner "
        ".quiet{{fill:var(--muted,#5b6673)}}.corner .frame{{fill:none;stroke:var(--line,#dde1e6)}}.corner "
        ".bars{{fill:var(--estimate,#0072b2);"
        "fill-opacity:0.28;stroke:var(--estimate,#0072b2);stroke-width:1}}.corner .contour{{fill:none;stroke:"
        "var(--estimate,#0072b2);stroke-width:1.3;stroke-linecap:round}}.corner .inner{{stroke-width:2}}.corner "
        ".mean{{stroke:var(--estimate,#0072b2);stroke-width:1.6}}.corner .truth{{stroke:var(--truth,#1b2129);"
        "stroke-width:1.2;stroke-dasharray:5 3}}.corner .prior{{fill:none;stroke:var(--initial,#a8508f);"
        "stroke-width:1.5;stroke-dasharray:2 3}}.corner .tick{{stroke:var(--muted,#5b6673)}}</style>\n",
        width, height);
    for (std::size_t row = 0; row < count; ++row)
      for (std::size_t column = 0; column < count; ++column) draw(row, column);
    return out_ + "</svg>\n";
  }

private:
  static constexpr double left = 84.0, top = 44.0, right = 24.0, bottom = 56.0, gap = 12.0, row_gap = 46.0;

  [[nodiscard]] double x(std::size_t column) const { return left + static_cast<double>(column) * (panel_ + gap); }
  [[nodiscard]] double y(std::size_t row) const { return top + static_cast<double>(row) * (panel_ + row_gap); }

  void draw(std::size_t row, std::size_t column) {
    if (row < column) {
      draw_correlation(row, column);
      return;
    }
    // A panel is an svg of its own, which clips what it holds.
    out_ += fmt::format("<svg x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\">\n", x(column), y(row),
                        panel_, panel_);
    if (row == column)
      draw_marginal(row);
    else
      draw_pair(row, column);
    out_ += "</svg>\n";
    out_ += fmt::format("<rect class=\"frame\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
                        x(column), y(row), panel_, panel_);
    if (row == column) draw_title(row);
    if (row + 1 == axes_.size()) draw_axis_below(column);
    if (column == 0 && row > 0) draw_axis_beside(row);
  }

  void draw_marginal(std::size_t index) {
    const auto& axis = axes_[index];
    const double width = (axis.high - axis.low) / bins_;
    VectorXd shares = VectorXd::Zero(bins_);
    for (Index k = 0; k < axis.samples.size(); ++k)
      if (axis.shows(axis.samples[k]))
        shares[std::min(bins_ - 1, static_cast<int>(bins_ * axis.part(axis.samples[k])))] += weights_[k];
    const double highest = 1.12 * std::max(1e-300, shares.maxCoeff());
    const auto height = [&](double share) { return panel_ * (1.0 - share / highest); };
    std::string path = fmt::format("M0 {:.1f}", panel_);
    for (int i = 0; i < bins_; ++i) path += fmt::format("V{:.1f}H{:.1f}", height(shares[i]), panel_ * (i + 1) / bins_);
    out_ += fmt::format("<path class=\"bars\" d=\"{}V{:.1f}Z\"/>\n", path, panel_);
    if (priors_[index]) draw_prior(axis, *priors_[index], width, height);
    line_at(axis, axis.values.posterior->mean, "mean", true);
    if (axis.values.truth) line_at(axis, *axis.values.truth, "truth", true);
  }

  /// Its density times the width of a bin, as high as the bars.
  template <typename Height>
  void draw_prior(const Axis& axis, const MarginalPrior& prior, double width, const Height& height) {
    constexpr int points = 96;
    std::string path;
    for (int i = 0; i <= points; ++i) {
      const double value = axis.low + (axis.high - axis.low) * i / points;
      const double share = std::exp(log_density(prior, value)) * width;
      const double drawn = std::isfinite(share) ? std::max(-panel_, height(share)) : panel_;
      path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", panel_ * i / points, drawn);
    }
    out_ += fmt::format("<path class=\"prior\" d=\"{}\"/>\n", path);
  }

  void line_at(const Axis& axis, double value, const char* kind, bool upright) {
    if (!axis.shows(value)) return;
    const double at = panel_ * (upright ? axis.part(value) : 1.0 - axis.part(value));
    out_ += upright ? fmt::format("<line class=\"{0}\" x1=\"{1:.1f}\" y1=\"0\" x2=\"{1:.1f}\" y2=\"{2:.1f}\"/>\n", kind,
                                  at, panel_)
                    : fmt::format("<line class=\"{0}\" x1=\"0\" y1=\"{1:.1f}\" x2=\"{2:.1f}\" y2=\"{1:.1f}\"/>\n", kind,
                                  at, panel_);
  }

  void draw_pair(std::size_t row, std::size_t column) {
    const auto &across = axes_[column], &up = axes_[row];
    const auto place = [&](double u, double v) {
      return fmt::format("{:.1f} {:.1f}", panel_ * across.part(u), panel_ * (1.0 - up.part(v)));
    };
    // Points as strokes without length and with round ends: far shorter than circles.
    std::string path;
    for (const Index k : cloud_)
      if (across.shows(across.samples[k]) && up.shows(up.samples[k]))
        path += "M" + place(across.samples[k], up.samples[k]) + "h0";
    out_ += fmt::format(
        "<path d=\"{}\" fill=\"none\" stroke=\"var(--estimate,#0072b2)\" stroke-opacity=\"0.42\" stroke-width=\"3\" "
        "stroke-linecap=\"round\"/>\n",
        path);
    Eigen::Matrix2Xd points(2, across.samples.size());
    points.row(0) = across.samples.transpose();
    points.row(1) = up.samples.transpose();
    for (const auto& [share, kind] : {std::pair{0.95, "contour"}, std::pair{0.5, "contour inner"}}) {
      std::string pieces;
      for (const auto& [from, to] : density_contour(points, weights_, share))
        pieces += "M" + place(from[0], from[1]) + "L" + place(to[0], to[1]);
      if (!pieces.empty()) out_ += fmt::format("<path class=\"{}\" d=\"{}\"/>\n", kind, pieces);
    }
    if (across.values.truth) line_at(across, *across.values.truth, "truth", true);
    if (up.values.truth) line_at(up, *up.values.truth, "truth", false);
  }

  void draw_correlation(std::size_t row, std::size_t column) {
    const double value = correlation_(static_cast<Index>(row), static_cast<Index>(column));
    const bool known = std::isfinite(value);
    out_ += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"4\" fill=\"var({})\" "
        "fill-opacity=\"{:.3f}\"/>\n<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" "
        "font-size=\"{}\"{}>{}</text>\n",
        x(column), y(row), panel_, panel_, value >= 0.0 ? "--estimate,#0072b2" : "--predicted,#d55e00",
        known ? 0.04 + 0.4 * std::min(1.0, std::abs(value)) : 0.0, x(column) + 0.5 * panel_,
        y(row) + 0.5 * panel_ + 5.0, std::abs(value) >= 0.5 ? 16 : 14, std::abs(value) >= 0.5 ? "" : " class=\"quiet\"",
        known ? fmt::format("{:.2f}", value) : "-");
  }

  void draw_title(std::size_t index) {
    const auto& [name, unit, prior, posterior, truth, most_probable, convergence] = axes_[index].values;
    const double middle = x(index) + 0.5 * panel_;
    out_ += fmt::format(
        "<text x=\"{0:.1f}\" y=\"{1:.1f}\" text-anchor=\"middle\" font-weight=\"600\" "
        "font-size=\"12\">{2}</text>\n<text "
        "x=\"{0:.1f}\" y=\"{3:.1f}\" text-anchor=\"middle\">{4}{5}</text>\n",
        middle, y(index) - 20.0, escaped(shortened(name, letters())), y(index) - 6.0,
        with_deviation(posterior->mean, posterior->deviation), unit.empty() || unit == "-" ? "" : escaped(" " + unit));
  }

  /// That fit over a panel.
  [[nodiscard]] std::size_t letters() const { return static_cast<std::size_t>((panel_ + gap) / 6.6); }

  std::string label(const Axis& axis, double value, double step) const {
    const double scale = std::pow(10.0, axis.exponent);
    const int digits = std::max(0, -static_cast<int>(std::floor(std::log10(step / scale) + 1e-9)));
    std::string text = fmt::format("{:.{}f}", value / scale, std::min(digits, 12));
    if (text.starts_with('-'))
      text = text.find_first_of("123456789") == std::string::npos ? text.substr(1) : "−" + text.substr(1);
    return text;
  }

  /// What labels are written with, their count chosen so that they do not touch.
  std::vector<double> ticks(const Axis& axis) const {
    for (int most = panel_ > 180.0 ? 5 : 3; most > 1; --most) {
      const auto values = axis_ticks(axis.low, axis.high, most);
      if (values.size() < 2) continue;
      const auto longest = std::max(label(axis, values.front(), values[1] - values[0]).size(),
                                    label(axis, values.back(), values[1] - values[0]).size());
      const double room = panel_ * (axis.part(values[1]) - axis.part(values[0]));
      if (6.2 * static_cast<double>(longest) + 6.0 < room) return values;
    }
    return {0.5 * (axis.low + axis.high)};
  }

  static double step_of(const Axis& axis, const std::vector<double>& values) {
    return values.size() > 1 ? values[1] - values[0] : (axis.high - axis.low) / 100.0;
  }

  void draw_axis_below(std::size_t column) {
    const auto& axis = axes_[column];
    const double base = y(axes_.size() - 1) + panel_;
    const auto values = ticks(axis);
    for (const double value : values) {
      const double at = x(column) + panel_ * axis.part(value);
      out_ += fmt::format(
          "<line class=\"tick\" x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{0:.1f}\" y2=\"{2:.1f}\"/><text class=\"quiet\" "
          "x=\"{0:.1f}\" y=\"{3:.1f}\" text-anchor=\"middle\">{4}</text>\n",
          at, base, base + 4.0, base + 16.0, label(axis, value, step_of(axis, values)));
    }
    write_label(axis, fmt::format("x=\"{:.1f}\"", x(column) + 0.5 * panel_), base + 33.0, "");
  }

  /// Name and below it the unit.
  void write_label(const Axis& axis, const std::string& across, double y, const std::string& turn) {
    out_ += fmt::format("<text {} y=\"{:.1f}\"{} text-anchor=\"middle\">{}</text>\n", across, y, turn,
                        escaped(shortened(axis.values.name, letters())));
    if (const auto unit = unit_of(axis); !unit.empty())
      out_ += fmt::format("<text class=\"quiet\" {} y=\"{:.1f}\"{} text-anchor=\"middle\">[{}]</text>\n", across,
                          y + 14.0, turn, escaped(unit));
  }

  void draw_axis_beside(std::size_t row) {
    const auto& axis = axes_[row];
    const auto values = ticks(axis);
    for (const double value : values) {
      const double at = y(row) + panel_ * (1.0 - axis.part(value));
      out_ += fmt::format(
          "<line class=\"tick\" x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{2:.1f}\" y2=\"{1:.1f}\"/><text class=\"quiet\" "
          "x=\"{3:.1f}\" y=\"{4:.1f}\" text-anchor=\"end\">{5}</text>\n",
          left - 4.0, at, left, left - 7.0, at + 4.0, label(axis, value, step_of(axis, values)));
    }
    // Turned about the middle of the row, in whose coordinates y runs to the right.
    write_label(axis, "x=\"0\"", 14.0,
                fmt::format(" transform=\"translate(0 {:.1f}) rotate(-90)\"", y(row) + 0.5 * panel_));
  }

  std::vector<Axis> axes_;
  VectorXd weights_;
  std::vector<Index> cloud_;
  MatrixXd correlation_;
  std::vector<std::optional<MarginalPrior>> priors_;
  int bins_;  ///< of a histogram, more for more effective samples
  double panel_;
  std::string out_;
};

/// Samples of finite values and weights, and these weights, which sum to one; the samples of the whole outcome.
struct FiniteSamples {
  std::vector<Index> columns;
  VectorXd weights;
};
FiniteSamples finite_samples(const SampleSet& samples) {
  FiniteSamples found;
  std::vector<double> weights;
  const bool weighted = samples.weights.size() == samples.values.cols();
  for (Index k = 0; k < samples.values.cols(); ++k) {
    const double weight = weighted ? samples.weights[k] : 1.0;
    if (!samples.values.col(k).allFinite() || !std::isfinite(weight) || weight <= 0.0) continue;
    found.columns.push_back(k);
    weights.push_back(weight);
  }
  found.weights = Eigen::Map<const VectorXd>(weights.data(), std::ssize(weights));
  if (found.weights.size() > 0) found.weights /= found.weights.sum();
  return found;
}

/// Places in the list of samples, equally weighted: every sample as often as its weight asks, at most `count`.
std::vector<Index> equally_weighted(const VectorXd& weights, Index count) {
  std::vector<Index> chosen;
  const Index size = std::min(count, weights.size());
  double reached = weights[0];
  for (Index k = 0, i = 0; k < size; ++k) {
    const double place = (static_cast<double>(k) + 0.5) / static_cast<double>(size);
    while (reached < place && i + 1 < weights.size()) reached += weights[++i];
    if (chosen.empty() || chosen.back() != i) chosen.push_back(i);
  }
  return chosen;
}

std::string caption_of(const InferenceOutcome& outcome, std::size_t drawn, bool with_prior, bool with_truth) {
  std::string text = drawn > 1 ? "Diagonal: density of the posterior; the line is its mean"
                               : "Density of the posterior; the line is its mean";
  if (with_prior) text += ", the dotted curve the prior";
  if (with_truth) text += "; dashed lines are the true values";
  text += ".";
  if (drawn > 1)
    text +=
        " Below it: draws, and the regions with 50 and 95 % of the probability. Above it: correlation, blue if "
        "positive, orange if negative.";
  if (drawn < outcome.posterior.size())
    text += fmt::format(" Of {} parameters the {} with the strongest correlations.", outcome.posterior.size(), drawn);
  return text;
}

}  // namespace

std::vector<Index> drawn_parameters(const InferenceOutcome& outcome, std::size_t most) {
  const auto size = static_cast<Index>(outcome.posterior.size());
  std::vector<Index> order(static_cast<std::size_t>(size));
  std::iota(order.begin(), order.end(), Index{0});
  if (order.size() <= most) return order;
  const auto strongest = [&](Index i) {
    double largest = 0.0;
    for (Index j = 0; j < std::min(size, outcome.correlation.cols()); ++j)
      if (j != i && i < outcome.correlation.rows() && std::isfinite(outcome.correlation(i, j)))
        largest = std::max(largest, std::abs(outcome.correlation(i, j)));
    return largest;
  };
  std::ranges::stable_sort(order, std::greater(), strongest);
  order.resize(most);
  std::ranges::sort(order);
  return order;
}

std::optional<Picture> corner_plot(const InferenceOutcome& outcome) {
  const auto [columns, weights] = finite_samples(outcome.samples);
  if (columns.empty() || outcome.posterior.empty() || outcome.samples.values.rows() < std::ssize(outcome.posterior))
    return std::nullopt;
  const auto all = inferred_values(outcome);
  std::vector<Axis> axes;
  std::vector<std::optional<MarginalPrior>> priors;
  const auto drawn = drawn_parameters(outcome, most_parameters);
  bool with_prior = false, with_truth = false;
  for (const Index i : drawn) {
    const auto index = static_cast<std::size_t>(i);
    Axis axis{.values = all[index], .samples = outcome.samples.values(i, columns).transpose()};
    set_range(axis, weights);
    priors.push_back(index < outcome.prior_marginals.size() ? std::optional(outcome.prior_marginals[index])
                                                            : std::nullopt);
    with_prior |= priors.back().has_value();
    with_truth |= axis.values.truth.has_value();
    axes.push_back(std::move(axis));
  }
  MatrixXd correlation = MatrixXd::Constant(std::ssize(drawn), std::ssize(drawn), std::nan(""));
  if (outcome.correlation.rows() == std::ssize(outcome.posterior)) correlation = outcome.correlation(drawn, drawn);
  return Picture{.title = drawn.size() > 1 ? "Posterior, pair by pair" : "Posterior of " + all.front().name,
                 .caption = caption_of(outcome, drawn.size(), with_prior, with_truth),
                 .svg = CornerPlot(std::move(axes), weights, equally_weighted(weights, most_points),
                                   std::move(correlation), std::move(priors))
                            .svg()};
}

}  // namespace kalfem

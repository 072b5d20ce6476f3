// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/record_splice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/local_polynomial.hpp"
#include "kalfem/records/noise_level.hpp"

namespace kalfem {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double second_difference_gain = 6.0;  ///< variance of the second difference of unit white noise
constexpr double least_kink = 6.0;              ///< [standard deviations]: noise alone does not reach it
constexpr double shift_resolution = 0.1;        ///< [samples]
constexpr Index one_sample = 10;                ///< in units of it

void check(const Record& record, const SpliceOptions& options) {
  IssueList issues;
  if (!(record.sample_rate > 0.0) || !std::isfinite(record.sample_rate))
    issues.add({}, "the sampling rate is " + std::to_string(record.sample_rate), "it must be positive and finite");
  if (!(options.noise_ratio > 1.0) || !std::isfinite(options.noise_ratio))
    issues.add({}, "noise_ratio is " + std::to_string(options.noise_ratio), "it must be greater than 1 and finite");
  if (!(options.rate > 0.0) || !std::isfinite(options.rate))
    issues.add({}, "rate is " + std::to_string(options.rate), "it must be positive and finite");
  if (options.degree < 1 || options.degree > 6)
    issues.add({}, "the fit's degree is " + std::to_string(options.degree), "it must be from 1 to 6");
  if (options.before <= options.degree || options.after <= options.degree)
    issues.add({},
               "the fit uses " + std::to_string(options.before) + " and " + std::to_string(options.after) + " samples",
               "each side needs more samples than the degree of the fit");
  if (options.shortest < 10 || options.largest < 1 || options.blanked < 0)
    issues.add({},
               "shortest, largest and blanked are " + std::to_string(options.shortest) + ", " +
                   std::to_string(options.largest) + " and " + std::to_string(options.blanked),
               "they must be at least 10, 1 and 0");
  if (options.largest > 1000 || options.before > 1000 || options.after > 1000)
    issues.add({}, "the search spans more than 1000 samples",
               "a polynomial cannot follow the motion over more than 1000 samples");
  issues.raise();
}

/// How many samples of the record stand for one of the options'.
Index samples_per_unit(const Record& record, const SpliceOptions& options) {
  return std::max<Index>(1, std::llround(record.sample_rate / options.rate));
}

/// The options with their lengths in samples of the record.
SpliceOptions in_samples(SpliceOptions options, Index times) {
  for (Index* length : {&options.shortest, &options.before, &options.after, &options.largest, &options.blanked})
    *length *= times;
  return options;
}

/// A sample and its largest second difference of all channels, in standard deviations of that of their noise.
struct Kink {
  Index sample = 0;
  double size = 0.0;
};

/// The sample near `about` where the second differences of all channels together stand out most.
Kink largest_kink(const MatrixXd& values, Index about, Index reach, const ArrayXd& noise) {
  Kink best{about, 0.0};
  double best_sum = 0.0;
  for (Index k = std::max<Index>(1, about - reach); k <= std::min<Index>(values.cols() - 2, about + reach); ++k) {
    const ArrayXd second = (values.col(k + 1) - 2.0 * values.col(k) + values.col(k - 1)).array().abs();
    const ArrayXd size = second.isFinite().select(second / noise, 0.0) / std::sqrt(second_difference_gain);
    if (size.sum() <= best_sum) continue;
    best_sum = size.sum();
    best = {k, size.maxCoeff()};
  }
  return best;
}

/// Samples on both sides of a splice that one polynomial is fitted to.
struct Surroundings {
  VectorXd offset;   ///< samples from the splice
  MatrixXd values;   ///< channels x points
  Index before = 0;  ///< the first points stand before the splice
};

Surroundings surroundings(const MatrixXd& values, Index splice, const SpliceOptions& options) {
  std::vector<Index> used;
  Surroundings result;
  const Index reach = options.blanked + std::max(options.before, options.after);
  for (Index k = std::max<Index>(0, splice - reach); k <= std::min(values.cols() - 1, splice + reach); ++k) {
    const Index distance = std::abs(k - splice) - options.blanked;
    if (distance <= 0 || distance > (k < splice ? options.before : options.after) || !values.col(k).allFinite())
      continue;
    used.push_back(k);
    if (k < splice) ++result.before;
  }
  result.values = values(Eigen::all, used);
  result.offset.resize(static_cast<Index>(used.size()));
  for (Index i = 0; i < result.offset.size(); ++i)
    result.offset[i] = static_cast<double>(used[static_cast<std::size_t>(i)] - splice);
  return result;
}

/// Squared misfit of each channel to one polynomial when the part after the splice is moved by `shift` samples.
ArrayXd misfit(const Surroundings& around, double shift, int degree) {
  VectorXd moved = around.offset;
  moved.tail(moved.size() - around.before).array() += shift;
  const MatrixXd basis = polynomial_basis(moved, degree);
  return (around.values - (around.values * basis) * basis.transpose()).rowwise().squaredNorm().array();
}

/// The best shift of each channel, and 1 / its standard deviation from the curvature of the misfit there.
void estimate_shifts(const Surroundings& around, const SpliceOptions& options, std::vector<SpliceEvidence>& evidence) {
  const auto steps = static_cast<Index>(std::llround(static_cast<double>(options.largest) / shift_resolution));
  const double freedom = std::max(1.0, static_cast<double>(around.offset.size() - options.degree - 2));
  const ArrayXd rounding = 1e-24 * around.values.rowwise().squaredNorm().array() + 1e-300;
  MatrixXd found(around.values.rows(), 2 * steps + 1);
  for (Index i = 0; i < found.cols(); ++i)
    found.col(i) = misfit(around, static_cast<double>(i - steps) * shift_resolution, options.degree).matrix();
  for (Index c = 0; c < found.rows(); ++c) {
    Index best = 0;
    const double least = found.row(c).minCoeff(&best) + rounding[c];
    auto& channel = evidence[static_cast<std::size_t>(c)];
    channel.missing = static_cast<double>(best - steps) * shift_resolution;
    if (best < one_sample || best >= found.cols() - one_sample) continue;  // no minimum: the channel says nothing
    const double curvature = found(c, best - one_sample) + found(c, best + one_sample) - 2.0 * found(c, best);
    channel.weight = std::sqrt(std::max(0.0, 0.5 * curvature / least * freedom));
  }
}

double weighted_median(const std::vector<SpliceEvidence>& evidence) {
  auto sorted = evidence;
  std::ranges::sort(sorted, {}, &SpliceEvidence::missing);
  const double total = std::accumulate(sorted.begin(), sorted.end(), 0.0,
                                       [](double sum, const SpliceEvidence& channel) { return sum + channel.weight; });
  double sum = 0.0;
  for (const auto& channel : sorted) {
    sum += channel.weight;
    if (sum >= 0.5 * total) return channel.missing;
  }
  return 0.0;
}

/// Whether channels of at least half the weight, and sharp enough, lie near the common number.
bool agree(const std::vector<SpliceEvidence>& evidence, double missing, Index samples_per_unit) {
  const double sharpness = 5.0 / static_cast<double>(samples_per_unit);  // all together tell it to 0.2 units
  const double tolerance = std::max(1.0, 0.25 * missing);
  double near = 0.0, all = 0.0;
  for (const auto& channel : evidence) {
    all += channel.weight;
    if (std::abs(channel.missing - missing) <= tolerance) near += channel.weight;
  }
  return near > sharpness && near >= 0.5 * all;
}

bool changes(const NoiseChange& noise, double ratio) {
  const ArrayXd size = (noise.after / noise.before).log().abs();
  return 2 * (size >= std::log(ratio)).count() >= size.size();
}

}  // namespace

std::optional<Splice> find_splice(const Record& record, const SpliceOptions& given) {
  check(record, given);
  const Index unit = samples_per_unit(record, given);
  const auto options = in_samples(given, unit);
  if (record.samples() < 2 * options.shortest + 3 || record.values.rows() == 0) return std::nullopt;
  const auto noise = strongest_noise_change(record.values, options.shortest);
  if (!changes(noise, options.noise_ratio)) return std::nullopt;

  Splice splice;
  for (Index c = 0; c < record.values.rows(); ++c) {
    const auto index = static_cast<std::size_t>(c);
    splice.evidence.push_back({index < record.channels.size() ? record.channels[index].name : std::to_string(c + 1),
                               noise.before[c], noise.after[c], 0.0, 0.0});
  }
  const Kink kink = largest_kink(record.values, noise.sample, options.shortest / 2, noise.before.max(noise.after));
  if (kink.size < least_kink) return std::nullopt;
  splice.sample = kink.sample;
  splice.time = record.time(splice.sample);
  splice.blanked = options.blanked;

  const auto around = surroundings(record.values, splice.sample, options);
  if (around.before <= options.degree || around.offset.size() - around.before <= options.degree) return std::nullopt;
  estimate_shifts(around, options, splice.evidence);
  splice.missing = weighted_median(splice.evidence);
  splice.inserted = static_cast<Index>(std::llround(splice.missing));
  if (splice.inserted < 1 || !agree(splice.evidence, splice.missing, unit)) return std::nullopt;
  return splice;
}

Record mend(const Record& record, const Splice& splice) {
  const Index n = record.samples();
  if (splice.sample < 0 || splice.sample >= n || splice.inserted < 0 || splice.blanked < 0)
    throw InvalidInput("the splice at sample " + std::to_string(splice.sample) + " is outside this record",
                       "the record has " + std::to_string(n) + " samples",
                       "search for the splice in the record that is repaired");
  const Index kept_before = std::max<Index>(0, splice.sample - splice.blanked);
  const Index kept_after = std::max<Index>(0, n - splice.sample - splice.blanked - 1);
  Record mended{record.sample_rate, record.start, record.channels};
  mended.values =
      MatrixXd::Constant(record.values.rows(), n + splice.inserted, std::numeric_limits<double>::quiet_NaN());
  mended.values.leftCols(kept_before) = record.values.leftCols(kept_before);
  mended.values.rightCols(kept_after) = record.values.rightCols(kept_after);
  return mended;
}

std::string to_string(const Splice& splice) {
  std::ostringstream text;
  text.precision(3);
  text << "splice at " << splice.time << " s (sample " << splice.sample << "): " << splice.inserted
       << " missing samples inserted (estimated " << splice.missing << "), " << 2 * splice.blanked + 1
       << " samples around it removed";
  for (const auto& channel : splice.evidence)
    text << "\n  " << channel.channel << ": the noise changes from " << channel.noise_before << " to "
         << channel.noise_after << ", the jump corresponds to " << channel.missing << " samples (weight "
         << channel.weight << ")";
  return text.str();
}

}  // namespace kalfem

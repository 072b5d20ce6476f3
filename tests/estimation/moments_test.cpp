// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <iomanip>
#include <iostream>

#include "estimation/chain_model.hpp"
#include "kalfem/estimation/process_model.hpp"

// Mean and covariance after one prediction and after one update, judged by Monte Carlo: how far the sigma points stand
// apart decides, and which random vector they stand for decides that. See docs/theory/partially-linear-ukf.md.

namespace kalfem {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd normals(RandomStream& random, Index rows, Index columns) {
  return MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

MatrixXd square_root(const MatrixXd& covariance) { return Eigen::LLT<MatrixXd>(covariance).matrixL(); }

MatrixXd values_of(PartiallyLinearMap& map, const MatrixXd& w) {
  ArrayXXd phi(w.cols(), map.gain().cols());
  if (!map.evaluate(w.transpose().array(), phi)) throw std::runtime_error("the map has no value at some sample");
  return phi.matrix().transpose();
}

// ---------------------------------------------------------------------------------------------- what is judged

/// A one-connector system with two unknowns, at rest on a ground that stands still.
struct Subject {
  std::string name;
  CoupledModel model;
  OutputMap sensors;
  int substeps;
};

Subject chain(int substeps) {
  const Chain chain;
  const auto acceleration = Chain::acceleration;
  return {"chain, " + std::to_string(substeps) + " parts", chain.model,
          make_outputs(chain.model, {acceleration("1"), acceleration("4"), acceleration("10")}), substeps};
}

Subject two_masses() {
  const auto parameters = values({5e3, Chain::mu_k1, 2e-3, 10.0, Chain::mu_c1, 0.05});
  const auto model = quarter_chain(1, {{"suspension", "wheel.w", "body.1", make_law("saturating"), parameters}},
                                   {{"road", InputKind::base_displacement, "wheel.ground"}}, 0.0);
  return {"two masses", model, make_outputs(model, {Chain::acceleration("1")}), 1};
}

/// Prior standard deviations: of the unknowns relative to their values, of the connector's deformation and rate
/// relative to those at which the law bends, 2 mm and 0.05 m/s.
struct Widths {
  double unknowns, motion;
};

AugmentedModel augmented_model_of(const Subject& subject, Widths widths) {
  auto options = all_known(subject.model.system(), 1.0 / Chain::rate);
  options.substeps = subject.substeps;
  options.unknowns = {{"mu_k1", "N", {{0, 1}}, {TransformKind::log}, Chain::mu_k1, widths.unknowns * Chain::mu_k1},
                      {"mu_c1", "N", {{0, 4}}, {TransformKind::log}, Chain::mu_c1, widths.unknowns * Chain::mu_c1}};
  return AugmentedModel(subject.model.system(), subject.sensors, {}, options);
}

/// Deformation and rate of the suspension at the begin: bent either way, near the middle, and sliding back.
struct Phase {
  double deformation, rate;
};
constexpr Phase phases[] = {{1.5e-3, 0.04}, {-0.5e-3, 0.06}, {3e-3, -0.02}, {0.2e-3, 0.01}};

/// The wheel for itself and the body as a whole, each of its masses with a twentieth of that of its own.
Gaussian prior_of(const AugmentedModel& augmented_model, Widths widths, Phase phase) {
  const Index n = augmented_model.layout().dofs, body = n - 1;
  MatrixXd shape = MatrixXd::Identity(n, n);
  shape.bottomRightCorner(body, body) = MatrixXd::Identity(body, body) / 400.0 + MatrixXd::Ones(body, body);
  auto prior = augmented_model.prior();
  prior.covariance.topLeftCorner(n, n) = 0.5 * std::pow(2e-3 * widths.motion, 2) * shape;
  prior.covariance.block(n, n, n, n) = 0.5 * std::pow(0.05 * widths.motion, 2) * shape;
  prior.mean.segment(1, body).setConstant(phase.deformation);
  prior.mean.segment(n + 1, body).setConstant(phase.rate);
  return prior;
}

struct Contender {
  std::string name;
  FilterKind kind;
  UnscentedOptions options;
};

std::vector<Contender> contenders(const PartiallyLinearMap& map) {
  const auto n = static_cast<double>(map.selection().cols()), q = static_cast<double>(map.selection().rows());
  return {{"points of the state, c = n", FilterKind::unscented, {}},
          {"points of the state, c = q", FilterKind::unscented, {.alpha = std::sqrt(q / n)}},
          {"points of the state, c = 3", FilterKind::unscented, {.alpha = std::sqrt(3.0 / n)}},
          {"points of w, c = q", FilterKind::partially_linear, {.kappa = 0.0}},
          {"points of w, c = 3", FilterKind::partially_linear, {}}};
}
enum : std::size_t { state_n, state_q, state_3, channels_q, channels_3, contender_count };

// -------------------------------------------------------------------------------------------------- the judge

/// Moments from all samples, and from either half of them.
struct Sampled {
  Gaussian all, first, second;
};

/// Moments of y = A x + G phi(N x + e) + b over x = m + S z from many z. What a straight line, fitted to a trial run,
/// explains of phi has exact moments, so that only r = phi - line is sampled.
class PredictedMoments {
public:
  PredictedMoments(PartiallyLinearMap& map, const Gaussian& prior, const std::vector<MatrixXd>& samples)
      : map_(map), prior_(prior), factor_(square_root(prior.covariance)) {
    line_ = MatrixXd::Zero(map.gain().cols(), prior.mean.size());
    level_ = VectorXd::Zero(map.gain().cols());
    level_ = sums(samples[0]).mean;
    line_ = sums(samples[0]).cross.transpose();
    const auto half = samples.size() / 2;
    Sums first, second;
    for (std::size_t i = 1; i <= half; ++i) first += sums(samples[i]);
    for (std::size_t i = half + 1; i < samples.size(); ++i) second += sums(samples[i]);
    moments_.first = moments(first), moments_.second = moments(second);
    first += second;
    moments_.all = moments(first);
  }
  [[nodiscard]] const Sampled& operator()() const { return moments_; }

private:
  struct Sums {
    double count = 0.0;
    VectorXd mean;           // of r
    MatrixXd cross, square;  // of z r^T and r r^T
    void operator+=(const Sums& other) {
      if (count == 0.0) return void(*this = other);
      const double share = other.count / (count += other.count);
      mean += share * (other.mean - mean);
      cross += share * (other.cross - cross);
      square += share * (other.square - square);
    }
  };

  Sums sums(const MatrixXd& samples) {
    const auto z = samples.topRows(prior_.mean.size());
    const VectorXd centre = map_.selection() * prior_.mean + map_.input_offset();
    const MatrixXd w = (map_.selection() * factor_ * z).colwise() + centre;
    const MatrixXd r = (values_of(map_, w) - line_ * z).colwise() - level_;
    const auto count = static_cast<double>(z.cols());
    return {count, r.rowwise().mean(), z * r.transpose() / count, r * r.transpose() / count};
  }

  [[nodiscard]] Gaussian moments(const Sums& sums) const {
    const MatrixXd& G = map_.gain();
    const MatrixXd D = map_.linear() * factor_ + G * line_, cross = D * sums.cross * G.transpose();
    return {map_.linear() * prior_.mean + G * (level_ + sums.mean) + map_.offset(),
            D * D.transpose() + cross + cross.transpose() +
                G * (sums.square - sums.mean * sums.mean.transpose()) * G.transpose()};
  }

  PartiallyLinearMap& map_;
  Gaussian prior_;
  MatrixXd factor_, line_;
  VectorXd level_;
  Sampled moments_;
};

/// Moments of x given y = map(x) + N(0, R) by importance sampling. Given w the rest of x is normal and y linear in it,
/// so that only w is sampled, and each sample carries a normal distribution.
class PosteriorMoments {
public:
  PosteriorMoments(PartiallyLinearMap& map, const Gaussian& prior, const MatrixXd& R, Index samples) : prior_(prior) {
    const MatrixXd &P = prior.covariance, &N = map.selection(), &A = map.linear();
    const MatrixXd L = square_root(N * P * N.transpose());
    to_state_ = L.triangularView<Eigen::Lower>().solve(N * P).transpose();  // E[x | w] = m + to_state u, w = L u
    const MatrixXd rest = P - to_state_ * to_state_.transpose();
    RandomStream random(2, "channels");
    u_ = normals(random, L.rows(), samples);
    const VectorXd centre = N * prior.mean + map.input_offset(), level = A * prior.mean + map.offset();
    expected_ = (A * to_state_ * u_ + map.gain() * values_of(map, (L * u_).colwise() + centre)).colwise() + level;
    noise_ = A * rest * A.transpose() + R;
    gain_ = rest * A.transpose() * noise_.inverse();
    covariance_ = rest - gain_ * A * rest;
  }

  [[nodiscard]] Sampled given(const VectorXd& y) {
    const Index half = u_.cols() / 2;
    return {given(y, 0, 2 * half), given(y, 0, half), given(y, half, half)};
  }
  /// How many samples the measurement leaves: 1 / sum of squared weights, of the last half.
  [[nodiscard]] double effective_samples() const { return effective_; }

  /// What a filter of mean and covariance makes of y where its joint moments are exact.
  [[nodiscard]] Gaussian with_exact_joint_moments(const VectorXd& y) const {
    const VectorXd mean = expected_.rowwise().mean();
    const MatrixXd centred = expected_.colwise() - mean;
    const auto count = static_cast<double>(u_.cols());
    const MatrixXd P_yy = centred * centred.transpose() / count + noise_;
    const MatrixXd K = (to_state_ * (u_ * centred.transpose() / count) + gain_ * noise_) * P_yy.inverse();
    return {prior_.mean + K * (y - mean), prior_.covariance - K * P_yy * K.transpose()};
  }

private:
  Gaussian given(const VectorXd& y, Index begin, Index count) {
    MatrixXd source(u_.rows() + y.size(), count), to_mean(prior_.mean.size(), source.rows());
    source << u_.middleCols(begin, count), (-expected_.middleCols(begin, count)).colwise() + y;
    to_mean << to_state_, gain_;
    const MatrixXd whitened = Eigen::LLT<MatrixXd>(noise_).matrixL().solve(source.bottomRows(y.size()));
    VectorXd weight = -0.5 * whitened.colwise().squaredNorm().transpose();
    weight = (weight.array() - weight.maxCoeff()).exp();
    weight /= weight.sum();
    effective_ = 1.0 / weight.squaredNorm();
    const VectorXd mean = source * weight;
    source.colwise() -= mean;
    const MatrixXd square = source * weight.asDiagonal() * source.transpose();
    return {prior_.mean + to_mean * mean, covariance_ + to_mean * square * to_mean.transpose()};
  }

  Gaussian prior_;
  MatrixXd u_, to_state_, expected_, noise_, gain_, covariance_;
  double effective_ = 0.0;
};

/// Errors of means in standard deviations and of variances relative to the true ones, the largest of the states and of
/// the unknowns; and of all covariances in products of standard deviations.
struct Errors {
  Eigen::Array<double, 5, 1> value = Eigen::Array<double, 5, 1>::Zero();
  double count = 0.0;

  Errors() = default;
  Errors(const Gaussian& found, const Gaussian& truth, Index unknown) : count(1.0) {
    const Eigen::ArrayXd deviation = truth.covariance.diagonal().cwiseSqrt();
    const Eigen::ArrayXd mean = (found.mean - truth.mean).array().abs() / deviation;
    const ArrayXXd covariance = (found.covariance - truth.covariance).array().abs() /
                                (deviation.matrix() * deviation.matrix().transpose()).array();
    const Eigen::ArrayXd variance = covariance.matrix().diagonal();
    value << mean.head(unknown).maxCoeff(), variance.head(unknown).maxCoeff(), covariance.maxCoeff(),
        mean.tail(mean.size() - unknown).maxCoeff(), variance.tail(mean.size() - unknown).maxCoeff();
    value = value.square();
  }
  void operator+=(const Errors& other) { value += other.value, count += other.count; }
  /// Root of the mean square over all that was added.
  [[nodiscard]] Eigen::Array<double, 5, 1> rms() const { return (value / count).sqrt(); }
  [[nodiscard]] double mean() const { return rms()[0]; }
  [[nodiscard]] double variance() const { return rms()[1]; }
  [[nodiscard]] double covariance() const { return rms()[2]; }
  [[nodiscard]] double unknown_mean() const { return rms()[3]; }
  [[nodiscard]] double unknown_variance() const { return rms()[4]; }
};

struct Verdict {
  std::array<Errors, contender_count> errors;
  Errors exact_joint_moments;  ///< of an update
  Errors halves;               ///< of Monte Carlo: either half against the other, twice the error of all samples
};

void print(const std::string& what, const std::vector<Contender>& names, const Verdict& verdict) {
  const auto line = [](const std::string& name, const Eigen::Array<double, 5, 1>& values) {
    std::cout << std::left << std::setw(30) << "  " + name << std::right << std::fixed << std::setprecision(4);
    for (const double value : values) std::cout << std::setw(10) << value;
    std::cout << "\n";
  };
  std::cout << what << "\n"
            << std::setw(40) << "mean" << std::setw(10) << "variance" << std::setw(10) << "covar." << std::setw(10)
            << "mean(u)" << std::setw(10) << "var.(u)"
            << "\n";
  for (std::size_t i = 0; i < contender_count; ++i) line(names[i].name, verdict.errors[i].rms());
  if (verdict.exact_joint_moments.count > 0.0) line("exact joint moments", verdict.exact_joint_moments.rms());
  line("Monte Carlo", 0.5 * verdict.halves.rms());
}

std::string title(const std::string& step, const Subject& subject, Widths widths) {
  std::ostringstream text;
  text << step << " of the " << subject.name << ": unknowns " << 100 * widths.unknowns << " %, motion " << widths.motion
       << " of the bend";
  return text.str();
}

/// The same for all: a trial run and twelve batches.
const std::vector<MatrixXd>& state_samples() {
  static const auto samples = [] {
    RandomStream random(1, "states");
    std::vector<MatrixXd> batches;
    for (int i = 0; i < 13; ++i) batches.push_back(normals(random, 24, 20000));
    return batches;
  }();
  return samples;
}

/// One sample interval from the prior, without process noise.
Verdict judge_prediction(const Subject& subject, Widths widths) {
  const auto augmented_model = augmented_model_of(subject, widths);
  const Index n = augmented_model.layout().size();
  ProcessModel transition(augmented_model);
  transition.set_inputs(VectorXd::Zero(3), VectorXd::Zero(3));
  MeasurementModel instant(augmented_model, sensor_outputs);
  const Index l = instant.linear().rows();
  const FilterModel model{transition, MatrixXd::Zero(n, n), instant, MatrixXd::Identity(l, l)};
  const auto names = contenders(transition);
  Verdict verdict;
  for (const auto& phase : phases) {
    const auto prior = prior_of(augmented_model, widths, phase);
    const PredictedMoments truth(transition, prior, state_samples());
    verdict.halves += Errors(truth().first, truth().second, augmented_model.layout().unknown());
    for (std::size_t i = 0; i < contender_count; ++i) {
      const auto filter = make_filter(names[i].kind, model, names[i].options);
      filter->reset(prior);
      EXPECT_EQ(filter->predict(), FilterOutcome::usable);
      verdict.errors[i] +=
          Errors({filter->mean(), filter->covariance()}, truth().all, augmented_model.layout().unknown());
    }
  }
  print(title("prediction", subject, widths), names, verdict);
  return verdict;
}

/// Accelerations with noise of 15 % of their prior standard deviation, six measurements of each phase.
Verdict judge_update(const Subject& subject, Widths widths) {
  const auto augmented_model = augmented_model_of(subject, widths);
  MeasurementModel instant(augmented_model, sensor_outputs);
  instant.set_inputs(VectorXd::Zero(3));
  ProcessModel transition(augmented_model);
  const Index n = augmented_model.layout().size(), l = instant.linear().rows();
  FilterModel model{transition, MatrixXd::Zero(n, n), instant, MatrixXd::Identity(l, l), &instant};
  const auto names = contenders(instant);
  Verdict verdict;
  for (const auto& phase : phases) {
    const auto prior = prior_of(augmented_model, widths, phase);
    const auto filter = make_filter(FilterKind::unscented, model, names[state_3].options);
    VectorXd mean, deviation;
    filter->reset(prior);
    EXPECT_EQ(filter->observe(mean, &deviation), FilterOutcome::usable);
    const MatrixXd R = (0.15 * deviation).cwiseAbs2().asDiagonal();
    model.measurement_noise = R;
    PosteriorMoments posterior(instant, prior, R, 200000);
    RandomStream random(5, "measurements");
    for (int i = 0; i < 6; ++i) {
      const VectorXd x = prior.mean + square_root(prior.covariance) * normals(random, prior.mean.size(), 1);
      const VectorXd y = instant.linear() * x + instant.offset() +
                         0.15 * deviation.cwiseProduct(normals(random, deviation.size(), 1)) +
                         instant.gain() * values_of(instant, instant.selection() * x + instant.input_offset());
      const auto truth = posterior.given(y);
      if (posterior.effective_samples() < 500.0) continue;  // too far out for the samples to tell
      verdict.halves += Errors(truth.first, truth.second, augmented_model.layout().unknown());
      verdict.exact_joint_moments +=
          Errors(posterior.with_exact_joint_moments(y), truth.all, augmented_model.layout().unknown());
      for (std::size_t j = 0; j < contender_count; ++j) {
        const auto contender = make_filter(names[j].kind, model, names[j].options);
        contender->reset(prior);
        Innovation innovation;
        EXPECT_EQ(contender->update(y, innovation), FilterOutcome::usable);
        verdict.errors[j] +=
            Errors({contender->mean(), contender->covariance()}, truth.all, augmented_model.layout().unknown());
      }
    }
  }
  EXPECT_GE(verdict.halves.count, 16.0);
  print(title("update", subject, widths), names, verdict);
  return verdict;
}

constexpr Widths narrow{0.05, 0.05}, medium{0.15, 0.3}, unsure{0.4, 0.3}, bending{0.15, 1.0}, wide{0.4, 1.0};

/// `found` is not worse than `factor` times `other` in each of the kinds of error, but for Monte Carlo's own.
void expect_at_most(const Errors& found, double factor, const Errors& other, const Errors& halves,
                    double margin = 0.0) {
  const auto limit = (factor * other.rms() + halves.rms() + margin).eval();  // halves: two errors of Monte Carlo
  EXPECT_LE(found.mean(), limit[0]);
  EXPECT_LE(found.variance(), limit[1]);
  EXPECT_LE(found.covariance(), limit[2]);
  EXPECT_LE(found.unknown_mean(), limit[3]);
  EXPECT_LE(found.unknown_variance(), limit[4]);
}

// ------------------------------------------------------------------------------------------------ the judge itself

TEST(Judge, PredictedMomentsAreThoseOfPlainSamples) {
  const auto augmented_model = augmented_model_of(two_masses(), wide);
  const auto prior = prior_of(augmented_model, wide, phases[0]);
  ProcessModel map(augmented_model);
  map.set_inputs(VectorXd::Zero(3), VectorXd::Zero(3));
  RandomStream random(3, "plain");
  const Index n = prior.mean.size(), count = 200000;
  const MatrixXd x = (square_root(prior.covariance) * normals(random, n, count)).colwise() + prior.mean;
  const MatrixXd w = (map.selection() * x).colwise() + map.input_offset();
  const MatrixXd y = (map.linear() * x + map.gain() * values_of(map, w)).colwise() + map.offset();
  const VectorXd mean = y.rowwise().mean();
  const Gaussian plain{mean, (y.colwise() - mean) * (y.colwise() - mean).transpose() / double(count)};
  const PredictedMoments moments(map, prior, state_samples());
  const Errors errors(plain, moments().all, augmented_model.layout().unknown());
  // found .3 of it
  EXPECT_LT(errors.mean(), 4.0 / std::sqrt(double(count)));  // four standard errors of plain sampling
  EXPECT_LT(errors.covariance(), 4.0 * std::sqrt(2.0 / double(count)));
}

TEST(Judge, PosteriorMomentsAreThoseOfWeightedStates) {
  const auto augmented_model = augmented_model_of(two_masses(), wide);
  const auto prior = prior_of(augmented_model, wide, phases[0]);
  MeasurementModel map(augmented_model, sensor_outputs);
  map.set_inputs(VectorXd::Zero(3));
  const MatrixXd R = MatrixXd::Constant(1, 1, 100.0);  // (10 m/s^2)^2
  const VectorXd y = VectorXd::Constant(1, 25.0);
  RandomStream random(4, "plain");
  const Index n = prior.mean.size(), count = 400000;
  const MatrixXd x = (square_root(prior.covariance) * normals(random, n, count)).colwise() + prior.mean;
  const MatrixXd w = (map.selection() * x).colwise() + map.input_offset();
  const MatrixXd expected = (map.linear() * x + map.gain() * values_of(map, w)).colwise() + map.offset();
  VectorXd weight = (-0.5 * (expected.row(0).array() - y[0]).square() / R(0, 0)).exp().transpose();
  weight /= weight.sum();
  const double effective = 1.0 / weight.squaredNorm();
  EXPECT_GT(effective, 20000.0);
  const VectorXd mean = x * weight;
  const MatrixXd centred = x.colwise() - mean;
  const Gaussian plain{mean, centred * weight.asDiagonal() * centred.transpose()};
  PosteriorMoments posterior(map, prior, R, 400000);
  const Errors errors(plain, posterior.given(y).all, augmented_model.layout().unknown());
  // found .4 of it
  EXPECT_LT(errors.mean(), 5.0 / std::sqrt(effective));  // both sides sampled
  EXPECT_LT(errors.covariance(), 5.0 * std::sqrt(2.0 / effective));
}

// ------------------------------------------------------------------------------------------------- what was found

class MomentsOfTheChain : public testing::TestWithParam<Widths> {};

TEST_P(MomentsOfTheChain, AfterAPrediction) {
  const auto verdict = judge_prediction(chain(1), GetParam());
  const auto& errors = verdict.errors;
  // n = 24 states and few channels: their points stand closer, and all errors are smaller.
  expect_at_most(errors[channels_q], 1.0, errors[state_n], verdict.halves);
  expect_at_most(errors[channels_3], 0.75, errors[state_n], verdict.halves);
  EXPECT_LE(errors[channels_3].mean(), 0.5 * errors[state_n].mean());
  // At the same c the 24 columns of S share a channel's deviation among themselves and reach less far along it: the
  // points of the state are then somewhat better, and at c = 3 there is little between them.
  expect_at_most(errors[channels_q], 3.0, errors[state_q], verdict.halves, 1e-3);
  expect_at_most(errors[channels_3], 2.0, errors[state_3], verdict.halves, 1e-3);
}

TEST_P(MomentsOfTheChain, AfterAnUpdate) {
  const auto verdict = judge_update(chain(1), GetParam());
  const auto& errors = verdict.errors;
  expect_at_most(errors[channels_q], 1.0, errors[state_n], verdict.halves);
  expect_at_most(errors[channels_3], 1.0, errors[state_n], verdict.halves);
  // What is left is that a posterior has no normal shape: exact joint moments do no better.
  expect_at_most(errors[channels_3], 1.0, verdict.exact_joint_moments, verdict.halves, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Widths, MomentsOfTheChain, testing::Values(narrow, medium, unsure, bending, wide));

class MomentsAtThree : public testing::TestWithParam<Widths> {};

TEST_P(MomentsAtThree, DoNotDependOnTheNumberOfChannels) {
  // Four parts per interval mean twice the channels, which nearly depend on each other: at c = q their
  // points stand almost as far as those of the 24 states and gain nothing over them. At c = 3 they do.
  const auto few = judge_prediction(chain(1), GetParam()), many = judge_prediction(chain(4), GetParam());
  expect_at_most(many.errors[channels_3], 0.75, many.errors[state_n], many.halves);
  expect_at_most(many.errors[channels_3], 1.25, few.errors[channels_3], many.halves, 1e-3);
}

TEST_P(MomentsAtThree, AreGoodForFewStatesToo) {
  // As many channels as states: only the spread is left to choose.
  const auto prediction = judge_prediction(two_masses(), GetParam()), update = judge_update(two_masses(), GetParam());
  expect_at_most(prediction.errors[channels_3], 1.25, prediction.errors[state_n], prediction.halves);
  expect_at_most(update.errors[channels_3], 1.0, update.errors[state_n], update.halves);
}

INSTANTIATE_TEST_SUITE_P(Widths, MomentsAtThree, testing::Values(medium, wide));

}  // namespace
}  // namespace kalfem

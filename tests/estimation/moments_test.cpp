#include <iomanip>
#include <iostream>

#include "estimation/chain_model.hpp"
#include "kalfem/estimation/observer_maps.hpp"

namespace kalfem {
namespace {

using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index batches = 20, batch_size = 20000;

MatrixXd normals(RandomStream& random, Index rows, Index columns) {
  return MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

// ------------------------------------------------------------------------------------------------ the systems

/// Standard deviations of the prior: parameters relative to their means, motion relative to where the law saturates.
struct Widths {
  double parameters, motion;
};

struct Case {
  std::string name;
  CoupledModel model;
  OutputMap sensors;
  int substeps;
};

Case chain_case(int substeps) {
  const Chain chain;
  return {"chain", chain.model, chain.sensors, substeps};
}

Case small_case() {
  const auto model = quarter_chain(1, {{"suspension", "wheel.w", "body.1", make_law("saturating"), values({5e3, 20.0, 2e-3, 10.0, 10.0, 0.05})}},
                             {{"road", InputKind::base_displacement, "wheel.ground"}}, 0.0);
  return {"two masses", model, make_outputs(model, {Chain::acceleration("1")}), 1};
}

/// The body moves as a whole, with a twentieth of that in each mass of its own; the suspension starts bent and moving.
Gaussian prior_of(const Observer& observer, Widths widths) {
  const Index n = observer.layout().dofs, body = n - 1;
  Gaussian prior = observer.prior();
  MatrixXd shape = MatrixXd::Identity(n, n) / 20.0;
  shape(0, 0) = 1.0;
  shape.bottomRightCorner(body, body) += MatrixXd::Ones(body, body) * 0.999 / static_cast<double>(body);
  shape = (shape * std::sqrt(0.5)).eval();
  (void)shape;
  const double d = 2e-3 * widths.motion / std::sqrt(2.0), v = 0.05 * widths.motion / std::sqrt(2.0);
  MatrixXd motion = MatrixXd::Zero(n, n);
  motion.bottomRightCorner(body, body).setOnes();
  motion.diagonal().array() += 0.0025;
  motion(0, 0) = 1.0;
  prior.covariance.topLeftCorner(n, n) = d * d * motion;
  prior.covariance.block(n, n, n, n) = v * v * motion;
  prior.mean.segment(1, body).setConstant(1.5e-3);
  prior.mean.segment(n + 1, body).setConstant(0.04);
  return prior;
}

Observer observer_of(const Case& study, Widths widths) {
  auto options = all_known(study.model.system(), 1e-3);
  options.substeps = study.substeps;
  options.unknowns = {{"mu_k1", "N", {{0, 1}}, {TransformKind::log}, 20.0, 20.0 * widths.parameters},
                      {"mu_c1", "N", {{0, 4}}, {TransformKind::log}, 10.0, 10.0 * widths.parameters}};
  return Observer(study.model.system(), study.sensors, {}, options);
}

// --------------------------------------------------------------------------------------------- Monte Carlo

/// Moments with the same from half of the samples each.
struct Sampled {
  Gaussian all, first, second;
};

/// Moments of y = A x + G phi(N x + e) + b, x = m + S z, from many z. What a straight line through a trial run
/// explains is known exactly and not sampled: y = const + D z + G r, D = A S + G B.
class TransformedMoments {
public:
  TransformedMoments(PartiallyLinearMap& map, const Gaussian& prior, std::uint64_t seed)
      : map_(&map), mean_(prior.mean), factor_(Eigen::LLT<MatrixXd>(prior.covariance).matrixL()), random_(seed, "moments") {
    line_ = MatrixXd::Zero(map.gain.cols(), prior.mean.size());
    line_ = draw().cross.transpose();
  }

  Sampled run() {
    Sums first = draw(), second = draw();
    for (Index i = 1; i < batches / 2; ++i) first += draw(), second += draw();
    Sums all = first;
    all += second;
    return {moments(all), moments(first), moments(second)};
  }

private:
  struct Sums {
    double count = 0.0;
    VectorXd mean;
    MatrixXd cross, square;
    void operator+=(const Sums& other) {
      const double share = other.count / (count + other.count);
      count += other.count;
      mean += share * (other.mean - mean), cross += share * (other.cross - cross), square += share * (other.square - square);
    }
  };

  Sums draw() {
    const MatrixXd z = normals(random_, mean_.size(), batch_size);
    const ArrayXXd in = ((map_->selection * (factor_ * z)).colwise() + (map_->selection * mean_ + map_->input_offset)).transpose();
    ArrayXXd phi(in.rows(), map_->gain.cols());
    if (!map_->evaluate(in, phi)) throw std::runtime_error("map");
    const MatrixXd r = phi.matrix().transpose() - line_ * z;
    const double n = batch_size;
    return {n, r.rowwise().sum() / n, z * r.transpose() / n, r * r.transpose() / n};
  }

  Gaussian moments(const Sums& sums) const {
    const MatrixXd& G = map_->gain;
    const MatrixXd D = map_->linear * factor_ + G * line_, cross = D * sums.cross * G.transpose();
    return {map_->linear * mean_ + G * sums.mean + map_->offset,
            D * D.transpose() + cross + cross.transpose() + G * (sums.square - sums.mean * sums.mean.transpose()) * G.transpose()};
  }

  PartiallyLinearMap* map_;
  VectorXd mean_;
  MatrixXd factor_, line_;
  RandomStream random_;
};

/// Posterior moments by importance sampling. Given w the rest is linear and normal, so only w is sampled.
class PosteriorMoments {
public:
  PosteriorMoments(PartiallyLinearMap& map, const Gaussian& prior, const MatrixXd& R, std::uint64_t seed) {
    const MatrixXd& P = prior.covariance;
    const MatrixXd& N = map.selection;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(N * P * N.transpose());
    const VectorXd root = eigen.eigenvalues().cwiseSqrt();
    spread_ = P * N.transpose() * eigen.eigenvectors() * root.cwiseInverse().asDiagonal();
    rest_ = P - spread_ * spread_.transpose();
    RandomStream random(seed, "posterior");
    points_ = normals(random, root.size(), batches * batch_size);
    const ArrayXXd in =
        ((eigen.eigenvectors() * root.asDiagonal() * points_).colwise() + (N * prior.mean + map.input_offset)).transpose();
    ArrayXXd phi(in.rows(), map.gain.cols());
    if (!map.evaluate(in, phi)) throw std::runtime_error("map");
    expected_ = ((map.linear * spread_ * points_ + map.gain * phi.matrix().transpose()).colwise() +
                (map.linear * prior.mean + map.offset));
    noise_ = map.linear * rest_ * map.linear.transpose() + R;
    gain_ = rest_ * map.linear.transpose() * noise_.inverse();
    covariance_ = rest_ - gain_ * map.linear * rest_;
    mean_ = prior.mean;
  }

  /// Posterior from the samples [begin, begin + count).
  Gaussian at(const VectorXd& y, Index begin, Index count) {
    const MatrixXd residual = (-expected_.middleCols(begin, count)).colwise() + y;
    const Eigen::LLT<MatrixXd> llt(noise_);
    const MatrixXd white = llt.matrixL().solve(residual);
    Eigen::ArrayXd weight = -0.5 * white.colwise().squaredNorm().transpose().array();
    weight = (weight - weight.maxCoeff()).exp();
    weight /= weight.sum();
    effective_ = 1.0 / weight.square().sum();
    MatrixXd v(points_.rows() + residual.rows(), count);
    v << points_.middleCols(begin, count), residual;
    const VectorXd mean = v * weight.matrix();
    v.colwise() -= mean;
    const MatrixXd square = v * weight.matrix().asDiagonal() * v.transpose();
    MatrixXd map(mean_.size(), v.rows());
    map << spread_, gain_;
    return {mean_ + map * mean, covariance_ + map * square * map.transpose()};
  }
  Sampled run(const VectorXd& y) {
    const Index n = points_.cols();
    Sampled s;
    s.first = at(y, 0, n / 2), s.second = at(y, n / 2, n / 2);
    s.all = at(y, 0, n);
    return s;
  }
  double effective_ = 0.0;
  /// The Gaussian filter with exact joint moments
  Gaussian linear_update(const VectorXd& y, const Gaussian& prior, const MatrixXd& R, const MatrixXd& /*A*/) const {
    (void)R;
    const VectorXd mean = expected_.rowwise().mean();
    const MatrixXd c = expected_.colwise() - mean;
    const double n = double(expected_.cols());
    const MatrixXd Pyy = c * c.transpose() / n + noise_;
    const MatrixXd Pxy = spread_ * (points_ * c.transpose() / n) + gain_ * noise_;
    const MatrixXd K = Pxy * Pyy.inverse();
    return {prior.mean + K * (y - mean), prior.covariance - K * Pyy * K.transpose()};
  }

private:
  MatrixXd points_, expected_, spread_, rest_, noise_, gain_, covariance_;
  VectorXd mean_;
};

struct Errors {
  double mean = 0.0, variance = 0.0, whole = 0.0, parameter_mean = 0.0, parameter_variance = 0.0;
};

Errors errors(const Gaussian& found, const Gaussian& truth, Index unknown) {
  const VectorXd deviation = truth.covariance.diagonal().cwiseSqrt();
  const Eigen::ArrayXd mean = ((found.mean - truth.mean).array() / deviation.array()).abs();
  const Eigen::ArrayXd variance = (found.covariance.diagonal().array() / truth.covariance.diagonal().array() - 1.0).abs();
  const Eigen::LLT<MatrixXd> llt(truth.covariance);
  MatrixXd white = llt.matrixL().solve(found.covariance);
  white = llt.matrixL().solve(white.transpose().eval());
  return {mean.head(unknown).maxCoeff(), variance.head(unknown).maxCoeff(), (white - MatrixXd::Identity(white.rows(), white.cols())).norm(),
          mean.segment(unknown, 2).maxCoeff(), variance.segment(unknown, 2).maxCoeff()};
}

void print(const std::string& name, const Errors& e) {
  std::cout << std::setw(22) << name << std::scientific << std::setprecision(2) << "  mean " << e.mean << "  var " << e.variance << "  whole " << e.whole << "  p mean "
            << e.parameter_mean << "  p var " << e.parameter_variance << "\n";
}

void add(Errors& sum, const Errors& e) {
  sum.mean += e.mean * e.mean, sum.variance += e.variance * e.variance, sum.whole += e.whole * e.whole,
      sum.parameter_mean += e.parameter_mean * e.parameter_mean, sum.parameter_variance += e.parameter_variance * e.parameter_variance;
}
Errors root(const Errors& s, double n) {
  return {std::sqrt(s.mean / n), std::sqrt(s.variance / n), std::sqrt(s.whole / n), std::sqrt(s.parameter_mean / n), std::sqrt(s.parameter_variance / n)};
}

struct Contender { std::string name; FilterKind kind; UnscentedOptions options; };

std::vector<Contender> contenders(double n, double q) {
  return {{"alpha 1", FilterKind::unscented, {}},
          {"same spread", FilterKind::unscented, {.alpha = std::sqrt(q / n)}},
          {"UKF c=3", FilterKind::unscented, {.alpha = std::sqrt(3 / n)}},
          {"partially linear", FilterKind::partially_linear, {}},
          {"partially linear c=3", FilterKind::partially_linear, {.alpha = std::sqrt(3 / q)}},
          {"partially linear c=3 k", FilterKind::partially_linear, {.alpha = 1.0, .beta=0.0,.kappa=3-q}},
          {"extended", FilterKind::extended, {}}};
}

TEST(Explore, Everything) {
  for (const auto& study : {chain_case(1), chain_case(4), small_case()})
    for (const Widths widths : {Widths{0.05, 0.05}, Widths{0.15, 0.3}, Widths{0.4, 0.3}, Widths{0.15, 1.0}, Widths{0.4, 1.0}}) {
      const auto observer = observer_of(study, widths);
      const auto prior = prior_of(observer, widths);
      const Index unknown = observer.layout().unknown(), n = observer.layout().size();
      TransitionMap transition(observer);
      const VectorXd still = VectorXd::Zero(3);
      transition.set_inputs(still, still);
      std::cout << study.name << " substeps " << study.substeps << " n " << n << " q " << transition.selection.rows() << " par " << widths.parameters << " motion " << widths.motion << "\n PREDICT\n";
      const auto truth = TransformedMoments(transition, prior, 1).run();
      const MatrixXd Q = MatrixXd::Zero(n, n);
      for (const auto& c : contenders(double(n), double(transition.selection.rows()))) {
        auto filter = make_filter(c.kind, c.options);
        filter->reset(prior);
        if (filter->predict(transition, Q) != FilterOutcome::usable) { std::cout << c.name << " unusable\n"; continue; }
        print(c.name, errors({filter->mean(), filter->covariance()}, truth.all, unknown));
      }
      auto floor = errors(truth.first, truth.second, unknown);
      print("floor x2", floor);

      InstantMap instant(observer, observer.form().outputs());
      instant.set_inputs(still);
      const Index l = instant.linear.rows();
      MatrixXd R = MatrixXd::Identity(l, l);
      RandomStream random(5, "truths");
      const MatrixXd S = Eigen::LLT<MatrixXd>(prior.covariance).matrixL();
      std::cout << " UPDATE\n";
      {  // noise: 15 % of predicted rms of each channel
        auto f = make_filter(FilterKind::partially_linear);
        f->reset(prior);
        VectorXd m, d;
        (void)f->observe(instant, m, d);
        R = (0.15 * d).cwiseAbs2().asDiagonal();
      }
      PosteriorMoments posterior(instant, prior, R, 2);
      std::vector<Errors> sums(20), ideals(20);
      Errors floors, ideal;
      const int draws = 12;
      double ess = 1e300;
      for (int j = 0; j < draws; ++j) {
        const VectorXd x = prior.mean + S * normals(random, n, 1);
        const ArrayXXd in = (instant.selection * x + instant.input_offset).transpose();
        ArrayXXd phi(1, instant.gain.cols());
        ASSERT_TRUE(instant.evaluate(in, phi));
        const VectorXd y = instant.linear * x + instant.gain * phi.matrix().transpose() + instant.offset +
                           R.diagonal().cwiseSqrt().asDiagonal() * normals(random, l, 1);
        const auto exact = posterior.run(y);
        ess = std::min(ess, posterior.effective_);
        const auto lin = posterior.linear_update(y, prior, R, instant.linear);
        add(floors, errors(exact.first, exact.second, unknown));
        add(ideal, errors(lin, exact.all, unknown));
        std::size_t i = 0;
        for (const auto& c : contenders(double(n), double(instant.selection.rows()))) {
          auto filter = make_filter(c.kind, c.options);
          filter->reset(prior);
          Innovation innovation;
          if (filter->update(instant, R, y, innovation) != FilterOutcome::usable) { sums[i++].mean = NAN; continue; }
          add(sums[i], errors({filter->mean(), filter->covariance()}, exact.all, unknown));
          add(ideals[i++], errors({filter->mean(), filter->covariance()}, lin, unknown));
        }
      }
      std::size_t i = 0;
      for (const auto& c : contenders(double(n), double(instant.selection.rows()))) print(c.name, root(sums[i++], draws));
      print("exact moments", root(ideal, draws));
      print("floor x2", root(floors, draws));
      std::cout << " to exact-moment filter, min effective samples " << ess << "\n";
      i = 0;
      for (const auto& c : contenders(double(n), double(instant.selection.rows()))) print(c.name, root(ideals[i++], draws));
    }
}

}  // namespace
}  // namespace kalfem

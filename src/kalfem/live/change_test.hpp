// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <deque>
#include <vector>

#include "kalfem/live/window_information.hpp"

namespace kalfem {

/// A step of one parameter at the start of a window.
struct ParameterStep {
  Eigen::Index parameter = 0;
  double since = 0.0;                    ///< start of the window [s]
  double earliest = 0.0, latest = 0.0;   ///< between these with 95 % [s]
  double change = 0.0, deviation = 0.0;  ///< estimate and standard deviation
  double statistic = 0.0;                ///< square root of twice the logarithm of the likelihood ratio
};

/// How a window's prediction errors count in the scatter.
enum class ScatterLearning {
  fully,    ///< of the reference
  limited,  ///< errors of more than three deviations as three: they may be a change that is not yet known
  none      ///< a change is suspected
};

/// Generalised likelihood ratio of a step in one of p parameters (Willsky and Jones 1976; window-limited as in Lai
/// 1995). The windows' own estimates y_w, with information Lambda_w, follow
///     y_w = a + sum_k B_k (c_kw - c_k0) + sum_s e_j(s) b_s [w >= tau_s] + noise,   noise ~ N(0, scatter Lambda_w^-1),
/// a: the parameters' levels; B_k: effects of the covariates c_k, one a parameter; b_s: steps that have been accepted.
/// All are estimated together from all windows by generalised least squares, a and B with a normal prior. A further
/// step of parameter j from the window tau on has the score and the information
///     s = sum_{w >= tau} e_j' (eta_w - Lambda_w X_w beta),   V = L_jj - C_j A^-1 C_j',
///     L = sum Lambda_w,  C = sum Lambda_w X_w,  A: information of beta,
/// so that it is s / V with the variance scatter / V, and the statistic |s| / sqrt(scatter V). What could as well be an
/// effect of a covariate, or be the level, has little V and therefore gives no alarm.
class ChangeTest {
public:
  /// `level`, `effect`: prior deviations of a, p, and of B_k, one a covariate. `memory`: windows that tau goes back.
  ChangeTest(const Eigen::VectorXd& level, const Eigen::VectorXd& effect, int memory);

  /// Takes a window that starts at a time [s].
  void add(double start, WindowInformation window, const Eigen::VectorXd& covariates, ScatterLearning learning);
  [[nodiscard]] long windows() const { return count_; }

  /// For each parameter the most likely further step; statistic 0 where none can be told.
  [[nodiscard]] std::vector<ParameterStep> likely_steps() const;
  /// From now on part of what is known to have happened.
  void accept(const ParameterStep& step);
  [[nodiscard]] const std::vector<ParameterStep>& accepted() const { return steps_; }
  /// The sum of a parameter's accepted steps by all windows, with its deviation.
  [[nodiscard]] ParameterStep total_change(Eigen::Index parameter) const;

  /// Effects of the covariates, p x k, and the variance of their sum over k for values relative to the first window's.
  [[nodiscard]] Eigen::MatrixXd effects() const;
  [[nodiscard]] Eigen::VectorXd effect_variance(const Eigen::VectorXd& relative) const;
  [[nodiscard]] Eigen::VectorXd relative(const Eigen::VectorXd& covariates) const { return covariates - origin_; }
  [[nodiscard]] const Eigen::VectorXd& origin() const { return origin_; }  ///< the first window's covariates

  /// Factor on the stated variances: mean square of the whitened prediction errors, at least 1, times the ratio of
  /// their long-run variance to it, (1 + rho) / (1 - rho) for a correlation rho between successive windows.
  [[nodiscard]] double scatter() const;

  static void transfer(auto& self, auto& archive) {
    archive(self.information_);
    archive(self.weighted_);
    archive(self.origin_);
    archive(self.count_);
    archive.each(self.ring_, [&](auto& window) {
      archive(window.start);
      WindowInformation::transfer(window.told, archive);
      archive(window.relative);
    });
    archive.each(self.steps_, [&](auto& step) {
      for (auto* number : {&step.since, &step.earliest, &step.latest, &step.change, &step.deviation, &step.statistic})
        archive(*number);
      archive(step.parameter);
    });
    archive(self.squares_);
    archive(self.freedom_);
    archive(self.products_);
    archive(self.before_);
    if constexpr (requires { archive.at_end(); }) self.solve();
  }

private:
  struct Window {
    double start = 0.0;
    WindowInformation told;
    Eigen::VectorXd relative;  ///< covariates less those of the first window
  };

  /// X_w, p x q.
  [[nodiscard]] Eigen::MatrixXd design(const Window& window) const;
  void learn_scatter(const Window& window, const Eigen::MatrixXd& design, ScatterLearning learning);
  void solve();

  Eigen::Index parameters_;
  std::size_t memory_;
  Eigen::MatrixXd information_;  ///< A, q x q
  Eigen::VectorXd weighted_;     ///< A beta, q
  Eigen::LDLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd solution_;  ///< beta, q
  Eigen::VectorXd origin_;
  std::deque<Window> ring_;
  std::vector<ParameterStep> steps_;
  long count_ = 0;
  double squares_ = 0.0, freedom_ = 0.0, products_ = 0.0;  ///< of whitened prediction errors
  Eigen::VectorXd before_;                                 ///< those of the window before, p
};

}  // namespace kalfem

#include "kalfem/system/laws/expression_law.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/system/laws/expression_checks.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr double weight = 0.29289321881345248;  ///< 1 - 1/sqrt(2), the L-stable choice

/// The steps of a law's tape, sorted by when they are computed.
struct Schedule {
  explicit Schedule(const ExpressionLawOptions& options) : at(options) {
    std::vector<char> known;
    of_parameters = at.tape.steps_from(at.parameters, known);
    auto by_rates = known, by_force = known;
    of_rates = at.tape.steps_to(at.rates, by_rates);
    of_force = at.tape.steps_to({at.force}, by_force);
    std::vector<int> motion{at.x, at.v};
    motion.insert(motion.end(), at.states.begin(), at.states.end());
    for (const int rate : at.rates) back_from_rates.push_back(at.tape.steps_back(rate, motion));
    motion.push_back(at.a);
    back_from_force = at.tape.steps_back(at.force, motion);
  }

  CompiledExpressions at;
  std::vector<TapeStep> of_parameters;  ///< once for a set of parameters
  std::vector<TapeStep> of_rates, of_force, back_from_force;
  std::vector<std::vector<TapeStep>> back_from_rates;
};

/// Values and adjoints of a tape at W points. Each thread has its own, which grow once.
template <int W>
struct Scratch {
  std::vector<TapeLanes<W>, Eigen::aligned_allocator<TapeLanes<W>>> values, adjoints;

  static Scratch& of_thread(int size) {
    thread_local Scratch scratch;
    if (std::ssize(scratch.values) < size) {
      scratch.values.resize(static_cast<std::size_t>(size));
      scratch.adjoints.resize(static_cast<std::size_t>(size));
    }
    return scratch;
  }
};

/// The law at W points of a call, which may repeat the last one.
template <int W>
class PointGroup {
  using Lanes = TapeLanes<W>;
  using States = std::array<Lanes, static_cast<std::size_t>(max_internal_states)>;
  using Matrix = std::array<States, static_cast<std::size_t>(max_internal_states)>;  ///< row i: derivatives of rate i

public:
  explicit PointGroup(const Schedule& schedule)
      : schedule_(schedule),
        at_(schedule.at),
        count_(at_.states.size()),
        values_(Scratch<W>::of_thread(at_.tape.size()).values.data()),
        adjoints_(Scratch<W>::of_thread(at_.tape.size()).adjoints.data()) {
    for (const auto& [number, value] : at_.tape.constants()) values_[number] = value;
  }

  void respond(const LawPoints& points, LawResponse& out, Index first) {
    first_ = first;
    last_ = points.deformation.size() - 1;
    for (std::size_t j = 0; j < at_.parameters.size(); ++j)
      values_[at_.parameters[j]] = gather(column_of(points.parameters, j));
    run<W>(schedule_.of_parameters, values_);
    States s;
    for (std::size_t i = 0; i < count_; ++i) s[i] = gather(column_of(points.begin_states, i));
    for (std::size_t i = 0; i < count_; ++i) by_x_[i] = by_v_[i] = 0.0;
    converged_ = 1.0;
    if (points.duration != 0.0 && count_ > 0) advance(points, s);
    set_motion(points, 1.0);
    values_[at_.a] = gather(points.acceleration.data());
    set_states(s);
    answer(s, out);
  }

private:
  /// Points from the first of the group on; the last point of the call stands in for those that it does not have.
  Lanes gather(const double* column) const {
    if (first_ + W - 1 <= last_) return Eigen::Map<const Lanes>(column + first_);
    Lanes lanes;
    for (int i = 0; i < W; ++i) lanes[i] = column[std::min<Index>(first_ + i, last_)];
    return lanes;
  }
  void scatter(const Lanes& lanes, double* column) const {
    if (first_ + W - 1 <= last_) {
      Eigen::Map<Lanes>(column + first_) = lanes;
      return;
    }
    for (int i = 0; first_ + i <= last_; ++i) column[first_ + i] = lanes[i];
  }
  /// The begin of a column of a block of columns.
  template <class Block>
  static auto column_of(Block& block, std::size_t j) {
    return block.data() + static_cast<Index>(j) * block.outerStride();
  }

  /// Motion and signals at a fraction of the interval.
  void set_motion(const LawPoints& points, double fraction) {
    const auto between = [&](const double* begin, const double* end) -> Lanes {
      if (fraction == 1.0) return gather(end);
      const Lanes from = gather(begin);
      return from + fraction * (gather(end) - from);
    };
    values_[at_.x] = between(points.begin_deformation.data(), points.deformation.data());
    values_[at_.v] = between(points.begin_rate.data(), points.rate.data());
    for (std::size_t i = 0; i < at_.signals.size(); ++i)
      values_[at_.signals[i]] = points.signals.cols() == 0
                                    ? Lanes(Lanes::Zero())
                                    : between(column_of(points.begin_signals, i), column_of(points.signals, i));
  }
  void set_states(const States& s) {
    for (std::size_t i = 0; i < count_; ++i) values_[at_.states[i]] = s[i];
  }
  void clear_adjoints() { std::fill_n(adjoints_, at_.tape.size(), Lanes::Zero()); }

  /// The law's force, and its derivatives also through the states.
  void answer(const States& s, LawResponse& out) {
    run<W>(schedule_.of_force, values_);
    clear_adjoints();
    adjoints_[at_.force] = 1.0;
    run_back<W>(schedule_.back_from_force, values_, adjoints_);
    Lanes stiffness = adjoints_[at_.x], damping = adjoints_[at_.v];
    for (std::size_t i = 0; i < count_; ++i) {
      stiffness += adjoints_[at_.states[i]] * by_x_[i];
      damping += adjoints_[at_.states[i]] * by_v_[i];
      scatter(s[i], column_of(out.states, i));
    }
    const Lanes& force = values_[at_.force];
    const auto usable = converged_ != 0.0 && force.isFinite();
    scatter(usable.select(force, std::numeric_limits<double>::quiet_NaN()), out.force.data());
    scatter(stiffness, out.stiffness.data());
    scatter(damping, out.damping.data());
    scatter(adjoints_[at_.a], out.inertance.data());
  }

  // Two-stage, second-order, L-stable diagonally implicit Runge-Kutta method [Ale77] for s' = g(d, v, s), with the
  // motion linear over the interval:
  //     s_1 = s_0 + w h g(at w h, s_1),   s_2 = s_0 + (1 - w) h g(at w h, s_1) + w h g(at h, s_2),   w = 1 - 1/sqrt(2).
  // The first stage's rate is taken from its increment, (s_1 - s_0) / w, so that no rate is evaluated twice. The
  // derivatives by the motion at the end follow from both stages by the implicit function theorem:
  //     (1 - w h dg/ds) ds_2 = reach ds_1 + w h (dg/dd, dg/dv).
  void advance(const LawPoints& points, States& s) {
    const double step = weight * points.duration, reach = (1.0 - weight) / weight;
    const States begin = s;
    States base = s;
    set_motion(points, weight);
    solve_stage(step, base, s);
    States middle_x, middle_v;
    for (std::size_t i = 0; i < count_; ++i) middle_x[i] = weight * step * rate_x_[i];
    for (std::size_t i = 0; i < count_; ++i) middle_v[i] = weight * step * rate_v_[i];
    solve_linear(middle_x);
    solve_linear(middle_v);
    for (std::size_t i = 0; i < count_; ++i) base[i] = begin[i] + reach * (s[i] - begin[i]);
    set_motion(points, 1.0);
    solve_stage(step, base, s);
    for (std::size_t i = 0; i < count_; ++i) by_x_[i] = reach * middle_x[i] + step * rate_x_[i];
    for (std::size_t i = 0; i < count_; ++i) by_v_[i] = reach * middle_v[i] + step * rate_v_[i];
    solve_linear(by_x_);
    solve_linear(by_v_);
  }

  /// Residual s - base - step g(s) and, with derivatives, also dg/dd, dg/dv and 1 - step dg/ds.
  void evaluate(double step, const States& base, const States& s, States& residual) {
    set_states(s);
    run<W>(schedule_.of_rates, values_);
    for (std::size_t i = 0; i < count_; ++i) residual[i] = s[i] - base[i] - step * values_[at_.rates[i]];
  }
  void differentiate(double step) {
    for (std::size_t i = 0; i < count_; ++i) {
      clear_adjoints();
      adjoints_[at_.rates[i]] = 1.0;
      run_back<W>(schedule_.back_from_rates[i], values_, adjoints_);
      rate_x_[i] = adjoints_[at_.x];
      rate_v_[i] = adjoints_[at_.v];
      for (std::size_t j = 0; j < count_; ++j) matrix_[i][j] = (i == j ? 1.0 : 0.0) - step * adjoints_[at_.states[j]];
    }
  }

  Lanes norm(const States& values) const {
    Lanes sum = Lanes::Zero();
    for (std::size_t i = 0; i < count_; ++i) sum += values[i].square();
    return sum;
  }

  // Newton's method at all points together. A step is halved at the points where it makes the residual larger, as laws
  // with powers and kinks can send the first steps far away. The end is judged by the correction, whose square is the
  // error that it leaves.
  /// Damped Newton iteration on a stage, from s and into s; leaves the derivatives of the rates there.
  void solve_stage(double step, const States& base, States& s) {
    constexpr int max_iterations = 50, max_halvings = 20;
    States residual, correction, trial, trial_residual;
    evaluate(step, base, s, residual);
    Lanes open = Lanes::Ones();  // points that have not ended
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      differentiate(step);
      correction = residual;
      solve_linear(correction);
      Lanes ending = Lanes::Ones();
      for (std::size_t i = 0; i < count_; ++i) {
        correction[i] *= open;
        ending *= (correction[i].abs() <= 1e-8 * s[i].abs() + 1e-300).template cast<double>();
      }
      const Lanes old_norm = norm(residual);
      for (int halving = 0; halving <= max_halvings; ++halving) {
        for (std::size_t i = 0; i < count_; ++i) trial[i] = s[i] - correction[i];
        if (ending.minCoeff() == 1.0) break;  // the last corrections need no residual
        evaluate(step, base, trial, trial_residual);
        const Lanes worse = open * (1.0 - ending) * (!(norm(trial_residual) < old_norm)).template cast<double>() *
                            (old_norm > 0.0).template cast<double>();
        if (halving == max_halvings || worse.maxCoeff() == 0.0) break;
        for (std::size_t i = 0; i < count_; ++i) correction[i] *= 1.0 - 0.5 * worse;
      }
      s = trial;
      residual = trial_residual;
      open *= 1.0 - ending;
      if (open.maxCoeff() == 0.0) break;
    }
    for (std::size_t i = 0; i < count_; ++i) converged_ *= s[i].isFinite().template cast<double>();
    converged_ *= (open == 0.0 || norm(residual).sqrt() <= 1e-9 * norm(s).sqrt()).template cast<double>();
  }

  /// Solves the stage's linear system at each point, into x.
  void solve_linear(States& x) const {
    if (count_ == 1)
      x[0] /= matrix_[0][0];
    else if (!eliminate(x))
      solve_with_exchanges(x);
  }

  // The matrix is near the identity where steps are short, so rows are exchanged only where a pivot turns out small.
  /// Gaussian elimination at all points together. False, and x as it was, where a pivot is small in its row.
  bool eliminate(States& x) const {
    constexpr double least_pivot = 1e-3;
    Matrix m;
    for (std::size_t i = 0; i < count_; ++i) std::copy_n(matrix_[i].begin(), count_, m[i].begin());
    States right = x;
    for (std::size_t k = 0; k < count_; ++k) {
      Lanes largest = m[k][k].abs();
      for (std::size_t j = k + 1; j < count_; ++j) largest = largest.max(m[k][j].abs());
      if (!(m[k][k].abs() >= least_pivot * largest).all()) return false;
      const Lanes inverse = m[k][k].inverse();
      for (std::size_t i = k + 1; i < count_; ++i) {
        const Lanes factor = m[i][k] * inverse;
        for (std::size_t j = k + 1; j < count_; ++j) m[i][j] -= factor * m[k][j];
        right[i] -= factor * right[k];
      }
      m[k][k] = inverse;
    }
    for (std::size_t k = count_; k-- > 0;) {
      for (std::size_t j = k + 1; j < count_; ++j) right[k] -= m[k][j] * right[j];
      right[k] *= m[k][k];
    }
    for (std::size_t i = 0; i < count_; ++i) x[i] = right[i];
    return true;
  }

  void solve_with_exchanges(States& x) const {
    using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_internal_states, max_internal_states>;
    using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_internal_states, 1>;
    const auto n = static_cast<Index>(count_);
    Square matrix(n, n);
    Column right(n);
    for (int lane = 0; lane < W; ++lane) {
      for (std::size_t i = 0; i < count_; ++i) {
        right[static_cast<Index>(i)] = x[i][lane];
        for (std::size_t j = 0; j < count_; ++j)
          matrix(static_cast<Index>(i), static_cast<Index>(j)) = matrix_[i][j][lane];
      }
      right = Eigen::PartialPivLU<Square>(matrix).solve(right).eval();
      for (std::size_t i = 0; i < count_; ++i) x[i][lane] = right[static_cast<Index>(i)];
    }
  }

  const Schedule& schedule_;
  const CompiledExpressions& at_;
  std::size_t count_;
  Lanes *values_, *adjoints_;
  Index first_ = 0, last_ = 0;
  Matrix matrix_;
  States rate_x_, rate_v_, by_x_, by_v_;
  Lanes converged_;
};

class ExpressionLaw final : public ConnectorLaw {
public:
  explicit ExpressionLaw(const ExpressionLawOptions& options)
      : parameters_(options.parameters), signals_(options.signals), schedule_(options) {
    for (const auto& state : options.states) states_.push_back(state.quantity);
    uses_acceleration_ = schedule_.at.tape.depends(schedule_.at.force, schedule_.at.a);
  }

  [[nodiscard]] std::string name() const override { return "expression"; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return states_; }
  [[nodiscard]] const std::vector<LawQuantity>& signals() const override { return signals_; }
  [[nodiscard]] bool uses_acceleration() const override { return uses_acceleration_; }
  [[nodiscard]] bool vectorised() const override { return true; }

  void respond(const LawPoints& points, LawResponse out) const override {
    const Index count = points.deformation.size();
    if (count > 4)
      respond_by<8>(points, out);
    else if (count > 1)
      respond_by<4>(points, out);
    else
      respond_by<1>(points, out);
  }

private:
  template <int W>
  void respond_by(const LawPoints& points, LawResponse& out) const {
    PointGroup<W> group(schedule_);
    for (Index first = 0; first < points.deformation.size(); first += W) group.respond(points, out, first);
  }

  std::vector<LawQuantity> parameters_, states_, signals_;
  Schedule schedule_;
  bool uses_acceleration_ = false;
};

}  // namespace

ConnectorLawPtr expression_law(const ExpressionLawOptions& options) {
  if (auto issues = find_issues(options); !issues.empty()) throw InvalidInput(std::move(issues));
  return std::make_shared<ExpressionLaw>(options);
}

}  // namespace kalfem

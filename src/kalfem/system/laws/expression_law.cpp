#include "kalfem/system/laws/expression_law.hpp"

#include <cmath>
#include <limits>

#include "kalfem/system/laws/expression_evaluator.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

// muParser evaluates through variables at fixed places, so one evaluator serves one thread at a time. A call borrows
// one from the pool, which grows to the number of threads and no further.
/// An evaluator for the time of one call.
class Lease {
public:
  explicit Lease(EvaluatorPool& pool) : pool_(pool), evaluator_(pool.borrow()) {}
  ~Lease() { pool_.give_back(std::move(evaluator_)); }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  [[nodiscard]] ExpressionEvaluator& evaluator() const { return *evaluator_; }

private:
  EvaluatorPool& pool_;
  std::unique_ptr<ExpressionEvaluator> evaluator_;
};

// Point by point: advance the internal states over the interval by the implicit scheme (advance_states()), which also
// gives their derivatives by the end's motion; then the force there. Tangents are central differences of the force by
// d, v, a, and by each state times that state's derivatives. A state that did not converge makes the force no number.
class ExpressionLaw final : public ConnectorLaw {
public:
  explicit ExpressionLaw(const ExpressionLawOptions& options) : parameters_(options.parameters), pool_(options) {
    for (const auto& state : options.states) states_.push_back(state.quantity);
    uses_acceleration_ = force_mentions_acceleration(options);
  }

  [[nodiscard]] std::string name() const override { return "expression"; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return states_; }
  [[nodiscard]] bool uses_acceleration() const override { return uses_acceleration_; }

  void respond(const LawPoints& points, LawResponse out) const override {
    const Lease lease(pool_);
    for (Index i = 0; i < points.deformation.size(); ++i) respond_at(i, lease.evaluator(), points, out);
  }

private:
  void respond_at(Index i, ExpressionEvaluator& evaluator, const LawPoints& points, LawResponse& out) const {
    for (std::size_t j = 0; j < parameters_.size(); ++j)
      evaluator.set_parameter(j, points.parameters(i, static_cast<Index>(j)));
    const ConnectorMotion end{points.deformation[i], points.rate[i]};
    const AdvancedStates advanced = advance(i, evaluator, points, end);
    out.states.row(i) = advanced.s.transpose();
    set_force_and_tangents(i, evaluator, end, points.acceleration[i], advanced, out);
    if (!advanced.converged || !std::isfinite(out.force[i])) out.force[i] = std::numeric_limits<double>::quiet_NaN();
  }

  // At an instant, and for laws without states, nothing advances.
  static AdvancedStates advance(Index i, const ExpressionEvaluator& evaluator, const LawPoints& points,
                                const ConnectorMotion& end) {
    const StateVector begin = points.begin_states.row(i).transpose();
    const StateVector none = StateVector::Zero(begin.size());
    if (points.duration == 0.0 || begin.size() == 0) return {begin, none, none, true};
    return advance_states(evaluator, points.duration, {points.begin_deformation[i], points.begin_rate[i]}, end, begin);
  }

  static void set_force_and_tangents(Index i, const ExpressionEvaluator& evaluator, const ConnectorMotion& at, double a,
                                     const AdvancedStates& advanced, LawResponse& out) {
    const StateVector& s = advanced.s;
    const double d_step = difference_step(at.d), v_step = difference_step(at.v), a_step = difference_step(a);
    out.force[i] = evaluator.force(at, a, s);
    out.stiffness[i] =
        (evaluator.force({at.d + d_step, at.v}, a, s) - evaluator.force({at.d - d_step, at.v}, a, s)) / (2.0 * d_step);
    out.damping[i] =
        (evaluator.force({at.d, at.v + v_step}, a, s) - evaluator.force({at.d, at.v - v_step}, a, s)) / (2.0 * v_step);
    out.inertance[i] = (evaluator.force(at, a + a_step, s) - evaluator.force(at, a - a_step, s)) / (2.0 * a_step);
    StateVector moved = s;
    for (Index j = 0; j < s.size(); ++j) {
      const double step = difference_step(s[j]);
      moved[j] = s[j] + step;
      const double above = evaluator.force(at, a, moved);
      moved[j] = s[j] - step;
      const double force_by_state = (above - evaluator.force(at, a, moved)) / (2.0 * step);
      moved[j] = s[j];
      out.stiffness[i] += force_by_state * advanced.by_d[j];
      out.damping[i] += force_by_state * advanced.by_v[j];
    }
  }

  std::vector<LawQuantity> parameters_, states_;
  bool uses_acceleration_ = false;
  mutable EvaluatorPool pool_;
};

}  // namespace

ConnectorLawPtr expression_law(const ExpressionLawOptions& options) {
  if (auto issues = find_issues(options); !issues.empty()) throw InvalidInput(std::move(issues));
  return std::make_shared<ExpressionLaw>(options);
}

}  // namespace kalfem

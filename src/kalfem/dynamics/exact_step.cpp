#include "kalfem/dynamics/exact_step.hpp"

namespace kalfem {

ExactStep::ExactStep(const FirstOrderForm& form, double step_) : step(step_) {
  const auto m = form.force_gain().cols();
  Eigen::MatrixXd gain(form.size(), m + form.input_gain().cols());
  gain << form.force_gain(), form.input_gain();
  const auto hold = first_order_hold(form.dynamics(), gain, step);
  transition = hold.transition;
  begin_force = hold.begin_weight.leftCols(m);
  end_force = hold.end_weight.leftCols(m);
  begin_input = hold.begin_weight.rightCols(gain.cols() - m);
  end_input = hold.end_weight.rightCols(gain.cols() - m);
  instant_compliance = form.motion().force;
  compliance = form.motion().state * end_force + form.motion().force;
}

}  // namespace kalfem

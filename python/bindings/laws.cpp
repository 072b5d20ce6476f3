// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>

#include "calls.hpp"
#include "kalfem/system/laws/law_library.hpp"
#include "structure.hpp"

namespace kalfem::python {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;

namespace {

constexpr double calls_a_sample = 10.0;   ///< of a filter with two parts of an interval, fourth order
constexpr double worth_a_warning = 10.0;  ///< [s]

/// Of central differences about x.
ArrayXd steps_about(const Eigen::Ref<const ArrayXd>& x) { return (6e-6 * x.abs()).max(1e-9); }

/// A function f(x, v, *parameters) of Python. All points of a call, and those of the central differences for the
/// tangents, go to it in one call.
class PythonLaw final : public ConnectorLaw {
public:
  PythonLaw(const py::function& force, std::vector<LawQuantity> parameters)
      : name_(py::str(py::getattr(force, "__name__", py::str("law")))),
        parameters_(std::move(parameters)),
        force_(force) {}
  ~PythonLaw() override {
    const py::gil_scoped_acquire acquired;  // the last owner may be a thread of the library
    force_ = py::object();
  }

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return states_; }
  [[nodiscard]] bool uses_acceleration() const override { return false; }
  [[nodiscard]] bool vectorised() const override { return true; }

  void respond(const LawPoints& points, LawResponse response) const override {
    const ArrayXd step_x = steps_about(points.deformation), step_v = steps_about(points.rate);
    const Index count = points.deformation.size();
    ArrayXd x(5 * count), v(5 * count);
    x << points.deformation, points.deformation + step_x, points.deformation - step_x, points.deformation,
        points.deformation;
    v << points.rate, points.rate, points.rate, points.rate + step_v, points.rate - step_v;
    const ArrayXd force = evaluate(x, v, points.parameters.replicate(5, 1));
    const auto part = [&](Index i) { return force.segment(i * count, count); };
    response.force = part(0);
    response.stiffness = (part(1) - part(2)) / (2.0 * step_x);
    response.damping = (part(3) - part(4)) / (2.0 * step_v);
    response.inertance.setZero();
  }

  /// Of a call with the points of a usual filter, at deformations about zero; the least of three.
  [[nodiscard]] double seconds_a_call(const Eigen::VectorXd& values) const {
    constexpr Index points = 100;
    const ArrayXd x = ArrayXd::LinSpaced(points, -1e-3, 1e-3);
    const ArrayXXd parameters = values.transpose().replicate(points, 1).array();
    double least = std::numeric_limits<double>::infinity();
    for (int trial = 0; trial < 3; ++trial) {
      const auto begin = std::chrono::steady_clock::now();
      static_cast<void>(evaluate(x, x, parameters));
      least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    static_cast<void>(take_raised());  // the run itself finds it
    return least;
  }

  /// What the function raised since the last call of this.
  [[nodiscard]] std::exception_ptr take_raised() const {
    const std::scoped_lock lock(guard_);
    return std::exchange(raised_, nullptr);
  }

private:
  /// Not a number once the function has raised: the filter ends there, and the error is raised after it.
  [[nodiscard]] ArrayXd evaluate(const ArrayXd& x, const ArrayXd& v, const ArrayXXd& parameters) const {
    const py::gil_scoped_acquire acquired;
    try {
      py::tuple arguments(2 + static_cast<std::size_t>(parameters.cols()));
      arguments[0] = py::cast(x);
      arguments[1] = py::cast(v);
      for (Index i = 0; i < parameters.cols(); ++i)
        arguments[2 + static_cast<std::size_t>(i)] = py::cast(ArrayXd(parameters.col(i)));
      const Column force = Column::ensure(force_(*arguments));
      if (!force) throw py::error_already_set();
      if (force.ndim() == 0) return ArrayXd::Constant(x.size(), *force.data());
      if (force.ndim() != 1 || force.size() != x.size())
        throw py::type_error("the law '" + name_ + "' returned another shape than (points,), that of x");
      return Eigen::Map<const ArrayXd>(force.data(), force.size());
    } catch (...) {
      const std::scoped_lock lock(guard_);
      if (!raised_) raised_ = std::current_exception();
      return ArrayXd::Constant(x.size(), std::numeric_limits<double>::quiet_NaN());
    }
  }

  std::string name_;
  std::vector<LawQuantity> parameters_, states_;
  py::object force_;
  mutable std::mutex guard_;
  mutable std::exception_ptr raised_;
};

/// What keeps an object of Python alive, from any thread.
std::shared_ptr<const void> owner_of(const py::object& object) {
  const auto release = [](py::object* held) {
    const py::gil_scoped_acquire acquired;
    delete held;
  };
  return std::shared_ptr<py::object>(new py::object(object), release);
}

/// The ctypes function of a compiled one: numba's cfunc has it as `ctypes`. None of anything else.
py::object ctypes_function_of(const py::object& given) {
  const bool numba = py::hasattr(given, "address") && py::hasattr(given, "ctypes");
  py::object function = numba ? given.attr("ctypes") : given;
  const py::object kind = py::module_::import("ctypes").attr("_CFuncPtr");
  return py::isinstance(function, kind) ? function : py::none();
}

/// double f(double x, double v, const double* parameters), as ctypes or numba's cfunc give it.
Law compiled_law_of(const py::object& given, const py::object& function, const NamedValues& values) {
  const py::module_ ctypes = py::module_::import("ctypes");
  const py::object number = ctypes.attr("c_double"), numbers = ctypes.attr("POINTER")(number);
  const std::string name = py::str(py::getattr(given, "__name__", py::str("law")));
  const py::object takes = function.attr("argtypes"), gives = function.attr("restype");
  if (takes.is_none() || !py::tuple(takes).equal(py::make_tuple(number, number, numbers)) || !gives.is(number))
    throw InvalidInput("law: the compiled function '" + name + "' takes " + std::string(py::str(takes)) +
                           " and gives " + std::string(py::str(gives)),
                       "a law is double f(double x, double v, const double* parameters)",
                       "set argtypes and restype of the ctypes function, or write "
                       "@numba.cfunc(\"float64(float64, float64, CPointer(float64))\")");
  const auto address = ctypes.attr("cast")(function, ctypes.attr("c_void_p")).attr("value").cast<std::uintptr_t>();
  const auto force = reinterpret_cast<double (*)(double, double, const double*)>(address);
  return law(name, values, [force, owner = owner_of(given)](double x, double v, std::span<const double> parameters) {
    return force(x, v, parameters.data());
  });
}

/// Powers as Python writes them.
std::string with_powers(std::string formula) {
  for (auto at = formula.find("**"); at != std::string::npos; at = formula.find("**")) formula.replace(at, 2, "^");
  return formula;
}

bool is_in_library(const std::string& name) {
  for (const auto& law : law_library())
    if (law.name == name) return true;
  return false;
}

}  // namespace

Law python_law(const py::function& force, const NamedValues& values) {
  std::vector<LawQuantity> parameters;
  for (const auto& [name, value] : values) parameters.push_back({name});
  return law(std::make_shared<const PythonLaw>(force, std::move(parameters)), values);
}

void raise_of_laws(const Structure& structure) {
  for (const auto& connector : structure.description().parts.connectors)
    if (const auto* law = dynamic_cast<const PythonLaw*>(connector.law.get()))
      if (const auto raised = law->take_raised()) std::rethrow_exception(raised);
}

void warn_of_slow_laws(const Structure& structure, Index samples) {
  for (const auto& connector : structure.description().parts.connectors) {
    const auto* law = dynamic_cast<const PythonLaw*>(connector.law.get());
    if (law == nullptr) continue;
    const double seconds = law->seconds_a_call(connector.parameters) * calls_a_sample * static_cast<double>(samples);
    if (seconds < worth_a_warning) continue;
    const std::string text = "the law '" + law->name() +
                             "' is a function of Python: a pass over the record takes about " +
                             std::to_string(std::lround(seconds)) +
                             " s, and a run several; a formula or a compiled function (numba.cfunc, ctypes) is as fast "
                             "as the library's laws";
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 2) != 0) throw py::error_already_set();
  }
}

/// A word is the name of a law, and no formula: it has a letter, and nothing that a formula computes with.
bool is_word(const std::string& text) {
  const auto of_name = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == ' ';
  };
  return std::ranges::all_of(text, of_name) &&
         std::ranges::any_of(text, [](char c) { return std::isalpha(static_cast<unsigned char>(c)); });
}

void refuse_unknown_name(const std::string& text) {
  std::vector<std::string> known;
  for (const auto& law : law_library()) known.push_back(law.name);
  std::string name = text;
  std::ranges::replace_if(
      name, [](char c) { return c == '-' || c == ' '; }, '_');
  const std::string hint = is_in_library(name) ? " (did you mean '" + name + "'?)" : did_you_mean(text, known);
  if (is_word(text) && !hint.empty())
    throw InvalidInput("law: there is no law '" + text + "'" + hint, "it is no formula of x and v either",
                       "kf.laws() lists the library's laws");
}

Law law_of(const py::object& given, const NamedValues& values) {
  if (py::isinstance<py::str>(given)) {
    const auto text = given.cast<std::string>();
    if (!is_in_library(text)) refuse_unknown_name(text);
    return is_in_library(text) ? law(text, values) : expression(with_powers(text), values);
  }
  if (const py::object function = ctypes_function_of(given); !function.is_none())
    return compiled_law_of(given, function, values);
  if (py::isinstance<py::function>(given) || PyCallable_Check(given.ptr()) != 0)
    return python_law(py::reinterpret_borrow<py::function>(given), values);
  throw InvalidInput("law: " + std::string(py::str(py::repr(given))) + " is given",
                     "a law is the name of one of the library's, a formula or a function",
                     "write law=\"cubic\", law=\"k*x + c*v\" or law=f");
}

void bind_laws(py::module_& module) {
  module.def("laws", [] {
    py::list all;
    for (const auto& law : law_library()) {
      py::dict parameters;
      for (const auto& each : law.parameters) parameters[py::str(each.name)] = py::make_tuple(each.unit, each.meaning);
      all.append(py::make_tuple(law.name, law.equation, law.meaning, parameters));
    }
    return all;
  });
}

}  // namespace kalfem::python

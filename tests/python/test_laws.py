# SPDX-License-Identifier: Apache-2.0
"""Laws that are functions: compiled ones, and ones of Python."""

import ctypes
import pickle
import shutil
import subprocess
import time
import warnings

import pytest
from structures import SENSORS, chain, record

import kalfem as kf

CUBIC = dict(k=8e3, k3=5e7, c=12.0)
FORMULA = "k*x + k3*x^3 + c*v"
SOURCE = "double force(double x, double v, const double* p) { return p[0]*x + p[1]*x*x*x + p[2]*v; }\n"


def estimate(law):
    t, road, y = record(301)
    return kf.estimate(
        chain(4, law, CUBIC), t, y, inputs={"road": road}, sensors=SENSORS, substeps=1,
        unknown={"suspension.k": (8e3, "30 %")}, progress=False, diagnose=False,
    )


def law_in_c(folder):
    compiler = shutil.which("cc") or shutil.which("clang++-16") or pytest.skip("needs a C compiler")
    source, library = folder / "law.c", folder / "law.so"
    source.write_text(SOURCE)
    subprocess.run([compiler, "-x", "c", "-O2", "-shared", "-fPIC", "-o", library, source], check=True)
    return ctypes.CDLL(str(library)).force


def declared(function):
    function.restype = ctypes.c_double
    function.argtypes = [ctypes.c_double, ctypes.c_double, ctypes.POINTER(ctypes.c_double)]
    return function


def same(run):
    """The formula has exact tangents; those of a compiled function are differences, which move nothing beyond 1e-7."""
    found, expected = (each.parameters["suspension.k"] for each in (run, estimate(FORMULA)))
    assert found.value == pytest.approx(expected.value, rel=1e-7)
    assert found.std == pytest.approx(expected.std, rel=1e-6)


def test_a_function_of_c_is_a_law(tmp_path):
    same(estimate(declared(law_in_c(tmp_path))))


def test_a_cfunc_of_numba_is_a_law():
    numba = pytest.importorskip("numba")

    @numba.cfunc("float64(float64, float64, CPointer(float64))")
    def force(x, v, p):
        return p[0] * x + p[1] * x**3 + p[2] * v

    law = force
    del force
    same(estimate(law))


def test_an_undeclared_function_is_refused(tmp_path):
    function = law_in_c(tmp_path)
    with pytest.raises(kf.InvalidInput, match="'force' takes None and gives .*c_int.*a law is double f"):
        chain(4, function, CUBIC)
    function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double]
    with pytest.raises(kf.InvalidInput, match="a law is double f"):
        chain(4, function, CUBIC)


def test_too_many_parameters_are_refused(tmp_path):
    with pytest.raises(kf.InvalidInput, match="33 parameters: a force function takes at most 32"):
        chain(4, declared(law_in_c(tmp_path)), {f"p{i}": 1.0 for i in range(33)})


def test_a_function_that_is_not_finite_ends_the_run(tmp_path):
    not_finite = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.POINTER(ctypes.c_double))(
        lambda x, v, p: float("nan"))
    run = estimate(not_finite)
    assert run.verdict.state == "unusable"


def test_a_slow_function_of_python_is_told_before_the_run():
    def slow(x, v, k, k3, c):
        time.sleep(5e-3)
        return k * x + c * v

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(RuntimeWarning, match="'slow' is a function of Python: a pass .* takes about 1.? s"):
            estimate(slow)
        estimate(lambda x, v, k, k3, c: k * x + c * v)


def test_a_compiled_function_has_no_pickle(tmp_path):
    with pytest.raises((ValueError, TypeError, kf.InvalidInput)):
        pickle.dumps(chain(4, declared(law_in_c(tmp_path)), CUBIC))

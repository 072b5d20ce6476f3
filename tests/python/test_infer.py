# SPDX-License-Identifier: Apache-2.0
"""The posterior of a structure's unknowns by a record, without a case."""

import math
import pickle

import numpy as np
import pytest

import kalfem as kf

MASS, DAMPING, RELEASE, NOISE = 2.0, 4.0, 5e-3, 1e-3
T = np.arange(200) / 100.0


def motion(k):
    """A mass that is let go, without the library."""
    delta = 0.5 * DAMPING / MASS
    w = np.sqrt(k / MASS - delta**2)
    return RELEASE * np.exp(-delta * T) * (np.cos(w * T) + delta / w * np.sin(w * T))


Y = motion(800.0) + NOISE * np.random.default_rng(2).normal(size=len(T))


def log_likelihood(k):
    return -0.5 * np.sum(((Y - motion(k)) / NOISE) ** 2) - len(T) * math.log(NOISE * math.sqrt(2 * math.pi))


def one_mass():
    return kf.Structure().add(kf.lumped("body").mass("m", MASS).spring("k", "ground", "m", 800.0, DAMPING))


def infer(structure=None, y=None, **options):
    question = dict(
        sensors={"x": kf.displacement("body.m", noise=NOISE)},
        unknown={"body.k.stiffness": {"initial": 780.0, "std": "5 %", "transform": "none"}},
        initial_state={"body.m": {"displacement": RELEASE}},
        progress=False,
    )
    return kf.infer(structure or one_mass(), T, {"x": Y} if y is None else y, **{**question, **options})


def quadrature(lower, upper, log_prior):
    k = np.linspace(lower, upper, 3001)
    log_density = np.array([log_likelihood(each) + log_prior(each) for each in k])
    density = np.exp(log_density - log_density.max())
    mean = density @ k / density.sum()
    std = math.sqrt(density @ (k - mean) ** 2 / density.sum())
    return mean, std, log_density.max() + math.log(density.sum() * (k[1] - k[0])), k, np.cumsum(density) / density.sum()


def normal(k):
    return -0.5 * ((k - 780.0) / 39.0) ** 2 - math.log(39.0 * math.sqrt(2 * math.pi))


@pytest.fixture(scope="module")
def found():
    return infer(profile="body.k.stiffness", samples=2000, seed=3)


def test_the_posterior_is_that_of_quadrature(found):
    """Sampling errors of 2,000 samples: 0.02 deviations of the mean, of a quantile at 2.5 % 0.06."""
    mean, std, log_evidence, k, below = quadrature(700.0, 900.0, normal)
    assert found.names == ["body.k.stiffness"] and found.units == ["N/m"]
    assert found.values.shape == (2000, 1) and found.weights.sum() == pytest.approx(1.0, abs=1e-12)
    assert found.mean[0] == pytest.approx(mean, abs=0.08 * std)
    assert found.std[0] == pytest.approx(std, rel=0.08)
    assert found.log_evidence == pytest.approx(log_evidence, abs=0.02) and found.log_evidence_std < 0.02
    for p, expected in zip((0.025, 0.5, 0.975), np.interp((0.025, 0.5, 0.975), below, k)):
        assert found.quantile(p)[0] == pytest.approx(expected, abs=0.2 * std)
    assert found.warnings == [] and "importance" in found.method


def test_moments_and_quantiles_are_those_of_the_library(found):
    """The same sums as in C++, over the same samples."""
    (details,) = found.details
    assert found.mean[0] == pytest.approx(details["estimate"], rel=1e-12)
    assert found.std[0] == pytest.approx(details["std"], rel=1e-9)
    assert found.interval(0.95)[0] == pytest.approx(details["interval_95"], rel=1e-12)
    assert found.interval(0.68)[0] == pytest.approx(details["interval_68"], rel=1e-12)
    assert found.quantile([0.1, 0.5]).shape == (2, 1) and found.quantile(0.5)[0] == pytest.approx(details["median"])
    assert details["initial"] == 780.0 and details["prior_std"] == pytest.approx(39.0)


def test_every_sample_has_the_exact_likelihood(found):
    for k, value in zip(found["body.k.stiffness"][::200], found.log_likelihood[::200]):
        assert value == pytest.approx(log_likelihood(k), abs=1e-6)
    with pytest.raises(kf.UnknownName, match="body.k.stiffness"):
        found["body.k"]


def test_profile_and_bands(found):
    profile = found.profiles["body.k.stiffness"]
    assert profile.lower < found.mean[0] < profile.upper and profile.unit == "N/m"
    assert log_likelihood(profile.upper) == pytest.approx(max(map(log_likelihood, found.values[:, 0])) - 1.92, abs=0.2)
    band = found.bands["x"]
    assert band.mean == pytest.approx(motion(800.0), abs=NOISE) and 0.9 <= band.coverage <= 1.0
    assert infer(predictions=0, samples=100).bands == {}


def test_draws_have_equal_weights(found):
    draws = found.draws(500)
    assert draws.shape == (500, 1) and set(draws[:, 0]) <= set(found.values[:, 0])
    assert draws.mean() == pytest.approx(found.mean[0], abs=0.2 * found.std[0])


def test_a_uniform_prior_cuts():
    found = infer(unknown=["body.k.stiffness"], priors={"body.k.stiffness": {"uniform": ["0.69 kN/m", 795]}}, samples=2000)
    mean, std, log_evidence, *_ = quadrature(690.0, 795.0, lambda k: -math.log(105.0))
    assert found.values.max() <= 795.0
    assert found.mean[0] == pytest.approx(mean, abs=0.08 * std)
    assert found.log_evidence == pytest.approx(log_evidence, abs=0.05)


@pytest.mark.parametrize("prior", [{"normal": ["0.78 kN/m", "5 %"]}, {"lognormal": [780.0, "5 %"]}])
def test_a_stated_prior_takes_the_place_of_the_unknown_s(found, prior):
    """A log-normal prior of 5 % is nearly the normal one; cut at 790, nothing lies above."""
    name = "body.k.stiffness"
    options = dict(unknown=[name], samples=500)
    other = infer(priors={name: prior}, **options)
    assert other.mean[0] == pytest.approx(found.mean[0], abs=0.3 * found.std[0])
    assert other.details[0]["prior_std"] == pytest.approx(39.0, rel=0.01)
    assert infer(priors={name: {**prior, "bounds": ["500 N/m", 790]}}, **options).values.max() <= 790.0


def test_two_parameters_are_correlated():
    found = infer(unknown={"body.k.stiffness": (780.0, 40.0), "body.k.damping": (4.5, 1.5)}, samples=500)
    assert found.correlation.shape == (2, 2) and found.correlation == pytest.approx(found.correlation.T)
    assert np.diag(found.correlation) == pytest.approx([1.0, 1.0])
    assert found.correlation[0, 1] == pytest.approx(found.covariance[0, 1] / found.std.prod())
    assert "determine" in found.identifiability


@pytest.mark.parametrize("method", ["laplace", "tempered", "metropolis", "filter"])
def test_methods_agree(found, method):
    other = infer(method=method, samples=1000)
    assert other.mean[0] == pytest.approx(found.mean[0], abs=0.25 * found.std[0])
    assert (other.log_evidence is None) == (method == "metropolis")
    assert other.chains == (4 if method == "metropolis" else 1)


def test_it_is_what_infer_of_a_case_gives(tmp_path):
    """To rounding: both search from the estimates of the filter, and the seed is the same."""
    case = f"""
kalfem: 1
substructures: {{body: {{masses: {{m: {MASS}}}, springs: [{{name: k, from: ground, to: m, stiffness: 800, damping: {DAMPING}}}]}}}}
sensors: {{x: {{displacement: body.m, noise: {NOISE} m}}}}
record: {{file: record.csv}}
estimate:
  diagnose: false
  initial_state: {{body.m: {{displacement: {RELEASE} m}}}}
  unknown: {{body.k.stiffness: {{initial: 780, std: 39, transform: none}}}}
infer: {{samples: 200, seed: 3}}
"""
    (tmp_path / "case.yaml").write_text(case)
    rows = [f"{float(t)!r},{float(y)!r}" for t, y in zip(T, Y)]
    (tmp_path / "record.csv").write_text("\n".join(["time [s],x [m]", *rows]) + "\n")
    run = kf.run(tmp_path / "case.yaml", steps="infer", progress=False)
    found = infer(samples=200, seed=3, y={"x": Y})
    assert found.log_evidence == pytest.approx(run.summary["inference"]["log_evidence"], rel=1e-12)
    assert found.log_evidence_std == pytest.approx(run.summary["inference"]["log_evidence_std"], rel=1e-9)
    assert found.evaluations == run.summary["inference"]["evaluations"]


def test_words_and_pickles(found):
    text = repr(found)
    assert "Posterior: importance samples" in text and "body.k.stiffness = " in text and "ln Z = " in text
    again = pickle.loads(pickle.dumps(found))
    assert np.array_equal(again.values, found.values) and again.bands["x"].coverage == found.bands["x"].coverage


def test_says_what_is_wrong():
    for options, words in [
        (dict(unknown={"body.k.stifness": 1.0}, samples=3, profile=["q"]), "samples: 3"),
        (dict(unknown={"body.k.stifness": 1.0}, samples=3, profile=["q"]), "did you mean 'body.k.stiffness'"),
        (dict(method="gibbs"), "method: there is no 'gibbs' here"),
        (dict(likelihood="comparisons"), "likelihood: there is no 'comparisons' here"),
        (dict(priors={"body.k.stiffness": {"gamma": [1, 2]}}), r"priors\['body.k.stiffness'\]: there is no entry 'gamma'"),
        (dict(priors={"body.k.stiffness": {"uniform": 3}}), "two numbers are needed"),
        (dict(priors={"body.k.stiffness": {"uniform": [1, 2]}}), "excludes the initial value"),
        (dict(priors={"body.k.stiffness": {"normal": [1, 2], "uniform": [1, 2]}}), "a prior has one shape"),
        (dict(priors={"body.k.stiffness": (1, 2)}), "a prior is a dictionary"),
        (dict(priors={"body.k.stiffness": {"normal": ["1 kg", 2]}}), "kg"),
        (dict(samples="many"), "samples: 'many' is given: a whole number is needed"),
        (dict(profile="body.q"), r"profile\[0\]: there is no unknown 'body.q'"),
        (dict(parameters=["body.q"]), r"parameters\[0\]: there is no unknown 'body.q'"),
    ]:
        with pytest.raises(kf.InvalidInput, match=words):
            infer(**options)


def damped(c):
    return kf.Structure().add(kf.lumped("body").mass("m", MASS).spring("k", "ground", "m", 800.0, c))


def compare(**options):
    unknown = {"body.k.stiffness": {"initial": 780.0, "std": 39.0, "transform": "none"}}
    question = dict(
        structures={"light": damped(2.0), "right": damped(DAMPING), "heavy": damped(6.0)},
        unknown={name: unknown for name in ("light", "right", "heavy")},
        sensors={"x": kf.displacement("body.m", noise=NOISE)},
        initial_state={"body.m": {"displacement": RELEASE}},
        samples=200,
        progress=False,
    )
    return kf.compare(t=T, y={"x": Y}, **{**question, **options})


def test_structures_are_ranked_by_their_evidence(found):
    """The right one has the evidence of quadrature; probabilities follow from the evidences alone."""
    ranked = compare()
    assert ranked[0].name == "right" and ranked[0].words == "" and ranked[1].words != ""
    assert ranked[0].log_evidence == pytest.approx(quadrature(700.0, 900.0, normal)[2], abs=0.03)
    evidence = np.array([each.log_evidence for each in ranked])
    weight = np.exp(evidence - evidence.max())
    assert [each.probability for each in ranked] == pytest.approx(weight / weight.sum(), rel=1e-9)
    assert ranked[0].parameters["body.k.stiffness"].value == pytest.approx(found.mean[0], abs=0.3 * found.std[0])
    assert repr(ranked[0]).startswith("right: P = ") and "ln Z = " in repr(ranked[0])


def test_a_comparison_says_what_is_wrong():
    unknown = {name: ["body.k.stiffness"] for name in ("light", "right", "heavy")}
    with pytest.raises(kf.UnknownName, match="did you mean 'right'"):
        compare(unknown={**unknown, "rigth": []})
    with pytest.raises(kf.InvalidInput, match="there are none of 'heavy'"):
        compare(unknown={name: unknown[name] for name in ("light", "right")})
    with pytest.raises(kf.InvalidInput, match=r"candidates\[1\] 'right': unknowns\[0\] 'body.q': there is no parameter"):
        compare(unknown={**unknown, "right": ["body.q"]})
    with pytest.raises(kf.InvalidInput, match="metropolis gives no evidence"):
        compare(method="metropolis")
    with pytest.raises(kf.InvalidInput, match="it is no dictionary"):
        compare(structures=[damped(2.0)])

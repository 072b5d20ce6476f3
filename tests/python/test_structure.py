# SPDX-License-Identifier: Apache-2.0
"""Structures: matrices, laws, parameters, finite elements, modes and frequency responses."""

import copy

import numpy as np
import pytest

import kalfem as kf
from structures import RATE, SENSORS, UNKNOWN, chain, record

M = np.diag([1.0, 1.0, 2.0])
K = 3e4 * np.array([[1.0, -1, 0], [-1, 2, -1], [0, -1, 1]])


def body_on_mount(body, law="k*x + c*v", parameters=dict(k=1e4, c=20.0)):
    return kf.Structure().add(body).connect("mount", "body.1", "ground", law=law, parameters=parameters)


def from_springs():
    body = kf.lumped("body").mass("1", 1.0).mass("2", 1.0).mass("3", 2.0)
    return body.spring("1-2", "1", "2", 3e4).spring("2-3", "2", "3", 3e4)


@pytest.mark.parametrize("kind", ["dense", "fortran", "integer", "csr", "csc"])
def test_matrices_give_the_structure_of_their_springs(kind):
    sparse = pytest.importorskip("scipy.sparse")
    convert = {
        "dense": np.asarray,
        "fortran": np.asfortranarray,
        "integer": lambda a: a.astype(int),
        "csr": sparse.csr_matrix,
        "csc": sparse.csc_matrix,
    }[kind]
    s = body_on_mount(kf.lumped("body", M=convert(M), K=convert(K), names=["1", "2", "3"]))
    expected = kf.modes(body_on_mount(from_springs()))
    assert s.points[:3] == ["body.1", "body.2", "body.3"]
    np.testing.assert_allclose(kf.modes(s).frequencies, expected.frequencies, rtol=1e-12)


def test_names_of_matrices_default_to_numbers():
    assert body_on_mount(kf.lumped("body", M=M, K=K)).points[:3] == ["body.1", "body.2", "body.3"]


def test_matrices_that_do_not_fit_are_named():
    for wrong, words in [
        (dict(M=M, K=K, names=["1"]), "M of 'body' is 3 x 3, with 1 names"),
        (dict(M=M, K=np.triu(K)), "K of 'body' is not symmetric"),
        (dict(K=K), "M of 'body' is missing"),
    ]:
        with pytest.raises(kf.InvalidInput, match=words):
            kf.modes(body_on_mount(kf.lumped("body", **wrong)))
    with pytest.raises(kf.InvalidInput, match="M: 1 dimensions"):
        kf.lumped("body", M=[1.0, 2.0])
    with pytest.raises(kf.InvalidInput, match="K: no array of numbers"):
        kf.lumped("body", M=M, K="stiff")


def cubic(x, v, k, k3, c):
    return k * x + k3 * x**3 + c * v


CUBIC = dict(k=1e4, k3=1e8, c=20.0)


@pytest.mark.parametrize("law", ["cubic", "k*x + k3*x^3 + c*v", cubic])
def test_laws_of_every_kind_give_the_same_estimate(law):
    def mount(law):
        return body_on_mount(from_springs(), law, CUBIC).force("shaker", "body.3")

    t = np.arange(301) / RATE
    f = 200 * np.sin(2 * np.pi * (5 + 20 * t) * t)
    sensors = {"a": kf.acceleration("body.1", noise=0.2)}
    data = kf.simulate(mount("cubic"), t, sensors=sensors, inputs={"shaker": f}, seed=2, progress=False)
    runs = [
        kf.estimate(
            mount(each), t, data, sensors=sensors, inputs={"shaker": f}, unknown={"mount.k3": (5e7, "80 %")}, substeps=4,
            progress=False,
        )
        for each in ("k*x + k3*x**3 + c*v", law)
    ]
    first, second = (run.parameters["mount.k3"] for run in runs)
    assert second.value == pytest.approx(first.value, rel=1e-5)
    assert second.std == pytest.approx(first.std, rel=1e-4)


def test_a_law_in_python_gets_all_points_in_one_call():
    shapes = []

    def law(x, v, k):
        assert x.shape == v.shape == k.shape and x.dtype == float
        shapes.append(len(x))
        return k * x

    s = body_on_mount(from_springs(), law, dict(k=1e4)).force("shaker", "body.3")
    arguments = dict(unknown={"mount.k": 9e3}, filter="ukf", input_delay=0)
    live = kf.Filter(s, RATE, sensors={"a": kf.acceleration("body.1", noise=0.1)}, **arguments)
    live.update([0.0])
    shapes.clear()
    live.predict([1.0])
    assert max(shapes) >= 5 * 13  # five for the tangents, at every sigma point


def test_an_error_in_a_law_in_python_reaches_the_caller():
    def law(x, v, k):
        if np.abs(x).max() > 1e-7:
            raise RuntimeError("too far")
        return k * x

    s = body_on_mount(from_springs(), law, dict(k=1e4)).force("shaker", "body.3")
    t = np.arange(200) / RATE
    with pytest.raises(RuntimeError, match="too far"):
        kf.simulate(s, t, sensors={"a": kf.acceleration("body.1")}, inputs={"shaker": 50 * np.sin(40 * t)}, progress=False)
    with pytest.raises(TypeError, match="another shape"):
        bad = body_on_mount(from_springs(), lambda x, v, k: k[:1], dict(k=1e4)).force("shaker", "body.3")
        kf.simulate(bad, t, sensors={"a": kf.acceleration("body.1")}, inputs={"shaker": np.ones(200)}, progress=False)


def test_laws_that_are_none_are_named():
    with pytest.raises(kf.InvalidInput, match="law: 3 is given"):
        body_on_mount(from_springs(), 3)
    with pytest.raises(kf.InvalidInput, match="mu_k3"):
        chain(parameters=dict(k=1.0, mu_k3=2.0))
    with pytest.raises(kf.InvalidInput, match=r"no law 'bouc-wen' \(did you mean 'bouc_wen'\?\)"):
        chain(law="bouc-wen", parameters={})
    assert "mu_k1" in kf.laws()["saturating"].parameters


def test_parameters_have_names_values_and_copies():
    s = chain()
    assert {"suspension.mu_k1", "wheel.k_w.stiffness", "body.2.mass"} <= set(s.parameters)
    moved = s.at({"suspension.mu_k1": 25.0, "wheel.k_w.stiffness": "30 kN/m"})
    assert moved.value("suspension.mu_k1") == 25.0 and moved.value("wheel.k_w.stiffness") == 3e4
    assert s.value("suspension.mu_k1") == 20.0
    copied = copy.deepcopy(s)
    copied.add(kf.lumped("other").mass("x", 1.0))
    assert "other.x" in copied.points and "other.x" not in s.points
    with pytest.raises(kf.InvalidInput, match="did you mean 'suspension.mu_k1'"):
        s.value("suspension.mu_k9")


def test_contents_and_their_table():
    s = chain()
    (connector,) = s.contents["connectors"]
    assert connector[:4] == ("suspension", "wheel.w", "body.1", "saturating") and connector[4]["mu_k1"] == (20.0, "N")
    assert s.contents["inputs"] == [("road", "m", "wheel.ground")]
    assert s.contents["substructures"][1] == ("body", "lumped", 4)
    assert "suspension" in s._repr_html_()
    assert repr(s) == "Structure(2 bodies, 1 connector, 1 input)"


def test_modes_and_their_damping():
    s = body_on_mount(from_springs())
    found = kf.modes(s)
    k = K + np.diag([1e4, 0, 0])
    values = np.linalg.eigvalsh(np.linalg.inv(np.sqrt(M)) @ k @ np.linalg.inv(np.sqrt(M)))
    np.testing.assert_allclose(found.frequencies, np.sqrt(values) / 2 / np.pi, rtol=1e-10)
    np.testing.assert_allclose(found.shapes.T @ M @ found.shapes, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(
        found.damping, 20 * found["body.1"] ** 2 / (4 * np.pi * found.frequencies), rtol=1e-10
    )
    assert len(kf.modes(s, 2)) == 2
    assert kf.modes(s, substructure="body").frequencies[0] == 0.0
    with pytest.raises(KeyError, match="did you mean 'body.1'"):
        found["body.11"]


def test_frequency_responses():
    s = body_on_mount(from_springs())
    f = np.linspace(0, 60, 40)
    found = kf.frf(s, f, "body.3", {"a1": kf.acceleration("body.1"), "x3": kf.displacement("body.3")})
    k, c = K + np.diag([1e4, 0, 0]), np.diag([20.0, 0, 0])
    for i, w in enumerate(2j * np.pi * f):
        x = np.linalg.solve(k + w * c + w**2 * M, [0, 0, 1])
        assert found["x3"][i] == pytest.approx(x[2], rel=1e-9)
        assert found["a1"][i] == pytest.approx(w**2 * x[0], rel=1e-8, abs=1e-12)
    with pytest.raises(kf.InvalidInput, match="is of a connector"):
        kf.frf(s, f, "body.3", {"f": kf.force("mount")})


def test_mac_of_real_and_complex_shapes():
    shapes = kf.modes(body_on_mount(from_springs())).shapes
    np.testing.assert_allclose(np.diag(kf.mac(shapes, 3 * shapes)), 1.0)
    turned = shapes * np.exp(1j * np.array([0.3, 1.0, 2.0]))
    np.testing.assert_allclose(kf.mac(shapes, turned), kf.mac(shapes, shapes), rtol=1e-12)
    with pytest.raises(kf.InvalidInput, match="b: shapes at 2 points, a has 3"):
        kf.mac(shapes, shapes[:2])


def test_update_finds_the_stiffness_of_the_frequencies():
    true = kf.modes(body_on_mount(from_springs()), substructure="body").frequencies[1:]
    start = from_springs().spring("extra", "1", "3", 1.0)
    s = body_on_mount(start).at({"body.1-2.stiffness": 2.6e4})
    run = kf.update(s, "body", true, 0.01 * true, {"body.1-2.stiffness": None}, above=1.0, progress=False)
    assert run.parameters["body.1-2.stiffness"].value == pytest.approx(3e4, rel=1e-3)
    assert run.verdict.state in ("consistent", "suspicious")
    np.testing.assert_allclose(run["updating/frequencies/after"], true, rtol=1e-3)
    with pytest.raises(kf.InvalidInput, match=r"parameters\['body.1-4.stiffness'\]"):
        kf.update(s, "body", true, 0.1, ["body.1-4.stiffness"], above=1.0)
    with pytest.raises(kf.InvalidInput, match="std: 1 values, frequencies has 2"):
        kf.update(s, "body", true, [0.1], ["body.1-2.stiffness"])


BAR = """*NODE
1, 0, 0, 0
2, 500, 0, 0
3, 1000, 0, 0
*ELEMENT, TYPE=B31, ELSET=bar
1, 1, 2
2, 2, 3
*MATERIAL, NAME=steel
*ELASTIC
210000, 0.3
*DENSITY
7.85e-9
*BEAM SECTION, ELSET=bar, MATERIAL=steel, SECTION=RECT
20, 10
0, 0, 1
*NSET, NSET=tip
3
*NSET, NSET=foot
1
"""


def bar(tmp_path):
    file = tmp_path / "bar.inp"
    file.write_text(BAR)
    return file


def test_a_deck_becomes_a_substructure(tmp_path):
    frame = kf.read_deck(bar(tmp_path), units="mm t s", nodes={"middle": 2}).fix("foot")
    assert frame.name == "bar" and frame.node_positions[2].tolist() == [1.0, 0.0, 0.0]
    reduced = frame.reduce(up_to=2000, boundary=["tip", "middle"])
    s = kf.Structure().add(reduced)
    s.connect("mount", "bar.tip.y", "ground", law="linear", parameters=dict(k=1e3))
    assert "bar.tip.y" in s.points and "bar.steel.youngs_modulus" in s.parameters
    assert s.value("bar.steel.youngs_modulus") == pytest.approx(210e9)
    assert reduced.natural_frequencies(2)[0] > 1.0
    with pytest.raises(kf.InvalidInput, match="node 'tap'"):
        kf.modes(kf.Structure().add(frame.reduce(boundary=["tap"])))
    with pytest.raises(kf.InvalidInput, match="'furlong'"):
        kf.read_deck(bar(tmp_path), units="furlong t s")


LUMPED = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,.5,0.,0.
GRID,3,,1.,0.,0.
CBAR,1,1,1,2,0.,1.,0.
CBAR,2,1,2,3,0.,1.,0.
PBAR,1,1,4.-4,1.3333-8,1.3333-8,2.25-8
MAT1,1,2.1+11,,.3,7850.
SPC1,1,123456,1
ENDDATA
"""


def test_rotations_without_mass_are_refused_or_given_mass(tmp_path):
    (tmp_path / "bar.bdf").write_text(LUMPED)

    def deflection(**mass):
        s = kf.Structure().add(kf.read_deck(tmp_path / "bar.bdf", nodes={"tip": 3}, **mass)).force("push", "bar.tip.z")
        t = np.arange(2001) / 2000.0
        sensors = {"tip": kf.displacement("bar.tip.z")}
        return kf.simulate(s, t, sensors=sensors, inputs={"push": np.ones_like(t)}, progress=False)["tip"].mean()

    full = kf.Structure().add(kf.read_deck(tmp_path / "bar.bdf"))
    assert kf.modes(full).frequencies[0] == pytest.approx(kf.modes(full, 1).frequencies[0])  # of those with mass
    with pytest.raises(kf.InvalidInput, match="have no mass"):
        deflection()
    assert deflection(mass_matrix="consistent") == pytest.approx(1 / (3 * 2.1e11 * 1.3333e-8), rel=0.05)  # F L^3 / 3 E I
    with pytest.raises(kf.InvalidInput, match="did you mean 'lumped'"):
        deflection(mass_matrix="lumpd")


def test_a_gauge_measures_the_strain_of_its_element(tmp_path):
    frame = kf.read_deck(bar(tmp_path), units="mm t s").fix("foot")
    s = kf.Structure().add(frame.gauge("g", 2).rayleigh_damping(0, 1e-4)).force("pull", "bar.tip.x")
    t = np.arange(101) / RATE
    pull = 1000 * np.sin(np.pi * t / t[-1]) ** 4  # slow beside the first frequency along the bar, 1.2 kHz
    strain = kf.strain("bar.g", noise="1 um/m")
    assert strain.unit == "m/m" and strain.noise == pytest.approx(1e-6)
    data = kf.simulate(s, t, sensors={"g": kf.strain("bar.g")}, inputs={"pull": pull}, progress=False)
    assert data["g"].max() == pytest.approx(1000 / (210e9 * 20e-3 * 10e-3), rel=1e-3)  # F / E A
    with pytest.raises(kf.InvalidInput, match="strain gauge 'g' stands on element 7"):
        kf.modes(kf.Structure().add(frame.gauge("g", 7)))
    with pytest.raises(kf.InvalidInput, match="surface is 'outside'"):
        kf.modes(kf.Structure().add(frame.gauge("g", 2, surface="outside")))


def test_an_estimate_on_a_structure_from_matrices():
    t, u, data = record()
    s = kf.Structure().add(kf.lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4))
    n = 4
    k = 3e4 * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    k[0, 0] = k[-1, -1] = 3e4
    c = 0.5 * (np.eye(n) * 0)
    s.add(kf.lumped("body", M=np.eye(n), C=c, K=k).modal_damping(0.01))
    s.connect("suspension", "wheel.w", "body.1", "saturating", dict(k=5e3, mu_k1=20.0, mu_k2=2e-3, c=10.0, mu_c1=10.0, mu_c2=0.05))
    s.base_displacement("road", "wheel.ground")
    arguments = dict(sensors=SENSORS, inputs={"road": u}, unknown=UNKNOWN, substeps=4, progress=False)
    expected = kf.estimate(chain(), t, data, **arguments).parameters["suspension.mu_k1"].value
    assert kf.estimate(s, t, data, **arguments).parameters["suspension.mu_k1"].value == pytest.approx(expected, rel=1e-6)


def test_wrong_types_are_named_by_their_arguments():
    body = kf.lumped("body")
    for call, words in [
        (lambda: body.mass("1", "heavy"), r"mass\(\): kilograms: 'heavy' is given: a number is needed"),
        (lambda: body.mass(1, 2.0), r"mass\(\): dof: 1 is given: a text is needed"),
        (lambda: body.mass("1"), r"mass\(\): 'kilograms' is missing"),
        (lambda: body.mass("1", kilogram=2.0), r"no argument 'kilogram' \(did you mean 'kilograms'\?\)"),
        (lambda: kf.chain("c", 2.5, 1.0, 1e4), r"chain\(\): masses: 2.5 is given: a whole number is needed"),
        (lambda: kf.low_pass("fast"), r"low_pass\(\): cutoff: 'fast' is given"),
        (lambda: chain().value(3), r"value\(\): parameter: 3 is given"),
    ]:
        with pytest.raises(kf.InvalidInput, match=words):
            call()


def test_two_inputs_of_one_name_are_refused_when_given():
    s = chain()
    for again in (lambda: s.force("road", "body.1"), lambda: s.base_velocity("road", "wheel.ground")):
        with pytest.raises(kf.InvalidInput, match="there is an input 'road' already"):
            again()


def test_a_geophone_moves_the_ground_as_its_displacement_does():
    t = np.arange(2001) / 500
    w = 2 * np.pi * 3
    sensors = {"a": kf.acceleration("body.3")}

    def driven(add, samples):
        s = kf.Structure().add(kf.lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4, 20.0))
        s.add(kf.chain("body", 3, mass=1.0, stiffness=3e4, damping=10.0))
        s.connect("mount", "wheel.w", "body.1", law="linear", parameters=dict(k=1e4, c=20.0))
        getattr(s, add)("road", "wheel.ground")
        return np.asarray(kf.simulate(s, t, sensors=sensors, inputs={"road": samples}, progress=False)["a"])

    displacement = 1e-3 * np.sin(w * t) * np.sin(np.pi * t / 4) ** 2
    velocity = np.gradient(displacement, t, edge_order=2)
    expected, found = driven("base_displacement", displacement), driven("base_velocity", velocity + 0.02)
    assert np.std(found - expected) < 0.01 * np.std(expected)
    s = chain()
    s = kf.Structure().add(kf.lumped("m").mass("1", 1.0).spring("k", "ground", "1", 1e3)).base_velocity("g", "m.ground")
    assert s.contents["inputs"] == [("g", "m/s", "m.ground")]
    with pytest.raises(kf.InvalidInput, match="would drift"):
        kf.Filter(s, 100.0, sensors={"a": kf.acceleration("m.1", noise=0.1)})


def test_factors_of_elements_and_of_matrices_are_updated(tmp_path):
    def frame(value):
        return kf.read_deck(bar(tmp_path), units="mm t s", name="b").fix("foot").factor("part", ["1"], value=value)

    measured = frame(0.8).natural_frequencies(3)
    run = kf.update(kf.Structure().add(frame(1.0)), "b", measured, 1e-4 * measured, ["b.part.factor"], progress=False)
    assert run.parameters["b.part.factor"].value == pytest.approx(0.8, rel=1e-3)
    assert run.summary["updating"]["before"]["groups"] == [["b.part.factor"]]
    with pytest.raises(kf.InvalidInput, match="there are no elements 'part'"):
        frame(1.0).factor("other", ["part"])

    def write(name, matrix):
        rows, columns = matrix.shape
        values = "\n".join(repr(float(each)) for each in matrix.T.ravel())
        (tmp_path / f"{name}.mtx").write_text(f"%%MatrixMarket matrix array real general\n{rows} {columns}\n{values}\n")

    K0, K1 = np.diag([3000.0, 2000.0]), np.array([[1.0, -1.0], [-1.0, 1.0]]) * 1000
    write("K0", K0), write("M0", np.eye(2)), write("K1", K1)
    (tmp_path / "rows.dof").write_text("1.1\n2.1\n")
    files = [tmp_path / "K0.mtx", tmp_path / "M0.mtx"]

    def pair(**more):
        factors = {"link": {"stiffness": tmp_path / "K1.mtx", **more}}
        return kf.read_matrices(files, dofs=tmp_path / "rows.dof", name="m", factors=factors)

    omega = np.sqrt(np.linalg.eigvalsh(K0 + 1.5 * K1)) / (2 * np.pi)
    assert pair(value=1.5).natural_frequencies(2) == pytest.approx(omega)
    run = kf.update(kf.Structure().add(pair()), "m", omega, 1e-4 * omega, ["m.link.factor"], progress=False)
    assert run.parameters["m.link.factor"].value == pytest.approx(1.5, rel=1e-3)
    with pytest.raises(kf.InvalidInput, match="'stifness'"):
        pair(stifness=1)

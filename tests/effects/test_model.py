"""A model gives what a hand calculation gives; its file keeps every digit and says what is wrong with one."""

import re
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_model import (
    ArmModel,
    FittedTerm,
    JointModel,
    Provenance,
    load_model,
    save_model,
    simple_model,
)
from friction_audit.effects.registry import term_of, terms
from friction_audit.errors import AnalysisError, InputError
from tests.effects.joint_data_by_hand import typical_term

JOINT = simple_model(inertia_kg_m2=0.3, coulomb_nm=0.4, viscous_nms_per_rad=0.1)
HEAD = 'schema = "friction-audit/model/1"\n'


def values_of(term: Effect) -> st.SearchStrategy[FittedTerm]:
    finite = (st.floats(max(one.lower, -1e300), min(one.upper, 1e300), allow_nan=False) for one in term.parameters)
    return st.tuples(*finite).map(lambda values: FittedTerm(term.name, values))


text = st.text(st.characters(exclude_categories=["Cs"]))
origin = st.builds(Provenance, method=text, log=text, sha256=text, cycles=st.integers(0, 2**53))
chosen_terms = st.sets(st.sampled_from(terms()[1:])).flatmap(
    lambda chosen: st.tuples(*(values_of(term) for term in sorted(chosen, key=lambda term: term.name)))
)
joint = chosen_terms.flatmap(
    lambda chosen: st.builds(
        JointModel,
        inertia_kg_m2=st.floats(-1e300, 1e300),
        terms=st.just(chosen),
        provenance=origin,
        held=st.sets(st.sampled_from([term.name for term in chosen])).map(sorted).map(tuple) if chosen else st.just(()),
    )
)
arm = st.lists(st.tuples(text, st.none() | joint), min_size=1, max_size=3).map(
    lambda pairs: ArmModel(names=tuple(name for name, _ in pairs), joints=tuple(joint for _, joint in pairs))
)


@given(arm)
def test_what_is_saved_is_loaded(tmp_path_factory: pytest.TempPathFactory, arm: ArmModel) -> None:
    path = tmp_path_factory.mktemp("model") / "model.toml"
    save_model(arm, path)
    assert load_model(path) == arm


def test_the_file_as_people_see_it(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    known = replace(JOINT, provenance=Provenance(method="energy", log="a.csv", sha256="00", cycles=7))
    save_model(ArmModel(names=("joint1", "joint2"), joints=(known, None)), path)
    lines = path.read_text().splitlines()
    assert lines[0] == 'schema = "friction-audit/model/1"'
    assert lines[3:6] == ["[[joint]]", 'name = "joint1"', "inertia_kg_m2 = 0.3"]
    assert "[joint.terms.coulomb]  # Coulomb friction" in lines
    assert "coulomb_nm = 0.4  # N m, friction at any speed" in lines
    assert lines[-2:] == ["[[joint]]", 'name = "joint2"']


GRAVITY = term_of("gravity_error")
SOFT = {"compliance_rad_per_nm": 1e-3, "spring_nm_per_rad": 900.0, "soft_nm": 0.1}
JOINT_TEXT = '[[joint]]\nname = "a"\ninertia_kg_m2 = 1.0\n'


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("schema =", "is no TOML: Invalid value"),
        ("", "schema is None; expected 'friction-audit/model/1'"),
        ('schema = "friction-audit/model/9"', "schema is 'friction-audit/model/9'; expected"),
        (HEAD, r"no \[\[joint\]\] table"),
        (HEAD + "joint = [1]", r"no \[\[joint\]\] table"),
        (HEAD + "[[joint]]\n[joint.terms.offset]", "joint 1: name, inertia_kg_m2 missing.*offset: offset_nm missing"),
        (HEAD + '[[joint]]\nname = "a"\ninertia_kg_m2 = "1"', "joint 1: inertia_kg_m2 is no number"),
        (HEAD + '[[joint]]\nname = "a"\ninertia_kg_m2 = nan', "joint 1: inertia_kg_m2 = nan; expected a number"),
        (HEAD + '[[joint]]\nname = "a"\ninertia = 1', "'inertia' is no key; did you mean inertia_kg_m2"),
        (HEAD + JOINT_TEXT + "held = [1]", "held is no list of names"),
        (HEAD + JOINT_TEXT + 'held = ["stribeck"]\nterms.coulomb.coulomb_nm = 1', "held: stribeck; .* terms: coulomb"),
        (HEAD + JOINT_TEXT + "terms = 1", "joint 1: terms is no table"),
        (HEAD + JOINT_TEXT + "provenance.cycles = 1.5", "joint 1: provenance: cycles is no whole number"),
        (HEAD + JOINT_TEXT + "provenance.log = 1", "joint 1: provenance: log is no text"),
        (HEAD + JOINT_TEXT + "terms.coulom.coulomb_nm = 1", "'coulom' is no term, expected.*; did you mean coulomb"),
        (HEAD + JOINT_TEXT + "terms.coulomb = 1", "joint 1: coulomb is no table"),
        (HEAD + JOINT_TEXT + "terms.coulomb.coulomb_nm = true", "coulomb: coulomb_nm is no number"),
        (HEAD + JOINT_TEXT + "terms.coulomb.coulomb_nm = -1", "joint 1: term coulomb: coulomb_nm = -1; expected"),
        (HEAD + JOINT_TEXT + "terms.offset.offset_nm = nan", "offset_nm = nan"),
        (HEAD + JOINT_TEXT + "terms.coulomb.coulomb = 1", "did you mean coulomb_nm.*coulomb_nm missing"),
        (HEAD + JOINT_TEXT + "terms.stribeck.stribeck_exponent = 1", "excess_nm, stribeck_speed_rad_s missing"),
        ("color = 1\n" + HEAD + JOINT_TEXT, "the file: 'color' is no key"),
        pytest.param(HEAD + '[[joint]]\nname = "a"\ninertia_kg_m2 = 1' + "0" * 400, "no number", id="10^400"),
        pytest.param(HEAD + JOINT_TEXT + "terms.coulomb.coulomb_nm = 1" + "0" * 400, "no number", id="10^400 N m"),
        pytest.param("schema = " + "1" * 5000, "is no TOML.*digits", id="a number of 5000 digits"),
        pytest.param("schema = " + "[" * 20000 + "]" * 20000, "nested too deeply", id="deep arrays"),
        pytest.param(".".join("k" * 20000) + " = 1", "dots in line 1", id="a key of many parts"),
        pytest.param(HEAD + JOINT_TEXT + "".join(f"k{i} = 1\n" for i in range(50_000)), "'k0' is no key", id="keys"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "model.toml"
    path.write_text(content)
    with pytest.raises(InputError, match=message) as caught:
        load_model(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_a_file_that_is_no_text_or_not_there(tmp_path: Path) -> None:
    (tmp_path / "model.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="is no TOML: 'utf-8' codec"):
        load_model(tmp_path / "model.toml")
    with pytest.raises(InputError, match="cannot be read: No such file"):
        load_model(tmp_path / "none.toml")


def test_the_page_shows_a_file_that_loads_and_every_term(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "model.md").read_text()
    path = tmp_path / "model.toml"
    path.write_text(page.split("```toml\n")[1].split("```")[0])
    origin = Provenance(method="energy", log="monday.parquet", cycles=12)
    assert load_model(path) == ArmModel(names=("joint1", "joint2"), joints=(replace(JOINT, provenance=origin), None))
    for term in terms()[1:]:
        assert f"| `{term.name}` | {as_listed([parameter.name for parameter in term.parameters])} |" in page


def as_listed(names: list[str]) -> str:
    """Names side by side, those that differ by a number only as a series."""
    groups = [list(group) for _, group in groupby(names, key=lambda name: re.sub(r"\d+_", "#_", name))]
    return ", ".join(f"`{group[0]}`" if len(group) == 1 else f"`{group[0]}` to `{group[-1]}`" for group in groups)


@pytest.mark.parametrize(
    ("values", "whole"),
    [
        (SOFT, ("joint_elasticity", (1e-3, 900.0, 0.1, 0.05, 1.0))),
        ({"backlash_share": 1.0, "gap_rad": 1e-3, "contact_hz": 40.0}, ("backlash", (1.0, 1e-3, 40.0, 0.2, 1.0))),
        (  # of version 0.1.0
            {p.name: float(k) for k, p in enumerate((*GRAVITY.coefficients[:8], *GRAVITY.nonlinear))},
            ("gravity_error", (*range(8), *[0] * 8, 8)),
        ),
    ],
)
def test_a_file_without_newer_numbers_means_what_it_meant(
    tmp_path: Path, values: dict[str, float], whole: tuple[str, tuple[float, ...]]
) -> None:
    name, numbers = whole
    path = tmp_path / "model.toml"
    lines = "".join(f"{key} = {value!r}\n" for key, value in values.items())
    path.write_text(f"{HEAD}{JOINT_TEXT}[joint.terms.{name}]\n{lines}")
    (joint,) = load_model(path).joints
    assert joint is not None
    assert joint.values(name) == numbers
    save_model(load_model(path), path, overwrite=True)
    assert "far_share" not in path.read_text()


# Terms and their sum.


SHAPES = {term.name: typical_term(term).values[len(term.coefficients) :] for term in terms()}
T, DQ = np.arange(401, dtype=np.float64) * 1e-3, np.sin(np.linspace(0.0, 20.0, 401))
KNOWN: dict[str, Any] = {"load": 2.0 + 0.0 * T, "temperature": 25.0 + T, "rest": 0.3 * np.sign(DQ) + 0.1 * DQ}
MOTION = Motion(t=T, q=np.cumsum(DQ) * 1e-3, dq=DQ, ddq=np.gradient(DQ, 1e-3), **KNOWN)


@pytest.mark.parametrize("term", terms(), ids=lambda term: term.name)
def test_friction_never_pushes(term: Effect) -> None:
    if term.friction and all(parameter.lower >= 0.0 for parameter in term.coefficients):
        values = tuple(0.3 for _ in term.coefficients) + SHAPES[term.name]
        assert np.all(term.torque(MOTION, values) * DQ >= 0.0)


@pytest.mark.parametrize("term", [term for term in terms() if term.axis == "speed"], ids=lambda term: term.name)
def test_a_term_of_the_velocity_alone_sees_nothing_else(term: Effect) -> None:
    values = tuple(0.3 for _ in term.coefficients) + SHAPES[term.name]
    others = {name: 3.0 * getattr(MOTION, name) - 1.0 for name in ("t", "q", "ddq", *KNOWN)}
    assert np.array_equal(term.torque(MOTION, values), term.torque(replace(MOTION, **others), values))


def test_torque_and_friction_of_a_model_by_hand() -> None:
    still = np.zeros(2)
    motion = Motion(t=np.array([0.0, 1.0]), q=still, dq=np.array([2.0, -2.0]), ddq=np.array([1.0, 1.0]))
    model = simple_model(inertia_kg_m2=0.5, coulomb_nm=0.3, viscous_nms_per_rad=0.1)
    model = replace(model, terms=(*model.terms, FittedTerm("offset", (0.05,))))
    assert model.torque(motion) == pytest.approx([1.05, 0.05])
    # What is left of the inertia where a model of the links took too much of it.
    assert JointModel(inertia_kg_m2=-0.1).torque(motion) == pytest.approx([-0.1, -0.1])


def test_a_term_twice_and_inertia_among_the_terms_are_refused() -> None:
    with pytest.raises(AnalysisError, match="term offset stands twice"):
        JointModel(inertia_kg_m2=1.0, terms=(FittedTerm("offset", (1.0,)), FittedTerm("offset", (2.0,))))
    with pytest.raises(AnalysisError, match="expected it as inertia_kg_m2"):
        JointModel(inertia_kg_m2=1.0, terms=(FittedTerm("inertia", (1.0,)),))

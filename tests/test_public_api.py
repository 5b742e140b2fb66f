"""The names at the top of the package: few, told of, quick to import, typed as the settings behind them."""

import ast
import importlib
import inspect
import re
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.text import Text

import friction_audit
from friction_audit import api as options
from friction_audit.api import replay_settings
from friction_audit.compensation.law import EnergyCompensator
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.errors import UsageError
from friction_audit.friction.settings import FrictionSettings
from friction_audit.io.readers.reader import OF_THE_COMMAND, ReadOptions
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import Diagnosis, Estimate
from friction_audit.preprocessing.interaction import Caution
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings
from tests.reporting.conftest import build_estimate
from tests.reporting.test_files import TABLES
from tests.test_docs import DOCS

MOST_NAMES = 11  # the eleventh is plot


def names_of(*settings: Any) -> set[str]:
    return {f.name for one in settings for f in fields(one)}


@pytest.fixture(scope="module")
def log() -> JointLog:
    return build_estimate(1, count=24, rate=200.0).log


@pytest.fixture(scope="module")
def estimated(log: JointLog) -> Estimate:
    return friction_audit.estimate_log(log)


@pytest.fixture(scope="module")
def diagnosed(estimated: Estimate) -> Diagnosis:
    return friction_audit.diagnose_log(estimated)


def test_names_are_few_documented_and_typed() -> None:
    names = friction_audit.__all__
    assert len(names) <= MOST_NAMES
    assert set(names) <= set(dir(friction_audit))
    page = (DOCS / "python.md").read_text()
    for name in names:
        assert len(inspect.getdoc(getattr(friction_audit, name)) or "") > 20, name
        assert f"`{name}" in page, name
    tree = ast.parse(Path(friction_audit.__file__).with_suffix(".pyi").read_text())
    imported = {alias.asname for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert imported == set(names)


def test_options_are_the_settings() -> None:
    assert set(options.ReadingOptions.__annotations__) == names_of(ReadOptions) - {*OF_THE_COMMAND}
    assert set(options.ReplayOptions.__annotations__) == names_of(ReplaySettings)
    assert set(options.DiagnosisOptions.__annotations__) == names_of(DiagnosisSettings)
    steps = (TorqueSettings, CycleSettings, FrictionSettings)
    assert sum(len(names_of(one)) for one in steps) == len(names_of(*steps))
    assert set(options.EstimateOptions.__annotations__) == names_of(*steps) | {"joints", "t_start_s", "t_stop_s"}


def test_options_reach_the_steps(log: JointLog) -> None:
    found = friction_audit.estimate_log(log, joints=1, t_stop_s=20.0, estimator="paper", cutoff_hz=15.0, drive="hand")
    settings = found.settings
    assert (found.log.duration_s < 20.0, settings.joints, settings.torque.drive) == (True, (1,), "hand")
    assert (settings.friction.estimator, settings.cycles.cutoff_hz) == ("paper", 15.0)


def test_a_replay_counts_the_cycles_that_the_hand_ended(estimated: Estimate) -> None:
    by_hand = CycleSettings(cycles_from="hand", minimum_path_rad=0.3)
    hand = replace(estimated, settings=replace(estimated.settings, cycles=by_hand))
    assert replay_settings(estimated, {}) == ReplaySettings()
    compensator = replay_settings(hand, {}).compensator
    assert isinstance(compensator, EnergyCompensator)
    assert compensator.minimum_path_rad == 0.3


@pytest.mark.parametrize(
    ("call", "wrong", "message"),
    [
        ("estimate_log", {"dirve": "hand"}, "estimate_log: no option dirve; .* did you mean drive"),
        ("replay_log", {"asume": "same-motion"}, "did you mean assume"),
        ("replay_log", {"assume": "wrong"}, "--assume wrong"),
        ("diagnose_log", {"sed": 1}, "did you mean seed"),
        ("diagnose_log", {"candidates": ("friktion",)}, "candidates: friktion: expected some of stribeck, "),
        *(("diagnose_log", {"min_effect_nm": one}, "expected a torque of zero or more") for one in (-0.1, np.nan)),
        ("estimate_log", {"drive": "hnad"}, "--drive hnad: expected one of"),
        ("to_frames", {}, "to_frames: JointLog: expected the result of estimate_log"),
        ("plot", {}, "plot: JointLog: expected the result of estimate_log"),
    ],
)
def test_what_is_wrong_is_refused_with_what_is_meant(call: str, wrong: Any, message: str, log: JointLog) -> None:
    with pytest.raises(UsageError, match=message):
        getattr(friction_audit, call)(log, **wrong)


def test_a_name_that_is_none_is_refused() -> None:
    with pytest.raises(AttributeError, match="no attribute 'estimat_log'"):
        _ = friction_audit.estimat_log  # type: ignore[attr-defined]
    with pytest.raises(UsageError, match="jont: no such scenario"):
        friction_audit.simulate_log("jont")
    with pytest.raises(UsageError, match=r"run.docx: ending .docx: expected one of .html, .pdf, .md, .json"):
        friction_audit.report_log(None, "run.docx")  # type: ignore[arg-type]
    for call in ("estimate_log", "replay_log", "diagnose_log", "report_log"):
        with pytest.raises(UsageError, match=r"str: expected a log, .* with read_log first"):
            getattr(friction_audit, call)("run.mcap")


def test_the_names_below_the_top_are_where_their_page_says() -> None:
    named = re.findall(r"^\| `(friction_audit[.\w]*)\.(\w+)", (DOCS / "python.md").read_text(), re.MULTILINE)
    assert len(named) > 2
    assert all(hasattr(importlib.import_module(module), name) for module, name in named)


def test_results_become_frames(log: JointLog, estimated: Estimate, tmp_path: Path) -> None:
    frames = friction_audit.to_frames(estimated)
    assert tuple(frames) == TABLES[:4]
    assert frames["coefficients"]["coulomb_nm"][0] == estimated.friction.joints[0].coulomb.value
    assert len(frames["interaction"]) == len(log.t)
    assert tuple(friction_audit.to_frames(friction_audit.replay_log(estimated))) == TABLES[4:7]
    report = friction_audit.report_log(estimated, tmp_path / "run.md")
    assert tuple(friction_audit.to_frames(report)) == TABLES
    assert (tmp_path / "run.md").read_text().startswith("# Joint friction")
    with pytest.raises(UsageError, match=r"run.md: exists already"):
        friction_audit.report_log(estimated, tmp_path / "run.md")


def test_a_residual_lies_in_the_cycle_that_it_names(estimated: Estimate, diagnosed: Diagnosis) -> None:
    cycles = friction_audit.to_frames(estimated)["cycles"]
    residual = friction_audit.to_frames(diagnosed)["residual"]
    both = residual.merge(cycles, on=["joint", "cycle"])
    assert len(both) == len(residual) > 100
    assert both["time_s"].between(both["start_s"], both["stop_s"]).all()


def test_a_log_is_simulated_written_and_read(tmp_path: Path) -> None:
    effect = "torque_bias:torque_nm=0.1"
    made = friction_audit.simulate_log("joint", seed=1, duration_s=5.0, effects=[effect])
    assert len(repr(made)) < 200
    with pytest.raises(UsageError, match=r"Simulation: expected a log, .* pass its \.log"):
        friction_audit.estimate_log(made)  # type: ignore[arg-type]
    friction_audit.write_log(made.log, tmp_path / "run.csv")
    with pytest.raises(UsageError, match="exists already"):
        friction_audit.write_log(made.log, tmp_path / "run.csv")
    again = friction_audit.read_log(tmp_path / "run.csv")
    assert set(again.q[:, 0]) <= set(made.log.q[:, 0])
    assert again.duration_s == pytest.approx(made.log.duration_s, abs=0.01)
    alone = friction_audit.simulate_log("joint", seed=1, duration_s=5.0, effects=effect)
    assert (alone.truth.motion.friction_nm == made.truth.motion.friction_nm).all()
    assert alone.truth.settings == made.truth.settings


def test_a_result_shows_its_numbers_in_a_line_a_joint(log: JointLog, estimated: Estimate, diagnosed: Diagnosis) -> None:
    joint = estimated.friction.joints[0]
    head, line = repr(estimated).splitlines()
    assert log.source.path in head
    for number in (joint.coulomb.value, joint.coulomb.low, joint.viscous.value, joint.viscous.high):
        assert f"{number:.4g}" in line
    assert diagnosed.joints[0].verdict in repr(diagnosed).splitlines()[1]
    assert "dissipation removed" in repr(friction_audit.replay_log(estimated)).splitlines()[1]
    assert f"{len(log.joint_names)} joints" in repr(log)
    assert str(Caution("hardly_moved", numbers={"travel": 0.001})) == "hardly moved: by 0.001 rad; move back and forth"


def test_a_result_is_drawn_into_axes_in_the_style_of_the_user(estimated: Estimate, diagnosed: Diagnosis) -> None:
    replay = friction_audit.replay_log(estimated)
    with rc_context({"axes.titlesize": 19.0}):
        for result, label in ((estimated, "Velocity"), (replay, "Velocity"), (diagnosed, "Residual")):
            axes = Figure().subplots()
            assert result.plot(joint=1, ax=axes) is axes
            assert "joint1</td>" in result._repr_html_()
            assert axes.get_xlabel().startswith(label)
            assert axes.has_data()
            titles = [one for one in axes.findobj(Text) if one.get_text() == axes.get_title("left")]
            assert {one.get_fontsize() for one in titles} == {19.0}
    assert isinstance(friction_audit.plot(estimated, "energy"), Figure)
    for wrong, message in (
        ({"kind": "ladder"}, "plot: ladder: expected one of coefficients, velocity-torque"),
        ({"kind": "energy", "ax": Figure().subplots()}, "plot: energy: into axes goes velocity-torque alone"),
        ({"joint": 9, "ax": Figure().subplots()}, "joint 9: not in this result"),
    ):
        with pytest.raises(UsageError, match=message):
            friction_audit.plot(estimated, **wrong)

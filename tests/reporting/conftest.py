"""A result made by hand: minimum-jerk strokes back and forth, friction and inertia known, every cycle a stroke."""

from collections.abc import Callable, Iterator
from dataclasses import fields
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from friction_audit.friction.history import (
    UNDETERMINED,
    Coefficient,
    CoefficientHistory,
    FrictionHistory,
    JointFriction,
    TorqueRegression,
)
from friction_audit.joint_log import Finding, Float, JointLog, Source
from friction_audit.pipeline import AuditSettings, Estimate
from friction_audit.preprocessing.energy_cycles import EnergyCycles, EnergySums
from friction_audit.preprocessing.interaction import Caution, Interaction, TorqueChoice
from tests.opened_page import Opened, open_in

if TYPE_CHECKING:
    from playwright.sync_api import Browser

COULOMB = (0.245, 0.152, 0.183, 0.359, 0.267, 0.166, 0.211)
VISCOUS = (0.4, 0.3, 0.25, 0.5, 0.13, 0.11, 0.12)
INERTIA = 0.1
STILL = 2
"""Column of the joint that stands still when there are seven."""
REJECTED = 3
"""Row of the cycle left out of each joint."""

EstimateFactory = Callable[..., Estimate]


def stroke(duration: float, amplitude: float, rate: float) -> tuple[Float, Float, Float]:
    """Return q, dq, ddq of a minimum-jerk stroke of ``amplitude`` rad."""
    s = np.arange(round(duration * rate)) / (duration * rate)
    q = amplitude * (10 * s**3 - 15 * s**4 + 6 * s**5)
    dq = amplitude * (30 * s**2 - 60 * s**3 + 30 * s**4) / duration
    ddq = amplitude * (60 * s - 180 * s**2 + 120 * s**3) / duration**2
    return q, dq, ddq


def strokes(count: int, rate: float, rng: np.random.Generator) -> tuple[Float, Float, Float, list[int]]:
    """Return q, dq, ddq and the borders of strokes back and forth of varied speed."""
    pieces, borders, place = [], [0], 0.0
    for row in range(count):
        direction = 1.0 if row % 2 == 0 else -1.0
        q, dq, ddq = stroke(rng.uniform(1.0, 2.4), direction * 0.9, rate)
        pieces.append((place + q, dq, ddq))
        place += direction * 0.9
        borders.append(borders[-1] + len(q))
    q, dq, ddq = (np.concatenate(column) for column in zip(*pieces, strict=True))
    return q, dq, ddq, borders


def energy_sums(work: Float) -> EnergySums:
    """Return sums of which only the work matters to a report."""
    columns = dict.fromkeys((f.name for f in fields(EnergySums)), np.zeros_like(work))
    return EnergySums(**columns | {"work_j": work})


def cycle_table(t: Float, dq: Float, torque: Float, borders: list[list[int]]) -> EnergyCycles:
    """Return the cycles between known borders, with rectangle sums (the noise is larger than the difference)."""
    last_sample, step = len(t) - 1, t[1] - t[0]
    pieces = [(column, a, b) for column, edges in enumerate(borders) for a, b in pairwise(edges)]
    joint, start, stop = (np.array(column, dtype=np.int64) for column in zip(*pieces, strict=True))
    work = np.array([np.sum(torque[a:b, j] * dq[a:b, j]) * step for j, a, b in pieces])
    row_of_joint = np.concatenate([np.arange(len(edges[1:])) for edges in borders])
    stop = np.minimum(stop, last_sample)
    return EnergyCycles(
        joint=joint,
        start=start,
        stop=stop,
        start_s=t[start],
        stop_s=t[stop],
        peak_speed_rad_s=np.array([np.abs(dq[a:b, j]).max() for j, a, b in pieces]),
        sums=energy_sums(work),
        parts=energy_sums(work[:, None]),
        open=np.ones(len(joint), dtype=np.bool_),
        reason=np.where(row_of_joint == REJECTED, 1, 0),
        initiation=np.full(len(borders), 0.2),
        termination=np.full(len(borders), 0.05),
        fastest=np.full(len(borders), 1.0),
        speed_unit="rad/s",
        standstill_rad_s=np.full(len(borders), 0.05),
        moving_s=np.array([15.0 if edges else 0.0 for edges in borders]),
        peak_power_w=np.full(len(borders), 1.0),
    )


def history(cycles: EnergyCycles, coulomb: float, viscous: float, rng: np.random.Generator) -> CoefficientHistory:
    """Return coefficients around the truth; the first window is too short to give one."""
    kept = cycles.rows(cycles.reason == 0)
    rows = len(kept.joint)
    columns: dict[str, Float] = {}
    for name, truth in (("coulomb{}_nm", coulomb), ("viscous{}_nms_per_rad", viscous)):
        value = truth * (1 + 0.03 * rng.standard_normal(rows))
        value[:1] = np.nan
        columns |= {
            name.format(""): value,
            name.format("_low"): value - 0.05 * truth,
            name.format("_high"): value + 0.05 * truth,
        }
    return CoefficientHistory(
        cycle=np.asarray(np.flatnonzero(cycles.reason == 0) + 1, dtype=np.float64),
        start_s=kept.start_s,
        stop_s=kept.stop_s,
        net_energy_j=np.cumsum(kept.dissipated_j),
        dissipated_j=kept.dissipated_j,
        path_rad=kept.sums.rectified_path_rad,
        square_speed_rad2_s=kept.sums.square_speed_rad2_s,
        **columns,
    )


def joint_friction(column: int, name: str, cycles: EnergyCycles, rng: np.random.Generator) -> JointFriction:
    """Return the friction of one joint: its truth, or a reason where it stood still."""
    own, nan = cycles.of_joint(column), float("nan")
    still, coulomb, viscous = len(own.joint) == 0, COULOMB[column], VISCOUS[column]
    near = [Coefficient(value=v, low=0.97 * v, high=1.03 * v) for v in (coulomb, viscous)]
    regression = TorqueRegression(
        coulomb=near[0],
        viscous=near[1],
        offset_nm=0.01,
        inertia=Coefficient(value=INERTIA, low=0.95 * INERTIA, high=1.05 * INERTIA),
        residual_rms_nm=0.05,
        samples=9000,
    )
    return JointFriction(
        window=20,
        joint=column + 1,
        name=name,
        model="combined",
        cycles=int((own.reason == 0).sum()),
        rejected_cycles=int((own.reason != 0).sum()),
        moving_s=0.0 if still else 15.0,
        coulomb=UNDETERMINED if still else near[0],
        viscous=UNDETERMINED if still else near[1],
        offset_nm=nan,
        gravity_error_nm=nan,
        condition_number=nan if still else 12.5,
        correlation=nan if still else -0.93,
        regression=None if still else regression,
        history=history(own, coulomb, viscous, rng),
        reason="the joint does not move; move it back and forth at two speeds" if still else "",
    )


def build_estimate(joints: int = 7, *, count: int = 16, rate: float = 200.0, damaged: bool = False) -> Estimate:
    """Return a result of ``joints`` joints and ``count`` strokes each; with seven of them, joint 3 stands still."""
    rng = np.random.default_rng(7)
    motions = [strokes(count, rate, rng) for _ in range(joints)]
    samples = min(len(m[0]) for m in motions)
    q, dq, ddq = (np.stack([m[k][:samples] for m in motions], axis=1) for k in range(3))
    borders = [[b for b in m[3] if b <= samples] for m in motions]
    if joints > STILL:
        q[:, STILL] = q[0, STILL]
        dq[:, STILL] = ddq[:, STILL] = 0.0
        borders[STILL] = []
    torque = np.array(COULOMB[:joints]) * np.sign(dq) + np.array(VISCOUS[:joints]) * dq + INERTIA * ddq
    torque += 0.05 * rng.standard_normal(torque.shape)
    dq += 0.003 * rng.standard_normal(dq.shape)
    t = np.arange(samples) / rate
    names = tuple(f"panda_joint{j + 1}" for j in range(joints))
    cycles = cycle_table(t, dq, torque, borders)
    lost = Finding(code="truncated", message="the file ends early; 3 messages were left out", amount=3, damaged=True)
    log = JointLog(
        t=t,
        q=q,
        dq=dq,
        tau_interaction=torque,
        joint_names=names,
        source=Source(
            path="run 1.csv",
            sha256="0" * 64,
            format="csv",
            robot="panda",
            channels={"q": "q_{i}", "dq": "dq_{i}"},
            findings=(lost,) if damaged else (),
        ),
    )
    choice = TorqueChoice(
        source="interaction",
        gravity="removed",
        inertia="none",
        drive="hand",
        sign=1,
        sign_proved=True,
        sign_turned=False,
        robot="none",
        payload=None,
        model_rate_hz=None,
        formula="F_m as logged",
    )
    interaction = Interaction(
        t=t,
        q=q,
        dq=dq,
        torque=torque,
        compensation=None,
        hand_speed=None,
        joint_numbers=tuple(range(1, joints + 1)),
        joint_names=names,
        choice=choice,
        warnings=(Caution(code="sign_unproved", numbers={"formula": "F_m as logged"}),),
    )
    friction = FrictionHistory(
        estimator="weighted",
        joints=tuple(joint_friction(j, names[j], cycles, rng) for j in range(joints)),
        warnings=(Caution(code="from_regression", joint=STILL + 1),) if joints > STILL else (),
    )
    return Estimate(log=log, interaction=interaction, cycles=cycles, friction=friction, settings=AuditSettings())


@pytest.fixture(scope="session")
def estimate_of() -> EstimateFactory:
    """Return the factory."""
    return build_estimate


@pytest.fixture(scope="session")
def seven() -> Estimate:
    """Return a result of seven joints, the third standing still."""
    return build_estimate(7)


@pytest.fixture(scope="session")
def single() -> Estimate:
    """Return a result of one joint."""
    return build_estimate(1)


Open = Callable[..., Opened]


@pytest.fixture
def open_page(browser: "Browser", tmp_path: Path) -> Iterator[Open]:
    """Return what opens HTML text at a width, in a colour scheme, with scripts or without."""
    contexts = []

    def opened(html: str, *, width: int = 1280, scheme: Any = "light", scripts: bool = True) -> Opened:
        path = tmp_path / "page.html"
        path.write_text(html, encoding="utf-8")
        context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=scheme, java_script_enabled=scripts
        )
        contexts.append(context)
        return open_in(context, path.as_uri())

    yield opened
    for context in contexts:
        context.close()

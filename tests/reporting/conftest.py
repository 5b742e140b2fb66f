"""A log made by hand, minimum-jerk strokes back and forth with known friction and inertia, and its estimate."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_audit.joint_log import Finding, Float, JointLog, Source
from friction_audit.pipeline import AuditSettings, Estimate, estimate_log
from tests.opened_page import Open, Opened

COULOMB = (0.245, 0.152, 0.183, 0.359, 0.267, 0.166, 0.211)
VISCOUS = (0.4, 0.3, 0.25, 0.5, 0.13, 0.11, 0.12)
INERTIA = 0.1
STILL = 2  # column of the joint that stands still when there are several


def strokes(count: int, rate: float, rng: np.random.Generator) -> tuple[Float, Float, Float]:
    """Return q, dq, ddq of minimum-jerk strokes of 0.9 rad back and forth, of varied speed."""
    pieces = []
    for row in range(count):
        displacement, duration = -0.9 if row % 2 else 0.9, rng.uniform(1.0, 2.4)
        s = np.arange(round(duration * rate)) / (duration * rate)
        q = displacement * (10 * s**3 - 15 * s**4 + 6 * s**5) + (0.9 if row % 2 else 0.0)
        dq = displacement * (30 * s**2 - 60 * s**3 + 30 * s**4) / duration
        pieces.append(np.stack([q, dq, displacement * (60 * s - 180 * s**2 + 120 * s**3) / duration**2]))
    q, dq, ddq = np.concatenate(pieces, axis=1)
    return q, dq, ddq


def build_log(joints: int, count: int, rate: float, *, damaged: bool) -> JointLog:
    rng = np.random.default_rng(7)
    motions = [strokes(count, rate, rng) for _ in range(joints)]
    samples = min(len(m[0]) for m in motions)
    q, dq, ddq = (np.stack([m[k][:samples] for m in motions], axis=1) for k in range(3))
    if joints > STILL:
        q[:, STILL] = q[0, STILL]
        dq[:, STILL] = ddq[:, STILL] = 0.0
    torque = np.array(COULOMB[:joints]) * np.sign(dq) + np.array(VISCOUS[:joints]) * dq + INERTIA * ddq
    torque += 0.05 * rng.standard_normal(torque.shape)
    dq += 0.003 * rng.standard_normal(dq.shape)
    lost = Finding(code="truncated", message="the file ends early; 3 messages were left out", amount=3, damaged=True)
    source = Source(
        path="run 1.csv", sha256="0" * 64, format="csv", robot="panda", channels={"q": "q_{i}", "dq": "dq_{i}"},
        findings=(lost,) if damaged else (),
    )  # fmt: skip
    names = tuple(f"panda_joint{j + 1}" for j in range(joints))
    return JointLog(t=np.arange(samples) / rate, q=q, dq=dq, tau_interaction=torque, joint_names=names, source=source)


@cache
def build_estimate(joints: int = 7, *, count: int = 16, rate: float = 200.0, damaged: bool = False) -> Estimate:
    """Return the estimate of a log of so many joints and strokes; with more than two of them, joint 3 stands still."""
    return estimate_log(build_log(joints, count, rate, damaged=damaged), AuditSettings())


@pytest.fixture(scope="session")
def seven() -> Estimate:
    """Return a result of seven joints, the third standing still."""
    return build_estimate(7)


@pytest.fixture(scope="session")
def single() -> Estimate:
    return build_estimate(1)


@pytest.fixture
def open_page(open_address: Open, tmp_path: Path) -> Open:

    def opened(html: str, **look: Any) -> Opened:
        path = tmp_path / "page.html"
        path.write_text(html, encoding="utf-8")
        return open_address(path.as_uri(), **look)

    return opened

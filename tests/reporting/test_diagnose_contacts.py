"""Contacts over time: every stretch shaded, the largest shown close by."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure

from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import AuditSettings, Diagnosis, diagnose_estimate, estimate_log
from friction_audit.reporting.figures.diagnose_contacts import touched
from friction_audit.reporting.figures.diagnose_evidence import draw_effects
from friction_audit.simulation import BenchSettings, simulate

LENGTH_S = 0.3

Pushes = tuple[tuple[float, float], ...]
"""When something touches the joint, and how hard. [s, N m]"""


@cache
def quiet() -> JointLog:
    """A log without contacts, simulated when the first test asks for it: collecting tests is to take no time."""
    return simulate(BenchSettings(duration_s=40.0), 3).log


def in_motion(after_s: float) -> float:
    """The first moment after one from which the joint moves for as long as a contact lasts."""
    log = quiet()
    slow = log.t[np.abs(log.dq[:, 0]) < 0.1]
    starts = np.append(after_s, slow[slow > after_s])
    return float(starts[np.flatnonzero(np.diff(starts) > 1.5 * LENGTH_S)[0]]) + 0.25 * LENGTH_S


@cache
def two_pushes() -> Pushes:
    return (in_motion(12.0), 2.0), (in_motion(25.0), -3.0)


def pushed(log: JointLog, pushes: Pushes) -> JointLog:
    """A log with half a sine of torque at each moment."""
    torque = np.array(log.tau_interaction)
    for start, size in pushes:
        inside = (log.t >= start) & (log.t < start + LENGTH_S)
        torque[inside, 0] += size * np.sin(np.pi * (log.t[inside] - start) / LENGTH_S)
    return replace(log, tau_interaction=torque)


@cache
def found_of(pushes: Pushes) -> Diagnosis:
    settings = DiagnosisSettings(candidates=("contact_event", "stribeck"))
    return diagnose_estimate(estimate_log(pushed(quiet(), pushes), AuditSettings()), settings)


def found() -> Diagnosis:
    return found_of(two_pushes())


def shaded(figure: Figure, panel: int) -> int:
    return len(figure.axes[panel].patches)


def test_each_contact_is_where_it_was_and_as_large_as_it_was() -> None:
    shown = touched(found(), found().discrepancy.joints[0])
    starts = [start for start, _ in two_pushes()]
    assert [contact.start_s for contact in shown.contacts] == pytest.approx(starts, abs=0.15)
    for start, size in two_pushes():
        near = shown.left[np.abs(shown.t - start - 0.5 * LENGTH_S) < 0.02]
        assert float(np.nanmean(near)) == pytest.approx(size, rel=0.1)
    apart = np.all([np.abs(shown.t - start - 0.5 * LENGTH_S) > 0.5 for start, _ in two_pushes()], axis=0)
    assert float(np.nanstd(shown.left[apart])) < 0.05


def test_a_contact_that_stops_the_joint_is_shown_too() -> None:
    log = quiet()
    speed = np.abs(log.dq[:, 0])
    before = np.interp(log.t - LENGTH_S, log.t, speed)
    stop = float(log.t[(log.t > 15.0) & (speed < 0.02) & (before > 0.2)][0])
    pushes = ((stop - 0.8 * LENGTH_S, 2.0),)
    shown = touched(found_of(pushes), found_of(pushes).discrepancy.joints[0])
    assert any(contact.start_s < stop - 0.3 * LENGTH_S < contact.stop_s for contact in shown.contacts)


def test_friction_below_zero_which_no_model_allows_is_drawn_all_the_same() -> None:
    joint = found().discrepancy.joints[0]
    numbers = dict(joint.grown)
    numbers["viscous_nms_per_rad"] = replace(numbers["viscous_nms_per_rad"], value=-0.4)
    shown = touched(found(), replace(joint, grown=numbers))
    apart = np.all([np.abs(shown.t - start - 0.5 * LENGTH_S) > 0.5 for start, _ in two_pushes()], axis=0)
    assert float(np.nanstd(shown.left[apart])) < 0.1


def test_one_joint_shows_all_the_log_and_the_largest_close_by() -> None:
    figure = draw_effects(found(), 1)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["joint 1: contact_event", "the largest"]
    assert [shaded(figure, panel) for panel in (0, 1)] == [2, 2]
    low, high = figure.axes[1].get_xlim()
    assert low < two_pushes()[1][0] < high
    assert high - low < 3.0


def test_a_sheet_shows_all_the_log() -> None:
    figure = draw_effects(found(), None)
    assert len(figure.axes) == 1
    assert shaded(figure, 0) == 2

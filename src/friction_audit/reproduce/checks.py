"""Checks of the paper's claims: Figs 3 and 6 to 11 for one joint, Figs 12 to 14 for a hand-guided Panda."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from friction_audit.compensation.comparison.experiment import compare
from friction_audit.compensation.comparison.methods import FULL, METHODS, PAPER, SETUPS
from friction_audit.compensation.comparison.result import SECOND, Comparison, Row
from friction_audit.joint_log import Float
from friction_audit.reporting.figures.panels import smooth
from friction_audit.reporting.figures.paper import Course, draw_adaptation
from friction_audit.reproduce.claims import Claim, Simulations, claim, make_course, relative, share, spread, within
from friction_audit.simulation.bench import Progress
from friction_audit.simulation.settings import CONTROL_RATE_HZ, Simulation

CLOSURE_BOUND, MINIMA_BOUND = 1e-5, 1e-4  # Fig. 3: shares of the dissipated energy
ESTIMATE_BOUND, RETURN_BOUND = 1e-3, 1e-2  # Figs 6, 7: relative errors of the coefficient


def check_3(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the balance (3), the dissipated energy, which never falls, and the minima of the net energy."""
    course, kinetic, dissipated = energies(simulations)
    closure = float(np.abs(course.energy_j - kinetic - dissipated).max() / dissipated[-1])
    falls = float(np.diff(dissipated).min())
    rises, error = minima(course.energy_j, dissipated)
    return (
        within("balance", closure, CLOSURE_BOUND),
        claim("dissipation", falls, falls >= 0.0, falls=falls),
        within("minima", error, MINIMA_BOUND, rises=rises),
    )


def energies(simulations: Simulations) -> tuple[Course, Float, Float]:
    """Return the course of Fig. 3 with its kinetic and dissipated energy, shape (n,) each. [J]"""
    (simulation,) = simulations["fig3"]
    truth = simulation.truth
    kinetic = 0.5 * truth.settings.joints[0].inertia_kg_m2 * truth.motion.dq[:, 0] ** 2
    return make_course(simulation, zero_crossings=True), kinetic, truth.motion.dissipated_j[:, 0]


def minima(energy: Float, dissipated: Float) -> tuple[int, float]:
    """Return the number of rises between minima of the net energy, from the start, and their largest relative error."""
    inner = energy[1:-1]
    places = np.append(0, np.flatnonzero((inner < energy[:-2]) & (inner <= energy[2:])) + 1)
    rise, lost = np.diff(energy[places]), np.diff(dissipated[places])
    return len(rise), float(np.abs(rise / lost - 1.0).max()) if len(rise) else np.inf


def check_6(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the estimates after the first and the fourth cycle, and the net energy between."""
    (simulation,) = simulations["fig6"]
    course, settings = make_course(simulation), simulation.truth.settings
    before = settings.joints[0].viscous_nms_per_rad
    after = before * (1.0 + settings.hidden[0].friction_step.change)
    ends = course.ends_j
    applied = [float(course.viscous_nms_per_rad[np.searchsorted(course.t, course.ends_s[k])]) for k in (0, 3)]
    first, last = (abs(one / truth - 1.0) for one, truth in zip(applied, (before, after), strict=True))
    return (
        within("first_estimate", first, ESTIMATE_BOUND, found=applied[0]),
        within("no_net_dissipation", float(np.abs(ends[1:3] / ends[0] - 1.0).max()), ESTIMATE_BOUND),
        within("adapted", last, ESTIMATE_BOUND, found=applied[1], fourth=(ends[3] - ends[2]) / ends[0]),
    )


def draw_6(simulations: Simulations) -> Any:  # noqa: ANN401 - a figure of Matplotlib
    """Draw the estimate and the true coefficient."""
    (simulation,) = simulations["fig6"]
    settings, t = simulation.truth.settings, simulation.truth.motion.t
    step = settings.hidden[0].friction_step
    factor = np.where(t < step.at_share * settings.duration_s, 1.0, 1.0 + step.change)
    return draw_adaptation(make_course(simulation), settings.joints[0].viscous_nms_per_rad * factor)


def check_7(simulations: Simulations) -> tuple[Claim, ...]:
    """Check over-compensation without and with the passivity controller."""
    (bare,), (guarded,) = simulations["fig7-unprotected"], simulations["fig7"]
    alone, course = make_course(bare), make_course(guarded)
    fallen, lowest = float(alone.energy_j.min() / alone.ends_j[0]), float(course.energy_j.min())
    tolerance = tolerance_j(guarded)
    acting = course.t[course.damping_nms_per_rad > 0.0]
    cycles = np.unique(np.searchsorted(course.ends_s, acting, side="right") + 1)
    truth, highest = guarded.truth, float(course.damping_nms_per_rad.max())
    after = float(course.viscous_nms_per_rad[np.searchsorted(course.t, course.ends_s[3])])  # applied after cycle 4
    cap = truth.settings.compensator.max_damping_nms_per_rad
    taken = float(truth.compensators["dissipated_j"][-1, 0] / course.ends_j[0])
    off = abs(after / truth.settings.joints[0].viscous_nms_per_rad - 1.0)
    numbers = ", ".join(map(str, cycles))
    return (
        claim("unprotected", fallen, fallen < 0.0, fallen=fallen),
        claim("passive", lowest, lowest >= -tolerance, lowest=lowest, tolerance=-tolerance),
        claim("acts_once", cycles[0] if len(cycles) else np.nan, list(cycles) == [4], cycles=numbers),
        claim("finite_damping", highest, 0.0 < highest <= cap and taken > 0.0, highest=highest, taken=taken, cap=cap),
        within("returns", off, RETURN_BOUND, found=after),
    )


def tolerance_j(simulation: Simulation) -> float:
    """Return the largest energy deficit that is possible although the passivity controller acts. [J]"""
    settings, motion = simulation.truth.settings, simulation.truth.motion
    hand, joint = settings.operator.inertia_kg_m2, settings.joints[0].inertia_kg_m2
    power = np.abs(motion.interaction_nm * motion.dq).max()
    return float(power / CONTROL_RATE_HZ * (hand + joint) / hand)


PEAK_NM = (1.3, 1.7)  # bounds of "approximately 1.5 N m"


def check_8(simulations: Simulations) -> tuple[Claim, ...]:
    """Check that every cycle dissipates energy, and the peak torque."""
    courses = [make_course(simulation) for simulation in simulations["fig8"]]
    rises = np.array([np.diff(course.ends_j, prepend=0.0).min() for course in courses])
    factor = np.median([course.ends_j[-1] / course.ends_j[1] for course in courses])
    peaks = np.array([peak_nm(course) for course in courses])
    near = (peaks > PEAK_NM[0]) & (peaks < PEAK_NM[1])
    return (
        claim("increases", rises.min(), (rises > 0.0).all(), rising=share(rises > 0.0), factor=factor),
        claim("peak", np.median(peaks), near.all(), peaks=spread(peaks, "N m"), near=share(near)),
    )


def peak_nm(course: Course) -> float:
    """Return the largest interaction torque, low-passed as in the figure. [N m]"""
    return float(np.abs(smooth(course.t, course.interaction_nm)).max())


NEAR_ZERO = 0.05  # share of the peak speed that counts as near zero
PLATEAU_BOUND = 0.02


def last_period(simulation: Simulation) -> Course:
    """Return the last period of the sinusoid, in steady state."""
    course = make_course(simulation, zero_crossings=True)
    return course.part(course.t >= course.t[-1] - simulation.truth.settings.operator.motion.period_s)


def plateau_nm(course: Course) -> float:
    """Return half the distance of the plateaus at velocity zero, where the inertial torque of both cancels. [N m]"""
    slow = np.abs(course.dq) < NEAR_ZERO * np.abs(course.dq).max()
    forth, back = (course.interaction_nm[slow & sign].mean() for sign in (course.dq > 0.0, course.dq < 0.0))
    return float(0.5 * (forth - back))


def check_9(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the plateaus of friction, and the ellipse that remains with compensation."""
    (raw,), (aided,) = simulations["fig9-friction"], simulations["fig9-compensated"]
    joint, before, after = raw.truth.settings.joints[0], last_period(raw), last_period(aided)
    speed = np.abs(before.dq)
    slow = float(speed[speed < NEAR_ZERO * speed.max()].mean())
    plateau = plateau_nm(before)
    # For one tick at standstill the compensator has no torque and friction holds the joint. Its velocity is then a dt
    # below the intended one, and the hand's damper b adds b a dt; B / (m + B) of it passes the sensor, relative to B a.
    hand, own = (one.inertia_kg_m2 for one in (aided.truth.settings.operator, aided.truth.settings.joints[0]))
    bound = float(aided.truth.settings.operator.damping_nms_per_rad / CONTROL_RATE_HZ / (hand + own))
    cost, alone = (float(course.energy_j[-1] - course.energy_j[0]) for course in (after, before))
    held = joint.coulomb_nm + joint.viscous_nms_per_rad * slow
    return (
        within("plateaus", abs(plateau / held - 1.0), PLATEAU_BOUND, plateau=plateau),
        within("no_plateau", abs(plateau_nm(after)) / plateau, PLATEAU_BOUND, cost=relative(cost / alone)),
        within("ellipse", off_ellipse(after), bound),
    )


def off_ellipse(course: Course) -> float:
    """Return the largest relative distance of the moving joint from the ellipse with the same half axes."""
    direction = np.sign(course.dq)
    moving = (direction != 0.0) & (np.diff(direction, prepend=direction[0]) == 0.0)
    dq, torque = (signal[moving] / np.abs(signal[moving]).max() for signal in (course.dq, course.interaction_nm))
    return float(np.abs(np.hypot(dq, torque) - 1.0).max())


FIG_10 = ("fig10", "fig10-published", "fig10-slow-noise")
BAND = 0.25  # largest change of the net energy after the second cycle, at ends of cycles, over E_cyclic^2
NEAR = 0.05  # the same for a good estimate of two cycles
PERSONS = 0.95  # share of the persons for whom BAND must hold: the paper shows one


def check_10(simulations: Simulations) -> tuple[Claim, ...]:
    """Check that the net energy rises for two cycles and then stays, also with (20) as printed."""
    courses, as_printed, with_slow_noise = ([make_course(one) for one in simulations[name]] for name in FIG_10)
    rises = np.array([np.diff(course.ends_j[: SECOND + 1], prepend=0.0).min() for course in courses])
    last_s = np.median([course.ends_s[-1] - course.ends_s[SECOND] for course in courses])

    def band(name: str, those: Sequence[Course], *, own: bool = False) -> Claim:
        ends = (course.ends_j[SECOND:] for course in those)
        leaves = np.array([np.abs(one[1:] / one[0] - 1.0).max() for one in ends])
        inside, near = leaves < BAND, leaves < NEAR
        found = f"over {last_s:.0f} s within {NEAR:.0%} in {share(near)}, within {BAND:.0%} in {share(inside)}"
        words = f"{found}: {spread(leaves, 'of it')}"
        return claim(name, leaves.max(), inside.mean() >= PERSONS, own=own, found=words)

    return (
        claim("rises_at_first", rises.min(), (rises > 0.0).all(), rising=share(rises > 0.0)),
        band("stays", courses),
        band("stays_as_printed", as_printed),
        band("stays_with_slow_noise", with_slow_noise, own=True),
    )


LOW_PEAK_NM = 0.5
FAST = 0.3  # speed of sliding friction, above dead-band and ramp of the compensation. [rad/s]
REMAINS = 0.15  # largest share of the friction that remains


def check_11(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the peak torque, and the friction that remains."""
    before = [make_course(simulation) for simulation in simulations["fig8"]]
    after = [compensated(make_course(simulation)) for simulation in simulations["fig10"]]
    peaks = np.array([peak_nm(course) for course in after])
    # The mean of F_m sgn(dq) where the joint slides is friction: acceleration and braking cancel.
    still, without = (
        np.array([(one.interaction_nm * np.sign(one.dq))[np.abs(one.dq) > FAST].mean() for one in courses])
        for courses in (after, before)
    )
    left = np.abs(still) / without
    high, low = spread(peaks, "N m"), peaks < LOW_PEAK_NM
    held_nm = simulations["fig10"][0].truth.settings.joints[0].coulomb_nm
    return (
        claim("low_peak", peaks.max(), low.all(), peaks=high, low=share(low), bound=LOW_PEAK_NM, held=held_nm),
        claim("inertia_left", left.max(), (left < REMAINS).all(), left=spread(left, ""), fast=FAST, bound=REMAINS),
    )


def compensated(course: Course) -> Course:
    """Return the part after the second cycle."""
    return course.part(course.t >= course.ends_s[SECOND])


# An arm: the hand speed ends the cycles of all joints.

# Slope of the cyclic energies over that of the first two cycles, below which they count as constant.
SLOPE_BOUND = 0.1


def check_12(simulations: Simulations) -> tuple[Claim, ...]:
    """Check that the joints' cycles end together, and that the net energy stays after the second one."""
    arms = simulations["fig12"]
    ended = [np.diff(arm.truth.compensators["cycle"], axis=0) != 0 for arm in arms]
    alone = sum(int((one.any(axis=1) & ~one.all(axis=1)).sum()) for one in ended)
    ends = [np.flatnonzero(one[:, 0]) + 1 for one in ended]
    t = [arm.truth.motion.t[own] for arm, own in zip(arms, ends, strict=True)]
    energies = [arm.truth.compensators["energy_j"][own] for arm, own in zip(arms, ends, strict=True)]
    whole = [one.sum(axis=1, keepdims=True) for one in energies]
    # Slopes after the second cycle over those before it; the last column is that of the arm.
    every = [(at, np.hstack(both)) for at, *both in zip(t, energies, whole, strict=True)]
    ratios = np.array([np.polyfit(at[SECOND:], e[SECOND:], 1)[0] / (e[SECOND] / at[SECOND]) for at, e in every])
    slopes, own_slopes = ratios[:, -1], ratios[:, :-1]
    stopped, joint = own_slopes < SLOPE_BOUND, int(np.argmax(own_slopes.max(axis=0)))
    leaves = np.array([np.abs(energy[SECOND + 1 :] / energy[SECOND] - 1.0).max() for energy in whole])
    estimated = [
        [arm.truth.compensators[f"estimated_{name}"][own] for name in ("coulomb_nm", "viscous_nms_per_rad")]
        for arm, own in zip(arms, ends, strict=True)
    ]
    negative = np.mean([((one < 0.0) | (other < 0.0))[np.isfinite(one)].mean() for one, other in estimated])
    inside, worst = leaves < BAND, own_slopes.max()
    arm: dict[str, Any] = {"slopes": spread(slopes, ""), "stopped": share(slopes < SLOPE_BOUND)}
    joints: dict[str, Any] = {"stopped": stopped.sum(), "joints": stopped.size, "worst": worst, "joint": joint + 1}
    kept: dict[str, Any] = {"inside": share(inside), "leaves": spread(leaves, "of it"), "negative": negative}
    return (
        claim("same_instants", alone, alone == 0, alone=alone),
        claim("arm_stops_rising", slopes.max(), (slopes < SLOPE_BOUND).all(), bound=SLOPE_BOUND, **arm),
        claim("joints_stop_rising", worst, stopped.all(), **joints),
        claim("arm_keeps", leaves.max(), inside.all(), band=BAND, **kept),
    )


# The paper's methods, from the steepest to the flattest net energy.
ORDER = ("none", "sigmoid", "disturbance_observer", "torque_regulation", "energy")
KEPT = 0.1  # slope over that without compensation, below which the net energy counts as constant


def compare_methods(seeds: int, progress: Progress | None = None) -> Comparison:
    """Compare the paper's methods on the arm, without sweeps and margins."""
    (arm,) = (setup for setup in SETUPS if setup.name == "panda")
    arm = replace(arm, tuning_seeds=0, margin_seeds=0)
    return compare(arm, seeds, [replace(method, sweeps=()) for method in METHODS if method.name in ORDER], progress)


def rows_of(comparison: Comparison, role: str) -> list[Row]:
    """Return the paper's methods with a role, in the paper's order."""
    rows = [comparison.row(name, role) or comparison.row(name, PAPER) for name in ORDER]
    return [row for row in rows if row is not None]


def in_words(rows: Sequence[Row], values: Sequence[float], factor: float, unit: str) -> str:
    """Return the methods with their values, largest first, and the shares of unstable loops."""
    pairs = sorted(zip(values, rows, strict=True), key=lambda pair: -pair[0])
    order = " > ".join(f"{row.label} {factor * value:.3g}" for value, row in pairs)
    lost = [f"{row.label} lost in {1 - row.stable_share:.0%} of seeds" for row in rows if row.stable_share < 1.0]
    return "; ".join([f"{order} {unit}", *lost])


# Prefix of a claim by role; the second one is not a claim of the paper.
OWN = {PAPER: "", FULL: "own experiment, the observer compensates all that it observes: "}


def check_13(comparison: Comparison) -> tuple[Claim, ...]:
    """Check the order of the methods by the slope of the net energy, and that the proposed method keeps it constant."""
    none, *_, proposed = rows_of(comparison, PAPER)
    slope, alone = (row.interval("energy_slope_w").value for row in (proposed, none))
    kept, stable = slope / alone, proposed.stable_share
    holds = abs(kept) < KEPT and stable == 1.0
    return (
        order(comparison, PAPER),
        claim("keeps", kept, holds, kept=kept, bound=KEPT, stable=stable),
        order(comparison, FULL),
    )


def order(comparison: Comparison, role: str) -> Claim:
    """Check the order of the methods by the slope of the net energy."""
    rows = rows_of(comparison, role)
    slopes = [row.interval("energy_slope_w").value for row in rows]
    falls = np.diff(slopes) < 0.0
    words = in_words(rows, slopes, 1000.0, "mW")
    return claim("order", falls.sum(), falls.all(), own=role == FULL, before=OWN[role], order=words)


def check_14(comparison: Comparison) -> tuple[Claim, ...]:
    """Check the order of the methods by the largest torque, and which one leaves least Coulomb friction."""
    rows = rows_of(comparison, PAPER)[:-1]
    drawn, raw = ([row.interval(name).value for row in rows] for name in ("drawn_peak_nm", "peak_torque_nm"))
    falls = np.diff(drawn) < 0.0
    as_drawn, as_read = (in_words(rows, found, 1.0, "N m") for found in (drawn, raw))
    return (
        claim("peaks", falls.sum(), falls.all(), drawn=as_drawn, raw=as_read),
        *(plateaus(comparison, role) for role in (PAPER, FULL)),
    )


def plateaus(comparison: Comparison, role: str) -> Claim:
    """Check that the last method leaves least of the plateaus of Coulomb friction."""
    rows = rows_of(comparison, role)
    left = [abs(row.interval("coulomb_left").value) for row in rows]
    holds, words = left[-1] == min(left) and rows[-1].stable_share == 1.0, in_words(rows, left, 1.0, "of it left")
    return claim("least_plateaus", left[-1], holds, own=role == FULL, before=OWN[role], left=words)

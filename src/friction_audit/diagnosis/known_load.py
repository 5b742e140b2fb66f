"""The load on every joint by a model of the arm or by the log, and the torque per unit of that model's errors."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.dynamics.motion import INERTIAL_PARAMETERS, RigidBody
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.parallel import per_joint
from friction_audit.preprocessing.even_grid import on_finer_grid
from friction_audit.preprocessing.interaction import TorqueChoice
from friction_audit.robot import unknown_chain
from friction_audit.robot.arm import Arm, chunks
from friction_audit.robot.regressor import Motion, random_motion, regressor_entries, significant, tilt_torque

# Above twice the bandwidth of the motion on the grid; at 100 Hz the noise of accelerations folds back: the floor of a
# measured Panda's joints 1 to 4 rises by half, and joint 4 is unexplained.
RATE_HZ = 200.0
MOMENTS_AND_MASS = (1, 2, 3, 0)  # inertial parameters that gravity acts on, in the order in which they are kept
ROUNDING = 1e-9  # a smaller torque per kg or kg m is none [N m]
INERTIA_POSES = 50  # of a recording, evenly spread
# Of a chain without a model: directions per sample, for friction needs samples too; samples from which gravity is known
# well enough, variance of noise over that of gravity's coefficients, and samples at once, for memory.
MOST_PER_SAMPLE, FITTED, NOISE, AT_ONCE = 0.25, 4000, 1e-6, 2**14


class KnownLoad(NamedTuple):
    """The load on the gears in addition to the joints' own models, for j joints on a grid of n samples."""

    # gravity, and the links' inertia where it was removed, with the sign of the torque, (n, j), or None [N m]
    load: Float | None
    # torque to subtract from the sensors' readings where links' inertia is part of it, else None [N m]
    removed: Float | None
    # torque of each joint per unit of what may be wrong with the model, or None without a model
    rigid: tuple[RigidBody, ...] | None


def know_load(choice: TorqueChoice, arm: Arm | None, t: Float, motion: Motion, logged: Float | None) -> KnownLoad:
    """Evaluate the model of an arm along a motion on a grid; gravity of the log there, shape (n, j), or None. [N m]"""
    if arm is None:
        return KnownLoad(load=None if logged is None else choice.sign * logged, removed=None, rigid=None)
    every = max(int(1.0 / (RATE_HZ * (t[1] - t[0])) + 0.5), 1)
    times, coarse = t[::every], (motion[0][::every], motion[1][::every], motion[2][::every])
    # Gravity of the log is preferred, unless the interaction torque was made with that of the model.
    own, driven = logged is None or choice.gravity == "model", choice.drive == "robot"
    weight = arm.gravity(coarse[0]) if own or driven else np.zeros(0)
    inertial = arm.inverse_dynamics(*coarse) - weight if driven else None
    load, removed = choice.sign * (on_finer_grid(weight, every, len(t)) if own or logged is None else logged), None
    if inertial is not None and choice.inertia == "model":
        taken = choice.sign * on_finer_grid(inertial, every, len(t))
        load = load + taken
        removed = load if choice.gravity in ("logged", "model") else taken
    return KnownLoad(load=load, removed=removed, rigid=_rigid_bodies(arm, choice.sign, times, coarse, inertial))


def _rigid_bodies(arm: Arm, sign: int, t: Float, motion: Motion, inertial: Float | None) -> tuple[RigidBody, ...]:
    joints, order, last = motion[0].shape[1], np.array(arm.columns), motion[0].shape[1] - 1
    # Numbers (1..j of the log) of each joint's own link, of the next, and of the last.
    links = [tuple((order[np.unique([k, min(k + 1, last), last])] + 1).tolist()) for k in np.argsort(order)]
    still = np.zeros_like(motion[0])
    tilt, tips = sign * tilt_torque(arm, motion[0]), None
    # Where the motors move the arm, a link that is heavier than in its model resists by its inertia too.
    pulled = (motion[0], still, still) if inertial is None else motion
    weights = _per_parameter(arm, pulled, links, MOMENTS_AND_MASS, sign, moving=False)
    if inertial is not None:
        weightless, every = arm.with_gravity((0.0, 0.0, 0.0)), range(INERTIAL_PARAMETERS)
        tips = _per_parameter(weightless, motion, [own[-1:] for own in links], every, sign, moving=True)
    return tuple(
        RigidBody(
            t=t,
            links=links[joint],
            weight=weights[joint].reshape(len(links[joint]), -1, len(t)).transpose(2, 0, 1),
            tilt=tilt[:, joint],
            inertial=None if inertial is None else sign * inertial[:, joint],
            tip=None if tips is None else tips[joint].T,
        )
        for joint in range(joints)
    )


def _per_parameter(
    arm: Arm, motion: Motion, links: Sequence[tuple[int, ...]], places: Sequence[int], sign: int, *, moving: bool
) -> list[NDArray[np.float32]]:
    """Torque of each joint per some inertial parameters of its links, zero where not identifiable, (p, n) each.

    Identifiable in any poses, at rest or moving. By chunks, so that few are there as doubles.
    """
    ends = np.cumsum([len(places) * len(own) for own in links])
    joints, carried = np.repeat(np.arange(len(links)), np.diff(ends, prepend=0)), np.concatenate(links) - 1
    entries = joints, np.repeat(carried, len(places)), np.tile(places, len(carried))
    anywhere = regressor_entries(arm, random_motion(len(links), moving=moving), *entries)
    kept = np.concatenate([significant(one) for one in np.hsplit(anywhere, len(carried))])
    kept &= np.abs(anywhere).max(axis=0) > ROUNDING
    out = np.zeros((len(kept), len(motion[0])), np.float32)
    parts, which = [*chunks(out.shape[1])], [one[kept] for one in entries]

    def fill(k: int) -> None:
        q, dq, ddq = (one[parts[k]] for one in motion)
        out[kept, parts[k]] = sign * regressor_entries(arm, (q, dq, ddq), *which).T

    per_joint(fill, len(parts))
    return np.split(out, ends[:-1])


def known_inertias(arm: Arm | None, choice: TorqueChoice, q: Float) -> Float:
    """Return the mean inertia of each joint whose torque a model removed, else zero, shape (j,). [kg m^2]"""
    if arm is None or choice.inertia != "model":
        return np.zeros(q.shape[1])
    return np.asarray(np.mean(arm.mass_diagonal(q[:: max(len(q) // INERTIA_POSES, 1)]), axis=0))


def chain_basis(data: JointData, weight: Float, seen: Callable[[Float], Float], X: Float, y: Float) -> Float:
    """What of the chain's torque the log can tell from noise, orthonormal on the m samples, shape (k, m).

    A direction counts, given nominal columns, shape (b, m), if its coefficient varies by more than noise makes of it.
    ``seen`` brings the fine grid, shape (n, j), to the samples, shape (j, m), of some weight each.
    """
    motion = _chain_of(data, lambda x: (seen(x) / weight).T)
    columns = unknown_chain.chain_columns(motion, weight, np.vstack([X, weight]), y)
    _, size, basis = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(basis[size > 1.0][: int(MOST_PER_SAMPLE * len(y))])


def left_to_effects(data: JointData) -> Float:
    """What of an unknown chain's torque is an effect of its own, on the fine grid, shape (n, e)."""
    motion = _chain_of(data)
    return np.vstack([process.effects(motion) for process in unknown_chain.PROCESSES]).T


def with_gravity(data: JointData) -> JointData:
    """The joint with gravity as its load where the torque holds it and nothing says how much, by ridge regression.

    Without a constant: a sine of a narrow range of angles and a constant of the opposite sign are nearly nothing.
    """
    used = np.flatnonzero(data.used)
    if not data.weighs or data.load is not None or not len(used):
        return data
    some, motion = used[:: len(used) // FITTED + 1], _chain_of(data)
    at = motion.at(some)
    chain, sines = unknown_chain.pivoted_cholesky(unknown_chain.GRAVITY, at), unknown_chain.own_gravity(at)
    of_chain = chain.at(at)
    weighing = np.vstack([sines, of_chain])
    rows = np.vstack([weighing, np.stack([data.direction, data.dq])[:, some], unknown_chain.constant_coupling(at)])
    size = np.maximum(np.sqrt(np.mean(rows**2, axis=1)), 1e-12)
    prior = np.zeros((len(weighing), len(rows)))
    np.fill_diagonal(prior, np.sqrt(NOISE * len(some)))
    known = np.append(data.torque[some], np.zeros(len(weighing)))
    found = np.linalg.lstsq(np.vstack([rows.T, prior]) / size, known, rcond=1e-9)[0] / size
    own, others = np.split(found[: len(weighing)], [2])
    load = np.empty(len(data.q))
    for first in range(0, len(load), AT_ONCE):
        part = motion.at(slice(first, first + AT_ONCE))
        load[first : first + AT_ONCE] = own @ unknown_chain.own_gravity(part) + others @ chain.at(part)
    return replace(data, load=load)


def _chain_of(data: JointData, seen: Callable[[Float], Float] = np.asarray) -> unknown_chain.ChainMotion:
    every = data.others
    return unknown_chain.ChainMotion.of(every.joint, seen(every.q), seen(every.dq), seen(every.ddq))

"""What the log of a joint says of the rigid-body torque of a chain whose model nobody gave."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.robot.unknown_chain import (
    GRAVITY,
    INERTIA,
    ChainMotion,
    chain_columns,
    constant_coupling,
    decomposed,
    own_sines,
)

MOST_PER_SAMPLE = 0.25  # directions: friction needs samples too
FITTED = 4000  # samples from which gravity is known well enough
NOISE = 1e-6  # variance of noise over that of gravity's coefficients
AT_ONCE = 2**14  # samples, for memory


def chain_basis(data: JointData, weight: Float, seen: Callable[[Float], Float], X: Float, y: Float) -> Float:
    """What of the chain's torque the log can tell from noise, orthonormal on the m samples, shape (k, m).

    A direction counts beside nominal columns, shape (b, m), if its coefficient varies by more than noise makes of it.
    ``seen`` brings the fine grid, shape (n, j), to the samples, shape (j, m), of some weight each.
    """
    motion = _chain_of(data, lambda x: (seen(x) / weight).T)
    columns = chain_columns(motion, weight, np.vstack([X, weight]), y)
    _, size, basis = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(basis[size > 1.0][: int(MOST_PER_SAMPLE * len(y))])


def left_to_effects(data: JointData) -> Float:
    """What of an unknown chain's torque is an effect of its own, on the fine grid, shape (n, e)."""
    motion = _chain_of(data)
    return np.vstack([process.effects(motion) for process in (GRAVITY, INERTIA)]).T


def with_gravity(data: JointData) -> JointData:
    """The joint with gravity as its load where the torque holds it and nothing says how much, by ridge regression.

    Without a constant: a sine of a narrow range of angles and a constant of the opposite sign are nearly nothing.
    """
    used = np.flatnonzero(data.used)
    if not data.weighs or data.load is not None or not len(used):
        return data
    some, motion = used[:: len(used) // FITTED + 1], _chain_of(data)
    at = motion.at(some)
    chain, sines = decomposed(GRAVITY, at), own_sines(at)
    of_chain = chain.at(at)
    weighing = np.vstack([sines, of_chain])
    rows = np.vstack([weighing, np.stack([data.direction, data.dq])[:, some], constant_coupling(at)])
    size = np.maximum(np.sqrt(np.mean(rows**2, axis=1)), 1e-12)
    prior = np.zeros((len(weighing), len(rows)))
    np.fill_diagonal(prior, np.sqrt(NOISE * len(some)))
    known = np.append(data.torque[some], np.zeros(len(weighing)))
    found = np.linalg.lstsq(np.vstack([rows.T, prior]) / size, known, rcond=1e-9)[0] / size
    own, others = np.split(found[: len(weighing)], [2])
    load = np.empty(len(data.q))
    for first in range(0, len(load), AT_ONCE):
        part = motion.at(slice(first, first + AT_ONCE))
        load[first : first + AT_ONCE] = own @ own_sines(part) + others @ chain.at(part)
    return replace(data, load=load)


def _chain_of(data: JointData, seen: Callable[[Float], Float] = np.asarray) -> ChainMotion:
    return ChainMotion.of(data.own_column, *map(seen, (data.others_q, data.others_dq, data.others_ddq)))

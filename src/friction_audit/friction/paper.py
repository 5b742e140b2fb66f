"""The linear equations of the energy balance: one row per part of a cycle.

    E_net = mu_c L + mu_v S + b dq + c_x G_x + c_y G_y + B d(v^2/2)

L is the path, S the integral of the squared speed (20); the other columns take up what is not friction: a torque
offset, an error of the gravity torque, and the kinetic energy at the borders of the parts.
"""

from dataclasses import dataclass, replace

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.preprocessing.energy_cycles import EnergyCycles

FRICTION = {"combined": ("coulomb", "viscous"), "coulomb": ("coulomb",), "viscous": ("viscous",)}
NUISANCE = ("offset", "inertia", "gravity_x", "gravity_y")

INDEPENDENT_SHARE = 0.02
"""A nuisance column counts if at least this share of its length is not already explained by the columns before it;
a column that the motion hardly excites (gravity about a vertical axis) would add nothing but variance."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Equations:
    """Weighted equations of one joint, gathered by cycle.

    Attributes:
        names: Names of the p columns; those of the friction model come first.
        normal: A_g^T W A_g per cycle, shape (m, p, p).
        right: A_g^T W y_g per cycle, shape (m, p).
        scale: Lengths by which the columns were divided, shape (p,).
    """

    names: tuple[str, ...]
    normal: Float
    right: Float
    scale: Float

    def first(self, cycles: int) -> "Equations":
        """Return the equations of the first cycles."""
        return replace(self, normal=self.normal[:cycles], right=self.right[:cycles])


def set_up(cycles: EnergyCycles, model: str) -> Equations:
    """Set up the equations of one joint's cycles.

    The noise of an energy is the torque's noise weighted with the velocity, so its variance grows with the integral of
    the squared speed; each row is divided by its square root.

    Args:
        cycles: Cycles of one joint, those that count, m of them.
        model: Friction model.

    Returns:
        The equations, columns scaled to unit length.
    """
    parts = cycles.parts
    candidates = {
        "coulomb": parts.path_rad,
        "viscous": parts.square_speed_rad2_s,
        "offset": parts.displacement_rad,
        "inertia": parts.half_square_speed_change,
        "gravity_x": parts.gravity_x_rad,
        "gravity_y": parts.gravity_y_rad,
    }
    usable = parts.square_speed_rad2_s > 0
    weight = np.sqrt(np.divide(1.0, parts.square_speed_rad2_s, out=np.zeros(usable.shape), where=usable))
    columns = {name: column * weight for name, column in candidates.items()}
    names = _independent(columns, FRICTION[model])
    matrix = np.stack([columns[name] for name in names], axis=-1)
    scale = np.sqrt((matrix**2).sum(axis=(0, 1)))
    matrix = matrix / scale
    right = parts.dissipated_j * weight
    return Equations(
        names=names,
        normal=np.swapaxes(matrix, 1, 2) @ matrix,
        right=np.einsum("gip,gi->gp", matrix, right),
        scale=scale,
    )


def _independent(columns: dict[str, Float], friction: tuple[str, ...]) -> tuple[str, ...]:
    """Keep the friction columns and those nuisance columns that say something of their own."""
    names = list(friction)
    basis = np.linalg.qr(np.stack([columns[name].ravel() for name in names], axis=1))[0]
    for name in NUISANCE:
        column = columns[name].ravel()
        length = np.linalg.norm(column)
        rest = column - basis @ (basis.T @ column)
        if length > 0 and np.linalg.norm(rest) > INDEPENDENT_SHARE * length:
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
            names.append(name)
    return tuple(names)


RANK_CUTOFF = 1e-6
"""Singular values below this share of the largest count as zero: cycles that are copies of one another."""


def estimate_paper(cycles: EnergyCycles, model: str, window: int) -> Float:
    """Estimate after each cycle from the last k cycles.

    Args:
        cycles: Cycles of one joint, m of them.
        model: ``"combined"``, ``"coulomb"`` or ``"viscous"``.
        window: k.

    Returns:
        Coulomb [N m] and viscous [N m s/rad] coefficients, shape (m - k + 1, 2), NaN where the model has none or k
        cycles cannot tell them apart.
    """
    sums = cycles.sums
    columns = {"coulomb": sums.rectified_path_rad, "viscous": sums.square_speed_rad2_s}
    used = [name for name in columns if model in (name, "combined")]
    matrix = _windows(np.stack([columns[name] for name in used], axis=1), window)
    energy = _windows(sums.printed_net_j, window)
    result = np.full((len(energy), 2), np.nan)
    for row, (a, e) in enumerate(zip(matrix, energy, strict=True)):
        scale = np.linalg.norm(a, axis=0)
        solution, _, rank, _ = np.linalg.lstsq(a / scale, e, rcond=RANK_CUTOFF)
        if rank == len(used):
            result[row, [list(columns).index(name) for name in used]] = solution / scale
    return result


def _windows(rows: Float, window: int) -> Float:
    """Return all runs of k consecutive rows, shape (m - k + 1, k, ...)."""
    if len(rows) < window:
        return np.empty((0, window, *rows.shape[1:]))
    return np.stack([rows[i : i + window] for i in range(len(rows) - window + 1)])

"""Interaction: the torque F_m at the friction port, its sign and its provenance.

With B the reflected inertia behind the sensor, u the torque of an active compensator and tau_f the friction:

    B ddq = F_m + u - tau_f,    tau_f * dq >= 0 is the dissipated power.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from friction_audit.errors import encodable
from friction_audit.joint_log import Float, Int

SIGNALS = ("t", "q", "dq", "torque", "compensation", "posture")
FITTED_STROKES = 3  # few strokes fit the direction, the offset and the position by themselves: three do not count


@dataclass(frozen=True, kw_only=True, slots=True)
class SignEvidence:
    """What the energy of one joint says about the sign of its torque."""

    joint: int  # joint number for people (1..n of the log)
    verdict: str  # ``"rises"`` (it is right), ``"falls"``, ``"undecided"``, ``"still"``, ``"no_torque"`` (dead)
    moving_s: float  # time for which the joint moves [s]
    path_rad: float  # how far it moves in that time, both directions added [rad]
    # part of F_m + u that goes with the direction of motion; NaN where it is undetermined [N m]
    against_motion_nm: float
    standard_error_nm: float  # its standard error, strokes taken as independent [N m]
    strokes: int  # motions between two reversals

    @property
    def score(self) -> float:
        """Torque against the motion in standard errors; NaN where it is undetermined."""
        return self.against_motion_nm / self.standard_error_nm if self.standard_error_nm else float("nan")

    @property
    def normal_score(self) -> float:
        """Score of the normal distribution that is as unlikely as ``score`` is with few strokes, NaN likewise.

        Student's t by D. L. Wallace, Ann. Math. Stat. 30 (1959) 1121: scipy.special takes long to load.
        """
        free, t = max(self.strokes - FITTED_STROKES, 1), self.score
        return float(np.copysign((8 * free + 1) / (8 * free + 3) * np.sqrt(free * np.log1p(t**2 / free)), t))


@dataclass(frozen=True, slots=True)
class Caution:
    """Something the user must know about a result; ``reporting/sentences.toml`` has the sentence of each code.

    As a text it is that sentence once ``api``, which knows it, has set ``words``; before, its code.
    """

    words: ClassVar[Callable[["Caution"], str]] = lambda one: one.code

    code: str  # stable short name
    joint: int | None = None  # joint number for people (1..n), or None
    # what the sentence needs, by name, as JSON knows it, or cautions that it quotes
    numbers: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def __str__(self) -> str:
        return type(self).words(self)

    def renamed(self, path: str, name: str) -> "Caution":
        """Return it with another name of the log, in commands to paste."""
        texts = {k: encodable(one.replace(path, name)) for k, one in self.numbers.items() if isinstance(one, str)}
        return replace(self, numbers={**self.numbers, **texts})


Reason = tuple[Caution, ...]  # why there is no result; empty where there is one


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueChoice:
    """How the interaction torque was made; stored in every result."""

    source: str  # ``"interaction"``, ``"tau_ext"`` or ``"tau_J"``
    gravity: str  # ``"logged"``, ``"model"``, ``"in-torque"`` (still in F_m) or ``"removed"`` (the source has none)
    inertia: str  # ``"model"`` or ``"none"``
    drive: str  # ``"hand"`` or ``"robot"``
    sign: int  # +1 or -1, the factor on the source torque
    sign_proved: bool  # True if the net energy proves the sign on most of the moving joints
    sign_turned: bool  # True if the log's energy turned the sign against the first reading
    robot: str  # the rigid-body model used, or ``"none"``
    payload: tuple[float, float, float, float] | None  # mass [kg], x, y, z [m] in the flange frame, or None
    model_rate_hz: float | None  # rate at which inertial torque was evaluated, or None [Hz]
    formula: str  # the balance in words, for people
    reason: Reason = ()  # why this source was chosen
    sign_evidence: tuple[SignEvidence, ...] = ()  # what the energy of each joint of the log says about the sign


def quoted(text: str) -> Reason:
    """Return a sentence of a document or of an error as a reason."""
    return (Caution("quoted", numbers={"text": text}),) if text else ()


def reason_of(error: Exception) -> Reason:
    """Return why an analysis ended in an error."""
    reason = error.args[0] if error.args else ""
    return reason if isinstance(reason, tuple) else quoted(str(error))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Interaction:
    """What friction sees: motion and torque at the friction port, n samples of j joints."""

    t: Float  # time, strictly increasing from 0, shape (n,) [s]
    q: Float  # joint position, shape (n, j) [rad]
    dq: Float  # joint velocity, shape (n, j) [rad/s]
    torque: Float  # interaction torque F_m, positive when it drives the joint towards positive velocity, (n, j) [N m]
    # torque u of everything a logged compensator did (its passivity controller included), shape (n, j), or None [N m]
    compensation: Float | None
    # position of every joint of the log, also those not kept, where gravity is in the torque, shape (n, all), else None
    posture: Float | None = None
    # x and y of the direction of gravity in each joint's own frame (z along the axis), at the samples of
    # ``gravity_index``, shape (g, j, 2), or None when the arm's kinematics are not known
    gravity_direction: Float | None = None
    # samples at which the direction was evaluated, from 0 to n - 1, shape (g,), or None
    gravity_index: Int | None = None
    joint_numbers: tuple[int, ...]  # number for people (1..n of the log) of each column
    joint_names: tuple[str, ...]  # name of each column
    choice: TorqueChoice  # how the torque was made
    warnings: tuple[Caution, ...] = ()  # what the user must know
    first: int = 0  # number of the first sample in the log, of a part of it

    def driving(self, column: int, rows: slice | Int = slice(None)) -> Float:
        """Return F_m + u of a joint (0-based) at some samples: what works against friction and inertia. [N m]"""
        torque: Float = self.torque[rows, column]
        if self.compensation is not None:
            torque = torque + self.compensation[rows, column]
        return torque

    def rows(self, first: int, stop: int) -> "Interaction":
        """Return the samples of these numbers in the log, as a part of it."""
        own = slice(first - self.first, stop - self.first)
        pairs = ((name, getattr(self, name)) for name in SIGNALS)
        signals: dict[str, Any] = {name: signal[own] for name, signal in pairs if signal is not None}
        index, direction = self.gravity_index, self.gravity_direction
        if index is not None and direction is not None:
            places = slice(*np.searchsorted(index, (own.start, own.stop)).tolist())
            index, direction = index[places] - own.start, direction[places]
        return replace(self, **signals, gravity_index=index, gravity_direction=direction, first=first)

    def followed_by(self, other: "Interaction", first: int) -> "Interaction":
        """Return the samples from this number on, and those of the part that follows."""
        mine = self.rows(first, self.first + len(self.t))
        pairs = ((name, getattr(mine, name), getattr(other, name)) for name in (*SIGNALS, "gravity_direction"))
        signals: dict[str, Any] = {name: np.concatenate([own, more]) for name, own, more in pairs if own is not None}
        if mine.gravity_index is not None and other.gravity_index is not None:
            signals["gravity_index"] = np.append(mine.gravity_index, other.gravity_index + len(mine.t))
        return replace(mine, **signals)

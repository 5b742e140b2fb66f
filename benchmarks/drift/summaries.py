"""Drift on summaries that scatter as those of the whole chain do: many arms, and what the chain does not have.

    python -m benchmarks.drift.summaries [--arms 200] [--rows 1 10 16] [--output benchmarks/drift/summaries.md]

100 arms of 30 sessions take about a minute of one core. Every row has a seed of its own and can be made alone.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.drift.arms import DRIFTING, JOINTS, Outcome, heading, judge, make_session, repeat, row
from friction_audit.drift.report import DriftSettings
from friction_audit.drift.session import Conditions, JointSummary, Session
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

LEVELS = {"coulomb_nm": 0.30, "viscous_nms_per_rad": 0.07}
ERRORS = {"coulomb_nm": 0.0095, "viscous_nms_per_rad": 0.061}
"""Standard errors, relative: those of ``chain``."""
SPREAD = 0.3
"""Of the logarithm of the errors."""
PER_K = {"coulomb_nm": -0.01, "viscous_nms_per_rad": -0.019}
CONDITIONS = Conditions(drive="hand", torque="interaction", gravity="removed", inertia="none")


@dataclass(frozen=True, kw_only=True)
class World:
    """What the sessions of an arm go through."""

    name: str  # for the table
    sessions: int = 30  # how many
    step: float = 0.0  # relative step of joint 3's Coulomb friction at a random session
    rise: float = 0.0  # its relative rise a session
    scatter: float = 0.005  # standard deviation between sessions beyond the errors
    correlation: float = 0.0  # of the scatter of a session with the next one's
    tails: float = np.inf  # degrees of freedom of the scatter; infinite for a normal one
    broken: float = 0.0  # share of the estimates that are off by a factor of 0.3 to 2
    warmth: bool = True  # whether the temperature is logged
    warming: float = 0.0  # rise of the temperature over the sessions [K]


WORLDS = (
    World(name="nothing changes, 30 sessions"),
    World(name="8 sessions", sessions=8),
    World(name="100 sessions", sessions=100),
    World(name="temperature not logged", warmth=False),
    World(name="temperature rises by 10 K", warming=10.0),
    World(name="scatter of 2 % with heavy tails (t, 3)", scatter=0.02, tails=3.0),
    World(name="one estimate in 50 is broken", broken=0.02),
    World(name="scatter of 2 %, correlation 0.4", scatter=0.02, correlation=0.4),
    World(name="scatter of 2 %, correlation 0.7", scatter=0.02, correlation=0.7),
    World(name="step of 15 %", step=0.15),
    World(name="step of 15 %, 8 sessions", step=0.15, sessions=8),
    World(name="step of 15 %, scatter of 2 %", step=0.15, scatter=0.02),
    World(name="step of 15 %, temperature not logged", step=0.15, warmth=False),
    World(name="step of 15 %, one estimate in 50 is broken", step=0.15, broken=0.02),
    World(name="step of 5 %", step=0.05),
    World(name="rise of 1 % a session, 20 sessions", rise=0.01, sessions=20),
    World(name="rise of 1 % a session, 10 sessions", rise=0.01, sessions=10),
)


def make_arm(world: World, rng: np.random.Generator, factor: Float) -> list[Session]:
    """Make the sessions of an arm.

    Args:
        world: What they go through.
        rng: For all that is random.
        factor: Of joint 3's Coulomb friction, shape (n,).
    """
    n = world.sessions
    warmth = 22.0 + 3.0 * rng.standard_normal(n) + world.warming * np.arange(n) / n
    columns = []
    for joint in range(1, JOINTS + 1):
        found = {name: estimate(world, rng, name, warmth) for name in LEVELS}
        if joint == DRIFTING:
            found["coulomb_nm"] = found["coulomb_nm"] * factor[:, None]
        columns.append(found)
    logged = [float(t) if world.warmth else None for t in warmth]
    return [
        make_session(
            i,
            tuple(summary(j, {name: found[name][i] for name in LEVELS}, logged[i]) for j, found in enumerate(columns)),
            CONDITIONS,
        )
        for i in range(n)
    ]


def estimate(world: World, rng: np.random.Generator, name: str, warmth: Float) -> Float:
    """Return estimates and their errors, shape (n, 2)."""
    n = world.sessions
    error = ERRORS[name] * np.exp(SPREAD * rng.standard_normal(n))
    shock = rng.standard_normal(n) if np.isinf(world.tails) else rng.standard_t(world.tails, n) / np.sqrt(3.0)
    for i in range(1, n):
        shock[i] = world.correlation * shock[i - 1] + np.sqrt(1.0 - world.correlation**2) * shock[i]
    value = np.exp(PER_K[name] * (warmth - 22.0)) * (1.0 + world.scatter * shock + error * rng.standard_normal(n))
    broken = rng.random(n) < world.broken
    value = np.where(broken, value * rng.uniform(0.3, 2.0, n), value)
    return np.asarray(LEVELS[name] * np.column_stack([value, error]))


def summary(j: int, found: dict[str, Float], temperature: float | None) -> JointSummary:
    """Return what is kept of one joint."""
    return JointSummary(
        joint=j + 1,
        name=f"joint{j + 1}",
        coefficients={
            name: Coefficient(value=float(v), low=float(v - 1.96 * s), high=float(v + 1.96 * s))
            for name, (v, s) in found.items()
        },
        cycles=20,
        moving_s=30.0,
        speed_rad_s=(0.4, 0.7, 1.0),
        temperature_c=temperature,
    )


def once(world: World, settings: DriftSettings, rng: np.random.Generator) -> Outcome:
    """Make and judge one arm."""
    n = world.sessions
    at = int(rng.integers(2, n - 1)) if world.step else None
    factor = 1.0 + world.rise * np.arange(n) + (world.step * (np.arange(n) >= at) if at is not None else 0.0)
    level = float(np.exp(np.mean(np.log(factor[: min(5, n // 2)]))))
    return judge(make_arm(world, rng, factor), settings, at, float(factor[-1]) / level - 1.0)


def page(arms: int, permutations: int, rows: Sequence[int]) -> Iterator[str]:
    """Yield the page, line by line; rows are counted from 1."""
    some = "" if len(rows) == len(WORLDS) else f" --rows {' '.join(map(str, rows))}"
    yield from heading(
        f"`python -m benchmarks.drift.summaries --arms {arms} --permutations {permutations}{some}`:\n"
        "summaries drawn at random, with the errors of `chain`, a scatter between sessions of 0.5 % where nothing\n"
        "else is said, and friction that falls by 1 % (Coulomb) and 1.9 % (viscous) per K. Shares in per cent, with\n"
        "95 % intervals."
    )
    settings = DriftSettings(permutations=permutations)
    for number in rows:
        world = WORLDS[number - 1]
        yield row(world.name, repeat(arms, 99 + number, partial(once, world, settings)))


def main() -> None:
    """Print the page, or write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=200)
    parser.add_argument("--permutations", type=int, default=499)
    numbers = range(1, len(WORLDS) + 1)
    parser.add_argument("--rows", type=int, nargs="+", choices=numbers, default=numbers, metavar="ROW")
    parser.add_argument("--output", type=Path)
    arguments = parser.parse_args()
    lines = []
    for line in page(arguments.arms, arguments.permutations, arguments.rows):
        print(line, flush=True)
        lines.append(line)
    if arguments.output:
        arguments.output.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

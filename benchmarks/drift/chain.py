"""Drift on the whole chain: simulated logs, estimated, pooled into arms of seven joints.

    python -m benchmarks.drift.chain [--sessions 600] [--arms 200] [--workers 2] [--output benchmarks/drift/chain.md]

1 000 sessions take about 2 minutes of one core, 1 000 arms about 50.
"""

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.drift.arms import Outcome, heading, judge, pool, repeat, row
from benchmarks.drift.library import DURATION_S, OneJoint, record_many
from friction_audit.drift.report import DriftSettings

SESSIONS = 30
STEP = 0.15
RISE = 0.01
FOUND_BY = 20


def nothing(rng: np.random.Generator, null: Sequence[OneJoint]) -> Outcome:
    """Judge an arm on which nothing changes."""
    return judge(pool(rng, null, None, SESSIONS), DriftSettings(), None, 0.0)


def step(rng: np.random.Generator, null: Sequence[OneJoint], after: Sequence[OneJoint]) -> Outcome:
    """Judge an arm with a step before a random session, two sessions at least on each side."""
    at = int(rng.integers(2, SESSIONS - 1))
    before = [null[k] for k in rng.choice(len(null), size=at, replace=False)]
    later = [after[k] for k in rng.choice(len(after), size=SESSIONS - at, replace=False)]
    reference = np.where(np.arange(5) >= at, 1.0 + STEP, 1.0)
    true = (1.0 + STEP) / float(np.exp(np.mean(np.log(reference)))) - 1.0
    return judge(pool(rng, null, [*before, *later], SESSIONS), DriftSettings(), at, true)


def ramp(rng: np.random.Generator, null: Sequence[OneJoint], rising: Sequence[Sequence[OneJoint]]) -> Outcome:
    """Judge an arm whose friction rises by 1 % of its first level a session, after so many sessions."""
    drifting = [level[int(rng.integers(len(level)))] for level in rising]
    true = (1.0 + RISE * (len(rising) - 1)) / (1.0 + RISE * 2.0) - 1.0
    return judge(pool(rng, null, drifting, len(rising)), DriftSettings(), None, true)


def page(sessions: int, arms: int, workers: int) -> Iterator[str]:
    """Yield the page, line by line."""
    null = record_many(1.0, sessions, 0, workers)
    after = record_many(1.0 + STEP, max(sessions // 4, SESSIONS), 1_000_000, workers)
    rising = [
        record_many(1.0 + RISE * i, max(sessions // 60, 4), 2_000_000 + 1000 * i, workers) for i in range(FOUND_BY)
    ]
    yield from heading(
        f"`python -m benchmarks.drift.chain --sessions {sessions} --arms {arms}`: each session of a joint is a\n"
        f"simulated log of {DURATION_S:g} s through `estimate`; {sessions} sessions without drift are pooled into\n"
        "arms of seven joints. Room temperature (22 degC, standard deviation 3 K, logged), speed (0.5 to 1.3 rad/s)\n"
        "and sensor noise (0.7 to 1.5 times a Panda's) differ from session to session; joints warm up in a session.\n"
        "Shares in per cent, with 95 % intervals."
    )
    yield row(f"nothing changes, {SESSIONS} sessions", repeat(arms, 1, lambda rng: nothing(rng, null)))
    yield row(
        f"step of 15 % at a random one of {SESSIONS} sessions", repeat(arms, 2, lambda rng: step(rng, null, after))
    )
    yield row(f"rise of 1 % a session, {FOUND_BY} sessions", repeat(arms, 3, lambda rng: ramp(rng, null, rising)))
    yield ""
    yield from scatter(null)


def scatter(null: Sequence[OneJoint]) -> Iterator[str]:
    """Tell how the sessions scatter, for the study on summaries."""
    for name in ("coulomb_nm", "viscous_nms_per_rad"):
        found = [one.summary.coefficients[name] for one in null]
        value = np.array([c.value for c in found])
        error = np.array([c.high - c.low for c in found]) / 3.92 / value
        warmth = np.array([one.summary.temperature_c for one in null], dtype=float)
        fit = np.polyfit(warmth - np.mean(warmth), np.log(value), 1)
        left = np.log(value) - np.polyval(fit, warmth - np.mean(warmth))
        yield (
            f"- `{name}`: standard error {100 * float(np.median(error)):.2g} % (median; "
            f"{100 * float(np.quantile(error, 0.05)):.2g} to {100 * float(np.quantile(error, 0.95)):.2g} %), standard "
            f"deviation between sessions at like temperature {100 * float(np.std(left)):.2g} %, "
            f"{100 * float(fit[0]):.2g} % per K"
        )


def main() -> None:
    """Print the page, or write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sessions", type=int, default=600)
    parser.add_argument("--arms", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--output", type=Path)
    arguments = parser.parse_args()
    text = "\n".join(page(arguments.sessions, arguments.arms, arguments.workers)) + "\n"
    print(text)
    if arguments.output:
        arguments.output.write_text(text)


if __name__ == "__main__":
    main()

"""The tables of the studies."""

from collections import Counter
from collections.abc import Iterator, Sequence

from scipy.stats import binomtest

from benchmarks.drift.arms import Outcome


def heading(made_by: str) -> Iterator[str]:
    """Yield how the table was made, and its head."""
    yield f"Made by {made_by}"
    yield ""
    yield (
        "| sessions | arms | drift reported | of joint 3, Coulomb | of another | within one session | moment covered | "
        "size covered | described as |"
    )
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"


def row(name: str, outcomes: Sequence[Outcome]) -> str:
    """Return one row; shares in per cent with their 95 % intervals."""
    timed = [outcome for outcome in outcomes if outcome.off is not None and outcome.found]
    shapes = Counter(outcome.shape for outcome in outcomes).most_common(3)
    cells = [
        name,
        str(len(outcomes)),
        share([o.drift for o in outcomes]),
        share([o.found for o in outcomes]),
        share([o.falsely for o in outcomes]),
        share([(o.off or 0) <= 1 for o in timed]),
        share([bool(o.covered) for o in timed]),
        share([o.size_covered for o in outcomes]),
        ", ".join(f"{shape} {100 * count / len(outcomes):.0f} %" for shape, count in shapes),
    ]
    return f"| {' | '.join(cells)} |"


def share(cases: Sequence[bool]) -> str:
    """Return how many of the cases hold, with the interval of Clopper and Pearson."""
    if not cases:
        return ""
    interval = binomtest(sum(cases), len(cases)).proportion_ci(0.95)
    return f"{100 * sum(cases) / len(cases):.3g} ({100 * interval.low:.2g} to {100 * interval.high:.3g})"

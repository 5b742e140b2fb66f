"""Comparison of methods: sweeps, choice of tunings, trials and stability margins."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import takewhile
from math import ceil, inf, isinf, sqrt
from typing import Any

from friction_audit.compensation.comparison import methods as kinds, result
from friction_audit.parallel import in_processes, workers_for
from friction_audit.simulation.bench import Progress
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import SomeSettings

REFERENCE_SHARE, SWEEP_SHARE, TRIAL_SHARE = 0.05, 0.3, 0.6  # progress after each stage before the margins
FIRST_TUNING_SEED = 10_000  # the sweeps use other persons than the reported trials
LARGEST = 32.0  # factor of the gain up to which a stability margin is searched
HALVINGS = 4  # bisections: the margin is then known to 2^(1/16), 4 %


def compare(
    setup: kinds.Setup, seeds: int, methods: Sequence[kinds.Method] = kinds.METHODS, progress: Progress | None = None
) -> result.Comparison:
    """Compare methods on the same setup, noise and persons, whose seeds are 0, 1, 2 and so on."""
    reported, first = tuple(range(seeds)), FIRST_TUNING_SEED
    tuning_seeds, margin_seeds = tuple(range(first, first + setup.tuning_seeds)), reported[: setup.margin_seeds]
    trials = _Trials(setup, (*reported, *tuning_seeds), progress or (lambda _: None))
    curves = trials.sweep(methods, tuning_seeds)
    chosen = [(method, *one) for method in methods for one in _tunings(setup, method, curves)]
    own = {(method.name, tuning.name): tuning for method, tuning, *_ in chosen}  # the best one may be that of the paper
    tunings = [*own.values()]
    tried = zip(trials.outcomes(tunings, reported, TRIAL_SHARE), trials.margins(tunings, margin_seeds), strict=True)
    found = dict(zip(own, tried, strict=True))
    rows = [
        result.Row(
            method=method.name,
            label=method.label,
            tuning=tuning,
            role=role,
            tuning_losses=losses,
            outcomes=tuple(outcome for outcome, _ in trials),
            margins=margins,
            margin=result.median_interval(margins),
            course=trials[0][1],
        )
        for method, tuning, role, losses in chosen
        for trials, margins in [found[method.name, tuning.name]]
    ]
    return result.Comparison(
        setup=setup.name,
        duration_s=setup.settings.duration_s,
        seeds=reported,
        tuning_seeds=tuning_seeds,
        margin_seeds=margin_seeds,
        rows=tuple(rows),
        curves=curves,
    )


def _tunings(
    setup: kinds.Setup, method: kinds.Method, curves: Sequence[result.Curve]
) -> Iterator[tuple[kinds.Tuning, str, int | None]]:
    """Yield the reported tunings of a method, their role and, of the best one, its unstable trials in the sweeps."""
    chosen = [(method.paper, kinds.PAPER, None)] + ([(method.full, kinds.FULL, None)] if method.full else [])
    yield from chosen
    names = {tuning.name for tuning, *_ in chosen}
    points = [point for curve in curves if curve.method == method.name for point in curve.points]
    if points:
        best = choose_best(points)
        yield best.tuning, kinds.BEST, len(best.lost_s)
        names.add(best.tuning.name)
    if setup.with_others:
        # A further tuning that is also the best one is not repeated.
        yield from ((tuning, kinds.OTHER, None) for tuning in method.others if tuning.name not in names)


class _Trials:
    """The trials of one comparison."""

    def __init__(self, setup: kinds.Setup, seeds: Sequence[int], progress: Progress) -> None:
        self.setup, self.first, self.progress, self._done = setup, seeds[0], progress, 0.0
        idle = setup.compensated(kinds.NO_COMPENSATION)

        def run_reference(seed: int) -> tuple[result.Reference, result.Outcome, result.Course]:
            simulation = simulate(idle, seed)
            reference = result.find_reference(simulation)
            return reference, result.measure(simulation, reference), result.make_course(simulation, reference)

        # Of each seed: the trial without compensation as reference, outcome and course. The first one runs in this
        # process, so that the worker processes share the loops that it compiles or loads.
        found = [run_reference(seeds[0]), *self._map(run_reference, [(seed,) for seed in seeds[1:]], REFERENCE_SHARE)]
        self.idle = dict(zip(seeds, found, strict=True))

    def _map(self, work: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], until: float) -> list[Any]:
        """Return the results of work, called with the arguments of each job; the progress rises to ``until``."""
        results, begun, count = [], self._done, len(jobs)
        for done in in_processes(lambda place: work(*jobs[place]), count, workers_for(count)):
            results.append(done)
            self._done = begun + (until - begun) * len(results) / count
            self.progress(self._done)
        return results

    def _run_all(
        self, work: Callable[[Any, int], Any], settings: Sequence[Any], seeds: Sequence[int], until: float
    ) -> list[list[Any]]:
        done = iter(self._map(work, [(one, seed) for one in settings for seed in seeds], until))
        return [[next(done) for _ in seeds] for _ in settings]

    def sweep(self, methods: Sequence[kinds.Method], seeds: Sequence[int]) -> tuple[result.Curve, ...]:
        """Run the sweeps of all methods."""
        sweeps = [(method, sweep) for method in methods for sweep in method.sweeps[: self.setup.sweeps]]
        values = [sweep.values[:: ceil(len(sweep.values) / self.setup.most_values)] for _, sweep in sweeps]
        tunings = [sweep.at(value) for (_, sweep), some in zip(sweeps, values, strict=True) for value in some]
        tried = zip(tunings, self.outcomes(tunings, seeds, SWEEP_SHARE), strict=True)
        curves = []
        for (method, sweep), some in zip(sweeps, values, strict=True):
            points = [
                result.Point(value=value, tuning=tuning, outcomes=tuple(outcome for outcome, _ in trials))
                for value, (tuning, trials) in zip(some, tried, strict=False)
            ]
            stable = [point.value for point in takewhile(lambda point: not point.lost_s, points)]
            boldest = stable[-1] if stable else None
            curves.append(result.Curve(method.name, method.label, sweep.name, sweep.axis, tuple(points), boldest))
        return tuple(curves)

    def outcomes(
        self, tunings: Sequence[kinds.Tuning], seeds: Sequence[int], until: float
    ) -> list[list[tuple[result.Outcome, Any]]]:
        """Return outcome and course of every tuning and seed; the course is None except for the first person."""
        settings = [self.setup.compensated(tuning) for tuning in tunings if tuning is not kinds.NO_COMPENSATION]

        def work(one: SomeSettings, seed: int) -> tuple[result.Outcome, result.Course | None]:
            simulation, reference = simulate(one, seed), self.idle[seed][0]
            course = result.make_course(simulation, reference) if seed == self.first else None
            return result.measure(simulation, reference), course

        tried, idle = iter(self._run_all(work, settings, seeds, until)), [self.idle[seed][1:] for seed in seeds]
        return [idle if tuning is kinds.NO_COMPENSATION else next(tried) for tuning in tunings]

    def margins(self, tunings: Sequence[kinds.Tuning], seeds: Sequence[int]) -> list[tuple[float, ...]]:
        """Return the stability margins of every tuning, one per seed."""
        settings = self.setup.settings
        shorter = replace(settings, duration_s=self.setup.margin_share * settings.duration_s)
        short = replace(self.setup, settings=shorter)

        def margin(tuning: kinds.Tuning, seed: int) -> float:
            tried = partial(short.compensated, tuning)
            return find_margin(
                lambda factor: isinf(result.find_instability(simulate(tried(factor), seed), self.idle[seed][0]))
            )

        return [tuple(own) for own in self._run_all(margin, tunings, seeds, 1.0)]


def choose_best(points: Sequence[result.Point]) -> result.Point:
    """Return the point of all sweeps with fewest unstable trials and, of these, the energy slope closest to zero."""
    slopes = [[abs(one.energy_slope_w) for one in point.outcomes if isinf(one.lost_s)] for point in points]
    badness = [(len(point.lost_s), result.mean_interval(own).value) for point, own in zip(points, slopes, strict=True)]
    return points[badness.index(min(badness))]


def find_margin(holds: Callable[[float], bool]) -> float:
    """Return the largest stable factor of the gain, by doubling and bisection; 0 if 1 is unstable, or infinity."""
    if not holds(1.0):
        return 0.0
    low, high = 1.0, 2.0
    while holds(high):
        if high >= LARGEST:
            return inf
        low, high = high, 2.0 * high
    for _ in range(HALVINGS):
        middle = sqrt(low * high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low

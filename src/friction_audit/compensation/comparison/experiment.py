"""The methods side by side: sweeps, the choice of tunings, trials and stability margins."""

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

REFERRED, SWEPT, TRIED = 0.05, 0.3, 0.6  # shares that are done, about, after the stages before the margins
FIRST_TUNING_SEED = 10_000  # the sweeps are made for other persons than those that are reported
LARGEST = 32.0  # factor of the gain up to which a stability margin is searched; more is of no interest
HALVINGS = 4  # the limit is then known to 2^(1/16), 4 %


def compare(
    scene: kinds.Scene, seeds: int, methods: Sequence[kinds.Method] = kinds.METHODS, progress: Progress | None = None
) -> result.Comparison:
    """Try methods on the same operator, arm, noise and persons, whose seeds are 0, 1, 2 and so on."""
    reported, first = tuple(range(seeds)), FIRST_TUNING_SEED
    tuning_seeds, margin_seeds = tuple(range(first, first + scene.tuning_seeds)), reported[: scene.margin_seeds]
    trials = _Trials(scene, (*reported, *tuning_seeds), progress or (lambda _: None))
    curves = trials.sweep(methods, tuning_seeds)
    chosen = [(method, *one) for method in methods for one in _tunings(scene, method, curves)]
    own = {(method.name, tuning.name): tuning for method, tuning, *_ in chosen}  # the best may be the paper's
    tunings = [*own.values()]
    tried = zip(trials.of(tunings, reported, TRIED), trials.margins(tunings, margin_seeds), strict=True)
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
        scene=scene.name,
        duration_s=scene.settings.duration_s,
        seeds=reported,
        tuning_seeds=tuning_seeds,
        margin_seeds=margin_seeds,
        rows=tuple(rows),
        curves=curves,
    )


def _tunings(
    scene: kinds.Scene, method: kinds.Method, curves: Sequence[result.Curve]
) -> Iterator[tuple[kinds.Tuning, str, int | None]]:
    """Yield the tunings of a method that are reported: role, and losses in the sweep that one was chosen from."""
    chosen = [(method.paper, kinds.PAPER, None)] + ([(method.full, kinds.FULL, None)] if method.full else [])
    yield from chosen
    names = {tuning.name for tuning, *_ in chosen}
    points = [point for curve in curves if curve.method == method.name for point in curve.points]
    if points:
        best = choose_best(points)
        yield best.tuning, kinds.BEST, len(best.lost_s)
        names.add(best.tuning.name)
    if scene.with_others:
        # A further tuning that is the best one has its row already.
        yield from ((tuning, kinds.OTHER, None) for tuning in method.others if tuning.name not in names)


class _Trials:
    """The trials of one comparison."""

    def __init__(self, scene: kinds.Scene, seeds: Sequence[int], progress: Progress) -> None:
        self.scene, self.first, self.progress, self._share = scene, seeds[0], progress, 0.0
        idle = scene.compensated(kinds.NO_COMPENSATION)

        def refer(place: int) -> tuple[result.Reference, result.Outcome, result.Course]:
            simulation = simulate(idle, seeds[place])
            reference = result.find_reference(simulation)
            return reference, result.measure(simulation, reference), result.make_course(simulation, reference)

        # Of each seed: the reference, and outcome and course of that trial, which is the one without compensation. The
        # first is made here: the loops that it compiles or loads are then those of all processes.
        found = [refer(0), *self._map(lambda place: refer(place + 1), len(seeds) - 1, REFERRED)]
        self.idle = dict(zip(seeds, found, strict=True))

    def _map(self, work: Callable[[int], Any], jobs: int, until: float) -> list[Any]:
        """Return the results of jobs (0-based) in their order, and report the progress up to a share."""
        results, begun = [], self._share
        for done in in_processes(work, jobs, workers_for(jobs)):
            results.append(done)
            self._share = begun + (until - begun) * len(results) / jobs
            self.progress(self._share)
        return results

    def _each(
        self, work: Callable[[Any, int], Any], settings: Sequence[Any], seeds: Sequence[int], until: float
    ) -> list[list[Any]]:
        jobs = [(one, seed) for one in settings for seed in seeds]
        done = iter(self._map(lambda place: work(*jobs[place]), len(jobs), until))
        return [[next(done) for _ in seeds] for _ in settings]

    def sweep(self, methods: Sequence[kinds.Method], seeds: Sequence[int]) -> tuple[result.Curve, ...]:
        """Make the sweeps of methods, all trials at once."""
        scene = self.scene
        sweeps = [(method, sweep) for method in methods for sweep in method.sweeps[: scene.sweeps]]
        values = [sweep.values[:: ceil(len(sweep.values) / scene.most_values)] for _, sweep in sweeps]
        tunings = [sweep.at(value) for (_, sweep), some in zip(sweeps, values, strict=True) for value in some]
        tried = zip(tunings, self.of(tunings, seeds, SWEPT), strict=True)
        curves = []
        for (method, sweep), some in zip(sweeps, values, strict=True):
            points = [
                result.Point(value=value, tuning=tuning, outcomes=tuple(outcome for outcome, _ in trials))
                for value, (tuning, trials) in zip(some, tried, strict=False)
            ]
            held = [point.value for point in takewhile(lambda point: not point.lost_s, points)]
            boldest = held[-1] if held else None
            curves.append(result.Curve(method.name, method.label, sweep.name, sweep.axis, tuple(points), boldest))
        return tuple(curves)

    def of(
        self, tunings: Sequence[kinds.Tuning], seeds: Sequence[int], until: float
    ) -> list[list[tuple[result.Outcome, Any]]]:
        """Return the outcome of every tuning and seed, and the course of the first person who is reported, or None."""
        settings = [self.scene.compensated(tuning) for tuning in tunings if tuning is not kinds.NO_COMPENSATION]

        def work(one: SomeSettings, seed: int) -> tuple[result.Outcome, result.Course | None]:
            simulation, reference = simulate(one, seed), self.idle[seed][0]
            course = result.make_course(simulation, reference) if seed == self.first else None
            return result.measure(simulation, reference), course

        tried, idle = iter(self._each(work, settings, seeds, until)), [self.idle[seed][1:] for seed in seeds]
        return [idle if tuning is kinds.NO_COMPENSATION else next(tried) for tuning in tunings]

    def margins(self, tunings: Sequence[kinds.Tuning], seeds: Sequence[int]) -> list[tuple[float, ...]]:
        """Return the stability margins of every tuning, one per seed."""
        settings = self.scene.settings
        shorter = replace(settings, duration_s=self.scene.margin_share * settings.duration_s)
        short = replace(self.scene, settings=shorter)

        def margin(tuning: kinds.Tuning, seed: int) -> float:
            tried = partial(short.compensated, tuning)
            return find_margin(
                lambda factor: isinf(result.find_loss(simulate(tried(factor), seed), self.idle[seed][0]))
            )

        return [tuple(own) for own in self._each(margin, tunings, seeds, 1.0)]


def choose_best(points: Sequence[result.Point]) -> result.Point:
    """Return the point of all sweeps with fewest losses and, of these, the energy slope closest to zero."""
    slopes = [[abs(one.energy_slope_w) for one in point.outcomes if isinf(one.lost_s)] for point in points]
    badness = [(len(point.lost_s), result.mean_interval(own).value) for point, own in zip(points, slopes, strict=True)]
    return points[badness.index(min(badness))]


def find_margin(holds: Callable[[float], bool]) -> float:
    """Search the largest factor of the gain that holds by doubling and bisection; 0 if 1 does not, or infinity."""
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

"""The methods side by side: sweeps, the choice of tunings, trials and stability margins."""

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from math import ceil, inf, isinf, sqrt
from multiprocessing import get_context
from os import cpu_count
from typing import Any, NamedTuple

from friction_audit.compensation.comparison.methods import (
    BEST,
    FULL,
    METHODS,
    NO_COMPENSATION,
    OTHER,
    PAPER,
    Joint,
    Method,
    Scene,
    Sweep,
    Tuning,
)
from friction_audit.compensation.comparison.result import Comparison, Curve, Point, Row
from friction_audit.compensation.comparison.trial import (
    Course,
    Outcome,
    Reference,
    find_loss,
    find_reference,
    make_course,
    measure,
)
from friction_audit.compensation.compensators import (
    Compensator,
    DisturbanceObserver,
    EnergyCompensator,
    FixedCompensation,
    JointModelCompensation,
    LugreCompensation,
    SigmoidCompensation,
    TorqueRegulation,
)
from friction_audit.errors import UsageError
from friction_audit.simulation.scenarios import simulate

Progress = Callable[[float], None]  # receives the share that is done, 0 to 1
FIRST_TUNING_SEED = 10_000  # the sweeps are made for other persons than those that are reported
MARGIN_TRIALS = 6  # simulations that a stability margin takes, about


class _Trial(NamedTuple):
    """Everything that a trial takes, without what only this process knows."""

    settings: Any
    seed: int
    reference: Reference
    drawn: bool


class Candidate(NamedTuple):
    """A row before its trials; its fields are those of ``Row``."""

    method: Method
    tuning: Tuning
    role: str
    tuning_losses: int | None = None


def compare(
    scene: Scene, seeds: int, methods: Sequence[Method] = METHODS, progress: Progress | None = None
) -> Comparison:
    """Try all methods on the same operator, arm, noise and seeds.

    Args:
        scene: Who moves what.
        seeds: Number of persons that are reported; their seeds are 0, 1, 2 and so on.
        methods: The methods.
        progress: Called with the share that is done, 0 to 1.

    Raises:
        AnalysisError: If the trials are too short.
    """
    with _pool(scene) as pool:
        return _Experiment(scene, seeds, tuple(methods), pool, progress).run()


@contextmanager
def _pool(scene: Scene) -> Iterator[Executor]:
    """Yield workers: threads where compiled loops give the interpreter away, else processes."""
    workers = cpu_count() or 1
    if scene.needs_processes:
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as processes:
            yield processes
    else:
        with ThreadPoolExecutor(workers, thread_name_prefix="trial") as threads:
            yield threads


class _Experiment:
    """One comparison under way."""

    def __init__(
        self, scene: Scene, seeds: int, methods: tuple[Method, ...], pool: Executor, progress: Progress | None
    ) -> None:
        self.scene, self.methods, self.pool, self.progress = scene, methods, pool, progress
        self.seeds = tuple(range(seeds))
        self.tuning_seeds = tuple(FIRST_TUNING_SEED + n for n in range(scene.plan.tuning_seeds))
        self.margin_seeds = self.seeds[: scene.plan.margin_seeds]
        self._done, self._all = 0, self._count()

    def _count(self) -> int:
        """Return the number of trials, about."""
        values = sum(len(self._values(sweep)) for _, sweep in self._sweeps())
        others = sum(len(method.others) for method in self.methods) if self.scene.plan.with_others else 0
        rows = sum(1 + bool(method.full) + bool(method.sweeps) for method in self.methods) + others - 1
        references = len(self.seeds) + len(self.tuning_seeds)
        margins = MARGIN_TRIALS * len(self.margin_seeds)
        return references + values * len(self.tuning_seeds) + rows * (len(self.seeds) + margins)

    def _values(self, sweep: Sweep) -> tuple[float, ...]:
        return sweep.values[:: ceil(len(sweep.values) / self.scene.plan.most_values)]

    def _sweeps(self) -> list[tuple[Method, Sweep]]:
        return [(method, sweep) for method in self.methods for sweep in method.sweeps[: self.scene.plan.sweeps]]

    def run(self) -> Comparison:
        """Sweep, choose, try."""
        references = self._references((*self.seeds, *self.tuning_seeds))
        curves = self._sweep(references)
        candidates = [one for method in self.methods for one in self._candidates(method, curves)]
        return Comparison(
            scene=self.scene.name,
            title=self.scene.title,
            duration_s=self.scene.settings.duration_s,
            seeds=self.seeds,
            tuning_seeds=self.tuning_seeds,
            margin_seeds=self.margin_seeds,
            rows=self._try(candidates, references),
            curves=curves,
        )

    def _map(self, work: Callable[[Any], Any], jobs: Iterable[Any]) -> list[Any]:
        """Work jobs off, in their order, and tell how far it is."""
        results = []
        for result in self.pool.map(work, list(jobs)):
            results.append(result)
            self._done += 1
            if self.progress is not None:
                self.progress(min(self._done / self._all, 1.0))
        return results

    def _references(self, seeds: Sequence[int]) -> dict[int, Reference]:
        settings = self.scene.compensated(NO_COMPENSATION)
        found = self._map(_refer, [(settings, seed) for seed in seeds])
        self._uncompensated = {seed: trial for seed, (_, trial) in zip(seeds, found, strict=True)}
        return {seed: reference for seed, (reference, _) in zip(seeds, found, strict=True)}

    def _sweep(self, references: dict[int, Reference]) -> tuple[Curve, ...]:
        """Make the sweeps of all methods, all trials in one heap."""
        sweeps = self._sweeps()
        if not sweeps:
            return ()
        tunings = [sweep.at(value) for _, sweep in sweeps for value in self._values(sweep)]
        heaps = iter(self._trials(tunings, self.tuning_seeds, references))
        curves = []
        for method, sweep in sweeps:
            values = self._values(sweep)
            points = tuple(Point(value=value, tuning=sweep.at(value), outcomes=next(heaps)[0]) for value in values)
            curves.append(Curve(method.name, method.label, sweep.name, sweep.axis, points))
        return tuple(curves)

    def _trials(
        self, tunings: Sequence[Tuning], seeds: Sequence[int], references: dict[int, Reference], *, drawn: bool = False
    ) -> list[tuple[tuple[Outcome, ...], Course | None]]:
        """Return the outcomes of every tuning, one per seed, and the course of the first if it is to be drawn."""
        settings = [self.scene.compensated(tuning) for tuning in tunings if tuning is not NO_COMPENSATION]
        jobs = [_Trial(one, seed, references[seed], drawn and seed == seeds[0]) for one in settings for seed in seeds]
        done = iter(self._map(_work, jobs))
        heaps = [
            [self._uncompensated[seed] if tuning is NO_COMPENSATION else next(done) for seed in seeds]
            for tuning in tunings
        ]
        return [(tuple(outcome for outcome, _ in heap), heap[0][1]) for heap in heaps]

    def _candidates(self, method: Method, curves: Sequence[Curve]) -> Iterator[Candidate]:
        """Yield the tunings of a method that are reported."""
        mine = [curve for curve in curves if curve.method == method.name]
        chosen = [Candidate(method, method.paper, PAPER)]
        if method.full is not None:
            chosen.append(Candidate(method, method.full, FULL))
        if mine:
            chosen.append(choose_best(method, mine))
        yield from chosen
        if self.scene.plan.with_others:
            # A further tuning that is the best one has its row already.
            named = {one.tuning.name for one in chosen}
            yield from (Candidate(method, tuning, OTHER) for tuning in method.others if tuning.name not in named)

    def _try(self, candidates: Sequence[Candidate], references: dict[int, Reference]) -> tuple[Row, ...]:
        tried = self._trials([one.tuning for one in candidates], self.seeds, references, drawn=True)
        margins = self._margins([one.tuning for one in candidates], references)
        rows = []
        for one, (outcomes, course), own in zip(candidates, tried, margins, strict=True):
            assert course is not None  # that of the first seed
            named = (one.method.name, one.method.label, one.tuning, one.role, one.tuning_losses)
            rows.append(Row(*named, outcomes=outcomes, margins=own, course=course))
        return tuple(rows)

    def _margins(self, tunings: Sequence[Tuning], references: dict[int, Reference]) -> list[tuple[float, ...]]:
        """Return the stability margins of every tuning, one per seed."""
        seeds, settings = self.margin_seeds, self.scene.settings
        shorter = replace(settings, duration_s=self.scene.plan.margin_share * settings.duration_s)
        short = replace(self.scene, settings=shorter)
        searches = [(tuning, seed) for tuning in tunings for seed in seeds]

        def hold(asked: Sequence[tuple[int, float]]) -> list[bool]:
            jobs = []
            for number, factor in asked:
                tuning, seed = searches[number]
                bolder = short.compensated(amplified(tuning, factor))
                jobs.append(_Trial(bolder, seed, references[seed], drawn=False))
            return self._map(_holds, jobs)

        margins = find_margins(len(searches), hold)
        return [tuple(margins[n * len(seeds) : (n + 1) * len(seeds)]) for n in range(len(tunings))]


def _refer(job: tuple[Any, int]) -> tuple[Reference, tuple[Outcome, Course]]:
    """Return the reference of a seed, and the outcome of that trial, which is the one without compensation."""
    simulation = simulate(*job)
    reference = find_reference(simulation)
    return reference, (measure(simulation, reference), make_course(simulation, reference))


def _work(trial: _Trial) -> tuple[Outcome, Course | None]:
    simulation = simulate(trial.settings, trial.seed)
    course = make_course(simulation, trial.reference) if trial.drawn else None
    return measure(simulation, trial.reference), course


def _holds(trial: _Trial) -> bool:
    return isinf(find_loss(simulate(trial.settings, trial.seed), trial.reference))


def choose_best(method: Method, curves: Sequence[Curve]) -> Candidate:
    """Return the tuning of all sweeps whose energy slope is closest to zero; of equals, the first.

    Only tunings with which no person of the sweeps lost the loop count; where there is none, those with which fewest
    did, and the row says so.
    """
    points = [point for curve in curves for point in curve.points]
    best = min(points, key=lambda point: (point.losses, point.off_w))
    return Candidate(method, best.tuning, BEST, best.losses)


LARGEST = (
    32.0  # stability margin: by which factor the gain may grow before the loop is unstable; more is of no interest
)
HALVINGS = 4  # the limit is then known to 2^(1/16), 4 %


def amplified(tuning: Tuning, factor: float) -> Tuning:
    """Return a tuning with its gain times a factor."""

    def make(joint: Joint) -> Compensator:
        return amplify(tuning.make(joint), factor)

    return replace(tuning, make=make)


def amplify(compensator: Compensator, factor: float) -> Compensator:
    """Return a compensator with its gain times a factor.

    The gain is what stands between what is measured and the torque: the whole law of a model, the factor on the
    estimate of the energy method, the bandwidth of an observer, the torque gain B / B_theta - 1 of a torque regulation.

    Raises:
        UsageError: For the terms of a model file, which run in a replay only.
    """
    match compensator:
        case FixedCompensation() | SigmoidCompensation() | LugreCompensation():
            return compensator.scaled(factor)
        case EnergyCompensator():
            return replace(compensator, factor=factor * compensator.factor)
        case DisturbanceObserver():
            return replace(compensator, observer_gain_per_s=factor * compensator.observer_gain_per_s)
        case TorqueRegulation():
            inertia = compensator.inertia_kg_m2 / (1.0 + factor * compensator.torque_gain)
            return replace(compensator, desired_inertia_kg_m2=inertia)
        case JointModelCompensation():
            raise UsageError("margin: the terms of a model file have no gain; expected a compensator of compare")


def search_margin() -> Generator[float, bool, float]:
    """Search the largest stable factor by doubling and bisection.

    Yields:
        A factor; expects to be sent whether the loop holds with it.

    Returns:
        The largest stable factor; infinity if ``LARGEST`` is stable, 0 if 1 is not.
    """
    if not (yield 1.0):
        return 0.0
    low, high = 1.0, 2.0
    while (yield high):
        if high >= LARGEST:
            return inf
        low, high = high, 2.0 * high
    for _ in range(HALVINGS):
        middle = sqrt(low * high)
        low, high = (middle, high) if (yield middle) else (low, middle)
    return low


def find_margins(searches: int, hold: Callable[[Sequence[tuple[int, float]]], Sequence[bool]]) -> list[float]:
    """Return several margins, searched for side by side."""
    margins = [0.0] * searches
    under_way = {number: search_margin() for number in range(searches)}
    asked = {number: next(search) for number, search in under_way.items()}
    while asked:
        answers = hold(tuple(asked.items()))
        following: dict[int, float] = {}
        for number, answer in zip(asked, answers, strict=True):
            try:
                following[number] = under_way[number].send(answer)
            except StopIteration as end:
                margins[number] = end.value
        asked = following
    return margins

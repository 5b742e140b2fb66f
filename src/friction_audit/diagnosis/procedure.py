"""The diagnosis of one joint, from the prepared motion to the result."""

from collections.abc import Sequence

import numpy as np

from friction_audit.diagnosis import contact_events, selection
from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.fitted_model import FittedModel, gains
from friction_audit.diagnosis.gram import Gram, Training
from friction_audit.diagnosis.noise import NoiseModel
from friction_audit.diagnosis.nonlinear import refine
from friction_audit.diagnosis.problem import AXES, PLAUSIBLE_SD, SIGNS, Nuisance, RegressionProblem, curve, knots_of
from friction_audit.diagnosis.samples import least_squares
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.joint_model import JointModel
from friction_audit.effects.registry import GRAVITY
from friction_audit.joint_log import Float

LEAST_Z = 2.0  # standard errors by which a held-out residual must shrink
LEAST_SHARE = 0.1  # rms of an effect over that of what is left: 0.5 % of the rms
# Variance inflation factor of what is collinear (S. Menard, Applied Logistic Regression Analysis, 1995), and share of
# what is left that its own part must be: errors of formulas grow by the root of that factor (whole_arms: ur one none
# 220000, joint 1, has nonlinear_viscous; iiwa sines none 220000, joint 2, warm_up less friction_step).
COLLINEAR, LEAST_OWN = 5.0, 0.5
REPEATS = 2
EFFECT_ERROR = 0.1  # of the torque of a named effect
GRAVITY_PARTS = (0.0, 0.1, 0.3, 1.0)  # of that: a sine of the angle may be exact
TRANSMISSION_ERROR = 0.25  # the same of a spring or a gap: the link side is known roughly
DROWNED = 0.25  # share of the mean square that gravity leaves, below which noise is estimated again given it at once
CHANGED = 0.02  # rms of the change of the nominal torque from which columns that need it are built again


class State:
    """Everything that the stages hand on."""

    def __init__(
        self,
        problem: RegressionProblem,
        dictionary: Dictionary,
        nuisances: Sequence[Nuisance],
        noise: NoiseModel,
        numbers: int,
    ) -> None:
        self.problem, self.dictionary = problem, dictionary
        self.gram = Gram(problem, noise, nuisances, dictionary.blocks)
        self.active: list[Block] = []
        self.contacts: tuple[contact_events.Contact, ...] = ()
        self.disturbed: RegressionProblem | None = None  # with the samples of the contacts
        self.folds: dict[str, int] | None = None
        training = Training(self.gram)

        def moved(block: Block, others: Sequence[Block]) -> Block | None:
            together = [*others, block] if block.effect.needs_nominal else others
            return refine(dictionary, training, block, others, FittedModel(training, together).nominal)

        def complete(name: str) -> list[Block]:
            return [block for block in dictionary.complete(name) if block.p + block.numbers <= numbers]

        self.search = selection.Search(training, moved, numbers, withheld=dictionary.withheld, complete=complete)

    def fitted(self, active: Sequence[Block] | None = None) -> FittedModel:
        """The model with the active effects, or others."""
        return FittedModel(self.search.training, self.active if active is None else active)


def select(data: JointData, model: JointModel | None, effects: Sequence[Effect]) -> State:
    """Everything up to the active set."""
    problem = RegressionProblem.build(data, model)
    state = _selected(problem, effects)
    if data.unknown_gravity:  # that of other joints looks like pushes
        return state
    fitted = state.fitted()
    left = contact_events.without_impulses(problem, fitted.residual, fitted.fine_residual)
    errors = [_formula_error(block) * torque for block, torque in zip(state.active, fitted.torques, strict=True)]
    contacts = contact_events.detect(problem, left, state.gram.noise, errors)
    if contacts:
        state = _selected(problem.without(contact_events.touched(problem, contacts)), effects)
        state.contacts, state.disturbed = contacts, problem
    return state


def _selected(problem: RegressionProblem, effects: Sequence[Effect]) -> State:
    gravity = problem.columns((problem.data.torque - problem.data.without_gravity)[:, None])[0]
    rows = np.vstack([problem.X, problem.left_to_effects])
    baseline = problem.nominal.baseline(least_squares(rows, problem.y - gravity)[: len(problem.X)])
    nuisances = plausible(problem, baseline)
    noise = NoiseModel.fit(problem.age, _plain_and_bent(problem, nuisances, problem.X), problem.model_error(baseline))
    dictionary = Dictionary.build(problem, effects, baseline, whole=False)
    # At most one number per independent cycle: the richer form of an effect enters only where the cycles can carry it.
    numbers = len(np.unique(problem.samples.cycle))
    dictionary.blocks = [b for b in dictionary.blocks if b.p + b.numbers <= numbers]
    state = State(problem, dictionary, nuisances, noise, numbers)
    fit, first = state.search.training.fit, [one.block for one in selection.ranked(state.search.scores(()))[:1]]
    if [block.name for block in first] == [GRAVITY] and fit(first).rss < DROWNED * fit(()).rss:
        state.active = first
        state = _refitted(state)
    for _ in range(2):
        orders = dictionary.scan_orders(state.fitted().residual)
        state.gram.add([*orders, *_change_point(state)])
        state.active = state.search.run(state.active)
        if not state.active:
            return state
    for _ in range(REPEATS):
        names = [b.name for b in state.active]
        state = _refitted(state)
        state.active = accepted(state, state.search.run(state.search.settle(state.active)))
        if [b.name for b in state.active] == names or not state.active:
            break
    # Effects that act on the nominal torque are fitted together with it, once more with all others and the last noise.
    for k, block in enumerate(state.active):
        others = state.active[:k] + state.active[k + 1 :]
        moved = state.search.refine(block, others) if block.effect.follows and state.search.refine else None
        if moved is not None:
            state.gram.add([moved])
            state.active[k] = moved
    # Where the joint fit leaves the nominal model no inertia, a transmission has no torque.
    state.active = [block for block in state.active if block.columns.any()]
    return state


def _change_point(state: State) -> list[Block]:
    """A step of friction at the best time of all (R. E. Quandt, J. Am. Stat. Assoc. 55 (1960) 324).

    The likelihood falls within a few samples of the change, so that no descent from a grid ends there
    (effects_friction_step_70004: a ramp, and a contact in its place).
    """
    steps = [b for b in state.dictionary.blocks if b.name == "friction_step"]
    data, samples, gram = state.problem.data, state.problem.samples, state.gram
    times = [b.shape["step_time_s"] for b in steps]
    inside = (samples.t >= min(times, default=np.inf)) & (samples.t <= max(times, default=-np.inf))
    if not inside.any():
        return []
    given = selection.Projected(state.search.training, [b for b in state.active if b.name != "friction_step"])
    white = gram.whiten(state.problem.columns(np.column_stack([data.direction, data.dq])))
    rows = np.vstack([given.left, given.basis, white])[:, np.argsort(gram.order)]
    # Products of the part of each column from a time on: rows are innovations in the order of time.
    later = np.cumsum((rows[-2:, None] * rows)[..., ::-1], axis=-1)[..., ::-1]
    right, along, own = later[:, 0], later[:, 1:-2], later[:, -2:]
    free = (own - np.einsum("ibm,jbm->ijm", along, along)).transpose(2, 0, 1)[inside]
    gain = np.einsum("im,mij,jm->m", right[:, inside], np.linalg.pinv(free, hermitian=True), right[:, inside])
    time = float(samples.t[inside][np.argmax(gain)])
    at_once = min(b.shape["step_length_s"] for b in steps)
    found = state.dictionary.build_blocks(steps[0].effect, [{"step_time_s": time, "step_length_s": at_once}])
    for block in found:
        block.log_prior, block.numbers = -float(np.log(len(np.unique(samples.cycle)))), steps[0].numbers
    return found


def _refitted(state: State) -> State:
    """Noise from what the augmented model leaves; columns that need the nominal model from its better fit."""
    problem, fitted = state.problem, state.fitted()
    baseline = fitted.nominal
    rows = np.vstack([state.gram.base_raw, *(b.columns for b in state.active)])
    left = problem.y - least_squares(rows, problem.y) @ rows
    torques = [*zip(state.active, fitted.torques, strict=True)]
    # The variance function of the largest likelihood (R. J. Carroll, D. Ruppert, Transformation and Weighting in
    # Regression (1988), ch. 3): with a tenth of all gravity as noise a clean joint has presliding.
    gravity = [block for block in state.active if block.name == GRAVITY]
    wrong = [np.zeros(len(left)), problem.model_error(baseline) ** 2]  # of gravity, of all else
    for block, torque in torques:
        wrong[block not in gravity] += (_formula_error(block) * torque) ** 2
    both = _plain_and_bent(problem, (), rows)
    noises = [NoiseModel.fit(problem.age, both, np.sqrt(wrong[1] + k**2 * wrong[0])) for k in GRAVITY_PARTS]
    noise = max(noises, key=lambda one: one.log_likelihood(left))
    known = [b for b in state.gram.blocks if not b.refined or b in state.active]
    state.dictionary.blocks = known
    before = state.dictionary.baseline.torque
    if np.mean((before - baseline.torque) ** 2) > CHANGED**2 * np.mean(before**2):
        others = [torque for block, torque in torques if not block.effect.transmits]
        state.dictionary.rebuild(baseline, problem.y - np.sum(others, axis=0))
    # Gravity in the torque hides the smoothing of the sign until it is named.
    nuisances = plausible(problem, baseline, gravity) if gravity else state.gram.nuisances
    made = State(problem, state.dictionary, nuisances, noise, state.search.most_numbers)
    made.active = state.active
    return made


def plausible(problem: RegressionProblem, baseline: Nominal, active: Sequence[Block] = ()) -> list[Nuisance]:
    """Nuisances within their priors given effects, with the likelier form of the sign; others would hide an effect."""
    given, found = np.vstack([problem.X, *(block.columns for block in active)]), []
    chain = [Nuisance(row, np.inf) for row in problem.left_to_effects if row.any()]
    for sign in SIGNS:
        kept = problem.nuisances(baseline, np.vstack([given, problem.left_to_effects]), sign)
        while True:
            known = [*kept, *chain]
            noise = NoiseModel.fit(problem.age, _plain_and_bent(problem, known, given), problem.model_error(baseline))
            gram = Gram(problem, noise, known, active)
            model = FittedModel(Training(gram), active)
            size = np.abs(model.fit.coefficients[len(problem.X) : len(model.fit.kept)]) / [one.sd for one in known]
            if size.max(initial=0.0) <= PLAUSIBLE_SD:
                break
            kept.pop(int(np.argmax(size)))
        found.append((noise.log_likelihood(model.residual), kept))
    return max(found, key=lambda one: one[0] - (one is not found[0]))[1]  # of forms that are about as likely, the first


def _formula_error(block: Block) -> float:
    """Share of an effect's torque that its formula may get wrong."""
    if block.effect.misses == "nothing":
        return 0.0
    return TRANSMISSION_ERROR if block.effect.transmits else EFFECT_ERROR


def accepted(state: State, active: Sequence[Block]) -> list[Block]:
    """Without effects that do not predict held-out cycles, or may be what a larger effect's formula lacks."""
    kept = list(active)
    while kept:
        found, model = gains(state.gram, kept), state.fitted(kept)
        size, left = model.sizes, float(np.std(model.residual))
        own = np.maximum(size / np.sqrt(model.inflations), 1e-300)  # rms of what nothing else holds
        inflated = (model.whole(state.dictionary)[1] / own) ** 2  # by a chain without a model too
        strengths = []
        for k, block in enumerate(kept):
            lost = any(
                size[k] < _formula_error(other) * s and _may_absorb_error(state, kept, block, other)
                for s, other in zip(size, kept, strict=True)
            )
            stands = found[k].z >= LEAST_Z and found[k].shrinks and size[k] >= LEAST_SHARE * left and not lost
            stands &= inflated[k] <= COLLINEAR or own[k] >= LEAST_OWN * left
            stands &= not state.dictionary.is_nuisance(block.shape)
            strengths.append(np.inf if stands else found[k].z)
        if not np.isfinite(min(strengths)):
            break
        kept.pop(int(np.argmin(strengths)))
    return kept


def _may_absorb_error(state: State, active: Sequence[Block], block: Block, other: Block) -> bool:
    """Whether an effect may be what the formula of another, larger one misses.

    What a torque of the position, the time or the load alone misses is of the same quantity: a free curve over it holds
    that, one for each direction if it is friction.
    """
    if other.effect.misses == "any":
        return True
    problem = state.problem
    values = next(axis.value(problem.data) for axis in AXES if axis.name == other.effect.axis)
    assert values is not None
    knots = knots_of(values, problem.data.used)
    hats = curve(values, knots, problem.data.dq)
    if other.effect.misses == "even":
        hats = hats[:, : len(knots)] + hats[:, len(knots) :]
    given = selection.Projected(state.search.training, [b for b in active if b is not block])
    return given.and_also(state.gram.whiten(problem.columns(hats))).evidence(state.gram.of(block)) < selection.PRIOR


def _plain_and_bent(problem: RegressionProblem, nuisances: Sequence[Nuisance], given: Float) -> list[Float]:
    plain = np.vstack([given, *(one.column for one in nuisances)])
    bent = np.vstack([plain, *(c.columns for c in problem.curves)])
    return [problem.y - least_squares(one, problem.y) @ one for one in (plain, bent)]

"""Effects that come with the time of the recording: slowly, at one moment, or for stretches of it."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Each, Effect, Points
from friction_audit.effects.joint_data import JointData, long_enough
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution

SHORTEST_S = 30.0  # sensors drift with their temperature, within minutes: what changes within seconds is the motion's

WAVES = 4
# A wave is slow that lasts longer than strokes do: else any misfit of the motion's own slow part passes for drift.
CYCLES_PER_HALF_TURN = 2

REFERENCE_DEGC = 25.0
# Time constants as shares of the log's length; beyond, an exponential is a straight line.
TIMES = (0.08, 0.2, 0.5, 1.5)
FOREVER = 1e4
UNFELT_PER_K = 1e-6
DECAYS = (0.3, 1.5, 5.0)  # how far friction fades over the range of the temperature, as exponents
LEAST_K = 0.5  # least range of a temperature

STEPS = 32
AT_ONCE = 1e-5  # length of a step, as a share of the log's: less than a sample
RAMPS = 16  # neighbours overlap by half, for from a step there is no way downhill to a ramp that lies between two
LENGTH = 0.12  # how long a ramp takes, as a share of the log's length; a ramp of the whole log would be a warm-up


class TorqueDrift(Effect):
    """Drift of the torque sensor's zero during a recording, nothing at its start.

    The waves are the principal components of a random walk (K. Karhunen, 1947; M. Loeve, Probability Theory, 1955): no
    others catch more of one with as many numbers, and a ramp or a settling needs only the first of them.
    """

    label = "the torque drifts slowly"
    axis = "time"
    coefficients = tuple(
        Parameter(f"drift_{i}_nm", "N m", f"wave of {i - 0.5:g} half turns over the recording")
        for i in range(1, WAVES + 1)
    )
    nonlinear = (
        # Files of earlier versions have all waves and do not say so.
        Parameter.choice(
            "drift_waves",
            "0 all waves, 1 the slowest wave alone, else number of the slowest waves",
            0.0,
            WAVES,
            optional=True,
        ),
    )
    requires = staticmethod(
        partial(long_enough, short="too_short_for_drift", shortest_s=SHORTEST_S, fewest=CYCLES_PER_HALF_TURN * WAVES)
    )
    record = "let the joint rest unloaded for 2 s early and late"
    separate = {
        "warm_up": "pass the same places in both directions early and late, with rests",
        "friction_step": "pass the same places in both directions before and after the change, with rests",
    }
    misses = "even"
    like_gravity = True  # as the other joints' poses change

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sin((i - 1/2) pi x) for i = 1..4, x the share of the recording that is over; 0 for waves not meant."""
        share = (motion.t - motion.t[0]) / (np.ptp(motion.t) or 1.0)
        number, meant = np.arange(WAVES)[:, None], round(values[0]) or WAVES
        return np.asarray(np.sin(np.pi * share * (number + 0.5)) * (number < meant)).T

    def tries(self, data: JointData) -> list[tuple[float]]:
        return [(float(waves),) for waves in range(1, WAVES + 1)]


class WarmUp(Effect):
    """Friction that fades as the joint gets warm, with the time or with a logged temperature.

    A body that is heated evenly approaches its temperature exponentially (Newton's law of cooling), and a lubricant's
    viscosity falls exponentially with the temperature (O. Reynolds, Philosophical Transactions 177 (1886) 157).
    """

    label = "friction falls as the joint warms"
    axis = "time"
    coefficients = (
        Parameter("cold_coulomb_nm", "N m", "extra Coulomb friction when cold"),
        Parameter("cold_viscous_nms_per_rad", "N m s/rad", "extra viscous friction when cold"),
    )
    nonlinear = (
        Parameter("warm_up_time_s", "s", "time constant", lower=1e-2, upper=1e9),
        Parameter("warm_up_per_k", "1/K", "share lost per kelvin", lower=0.0, upper=100.0),
    )
    friction = True
    requires = staticmethod(partial(long_enough, short="too_short_to_warm_up", shortest_s=SHORTEST_S))
    record = "record from a cold start, slow and fast motions early and late"
    separate = {
        "friction_step": "record on for one and a half times as long: warming slows down, a step is over",
        "unlogged_compensation": "log the commanded torque, and repeat the same motions early and late",
    }

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) and dq times exp(-t / T - k (temperature - 25 degC)) as columns, t from the start."""
        time_constant, per_kelvin = values
        fading = -(motion.t - motion.t[0]) / time_constant
        if motion.temperature is not None:
            fading = fading - per_kelvin * (motion.temperature - REFERENCE_DEGC)
        cold = np.exp(fading)
        return np.stack([motion.direction * cold, motion.dq * cold]).T

    def tries(self, data: JointData) -> list[Sequence[float]]:
        """Return time constants by the length of the log; rates by the range of the temperature, where there is one."""
        length, rise = float(np.ptp(data.t)), 0.0 if data.temperature is None else float(np.ptp(data.temperature))
        by_temperature = [(FOREVER * length, decay / rise) for decay in DECAYS] if rise >= LEAST_K else []
        return [*((share * length, UNFELT_PER_K) for share in TIMES), *by_temperature]

    def possible(self, coefficients: Float, at: Points) -> Each:
        return np.any(coefficients > 0, axis=0)  # a cold joint has more friction of one kind at least


class FrictionStep(Effect):
    """Friction that changes once, at a moment of the recording, at once or within some seconds."""

    label = "friction changes at one moment"
    axis = "time"
    coefficients = (
        Parameter("step_coulomb_nm", "N m", "change of Coulomb friction"),
        Parameter("step_viscous_nms_per_rad", "N m s/rad", "change of viscous friction"),
    )
    nonlinear = (
        Parameter("step_time_s", "s", "time of the change"),
        Parameter("step_length_s", "s", "duration of the change", lower=0.0),
    )
    friction = True
    requires = staticmethod(partial(long_enough, short="few_cycles_around", fewest=8))
    record = "record at least 4 cycles before and after the change"
    separate = {"contact_event": "record at least 4 cycles before and after the moment: a contact passes"}

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) and dq times a ramp from 0 to 1 about a time, as columns; a step where its length is 0."""
        time, length = values
        first, stop = np.searchsorted(motion.t, (time - 0.5 * length, time + 0.5 * length)).tolist()
        columns = np.zeros((2, len(motion.t)))
        columns[:, first:] = motion.direction[first:], motion.dq[first:]
        if stop > first:
            columns[:, first:stop] *= np.clip(0.5 + (motion.t[first:stop] - time) / length, 0.0, 1.0)
        return columns.T

    def tries(self, data: JointData) -> list[Sequence[float]]:
        start, length = float(data.t[0]), float(np.ptp(data.t))
        steps = [(k / STEPS, AT_ONCE) for k in range(2, STEPS - 1)]
        ramps = [(k / RAMPS, LENGTH) for k in range(1, RAMPS)]
        return [(start + share * length, part * length) for share, part in (*steps, *ramps)]


class ContactEvent(Effect):
    """A contact, found by a detector of its own, which leaves out its samples: it has no columns."""

    label = "short contact with the arm"
    axis = "time"
    requires = staticmethod(lambda data, _: Caution("unknown_gravity") if data.unknown_gravity else None)
    record = "record again with no person and no object near the arm"

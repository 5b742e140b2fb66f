"""Effects of other joints: their torque in this joint's sensor, and what their acceleration takes."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import INERTIAL_PARAMETERS, Motion
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution

# A neighbour's torque must change by so much of this joint's Coulomb friction before a few percent of it are seen.
CHANGE_PER_COULOMB = 0.5


class TorqueCrosstalk(Effect):
    """Crosstalk: a torque sensor also feels what the sensors before and after it feel."""

    label = "torque of a neighbour leaks in"
    axis = "neighbour"
    coefficients = (
        # A sensor feels its own load best.
        Parameter("crosstalk_before", "1", "share of the previous joint's torque", lower=-1.0, upper=1.0),
        Parameter("crosstalk_after", "1", "share of the next joint's torque", lower=-1.0, upper=1.0),
    )
    nonlinear = (Parameter.choice("crosstalk_side", "-1 previous joint, 1 next joint, 0 both", -1, 1),)
    record = "push against a neighbour while the arm rests"
    separate = {"inertial_coupling": "move one joint at a time, then push against a neighbour at rest"}

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return the readings of the joints before and after as columns, 0 where there is none or it is not meant."""
        side = round(values[0])
        columns = np.zeros((len(motion.t), 2))
        if motion.others is None:
            return columns
        joint, sensed = motion.others.joint, motion.others.sensed
        if side <= 0 and joint > 0:
            columns[:, 0] = sensed[:, joint - 1]
        if side >= 0 and joint + 1 < sensed.shape[1]:
            columns[:, 1] = sensed[:, joint + 1]
        return columns

    def tries(self, data: JointData) -> list[tuple[float]]:
        before, after = data.others.joint > 0, data.others.joint + 1 < data.others.sensed.shape[1]
        return [(side,) for side, there in ((-1.0, before), (1.0, after), (0.0, before and after)) if there]

    @staticmethod
    def requires(data: JointData, nominal: Nominal) -> Caution | None:
        joint, joints = data.others.joint, data.others.sensed.shape[1]
        neighbours = [k for k in (joint - 1, joint + 1) if 0 <= k < joints]
        if not neighbours:
            return Caution("one_joint")
        change = data.others.sensed[data.used][:, neighbours].std(axis=0).max()
        return Caution("even_neighbours") if change < CHANGE_PER_COULOMB * abs(nominal.coulomb_nm) else None


BEFORE, AFTER, BOTH, ALL, MODEL, TIP = range(6)  # values of the source
JOINTS = 7  # accelerations of more joints are not looked at
INERTIAL = ("moment_x", "moment_y", "moment_z", "xx", "xy", "yy", "xz", "yz", "zz")
UNITS = ("kg_m",) * 3 + ("kg_m2",) * 6
# Either sign is possible, for a rotor may turn against its neighbour.
SHARE = 2.0  # of the model's inertial torque at most: 1 where it was not subtracted, -1 where it was twice
MASS_KG = 10.0  # what columns that nearly cancel may make of the last link is no body
CYCLES_PER_COLUMN = 2  # a dozen coefficients from as many cycles overfit, with masses that no arm carries


class InertialCoupling(Effect):
    """Torque that a joint takes because others accelerate.

    Where the arm's model is known, a share of its inertial torque M(q) ddq + c(q, dq), or what an unknown body on the
    last link adds to it (Atkeson, An, Hollerbach, Int. J. Robotics Research 5(3), 1986). Where it is not, or for motors
    whose rotors turn with other joints (De Luca, Book, Robots with flexible elements, 2016), accelerations and squared
    speeds of the others, with constant coefficients.
    """

    label = "acceleration of other joints"
    axis = "neighbour"
    coefficients = (
        *(
            Parameter(f"coupling_to_{to}{k}_kg_m2", "kg m^2", f"torque per {what} of joint {k}")
            for to, what in (("joint", "acceleration"), ("speed", "squared speed"))
            for k in range(1, JOINTS + 1)
        ),
        Parameter("inertial_torque_share", "1", "share of the model's inertial torque", lower=-SHARE, upper=SHARE),
        Parameter("tip_mass_kg", "kg", "of the last link, mass", lower=-MASS_KG, upper=MASS_KG),
        *(
            Parameter(f"tip_{name}_{unit}", unit.replace("_", " "), f"of the last link, {name}")
            for name, unit in zip(INERTIAL, UNITS, strict=True)
        ),
    )
    nonlinear = (
        Parameter.choice(
            "coupling_source",
            "0 previous joint, 1 next joint, 2 both, 3 all joints, 4 model of the arm, 5 with its last link",
            *(BEFORE, TIP),
        ),
    )
    record = "move the neighbours one at a time, also while this joint rests"

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return the columns of one source of the torque; those of the others are zero."""
        source = round(values[0])
        columns = np.zeros((len(self.coefficients), len(motion.t))).T  # one behind the other in memory
        rigid = None if motion.rigid is None else motion.rigid.on(motion.t)
        if source <= ALL:
            if motion.others is None:
                return columns
            joint, joints = motion.others.joint, min(motion.others.ddq.shape[1], JOINTS)
            wanted = {BEFORE: (joint - 1,), AFTER: (joint + 1,), BOTH: (joint - 1, joint + 1)}
            meant = [k for k in wanted.get(source, range(joints)) if 0 <= k < joints and k != joint]
            columns[:, meant] = motion.others.ddq[:, meant]
            if source == ALL:
                columns[:, [JOINTS + joint for joint in meant]] = motion.others.dq[:, meant] ** 2
        elif rigid is not None and rigid.inertial is not None and rigid.tip is not None:
            columns[:, 2 * JOINTS] = rigid.inertial
            if source == TIP:
                columns[:, -INERTIAL_PARAMETERS:] = rigid.tip
        return columns

    def tries(self, data: JointData) -> list[tuple[float]]:
        """Return the neighbours and the arm's model; sources with many coefficients where there are many cycles."""
        joints, joint = data.others.dq.shape[1], data.others.joint
        model = data.rigid is not None and data.rigid.inertial is not None
        columns = len(np.unique(data.cycle[data.used])) // CYCLES_PER_COLUMN
        tried = (
            (BEFORE, joint > 0),
            (AFTER, joint + 1 < joints),
            (BOTH, 0 < joint < joints - 1),
            (ALL, joints > 1 and 2 * (joints - 1) <= columns),
            (MODEL, model),
            (TIP, model and columns >= 1 + INERTIAL_PARAMETERS),
        )
        return [(float(source),) for source, there in tried if there]

    @staticmethod
    def requires(data: JointData, _nominal: Nominal) -> Caution | None:
        other = np.delete(data.others.dq[data.valid], data.others.joint, axis=1)
        still = other.size == 0 or np.sqrt(np.mean(other**2, axis=0)).max() < data.dead_speed_rad_s
        return Caution("still_neighbours") if still else None

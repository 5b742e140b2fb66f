"""Acceleration of coordinates that slide, stick or are free, with friction holding what it can."""

import math

from friction_audit.compiled import compiled
from friction_audit.replay.records import Record
from friction_audit.simulate.mechanics.body import FREE


@compiled()
def solve(body: Record, count: int) -> None:
    """Solve the first ``count`` equations, symmetric and positive definite, in place (Cholesky)."""
    system, right = body.system, body.right
    for i in range(count):
        for j in range(i + 1):
            rest = system[i, j]
            for k in range(j):
                rest -= system[i, k] * system[j, k]
            system[i, j] = math.sqrt(rest) if i == j else rest / system[j, j]
        for k in range(i):
            right[i] -= system[i, k] * right[k]
        right[i] /= system[i, i]
    for i in range(count - 1, -1, -1):
        for k in range(i + 1, count):
            right[i] -= system[k, i] * right[k]
        right[i] /= system[i, i]


@compiled()
def _move_the_active(body: Record, h: float) -> None:
    """Give the coordinates that are not stuck their accelerations, damping taken at the middle of the step."""
    count = 0
    for c in range(body.count):
        body.a[c] = 0.0
        if body.mode[c] != 0.0:
            body.active[count] = c
            count += 1
    for i in range(count):
        row = body.active[i]
        sign = 1.0 if body.mode[row] == FREE else body.mode[row]
        torque = body.force[row] - sign * body.level[row]
        for c in range(body.count):
            torque -= body.damping[row, c] * body.v[c]
        body.right[i] = torque
        for j in range(i + 1):
            column = body.active[j]
            body.system[i, j] = body.mass[row, column] + 0.5 * h * body.damping[row, column]
    solve(body, count)
    for i in range(count):
        body.a[body.active[i]] = body.right[i]


@compiled()
def _release(body: Record, h: float) -> bool:
    """Free the stuck coordinate that is pulled most beyond what friction can bear; return whether there is one."""
    worst, excess, way = -1, 0.0, 0.0
    for c in range(body.count):
        if body.mode[c] == 0.0:
            pull = body.force[c]
            for k in range(body.count):
                pull -= body.mass[c, k] * body.a[k] + body.damping[c, k] * (body.v[k] + 0.5 * h * body.a[k])
            body.reaction[c] = pull
            over = max(pull - body.hold[c, 1], -pull - body.hold[c, 0])
            if over > excess:
                worst, excess, way = c, over, math.copysign(1.0, pull)
    if worst < 0:
        return False
    body.mode[worst] = way
    body.level[worst] = body.slip[worst, 1 if way > 0.0 else 0]
    return True


@compiled()
def _hold_again(body: Record) -> bool:
    """Hold a coordinate that broke away and that others, free since then, pull back; return whether there is one."""
    for c in range(body.count):
        if body.v[c] == 0.0 and abs(body.mode[c]) == 1.0 and body.a[c] * body.mode[c] < 0.0:
            body.mode[c] = 0.0
            return True
    return False


@compiled()
def accelerate(body: Record, h: float) -> None:
    """Set ``a`` for a step of length h, ``mode`` where a stuck coordinate breaks away, ``reaction`` where it does not.

    With h = 0 the accelerations are those of the instant.
    """
    _move_the_active(body, h)
    for _ in range(2 * body.count):
        if not (_hold_again(body) or _release(body, h)):
            break
        _move_the_active(body, h)

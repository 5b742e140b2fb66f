"""The sequential loops of the simulator, compiled by numba; import this module only where they run."""

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float

ROOT_ITERATIONS = 4


@compiled()
def slide(
    q: float, v: float, sign: float, h: float, hand: tuple[float, float, float, float], u: float, body: Float
) -> tuple[float, float]:
    """Move on by h while the joint slides in direction ``sign``: one step of the trapezoidal rule, solved exactly.

    ``hand`` holds the intended position and velocity at the step's start and end; ``body`` holds mass, stiffness,
    damping, Coulomb and viscous friction.
    """
    mass, stiffness, damping, coulomb, viscous = body
    place, speed, next_place, next_speed = hand
    steady = u - coulomb * sign
    force = stiffness * (place - q) + damping * (speed - v) - viscous * v + steady
    predicted = stiffness * (next_place - q - 0.5 * h * v) + damping * next_speed + steady
    momentum = mass * v + 0.5 * h * (force + predicted)
    v_next = momentum / (mass + 0.5 * h * (0.5 * h * stiffness + damping + viscous))
    return q + 0.5 * h * (v + v_next), v_next


@compiled()
def split_hand(hand: tuple[float, float, float, float], share: float) -> tuple[float, float]:
    """Return the intended position and velocity at a share of the step."""
    return hand[0] + share * (hand[2] - hand[0]), hand[1] + share * (hand[3] - hand[1])


@compiled()
def find_stop(
    q: float, v: float, sign: float, h: float, hand: tuple[float, float, float, float], u: float, body: Float
) -> tuple[float, float]:
    """Find the share of the step after which the velocity is zero, by regula falsi; return it and the position."""
    low, v_low = 0.0, v
    high, v_high = 1.0, slide(q, v, sign, h, hand, u, body)[1]
    share, place = 0.0, q
    for _ in range(ROOT_ITERATIONS):
        share = low + (high - low) * v_low / (v_low - v_high)
        middle = split_hand(hand, share)
        place, speed = slide(q, v, sign, share * h, (hand[0], hand[1], middle[0], middle[1]), u, body)
        if speed * sign > 0.0:
            low, v_low = share, speed
        elif speed * sign < 0.0:
            high, v_high = share, speed
        else:
            break
    return share, place


@compiled()
def slip_direction(q: float, place: float, speed: float, u: float, body: Float) -> float:
    """Return the direction in which a joint at rest breaks away, or 0 where friction holds it."""
    drive = body[1] * (place - q) + body[2] * speed + u
    if abs(drive) <= body[3]:
        return 0.0
    return 1.0 if drive > 0.0 else -1.0


@compiled()
def dissipation(q: float, v: float, q_next: float, v_next: float, h: float, body: Float) -> float:
    """Return what friction takes in a step without reversal, the velocity being linear in time. [J]"""
    return float(body[3] * abs(q_next - q) + body[4] * h / 3.0 * (v * v + v * v_next + v_next * v_next))


@compiled()
def advance(
    q: float, v: float, sign: float, h: float, hand: tuple[float, float, float, float], u: float, body: Float
) -> tuple[float, float, float, float]:
    """Move on by one step with stick and slip; return position, velocity, direction (0: stuck) and dissipation."""
    if sign == 0.0:
        return q, 0.0, slip_direction(q, hand[2], hand[3], u, body), 0.0
    q_next, v_next = slide(q, v, sign, h, hand, u, body)
    if v_next * sign >= 0.0:
        return q_next, v_next, sign, dissipation(q, v, q_next, v_next, h, body)
    share, q_stop = find_stop(q, v, sign, h, hand, u, body)
    taken = dissipation(q, v, q_stop, 0.0, share * h, body)
    place, speed = split_hand(hand, share)
    turned = slip_direction(q_stop, place, speed, u, body)
    if turned == 0.0:
        return q_stop, 0.0, slip_direction(q_stop, hand[2], hand[3], u, body), taken
    rest = (1.0 - share) * h
    q_next, v_next = slide(q_stop, 0.0, turned, rest, (place, speed, hand[2], hand[3]), u, body)
    return q_next, v_next, turned, taken + dissipation(q_stop, 0.0, q_next, v_next, rest, body)


@compiled()
def integrate(place: Float, speed: Float, h: float, substeps: int, body: Float, compensator: Float) -> Float:
    """Integrate the joint held by the hand from rest; see ``dynamics.move``.

    Args:
        place: Intended position at every step, shape (n * substeps + 1,). [rad]
        speed: Intended velocity. [rad/s]
        h: Step. [s]
        substeps: Steps per sample.
        body: Mass of hand and joint, stiffness, damping, Coulomb, viscous friction.
        compensator: Coulomb, viscous coefficient and dead-band.

    Returns:
        Rows q, v, acceleration, compensator torque and energy dissipated so far, shape (5, n + 1).
    """
    samples = (len(place) - 1) // substeps + 1
    out = np.zeros((5, samples))
    q, v, sign, taken = place[0], 0.0, 0.0, 0.0
    for k in range(samples):
        u = 0.0
        if abs(v) > compensator[2]:
            u = compensator[0] * np.sign(v) + compensator[1] * v
        first = k * substeps
        force = body[1] * (place[first] - q) + body[2] * (speed[first] - v) + u
        out[0, k], out[1, k], out[3, k], out[4, k] = q, v, u, taken
        out[2, k] = 0.0 if sign == 0.0 else (force - body[3] * sign - body[4] * v) / body[0]
        if k == samples - 1:
            break
        for i in range(first, first + substeps):
            hand = (place[i], speed[i], place[i + 1], speed[i + 1])
            q, v, sign, loss = advance(q, v, sign, h, hand, u, body)
            taken += loss
    return out

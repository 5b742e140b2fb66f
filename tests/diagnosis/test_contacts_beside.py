"""Beside a play: a strike that comes at another moment is no contact, a push in mid-stroke is."""

from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.contacts import Undisturbed, contacts_beside
from friction_audit.diagnosis.find_contacts import find_contacts
from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.library import Library
from friction_audit.diagnosis.naming import Names
from friction_audit.effects.backlash import EFFECT as BACKLASH
from friction_audit.effects.contact_event import Contact, overlap
from tests.diagnosis.found_effect import found_effect
from tests.diagnosis.moved_joint import GRID_HZ, moved_joint

PLAY = {"gap_rad": 3e-3, "contact_hz": 50.0, "flank_damping_ratio": 0.5}
LATE, PUSHED = Contact(start_s=20.0, stop_s=20.5), Contact(start_s=24.4, stop_s=24.7)
LATE_BY_S, PUSH_NM = 0.04, 0.6


def test_a_strike_at_another_moment_is_no_contact_and_a_push_is() -> None:
    quiet = moved_joint(noise_nm=0.01, duration_s=40.0)
    play = BACKLASH.regressor(quiet, make_ground(quiet, None, 0).baseline(), PLAY)[:, 0]
    late = (quiet.t > LATE.start_s) & (quiet.t < LATE.stop_s)
    struck = np.where(late, np.roll(play, round(LATE_BY_S * GRID_HZ)), play)
    push = PUSH_NM * np.sin(np.pi * np.clip((quiet.t - PUSHED.start_s) / (PUSHED.stop_s - PUSHED.start_s), 0.0, 1.0))
    ground = make_ground(replace(quiet, torque=quiet.torque + struck + push), None, 0)
    library = Library(entries=(), untestable={})
    names = Names(found=(found_effect(ground, BACKLASH, PLAY),), library=library, baseline=ground.baseline())
    outlying = find_contacts(ground.data, play)
    assert all(any(overlap(one, other) for other in outlying) for one in (LATE, PUSHED))
    told = contacts_beside(ground, Undisturbed(ground=ground, library=library, contacts=(LATE, PUSHED)), names)
    assert told == (PUSHED,)

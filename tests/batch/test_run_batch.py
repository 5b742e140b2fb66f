"""Batches from logs to sessions: formats, copies, faults, several arms, URLs; and what is kept of an estimate."""

import os
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest

from friction_audit.batch import ledger, work
from friction_audit.batch.find_logs import find_logs
from friction_audit.batch.ledger import BatchSettings
from friction_audit.batch.work import bin_torque, session_of
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.drift.session import JointSummary, Session
from friction_audit.friction.history import Coefficient
from friction_audit.io.files import sha256_of as hash_file
from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import Float, JointLog
from friction_audit.pipeline import AuditSettings, Estimate, estimate_log
from friction_audit.simulation import BenchSettings, simulate
from tests.batch.conftest import COULOMB_NM, Batch, Inline
from tests.reporting.conftest import build_estimate


def coulomb(session: Session) -> float:
    return session.joints[0].coefficients["coulomb_nm"].value


def test_every_log_becomes_a_session_in_any_format(rig: Path, batch: Batch) -> None:
    result = batch(rig)
    assert (result.new, result.known, result.failed, result.warnings) == (4, 0, (), ())
    assert [session.robot for session in result.sessions] == ["rig"] * 4
    assert [session.start_from for session in result.sessions] == ["name"] * 4
    for session, friction in zip(result.sessions, COULOMB_NM, strict=True):
        found = session.joints[0].coefficients["coulomb_nm"]
        assert found.low - 0.01 < friction < found.high + 0.01
        assert session.joints[0].cycles > 4


def test_a_second_run_computes_only_new_content(rig: Path, batch: Batch, recordings: tuple[JointLog, ...]) -> None:
    first, executor = batch(rig), Inline()
    write_log(recordings[0].take_window(0.0, 12.0), rig / "2026-03-09.parquet")
    (rig / "2026-03-01.parquet").rename(rig / "2026-04-01.parquet")
    os.utime(rig / "2026-03-02.csv", (1, 1))
    second = batch(rig, executor=executor)
    assert executor.taken == ["2026-03-09.parquet"]
    assert (second.new, second.known) == (1, 4)
    assert repr(second.sessions[:3]) == repr(first.sessions[1:])
    assert second.sessions[-1].path == "rig/2026-04-01.parquet"
    assert coulomb(second.sessions[-1]) == coulomb(first.sessions[0])


def test_only_logs_of_one_size_are_hashed_before_they_are_read(
    rig: Path, batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    hashed: list[str] = []

    def sha256_of(path: Path) -> str:
        hashed.append(path.name)
        return hash_file(path)

    monkeypatch.setattr(ledger, "sha256_of", sha256_of)
    (rig / "copy.csv").write_bytes((rig / "2026-03-02.csv").read_bytes())
    result = batch(rig)
    assert sorted(hashed) == ["2026-03-02.csv", "copy.csv"]
    assert (result.new, len(result.warnings)) == (4, 1)


def test_a_bad_file_is_listed_and_not_tried_again(rig: Path, batch: Batch) -> None:
    (rig / "bad.csv").write_text("time,q_1\n0,1\n1,2\n")
    (rig / "empty.mcap").touch()
    first = batch(rig)
    assert len(first.sessions) == 4
    assert [failed.path for failed in first.failed] == ["rig/bad.csv", "rig/empty.mcap"]
    assert first.failed[0].message.startswith("no column for a torque")
    executor = Inline()
    second = batch(rig, executor=executor)
    assert second.failed == first.failed
    assert executor.taken == []
    (rig / "bad.csv").write_text((rig / "2026-03-02.csv").read_text() + "\n")
    assert [failed.path for failed in batch(rig).failed] == ["rig/empty.mcap"]


def test_what_was_lost_is_tried_again(rig: Path, batch: Batch) -> None:
    first = batch(rig, executor=Inline(lose="2026-03-03"))
    assert [(failed.path, failed.message) for failed in first.failed] == [("rig/2026-03-03.npz", "gone")]
    second = batch(rig)
    assert (second.new, second.failed, len(second.sessions)) == (1, (), 4)


def test_a_bug_that_one_log_shows_does_not_cost_the_others(
    rig: Path, batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(log: JointLog, settings: AuditSettings) -> object:
        if "2026-03-02" in log.source.path:
            raise ZeroDivisionError
        return estimate_log(log, settings)

    with monkeypatch.context() as patch:
        patch.setattr(work, "estimate_log", fail)
        result = batch(rig)
    assert len(result.sessions) == 3
    assert "a bug of friction-audit, please report it: ZeroDivisionError" in result.failed[0].message
    assert batch(rig).failed == ()  # it is tried again


def test_several_arms_in_a_log_are_several_robots(rig: Path, batch: Batch, recordings: tuple[JointLog, ...]) -> None:
    columns = {"time": recordings[0].t[:2500]}
    for arm, log in zip(("left", "right"), recordings[:2], strict=True):
        for channel in ("q", "dq", "tau_interaction"):
            columns[f"{arm}_joint1/{channel}"] = getattr(log, channel)[:2500, 0]
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(rig / "2026-03-05.csv", table, delimiter=",", header=",".join(columns), comments="")
    result = batch(rig / "2026-03-05.csv")
    found = {session.robot: coulomb(session) for session in result.sessions}
    assert found == pytest.approx({"left": COULOMB_NM[0], "right": COULOMB_NM[1]}, abs=0.02)
    paths = [f"rig/2026-03-05.csv [#{arm}]" for arm in ("left", "right")]
    assert [session.path for session in result.sessions] == paths
    assert batch(rig / "2026-03-05.csv").new == 0
    one = BatchSettings(reading=replace(BatchSettings().reading, topic="#right"))
    assert [session.robot for session in batch(rig / "2026-03-05.csv", settings=one).sessions] == ["right"]


def test_a_diagnosis_is_kept_with_the_estimate(rig: Path, batch: Batch) -> None:
    settings = BatchSettings(diagnosis=DiagnosisSettings(candidates=("stribeck",)))
    for new in (1, 0):
        result = batch(rig / "2026-03-01.parquet", settings=settings)
        assert (result.new, result.sessions[0].joints[0].verdict is None) == (new, False)


def test_a_folder_of_an_object_store(rig: Path, batch: Batch) -> None:
    """A file system that is no disk: objects by their names, as in a bucket."""
    fsspec = pytest.importorskip("fsspec")
    store = fsspec.filesystem("memory")
    store.put(str(rig), "/lab/rig", recursive=True)
    try:
        executor = Inline()
        there = batch("memory://lab/rig", executor=executor)
        assert [session.path.rpartition("/")[2] for session in there.sessions] == sorted(p.name for p in rig.iterdir())
        assert {session.robot for session in there.sessions} == {"rig"}
        here = batch(rig, ledger="here").sessions
        assert [coulomb(session) for session in there.sessions] == [coulomb(session) for session in here]
        assert batch("memory://lab/rig", executor=executor).new == 0
    finally:
        store.rm("/lab", recursive=True)


@pytest.fixture
def server(rig: Path) -> Iterator[str]:
    """Yield the address of a web server of the folder that holds the rig."""

    class Handler(SimpleHTTPRequestHandler):
        def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - its name there
            """Say nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=str(rig.absolute().parent))) as serving:
        thread = Thread(target=serving.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{serving.server_port}"
        serving.shutdown()
        thread.join()


def test_logs_on_the_web(rig: Path, batch: Batch, server: str) -> None:
    executor = Inline()
    names = sorted(path.name for path in rig.iterdir())
    there = batch(f"{server}/rig/{names[0]}", f"{server}/rig/{names[1]}", executor=executor)
    assert [session.path for session in there.sessions] == [f"{server}/rig/{name}" for name in names[:2]]
    assert {session.robot for session in there.sessions} == {"rig"}
    here = batch(rig / names[0], rig / names[1], ledger="here")
    assert [coulomb(session) for session in there.sessions] == [coulomb(session) for session in here.sessions]
    assert batch(f"{server}/rig/{names[0]}", executor=executor).new == 0
    changed = (rig / names[0]).stat()
    other = bytearray((rig / names[0]).read_bytes())
    other[len(other) // 2] ^= 1  # of the same size
    (rig / names[0]).write_bytes(other)
    os.utime(rig / names[0], (changed.st_atime + 10.0, changed.st_mtime + 10.0))
    assert batch(f"{server}/rig/{names[0]}", executor=executor).new == 1
    assert executor.taken == [names[0], names[1], names[0]]
    (rig / "bad.csv").write_text("time,q_1\n0,1\n1,2\n")
    (failed,) = batch(f"{server}/rig/bad.csv").failed
    assert (failed.path, "friction-audit-" in failed.message) == (f"{server}/rig/bad.csv", False)


def test_a_log_that_the_worker_does_not_see(rig: Path) -> None:
    log = find_logs([str(rig / "2026-03-01.parquet")], {})[0]
    fault = work.work_on(BatchSettings(), replace(log, place="/nowhere/2026-03-01.parquet")).faults[0]
    assert "give a path that every worker sees" in fault.message
    assert not fault.lasting


# Estimates made by hand, whose summaries are known.


def summaries(estimate: Estimate) -> tuple[JointSummary, ...]:
    return session_of(estimate).joints


@pytest.fixture(scope="module")
def log() -> JointLog:
    """Return one joint moved by hand for a minute."""
    return simulate(BenchSettings(duration_s=60.0, rate_hz=250.0), seed=3).log


def test_coefficients_and_reasons_are_those_of_the_estimate() -> None:
    seven = estimate_log(build_estimate(7, rate=250.0).log, AuditSettings())  # the third stands still
    found = summaries(seven)
    assert [one.joint for one in found] == list(range(1, 8))
    assert [one.name for one in found] == list(seven.interaction.joint_names)
    assert found[0].coefficients["coulomb_nm"] == seven.friction.joints[0].coulomb
    assert found[0].coefficients["viscous_nms_per_rad"] == seven.friction.joints[0].viscous
    assert [bool(one.reason) for one in found] == [False, False, True, False, False, False, False]
    assert np.isnan(found[2].coefficients["coulomb_nm"].value)
    assert (len(found[2].curve.speed_rad_s), found[0].verdict, found[0].effects) == (0, None, ())
    assert np.isnan(found[2].speed_rad_s).all()


def test_bins_hold_means_and_spreads() -> None:
    velocity = np.repeat([-1.0, 1.0], 100)
    torque = np.where(velocity > 0, 0.5, -0.3) + np.tile([0.1, -0.1], 100)
    curve = bin_torque(velocity, torque)
    assert list(curve.speed_rad_s) == [-1.0, 1.0]
    assert curve.torque_nm == pytest.approx((-0.3, 0.5))
    assert curve.spread_nm == pytest.approx((0.1, 0.1))


def test_a_compensator_s_torque_counts_with_the_hand_s() -> None:
    bare = estimate_log(build_estimate(1, rate=250.0).log, AuditSettings())
    help_nm = np.full_like(bare.interaction.torque, 0.1)
    helped = replace(bare, interaction=replace(bare.interaction, compensation=help_nm))
    pairs = zip(summaries(helped)[0].curve.torque_nm, summaries(bare)[0].curve.torque_nm, strict=True)
    assert all(a == pytest.approx(b + 0.1) for a, b in pairs)


def test_what_changes_within_a_session_is_reported(log: Any) -> None:
    def within(change: Float | float) -> Coefficient:
        warmed = replace(log, tau_interaction=log.tau_interaction * np.broadcast_to(change, log.t.shape)[:, None])
        return summaries(estimate_log(warmed, AuditSettings()))[0].within["coulomb_nm"]

    steady, falling = within(1.0), within(1.0 - 0.3 * log.t / log.t[-1])
    assert steady.low < 0.0 < steady.high
    # From the middle of the first third to the middle of the last one: 0.75 / 0.95 - 1.
    assert falling.low < 0.75 / 0.95 - 1.0 < falling.high < 0.0

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from threadpoolctl import threadpool_info, threadpool_limits

from friction_audit.errors import AnalysisError
from friction_audit.parallel import WORKERS, in_copies, one_joint_at_a_time, own_process, workers_for

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="no process is copied there")


def is_a_copy() -> bool:
    return multiprocessing.current_process().daemon


def until(there: Callable[[], bool]) -> None:
    """Wait for another process, as long as a busy machine may need."""
    end = time.monotonic() + 60.0
    while not there():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_results_come_in_order_from_all_processes(tmp_path: Path) -> None:
    def work(piece: int) -> tuple[int, int]:
        (tmp_path / str(os.getpid())).touch()
        until(lambda: len(list(tmp_path.iterdir())) == 3)
        return 10 * piece, os.getpid()

    found = list(in_copies(work, 9, 3))
    assert [value for value, _ in found] == [10 * piece for piece in range(9)]
    assert len({process for _, process in found}) == 3
    assert os.getpid() in {process for _, process in found}


def test_pieces_are_begun_in_the_order_that_is_asked_for(tmp_path: Path) -> None:
    def work(piece: int) -> int:
        before = {int(one.name) for one in tmp_path.iterdir()}
        (tmp_path / str(piece)).touch()
        until(lambda: {"2", "3"} <= {one.name for one in tmp_path.iterdir()})  # both processes have begun
        return len(before)

    before = list(in_copies(work, 4, 2, begun=(2, 3, 0, 1)))
    assert max(before[2:]) <= 1
    assert min(before[:2]) >= 2


def test_one_worker_is_this_process_and_does_a_piece_when_it_is_asked_for() -> None:
    done: list[int] = []
    results = in_copies(done.append, 3, 1)
    next(results)
    assert done == [0]
    assert list(results) == [None, None]
    assert done == [0, 1, 2]


def test_an_error_anywhere_is_raised_here_when_its_turn_comes(tmp_path: Path) -> None:
    def work(piece: int) -> int:
        (tmp_path / str(os.getpid())).touch()
        until(lambda: len(list(tmp_path.iterdir())) == 2)  # this process and a copy, one of them not with the first
        if piece > 0:
            raise AnalysisError(f"joint {piece}: no cycle")
        return piece

    results = in_copies(work, 5, 2)
    assert next(results) == 0
    with pytest.raises(AnalysisError, match="joint 1: no cycle"):
        next(results)


@pytest.mark.parametrize("signal_number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_what_a_copy_does_not_live_to_send_is_done_here(signal_number: int, tmp_path: Path) -> None:
    def work(piece: int) -> tuple[int, bool]:
        if is_a_copy():
            (tmp_path / "copied").touch()
            os.kill(os.getpid(), signal_number)
            time.sleep(60.0)
        until((tmp_path / "copied").exists)
        return piece, is_a_copy()

    assert list(in_copies(work, 5, 2)) == [(piece, False) for piece in range(5)]


def test_what_cannot_be_sent_is_done_here() -> None:
    def work(piece: int) -> Callable[[], int]:
        return lambda: 10 * piece

    assert [one() for one in in_copies(work, 4, 2)] == [0, 10, 20, 30]


def test_a_copy_goes_on_while_this_process_has_no_time_for_its_large_results(tmp_path: Path) -> None:
    def work(piece: int) -> NDArray[np.int64]:
        if is_a_copy():
            (tmp_path / str(piece)).touch()
        else:
            until(lambda: len(list(tmp_path.iterdir())) == 3)
        return np.full(1_000_000, piece)

    first = list(in_copies(work, 4, 2))
    assert [(len(one), one[0], one[-1]) for one in first] == [(1_000_000, k, k) for k in range(4)]


def test_what_a_copy_warns_of_is_said_here(tmp_path: Path) -> None:
    def work(piece: int) -> int:
        if is_a_copy():
            warnings.warn("a column of zeros", RuntimeWarning, stacklevel=1)
            (tmp_path / "warned").touch()
        until((tmp_path / "warned").exists)
        return piece

    with pytest.warns(RuntimeWarning, match="a column of zeros") as said:
        assert list(in_copies(work, 2, 2)) == [0, 1]
    assert {Path(one.filename).name for one in said} == {"test_in_copies.py"}


def test_products_of_matrices_take_one_thread_meanwhile() -> None:
    def threads(_: int = 0) -> set[int]:
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    with threadpool_limits(limits=2, user_api="blas"):
        assert list(in_copies(threads, 4, 2)) == [{1}] * 4
        assert threads() == {2}


def test_copies_end_with_what_stops_this_process(tmp_path: Path) -> None:
    def work(_: int) -> None:
        if is_a_copy():
            (tmp_path / "copied").touch()
            time.sleep(60.0)
        until((tmp_path / "copied").exists)
        raise KeyboardInterrupt

    threads, begin = threading.active_count(), time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        list(in_copies(work, 2, 2))
    assert time.monotonic() - begin < 60.0
    assert multiprocessing.active_children() == []
    assert threading.active_count() == threads


def test_only_a_process_that_is_known_all_through_is_copied(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    assert workers_for(7) == 1
    with own_process():
        assert [workers_for(pieces) for pieces in (0, 1, 2, 7)] == [1, 1, min(WORKERS, 2), min(WORKERS, 2)]
        with one_joint_at_a_time():
            assert workers_for(7) == 1
        with ThreadPoolExecutor(1) as pool:
            assert pool.submit(copy_context().run, workers_for, 7).result() == 1
        assert list(in_copies(lambda _: workers_for(7) if is_a_copy() else 1, 4, 2)) == [1] * 4
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
        assert workers_for(7) == 1


SLEEPING = """
import os, signal, sys, time
from pathlib import Path
from friction_audit.parallel import in_copies

signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts behind itself ignores it
folder, seconds = Path(sys.argv[1]), float(sys.argv[2])

def work(piece):
    (folder / str(os.getpid())).touch()
    time.sleep(seconds if os.getpid() != parent else 60.0)
    return bytes(1_000_000)

parent = os.getpid()
list(in_copies(work, 9, 3))
"""


def asleep(folder: Path, seconds: float) -> subprocess.Popen[str]:
    """Start three processes that sleep in their first piece."""
    command = [sys.executable, "-c", SLEEPING, str(folder), str(seconds)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    until(lambda: len(list(folder.iterdir())) == 3)
    return process


def is_there(process: int) -> bool:
    """Whether a process lives; one that ended and that nobody has waited for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_ctrl_c_ends_all_at_once_and_only_one_has_something_to_say(tmp_path: Path) -> None:
    process = asleep(tmp_path, 60.0)
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60.0)
    assert said.count("Traceback") == 1
    assert process.returncode == -signal.SIGINT
    assert not any(is_there(int(one.name)) for one in tmp_path.iterdir())


def test_copies_do_not_outlive_the_piece_they_are_at_when_nobody_listens(tmp_path: Path) -> None:
    process = asleep(tmp_path, 1.0)
    process.kill()
    process.wait()
    until(lambda: not any(is_there(int(one.name)) for one in tmp_path.iterdir()))
    assert len(list(tmp_path.iterdir())) == 3
    assert process.stderr is not None
    assert process.stderr.read() == ""
    process.stderr.close()

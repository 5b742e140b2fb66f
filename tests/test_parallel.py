"""Threads and processes: order, errors, what happens when one is killed or the program is stopped; compiled loops."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from numba.core import caching
from threadpoolctl import threadpool_info, threadpool_limits

from friction_audit.cli.diagnose import LOADED
from friction_audit.compiled import compiled, load
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float, read_only
from friction_audit.parallel import (
    WORKERS,
    aside,
    in_processes,
    one_joint_at_a_time,
    own_process,
    per_joint,
    workers_for,
)

forked = pytest.mark.skipif(sys.platform != "linux", reason="no process is forked there")


@pytest.fixture
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})


def is_child() -> bool:
    return multiprocessing.parent_process() is not None


def until(there: Callable[[], bool]) -> None:
    """Wait for another process, as long as a busy machine may need."""
    end = time.monotonic() + 60.0
    while not there():
        assert time.monotonic() < end
        time.sleep(0.01)


def blas_threads(_: int = 0) -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_joints_come_in_order_from_threads_and_an_error_is_raised() -> None:
    assert per_joint(lambda joint: 10 * joint, 7) == [0, 10, 20, 30, 40, 50, 60]

    def work(joint: int) -> int:
        if joint == 3:
            raise AnalysisError("joint 4: no cycle")
        return joint

    with pytest.raises(AnalysisError, match="joint 4: no cycle"):
        per_joint(work, 7)


def test_one_joint_at_a_time_takes_no_threads() -> None:
    here = threading.get_ident()
    with one_joint_at_a_time():
        assert per_joint(lambda _: threading.get_ident(), 3) == [here] * 3
    meeting = threading.Barrier(min(WORKERS, 2), timeout=30.0)
    per_joint(lambda _: meeting.wait(), 2)  # at once, or it fails


@forked
def test_products_of_matrices_take_one_thread_meanwhile() -> None:
    with threadpool_limits(limits=2, user_api="blas"):
        assert per_joint(blas_threads, 2) == [{1}] * 2
        assert list(in_processes(blas_threads, 4, 2)) == [{1}] * 4
        assert blas_threads() == {2}


@forked
def test_results_come_in_order_from_all_processes(tmp_path: Path) -> None:
    def work(piece: int) -> tuple[int, int, int]:
        (tmp_path / str(os.getpid())).touch()
        until(lambda: len(list(tmp_path.iterdir())) == 3)
        return 10 * piece, os.getpid(), int(np.full(1_000_000, piece)[-1])

    found = list(in_processes(work, 9, 3))
    assert [(value, last) for value, _, last in found] == [(10 * piece, piece) for piece in range(9)]
    assert len({process for _, process, _ in found}) == 3
    assert multiprocessing.active_children() == []


def test_one_worker_is_this_process_and_does_a_piece_when_it_is_asked_for() -> None:
    done: list[int] = []
    results = in_processes(done.append, 3, 1)
    next(results)
    assert done == [0]
    assert list(results) == [None, None]
    assert done == [0, 1, 2]


@forked
@pytest.mark.usefixtures("two_cores")
def test_an_error_anywhere_is_raised_here_when_its_turn_comes() -> None:
    def work(piece: int) -> int:
        if piece > 0:
            raise AnalysisError(f"joint {piece}: no cycle")
        return piece

    results = in_processes(work, 5, 2)
    assert next(results) == 0
    with pytest.raises(AnalysisError, match="joint 1: no cycle"):
        next(results)
    with own_process(), pytest.raises(AnalysisError, match="joint 2: no cycle"), aside(lambda: work(2)) as result:
        result()


@forked
@pytest.mark.usefixtures("two_cores")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_what_a_killed_process_was_to_do_is_done_here(number: int) -> None:
    def work(piece: int) -> tuple[int, bool]:
        if is_child():
            os.kill(os.getpid(), number)
            time.sleep(60.0)
        return piece, is_child()

    assert list(in_processes(work, 5, 2)) == [(piece, False) for piece in range(5)]
    with own_process(), aside(lambda: work(3)) as result:
        assert result() == (3, False)


@forked
@pytest.mark.usefixtures("two_cores")
def test_only_a_process_that_is_known_all_through_is_forked(monkeypatch: pytest.MonkeyPatch) -> None:
    assert workers_for(7) == 1
    with own_process():
        assert [workers_for(pieces) for pieces in (0, 1, 2, 7)] == [1, 1, min(WORKERS, 2), min(WORKERS, 2)]
        with one_joint_at_a_time():
            assert workers_for(7) == 1
        with ThreadPoolExecutor(1) as pool:
            assert pool.submit(copy_context().run, workers_for, 7).result() == 1
        assert list(in_processes(lambda _: workers_for(7), 4, 2)) == [1] * 4
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
        assert workers_for(7) == 1


@forked
@pytest.mark.usefixtures("two_cores")
def test_arrays_come_from_work_aside_whose_files_are_removed_where_this_process_fails(tmp_path: Path) -> None:
    def work() -> tuple[bool, list[Float]]:
        return is_child(), [np.arange(n, dtype=np.float64) for n in (0, 1, 500_000)]

    def unpack() -> None:
        with TemporaryDirectory(dir=tmp_path):
            time.sleep(60.0)

    def fail() -> None:
        until(lambda: bool([*tmp_path.iterdir()]))
        raise InterruptedError

    with own_process(), aside(work) as result:
        child, arrays = result()
    assert (child, [float(one.sum()) for one in arrays]) == (True, [0.0, 0.0, 124_999_750_000.0])
    with own_process(), pytest.raises(InterruptedError), aside(unpack):
        fail()
    assert not [*tmp_path.iterdir()]


SLEEPING = """
import os, signal, sys, time
from pathlib import Path
from friction_audit.parallel import in_processes

signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores it

def work(piece):
    (Path(sys.argv[1]) / str(os.getpid())).touch()
    time.sleep(60.0)

list(in_processes(work, 9, 3))
"""


@forked
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_processes_end_at_once_with_this_one_and_only_one_speaks(number: signal.Signals, tmp_path: Path) -> None:
    command = [sys.executable, "-c", SLEEPING, str(tmp_path)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    until(lambda: len(list(tmp_path.iterdir())) == 3)
    begin = time.monotonic()
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # as a terminal does
    else:
        process.kill()
    _, said = process.communicate(timeout=50.0)
    until(lambda: not any(is_there(int(one.name)) for one in tmp_path.iterdir()))
    assert time.monotonic() - begin < 50.0
    assert process.returncode == -number
    assert said.count("Traceback") == (number == signal.SIGINT)


def is_there(process: int) -> bool:
    """Whether a process lives; one that ended and that nobody has waited for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize("numbers", [np.arange(6.0), np.arange(12.0)[::2], np.asfortranarray(np.ones((3, 2)))])
def test_numbers_for_a_loop_are_of_one_kind(numbers: Float) -> None:
    given = read_only(numbers)
    assert given.flags.c_contiguous
    assert not given.flags.writeable
    assert numbers.flags.writeable
    np.testing.assert_array_equal(given, numbers)


def test_a_loop_compiles_where_no_cache_can_be_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", [])
    assert compiled()(lambda x: 2 * x)(21) == 42


def test_a_diagnosis_loads_loops_while_it_reads_the_log() -> None:
    assert any(map(load, LOADED))


LOOP = "from friction_audit.compiled import compiled\n\n@compiled()\ndef {}:\n    return {}\n"
MODULES = {
    "inner.py": LOOP.format("inner(x)", "{factor} * x"),
    "outer.py": "import inner\n" + LOOP.format("outer(x)", "inner.inner(x) + 1"),
    "point.py": "from typing import NamedTuple\n\nclass {name}(NamedTuple):\n    x: float\n",
    "loop.py": LOOP.format("of_point(p)", "p.x"),
}
RUN = "import loop, outer, point; print(outer.outer(20), loop.of_point(point.{name}(1.0)))"


def test_a_loop_is_compiled_again_where_what_it_uses_has_changed_or_is_gone(tmp_path: Path) -> None:
    for factor, name, printed in ((2, "Point", "41 1.0\n"), (30, "Place", "601 1.0\n")):
        for file, text in MODULES.items():
            (tmp_path / file).write_text(text.format(factor=factor, name=name))
            if file in ("outer.py", "loop.py"):  # they are as they were
                os.utime(tmp_path / file, (0, 0))
        command = [sys.executable, "-c", RUN.format(name=name)]
        assert subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout == printed

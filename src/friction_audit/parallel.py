"""Whether this process is a command of friction-audit and nothing else, so that it is known what its threads do.

A program that uses this package as a library may have threads that hold anything.
"""

import gc
import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from multiprocessing.reduction import ForkingPickler
from queue import SimpleQueue
from typing import Any, TypeVar

_OWN = ContextVar("_OWN", default=False)


@contextmanager
def own_process() -> Iterator[None]:
    """Say in a block that this process belongs to friction-audit."""
    token = _OWN.set(True)
    try:
        yield
    finally:
        _OWN.reset(token)


def is_own_process() -> bool:
    """Return True in a block of ``own_process``."""
    return _OWN.get()


Result = TypeVar("Result")

WORKERS = min(4, os.cpu_count() or 1)
"""Each one needs working memory for a joint of its own."""

_ALONE = ContextVar("_ALONE", default=False)


@contextmanager
def one_joint_at_a_time() -> Iterator[None]:
    """Work through joints one after the other in a block: where logs run side by side, joints need not."""
    token = _ALONE.set(True)
    try:
        yield
    finally:
        _ALONE.reset(token)


def is_alone() -> bool:
    """Return True in a block of ``one_joint_at_a_time``."""
    return _ALONE.get()


def per_joint(work: Callable[[int], Result], joints: int) -> list[Result]:
    """Return the result of the work for each joint (0-based), in order."""
    from threadpoolctl import threadpool_limits

    if is_alone():
        return [work(joint) for joint in range(joints)]
    # Matrices of a joint are tall and narrow: threads inside a product would only wait for each other.
    with (
        threadpool_limits(limits=1, user_api="blas"),
        ThreadPoolExecutor(max_workers=WORKERS, thread_name_prefix="joint") as pool,
    ):
        return list(pool.map(work, range(joints)))


Arrived = SimpleQueue[bytes | None]
"""What copies have sent; None behind the last of it."""
Copy = tuple[BaseProcess, Connection]
"""A copy, and the end of a pipe at which it is heard."""

NUMBER_BYTES = 4
"""Of the number of a piece. A pipe hands over such a few at once, and holds the numbers of ten thousand pieces."""


def workers_for(pieces: int) -> int:
    """Return how many processes are to share pieces of work, this one among them: 1 where it is not to be copied."""
    first = threading.current_thread() is threading.main_thread() and not multiprocessing.current_process().daemon
    if sys.platform != "linux" or not (first and is_own_process()) or is_alone():
        return 1
    return max(min(WORKERS, len(os.sched_getaffinity(0)), pieces), 1)


def in_copies(
    work: Callable[[int], Result], pieces: int, workers: int, begun: Sequence[int] | None = None
) -> Iterator[Result]:
    """Yield the result of each piece of work (0-based), in order, each as soon as it is there.

    Args:
        work: Does one piece; results can be pickled. It writes nowhere: a copy may end at any time.
        pieces: How many there are.
        workers: Processes that share them, this one among them.
        begun: All of them in the order in which several processes begin them, their own order if None.
    """
    from threadpoolctl import threadpool_limits

    if workers == 1:
        yield from map(work, range(pieces))
        return
    done: dict[int, Result] = {}
    numbered = range(pieces) if begun is None else begun
    # Matrices of a joint are tall and narrow: threads inside a product would only wait for each other.
    with threadpool_limits(limits=1, user_api="blas"), _copies(work, numbered, workers - 1) as (numbers, arrived):
        for piece in range(pieces):
            while piece not in done:
                done |= _more(work, numbers, arrived, piece)
            yield done.pop(piece)


def _more(work: Callable[[int], Result], numbers: int, arrived: Arrived, piece: int) -> dict[int, Result]:
    """What there is next: sent by a copy, done here, or, where nothing is left to wait for, the piece asked for."""
    if arrived.empty() and (mine := _number(numbers)) is not None:
        if mine == piece:
            return {mine: work(mine)}
        with suppress(Exception):  # an error waits for its turn, as one in a copy does
            return {mine: work(mine)}
        return {}
    message = arrived.get()
    if message is not None:
        return _opened(message)
    arrived.put(None)
    return {piece: work(piece)}


@contextmanager
def _copies(work: Callable[[int], Any], pieces: Sequence[int], many: int) -> Iterator[tuple[int, Arrived]]:
    """Start copies; yield the end of a pipe with the numbers of pieces that nobody has taken, and what arrives."""
    numbers, given = os.pipe()
    os.write(given, b"".join(piece.to_bytes(NUMBER_BYTES) for piece in pieces))
    os.close(given)
    arrived: Arrived = SimpleQueue()
    copies: list[Copy] = []
    receiver = threading.Thread(target=_receive, args=(copies, arrived), daemon=True)
    try:
        with suppress(OSError):  # there may be no room for as many: what they would have done is done here
            for _ in range(many):
                copies.append(_start(work, numbers, [heard for _, heard in copies]))
        receiver.start()  # last, for no copy is to have it; without it they would wait while this process is at work
        yield numbers, arrived
    finally:
        for process, _ in copies:
            process.kill()
            process.join()
        if receiver.is_alive():
            receiver.join()
        os.close(numbers)


def _start(work: Callable[[int], Any], numbers: int, others: Sequence[Connection]) -> Copy:
    """Start a copy; it has no use for what this process hears the others by."""
    heard, sent = multiprocessing.Pipe(duplex=False)
    with sent, warnings.catch_warnings():
        # Python warns of copying a process with threads. Those of a command show progress, and no copy does; those of
        # libraries have ended or are begun anew.
        warnings.filterwarnings("ignore", message=".*fork", category=DeprecationWarning)
        process = multiprocessing.get_context("fork").Process(
            target=_be_a_copy, args=(work, numbers, sent, (*others, heard)), daemon=True
        )
        process.start()
    return process, heard


def _be_a_copy(work: Callable[[int], Any], numbers: int, sent: Connection, others: Sequence[Connection]) -> None:
    """Do pieces as long as there are any and somebody listens."""
    for stop in (signal.SIGINT, signal.SIGTERM):
        signal.signal(stop, signal.SIG_DFL)  # a copy has nothing to tidy up, and nothing to say
    gc.freeze()  # to look through all that is shared for garbage would make it no longer shared
    # A display may have had its hand on these when the copy was made.
    sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__
    for other in others:
        other.close()
    while (piece := _number(numbers)) is not None:
        try:
            message = _packed(work, piece)
        except Exception:  # noqa: BLE001, S112 - who asks does what is lacking, and has the error
            continue
        try:
            sent.send_bytes(message)
        except OSError:
            return


def _number(numbers: int) -> int | None:
    """Take the number of a piece that nobody has taken, None if there is none."""
    taken = os.read(numbers, NUMBER_BYTES)
    return int.from_bytes(taken) if taken else None


def _packed(work: Callable[[int], Any], piece: int) -> bytes:
    """Do a piece: its number, the result and what was warned of."""
    with warnings.catch_warnings(record=True) as said:
        result = work(piece)
    warned = [(one.message, one.category, one.filename, one.lineno) for one in said]
    return bytes(ForkingPickler.dumps((piece, result, warned)))


def _opened(message: bytes) -> dict[int, Any]:
    """Return the result of a piece by its number, and say what it warned of."""
    piece, result, warned = ForkingPickler.loads(message)
    for one in warned:
        warnings.warn_explicit(*one)
    return {piece: result}


def _receive(copies: Sequence[Copy], arrived: Arrived) -> None:
    """Take in what copies send until the last of them has ended."""
    left = [heard for _, heard in copies]
    while left:
        for heard in [one for one in left if one in wait(left)]:
            try:
                arrived.put(heard.recv_bytes())
            except (EOFError, OSError):
                left.remove(heard)
                heard.close()
    arrived.put(None)

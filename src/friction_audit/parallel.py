"""Work side by side: threads for what releases the interpreter (numpy, compiled loops), processes for what holds it."""

import ctypes
import gc
import os
import pickle
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor, wait as wait_for
from contextlib import contextmanager, nullcontext, suppress
from contextvars import ContextVar
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing.process import BaseProcess

Result = TypeVar("Result")

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD, M_ARENA_MAX = -1, -3, -8  # of mallopt(3)
LARGE, KEPT = 1 << 25, 1 << 26  # bytes: to map the arrays of every block anew takes a tenth of the time
BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # read by the library when numpy loads it
ENDS_S = 1.0  # in which interrupted work removes what it has written
WORKERS = min(4, os.cpu_count() or 1)  # each one needs working memory for a joint of its own

_OWN = ContextVar("_OWN", default=False)
_ALONE = ContextVar("_ALONE", default=False)


@contextmanager
def own_process() -> Iterator[None]:
    """Say in a block that this process is friction-audit's own: one of a user may have threads and is not forked."""
    token = _OWN.set(True)
    _tune_malloc(mapped=LARGE, kept=KEPT)
    try:
        yield
    finally:
        _OWN.reset(token)


@contextmanager
def one_joint_at_a_time() -> Iterator[None]:
    """Work through joints one after the other in a block: where logs run side by side, joints need not."""
    token = _ALONE.set(True)
    try:
        yield
    finally:
        _ALONE.reset(token)


def per_joint(work: Callable[[int], Result], joints: int) -> list[Result]:
    """Return the result of the work for each joint (0-based), in order, by this thread and those that are free."""
    if _ALONE.get():
        return [work(joint) for joint in range(joints)]
    left, done = iter(range(joints)), dict[int, Future[Result]]()

    def share() -> None:
        for joint in left:
            one = done[joint] = Future()
            try:
                one.set_result(work(joint))
            except Exception as error:  # noqa: BLE001 - raised below, in the order of the joints
                one.set_exception(error)

    with _one_blas_thread():
        helpers = [_threads(os.getpid()).submit(share) for _ in range(min(WORKERS, joints) - 1)]
        try:
            share()
        finally:
            list(left)  # of work that is interrupted, no more is begun
            wait_for([one for one in helpers if not one.cancel()])
    return [done[joint].result() for joint in range(joints)]


def _one_blas_thread() -> Any:  # noqa: ANN401 - of two libraries
    # Matrices of a joint are tall and narrow: threads inside a product would only wait. Our own process asked for none.
    single = _OWN.get() and all(os.environ.get(name) == "1" for name in BLAS_THREADS)
    return nullcontext() if single else _libraries(len(sys.modules)).limit(limits=1, user_api="blas")


@lru_cache(maxsize=1)
def _threads(process: int) -> ThreadPoolExecutor:  # noqa: ARG001 - a forked one has none of its parent's threads
    """Return the threads that, with the one that asks them, are as many as the cores: more would only take turns."""
    return ThreadPoolExecutor(max_workers=max(WORKERS - 1, 1), thread_name_prefix="helper")


@lru_cache(maxsize=1)
def _libraries(modules: int) -> Any:  # noqa: ANN401, ARG001 - with more of them, there may be new libraries
    """Return the libraries whose threads can be limited; to look for them takes milliseconds, for every block."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def ahead(items: Iterator[Result]) -> Iterator[Result]:
    """Yield items of which the next one is made in a thread while one is worked on, by this one if none was free."""
    coming = _threads(os.getpid()).submit(next, items, None)
    try:
        while (item := next(items, None) if coming.cancel() else coming.result()) is not None:
            coming = _threads(os.getpid()).submit(next, items, None)
            yield item
    finally:
        wait_for([] if coming.cancel() else [coming])


def workers_for(pieces: int, working_bytes: int = 0) -> int:
    """Return how many processes share work, for cores and memory (``working_bytes`` each); 1 without forks."""
    import multiprocessing

    first = threading.current_thread() is threading.main_thread() and multiprocessing.parent_process() is None
    if sys.platform != "linux" or not (first and _OWN.get()) or _ALONE.get():
        return 1
    lines = Path("/proc/meminfo").read_text().splitlines()
    available = next(1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    return max(min(WORKERS, len(os.sched_getaffinity(0)), pieces, available // max(working_bytes, 1)), 1)


def release_memory() -> None:
    """Give freed memory back to the system, which Arrow and Linux C libraries keep; forked processes would copy it."""
    if arrow := sys.modules.get("pyarrow"):
        arrow.default_memory_pool().release_unused()
    with suppress(OSError, AttributeError):  # another C library
        ctypes.CDLL(None).malloc_trim(0)


@contextmanager
def sparing_memory() -> Iterator[None]:
    """Give large arrays back as soon as they are freed, in a block: the peak is lower, the work a little slower."""
    release_memory()
    _tune_malloc(mapped=1 << 21, kept=1 << 17)
    try:
        yield
    finally:
        _tune_malloc(mapped=LARGE, kept=KEPT)


def _tune_malloc(*, mapped: int, kept: int) -> None:
    """From how many bytes on arrays are mapped one by one, and how many the heap keeps at its end: mallopt(3)."""
    with suppress(OSError, AttributeError):  # another C library
        library = ctypes.CDLL(None)
        library.mallopt(M_MMAP_THRESHOLD, mapped)
        library.mallopt(M_TRIM_THRESHOLD, kept)
        library.mallopt(M_ARENA_MAX, 2)  # every further one keeps what the threads of some block have freed


def in_processes(work: Callable[[int], Result], pieces: int, workers: int) -> Iterator[Result]:
    """Yield the result of each piece of work (0-based), in order, each as soon as it is there.

    Processes are forked, so that they share the data that the work refers to; results can be pickled. Work writes
    nowhere, since a process may end at any time: what one that is killed was to do is done here.
    """
    if workers == 1:
        yield from map(work, range(pieces))
        return
    release_memory()
    with _one_blas_thread(), processes(workers, "fork", work) as pool:
        futures = {piece: _submit(pool, piece) for piece in range(pieces)}
        for piece in range(pieces):
            yield _result(futures.pop(piece), partial(work, piece))


def _result(future: "Future[Any] | None", work: Callable[[], Result]) -> Result:
    """Return what a process has done, or do it here where there is none, or it was ended."""
    try:
        return work() if future is None else cast("Result", future.result())
    except (BrokenExecutor, SystemExit):
        return work()


def _submit(pool: "ProcessPoolExecutor", piece: int) -> "Future[Any] | None":
    with warnings.catch_warnings():
        # Python warns of forking a process with threads. Those of a command show progress, and no child does; those of
        # libraries have ended or are begun anew.
        warnings.filterwarnings("ignore", message=".*fork", category=DeprecationWarning)
        try:
            return pool.submit(_do, piece)
        except (BrokenExecutor, OSError):  # killed already, or there is no room for processes
            return None


@contextmanager
def aside(work: Callable[[], Result]) -> Iterator[Callable[[], Result]]:
    """Begin work in a forked process and yield what waits for its result; without forks, what does the work.

    Result and errors can be pickled, arrays come through memory. Of work that is not waited for, files are removed.
    """
    if workers_for(2) == 1:
        yield work
        return
    memory = os.memfd_create("arrays")

    def share(_: int) -> Callable[[], Result]:
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
        arrays: list[pickle.PickleBuffer] = []
        rest = pickle.dumps(work(), protocol=5, buffer_callback=arrays.append)
        with os.fdopen(memory, "wb", closefd=False) as file:
            return partial(_unpickled, memory, rest, [file.write(array.raw()) for array in arrays])

    def wait() -> Result:
        return _result(future, lambda: work)()

    with os.fdopen(memory, "rb"), processes(1, "fork", share) as pool:
        future = _submit(pool, 0)
        try:
            yield wait
        except BaseException:
            for process in team_of(pool):
                process.terminate()
            wait_for([future] if future else [], timeout=ENDS_S)
            raise


def _unpickled(memory: int, rest: bytes, sizes: Sequence[int]) -> Any:  # noqa: ANN401
    """Return what was pickled, but for arrays of some sizes that stand in a file one after the other: they leave it."""
    arrays = [bytearray(size) for size in sizes]
    with os.fdopen(memory, "rb", closefd=False) as file:
        for array in reversed(arrays):  # the last one first, so that each is freed as soon as it is read
            begin = file.seek(-len(array), os.SEEK_END)
            file.readinto(array)
            os.ftruncate(memory, begin)
    return pickle.loads(rest, buffers=arrays)  # noqa: S301 - a process of this program has written it


@contextmanager
def processes(
    workers: int, method: str, work: Callable[[int], Any] | None = None, preload: Sequence[str] = ()
) -> "Iterator[ProcessPoolExecutor]":
    """Yield a pool whose processes end with the block, at once and however it ends, and with this process.

    They start by ``"fork"`` and do ``work``, or by ``"forkserver"`` where this process has threads and open files: that
    server imports the modules of ``preload`` once for all of them.
    """
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    if preload:
        multiprocessing.set_forkserver_preload([*preload])
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context(method), initializer=_begin, initargs=(work,))
    try:
        yield pool
    finally:
        for process in team_of(pool):
            process.kill()
        pool.shutdown(cancel_futures=True)


def team_of(pool: "ProcessPoolExecutor") -> "list[BaseProcess]":
    """Return the processes of a pool; none of one that has ended."""
    return [*(pool._processes or {}).values()]  # noqa: SLF001 - kill_workers of Python 3.14 is not there yet


_WORK: Callable[[int], Any] | None = None  # of a forked process


def _do(piece: int) -> Any:  # noqa: ANN401
    assert _WORK is not None
    return _WORK(piece)


def _begin(work: Callable[[int], Any] | None) -> None:
    """Prepare a process of a pool: its parent alone talks, decides what Ctrl-C means, and is not outlived."""
    global _WORK  # noqa: PLW0603 - set once, before any work
    _WORK = work
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    gc.freeze()  # to look through all that is shared for garbage would make it no longer shared
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__  # a display may have had its hand on these
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    from multiprocessing import parent_process
    from multiprocessing.connection import wait

    parent = parent_process()
    assert parent is not None
    wait([parent.sentinel])
    os._exit(1)

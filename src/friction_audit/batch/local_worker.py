"""What a process of the local executor does: work after work, each with its task, until there is nobody left."""

from multiprocessing.connection import Connection


def labour(handle: int) -> None:
    """Work at the end of a pipe.

    Args:
        handle: File descriptor of the pipe.
    """
    with Connection(handle) as pipe:
        try:
            while True:
                work, task = pipe.recv()
                pipe.send(work(task))
        except (EOFError, BrokenPipeError, ConnectionResetError):
            return  # whoever wanted it has gone

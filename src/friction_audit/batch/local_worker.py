"""What a process of the local executor does: it takes the work, then task after task, until there is nobody left."""

from multiprocessing.connection import Connection


def labour(handle: int) -> None:
    """Work at the end of a pipe.

    Args:
        handle: File descriptor of the pipe.
    """
    with Connection(handle) as pipe:
        try:
            work = pipe.recv()
            while True:
                pipe.send(work(pipe.recv()))
        except (EOFError, BrokenPipeError, ConnectionResetError):
            return  # whoever wanted it has gone

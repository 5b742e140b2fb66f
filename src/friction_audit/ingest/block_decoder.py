"""Messages of constant layout, decoded as one NumPy structured array and guarded byte for byte."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.ingest.message_layout import Layout
from friction_audit.ingest.message_stream import Block

Records = NDArray[np.void]


class BlockDecoder:
    """Decodes blocks whose messages are all laid out as the first one was.

    Attributes:
        layout: Layout of the first message.
    """

    def __init__(self, layout: Layout, payload: bytes, paths: tuple[str, ...]) -> None:
        """Keep the first message's deciding bytes and the fields wanted."""
        self.layout = layout
        self._fixed_bytes = np.frombuffer(payload, np.uint8)[layout.fixed]
        leaves = [layout.numbers[path] for path in paths]
        self._dtype = np.dtype(
            {
                "names": list(paths),
                "formats": [(leaf.dtype, (leaf.count,)) for leaf in leaves],
                "offsets": [leaf.offset for leaf in leaves],
                "itemsize": layout.size,
            }
        )
        self._bytes = np.dtype((np.uint8, (layout.size,)))

    def decode(self, block: Block) -> Records | None:
        """View a block as records, one per message, one field per path; None if any message is laid out differently."""
        if not (block.size == self.layout.size).all():
            return None
        buffer, start, stride = _evenly_spaced(block)
        count = len(block)
        rows = np.ndarray((count, self.layout.size), np.uint8, buffer, offset=start, strides=(stride, 1))
        if not (rows[:, self.layout.fixed] == self._fixed_bytes).all():
            return None
        return np.ndarray((count,), self._dtype, buffer, offset=start, strides=(stride,))


def _evenly_spaced(block: Block) -> tuple[bytes, int, int]:
    """Return a buffer in which the payloads lie at a constant distance, the first offset and that distance."""
    size = int(block.size[0])
    if len(block) == 1:
        return block.buffer, int(block.start[0]), size
    steps = np.diff(block.start)
    stride = int(steps[0])
    if stride >= size and (steps == stride).all():
        return block.buffer, int(block.start[0]), stride
    return b"".join(block.payload(index) for index in range(len(block))), 0, size

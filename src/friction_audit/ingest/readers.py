"""The readers there are, in the order in which they are asked whether they recognise a file.

A format is added by writing one file and naming its record here.
"""

from friction_audit.ingest.read_csv import CSV
from friction_audit.ingest.read_mcap import MCAP
from friction_audit.ingest.read_npz import NPZ
from friction_audit.ingest.read_parquet import PARQUET
from friction_audit.ingest.read_rosbag1 import ROSBAG1
from friction_audit.ingest.read_rosbag2 import ROSBAG2
from friction_audit.ingest.reader import Reader

READERS: tuple[Reader, ...] = (PARQUET, NPZ, ROSBAG1, ROSBAG2, MCAP, CSV)
"""CSV comes last: any text with separators looks like one."""

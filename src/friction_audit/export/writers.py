"""The writers there are; of those that share an ending, the first is its default.

A format is added by writing one file and naming its record here.
"""

from friction_audit.export.write_csv import CSV, CSV_BAG, CSV_LONG, CSV_ROSTOPIC
from friction_audit.export.write_foxglove import MCAP_JSON, MCAP_PROTOBUF
from friction_audit.export.write_libfranka_csv import LIBFRANKA, LIBFRANKA_OLD
from friction_audit.export.write_mcap import (
    MCAP,
    MCAP_FRANKA_ROBOT_STATE,
    MCAP_FRANKA_ROBOT_STATE_FLAT,
    MCAP_FRANKA_STATE,
    MCAP_ROS1,
)
from friction_audit.export.write_npz import NPZ
from friction_audit.export.write_parquet import PARQUET, PARQUET_LISTS
from friction_audit.export.write_rosbag1 import ROSBAG1_FRANKA_STATE, ROSBAG1_JOINT_STATE
from friction_audit.export.write_rosbag2 import ROSBAG2_DB3, ROSBAG2_DB3_FRANKA_STATE, ROSBAG2_MCAP, ROSBAG2_SQLITE3
from friction_audit.export.writer import Writer

WRITERS: tuple[Writer, ...] = (
    PARQUET,
    PARQUET_LISTS,
    CSV,
    CSV_LONG,
    CSV_ROSTOPIC,
    CSV_BAG,
    LIBFRANKA,
    LIBFRANKA_OLD,
    NPZ,
    ROSBAG1_JOINT_STATE,
    ROSBAG1_FRANKA_STATE,
    ROSBAG2_SQLITE3,
    ROSBAG2_MCAP,
    ROSBAG2_DB3,
    ROSBAG2_DB3_FRANKA_STATE,
    MCAP,
    MCAP_FRANKA_ROBOT_STATE,
    MCAP_FRANKA_ROBOT_STATE_FLAT,
    MCAP_FRANKA_STATE,
    MCAP_ROS1,
    MCAP_JSON,
    MCAP_PROTOBUF,
)

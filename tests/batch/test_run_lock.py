from pathlib import Path

from friction_audit.batch.run_batch import run_lock


def test_the_second_run_in_a_folder_knows_of_the_first(tmp_path: Path) -> None:
    with run_lock(tmp_path) as alone:
        assert alone
        with run_lock(tmp_path) as also:
            assert not also
    with run_lock(tmp_path) as alone:
        assert alone

from pathlib import Path

import pytest

from friction_audit.errors import UsageError
from friction_audit.whole_file import whole_file


def test_the_file_appears_only_when_the_block_succeeds(tmp_path: Path) -> None:
    target = tmp_path / "result.json"
    with whole_file(target) as draft:
        draft.write_text("all of it")
        assert not target.exists()
    assert target.read_text() == "all of it"
    assert list(tmp_path.iterdir()) == [target]


def test_a_failure_leaves_nothing_and_keeps_what_was_there(tmp_path: Path) -> None:
    target = tmp_path / "result.json"
    target.write_text("old")
    with pytest.raises(ZeroDivisionError), whole_file(target, overwrite=True) as draft:
        fail_half_way(draft)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def fail_half_way(draft: Path) -> None:
    draft.write_text("half")
    raise ZeroDivisionError


def test_an_existing_result_is_refused_unless_asked(tmp_path: Path) -> None:
    target = tmp_path / "bag"
    target.mkdir()
    (target / "a").touch()
    with pytest.raises(UsageError, match="exists already"), whole_file(target):
        pass
    with whole_file(target, overwrite=True) as draft:
        draft.mkdir()
        (draft / "b").touch()
    assert [p.name for p in target.iterdir()] == ["b"]


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with (
        pytest.raises(UsageError, match=r"cannot be written.*choose another place"),
        whole_file(tmp_path / "file" / "out.json"),
    ):
        pass

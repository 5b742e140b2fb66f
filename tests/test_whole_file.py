import os
from pathlib import Path

import pytest

from friction_audit.errors import UsageError
from friction_audit.io.files import whole_file

METADATA = "rosbag2_bagfile_information:\n  ros_distro: rosbags\n"


def make_bag(folder: Path) -> Path:
    folder.mkdir()
    (folder / "metadata.yaml").write_text(METADATA)
    (folder / f"{folder.name}.db3").write_text("old")
    return folder


def state(folder: Path) -> dict[str, bytes | None]:
    """Return all files and folders below a folder, so that nothing is lost and nothing left over."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
    }


def fill_the_disk(draft: Path) -> None:
    draft.write_text("half of it")
    Path("/dev/full").write_text("the other half")


def test_a_failure_leaves_nothing_and_keeps_what_was_there(tmp_path: Path) -> None:
    target = tmp_path / "result.json"
    target.write_text("old")
    with pytest.raises(UsageError, match=r"result.json: .*No space.*room"), whole_file(target, overwrite=True) as draft:
        fill_the_disk(draft)
    assert state(tmp_path) == {"result.json": b"old"}


def test_a_bag_is_refused_unless_asked_and_then_replaced_whole(tmp_path: Path) -> None:
    target = make_bag(tmp_path / "bag")
    with pytest.raises(UsageError, match="exists already"), whole_file(target):
        pass
    with whole_file(target, overwrite=True) as draft:
        draft.mkdir()
        (draft / "b").touch()
    assert state(tmp_path) == {"bag": None, "bag/b": b""}


@pytest.mark.parametrize("kind", ["with another file", "recorded by ROS", "a bag for a file"])
def test_only_a_bag_of_this_program_gives_way_to_a_bag(kind: str, tmp_path: Path) -> None:
    target = make_bag(tmp_path / "data")
    if kind == "with another file":
        (target / "chapter1.txt").write_text("precious")
    elif kind == "recorded by ROS":
        (target / "metadata.yaml").write_text(METADATA.replace("rosbags", "jazzy"))
    before = state(tmp_path)
    with pytest.raises(UsageError, match="choose another name"), whole_file(target, overwrite=True) as draft:
        draft.write_text("a file") if kind == "a bag for a file" else draft.mkdir()
    assert state(tmp_path) == before


@pytest.mark.parametrize("fault", [OSError(30, "Read-only file system"), KeyboardInterrupt()])
def test_the_old_bag_is_there_again_if_the_new_one_cannot_take_its_place(
    fault: BaseException, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = make_bag(tmp_path / "bag")
    before = state(tmp_path)

    def refuse(*_: object) -> None:
        raise fault

    monkeypatch.setattr(Path, "replace", refuse)
    kind = UsageError if isinstance(fault, OSError) else KeyboardInterrupt
    with pytest.raises(kind), whole_file(target, overwrite=True) as draft:
        draft.mkdir()
    assert state(tmp_path) == before


def test_a_link_stays_and_its_target_is_written(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    target, link = tmp_path / "deep" / "target.txt", tmp_path / "link.csv"
    target.write_text("old")
    link.symlink_to("deep/target.txt")
    with pytest.raises(UsageError, match="exists already"), whole_file(link):
        pass
    for text in ("new", "of a link that leads nowhere"):
        with whole_file(link, overwrite=True) as draft:
            assert draft.suffix == ".csv"
            draft.write_text(text)
        assert link.is_symlink()
        assert target.read_text() == text
        assert list((tmp_path / "deep").iterdir()) == [target]
        target.unlink()
    with pytest.raises(UsageError, match="exists already"), whole_file(link):
        pass


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nowhere.csv", "is a link"),
        ("itself.csv", "is a link"),
        ("pipe.csv", "no regular file"),
        ("file/out.json", r"cannot be written.*choose another place"),
    ],
)
def test_places_where_nothing_can_be_written_are_refused(name: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "nowhere.csv").symlink_to("absent/file.csv")
    (tmp_path / "itself.csv").symlink_to("itself.csv")
    (tmp_path / "file").touch()
    os.mkfifo(tmp_path / "pipe.csv")
    before = state(tmp_path)
    with pytest.raises(UsageError, match=words), whole_file(tmp_path / name, overwrite=True):
        pass
    assert state(tmp_path) == before
    assert (tmp_path / "nowhere.csv").readlink() == Path("absent/file.csv")
    assert (tmp_path / "pipe.csv").is_fifo()


def test_names_as_long_as_names_can_be(tmp_path: Path) -> None:
    with whole_file(tmp_path / ("x" * 255)) as draft:
        draft.write_text("text")
    with pytest.raises(UsageError, match="name too long"), whole_file(tmp_path / ("x" * 256)) as draft:
        draft.write_text("text")
    assert state(tmp_path) == {"x" * 255: b"text"}

"""Drawings: each figure once, for its files and for the page."""

import pickle
from dataclasses import replace

import pytest

from friction_audit.reporting.batch_drawings import ON_A_SHEET, Drawing, draw, drawings_of
from friction_audit.reporting.figures.batch import BATCH_FIGURES
from friction_audit.reporting.html.batch_page import write_page
from tests.reporting import batch_by_hand as by_hand

KINDS = [kind.name for kind in BATCH_FIGURES]
TWO = by_hand.arm(4, 2, robot="two")


def drawings(*joints: int) -> list[Drawing]:
    arms = [replace(by_hand.arm(4, count), robot=f"arm{count}") for count in joints]
    return list(drawings_of(arms, {arm.robot: f"{arm.robot}-" for arm in arms}, ["png", "svg"]))


def test_what_fits_on_a_sheet_is_drawn_once() -> None:
    found = drawings(2)
    assert [(one.name, one.anchor) for one in found] == [(f"arm2-{kind}", f"arm-1-{kind}-1") for kind in KINDS]
    assert {one.formats for one in found} == {("png", "svg")}


def test_one_joint_is_a_column_in_its_files_and_a_sheet_on_the_page() -> None:
    found = [one for one in drawings(1) if one.kind == "drift"]
    assert [(one.name, one.anchor, one.joint) for one in found] == [
        ("", "arm-1-drift-1", None),
        ("arm1-drift", "", 1),
    ]


def test_many_joints_make_several_sheets_of_the_page_and_one_of_the_files() -> None:
    found = [one for one in drawings(ON_A_SHEET + 2) if one.kind == "drift"]
    assert [len(one.arm.joints) for one in found] == [ON_A_SHEET, 2, ON_A_SHEET + 2]
    assert [one.which for one in found] == [", joints 1 to 8", ", joints 9 to 10", ""]


def test_an_arm_without_joints_is_not_drawn() -> None:
    assert list(drawings_of([replace(TWO, joints=())], {}, ["png"])) == []


@pytest.mark.usefixtures("sketched")
def test_the_page_takes_what_others_have_drawn() -> None:
    summary = by_hand.batch(TWO)
    done = [draw(pickle.loads(pickle.dumps(one))) for one in drawings_of([TWO], {"two": ""}, ["svg"])]
    assert [list(one.files) for one in done] == [[f"{kind}.svg"] for kind in KINDS]
    assert all(content.startswith(b"<?xml") for one in done for content in one.files.values())
    figures = {f"arm-1-{kind}-1": one.figure for kind, one in zip(KINDS, done, strict=True) if one.figure}
    titled = {anchor: replace(figure, title=f"drawn {anchor}") for anchor, figure in figures.items()}
    page = write_page(summary, titled)
    assert all(f"drawn {anchor}" in page for anchor in titled)

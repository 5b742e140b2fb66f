"""Limits of a drift report -> JUnit, which servers of continuous integration read: a test case per joint and limit."""

from collections.abc import Sequence
from xml.etree import ElementTree as ET

from friction_audit.drift.report import DriftReport, Judged, Limit, judge
from friction_audit.errors import printable
from friction_audit.reporting.drift_words import NAMES, limit_sentence, total_text
from friction_audit.reporting.words import NEWTON_METRES, in_unit

# Of what is not kept: the element, and what it counts as. A limit that cannot be tested is an error and not skipped,
# for servers count what is skipped as passed, and the command exits with 7.
OUTCOMES = {"exceeded": ("failure", "failures"), "untestable": ("error", "errors")}


def junit_text(command: str, report: DriftReport, limits: Sequence[Limit], unit: str = NEWTON_METRES) -> str:
    """Return the XML of the limits of a command, a suite per limit; torques are in a unit."""
    root = ET.Element("testsuites", name=f"friction-audit {command}")
    judged = list(judge(report, limits))
    for limit in limits:
        suite = ET.SubElement(root, "testsuite", name=limit.text)
        for one in judged:
            if one.limit is limit:
                _add_case(suite, command, one, unit)
        _count(suite)
    _count(root)
    ET.indent(root)
    return ET.tostring(root, "unicode", xml_declaration=True) + "\n"


def _add_case(suite: ET.Element, command: str, one: Judged, unit: str) -> None:
    name = f"limit {one.limit.text}"
    if one.found is not None:
        name = f"joint {one.joint}: {NAMES[one.found.coefficient]} friction, {name}"
    classname = ".".join(
        printable(part).replace(".", "_") for part in ("friction-audit", command, one.robot or "no arm")
    )
    case = ET.SubElement(suite, "testcase", classname=classname, name=name)
    if one.verdict in OUTCOMES:
        sentence = printable(in_unit(limit_sentence(one), unit))
        outcome = ET.SubElement(case, OUTCOMES[one.verdict][0], message=sentence, type=one.verdict)
        outcome.text = sentence
    elif one.found is not None:
        ET.SubElement(case, "system-out").text = f"change {in_unit(total_text(one.found), unit)}"


def _count(whole: ET.Element) -> None:
    for element, counted in (("testcase", "tests"), *OUTCOMES.values()):
        whole.set(counted, str(len(whole.findall(f".//{element}"))))

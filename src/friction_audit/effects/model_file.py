"""ArmModel <-> ``model.toml``, the file that people may read and edit."""

import json
import sys
from collections.abc import Iterator, Mapping
from itertools import chain, islice
from pathlib import Path
from typing import Any

from friction_audit import __version__
from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, Provenance
from friction_audit.effects.registry import near_names, terms
from friction_audit.errors import AnalysisError, InputError, shortened
from friction_audit.io.files import read_toml, whole_file

SCHEMA = "friction-audit/model/1"
ORIGIN: dict[str, type] = {"method": str, "log": str, "sha256": str, "cycles": int}
"""Keys of a joint's provenance and their types."""
MOST_FAULTS, LONGEST_VALUE = 50, 80  # faults that a message names, and characters of a key or value in it


def save_model(model: ArmModel, path: Path, *, overwrite: bool = False) -> None:
    """Write a model, whole or not at all.

    Raises:
        UsageError: If the file exists and ``overwrite`` is false, or its folder cannot be written to.
    """
    with whole_file(path, overwrite=overwrite) as draft:
        draft.write_text("\n".join(_lines(model)) + "\n", encoding="utf-8")


def load_model(path: Path) -> ArmModel:
    """Read a model.

    Raises:
        InputError: If the file is none; the message names all that is missing at once.
    """
    document = _read(path)
    schema = document.get("schema")
    if schema != SCHEMA:
        found = shortened(repr(schema), LONGEST_VALUE)
        raise InputError(f"{path}: schema is {found}; expected {SCHEMA!r}; is it a file of a joint model?")
    tables = document.get("joint")
    if not isinstance(tables, list) or not tables or not all(isinstance(table, dict) for table in tables):
        raise InputError(f"{path}: no [[joint]] table; expected one per joint; write the model again")
    strange = _strangers(document, ("schema", "version", "joint"), "the file")
    of_joints = (fault for i, table in enumerate(tables) for fault in _faults(table, f"joint {i + 1}"))
    faults = list(islice(chain(strange, of_joints), MOST_FAULTS))
    if faults:
        raise InputError(f"{path}: {'; '.join(faults)}; correct the file or write the model again")
    joints = tuple(_joint(path, i + 1, table) for i, table in enumerate(tables))
    return ArmModel(names=tuple(table["name"] for table in tables), joints=joints)


def _lines(model: ArmModel) -> Iterator[str]:
    """Yield the lines of the file."""
    yield f"schema = {_text(SCHEMA)}"
    yield f"version = {_text(__version__)}"
    for name, joint in zip(model.names, model.joints, strict=True):
        yield from ("", "[[joint]]", f"name = {_text(name)}")
        if joint is not None:
            yield from _joint_lines(joint)


def _joint_lines(joint: JointModel) -> Iterator[str]:
    """Yield the lines of one joint below its name."""
    yield f"inertia_kg_m2 = {float(joint.inertia_kg_m2)!r}"
    if joint.held:
        yield f"held = [{', '.join(_text(name) for name in joint.held)}]"
    origin = joint.provenance
    yield from ("", "[joint.provenance]")
    yield from (f"{key} = {_text(getattr(origin, key))}" for key in ("method", "log", "sha256"))
    yield f"cycles = {origin.cycles}"
    for term in joint.terms:
        yield from ("", f"[joint.terms.{term.name}]  # {term.effect.label}")
        for parameter, value in zip(term.effect.parameters, term.values, strict=True):
            if value != parameter.default or not parameter.optional:
                yield f"{parameter.name} = {float(value)!r}  # {parameter.unit}, {parameter.meaning}"


def _text(text: str) -> str:
    """Return a basic string of TOML; JSON's escapes are a part of TOML's, which wants DEL escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _read(path: Path) -> dict[str, Any]:
    """Return the file as TOML."""
    try:
        return read_toml(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; give a file of a joint model") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no text in UTF-8; expected a model.toml") from error
    except ValueError as error:
        raise InputError(f"{path}: is no TOML: {error}; expected a model.toml") from error


def _faults(table: Mapping[str, Any], where: str) -> Iterator[str]:
    """Yield what is wrong with the table of one joint: keys missing, strange, or of the wrong type."""
    yield from _strangers(table, ("name", "inertia_kg_m2", "held", "provenance", "terms"), where)
    if not isinstance(table.get("name"), str):
        yield f"{where}: name is missing or no text"
    known = "inertia_kg_m2" in table
    terms, origin, held = table.get("terms", {}), table.get("provenance", {}), table.get("held", [])
    if known and not _is_number(table["inertia_kg_m2"]):
        yield f"{where}: inertia_kg_m2 is no number"
    if not isinstance(held, list) or not all(isinstance(name, str) for name in held):
        yield f"{where}: held is no list of names of terms"
    if not known and (terms or origin or held):
        yield f"{where}: inertia_kg_m2 is missing"
    if isinstance(terms, dict):
        for name, values in terms.items():
            yield from _term_faults(name, values, where)
    else:
        yield f"{where}: terms is no table"
    yield from _origin_faults(origin, f"{where}: provenance")


def _term_faults(name: str, values: object, where: str) -> Iterator[str]:
    """Yield what is wrong with the table of one term."""
    names = [term.name for term in terms() if term.name != "inertia"]
    term = next((term for term in terms() if term.name == name and name in names), None)
    if term is None:
        yield f"{where}: {name!r} is no term{near_names(name, names)}, expected {', '.join(names)}"
        return
    if not isinstance(values, dict):
        yield f"{where}: {name} is no table"
        return
    wanted = tuple(parameter.name for parameter in term.parameters)
    yield from _strangers(values, wanted, f"{where}: {name}")
    missing = [p.name for p in term.parameters if p.name not in values and not p.optional]
    if missing:
        yield f"{where}: {name}: {', '.join(missing)} missing"
    yield from (
        f"{where}: {name}: {key} is no number" for key in wanted if key in values and not _is_number(values[key])
    )


def _origin_faults(origin: object, where: str) -> Iterator[str]:
    """Yield what is wrong with the table of a provenance."""
    if not isinstance(origin, dict):
        yield f"{where} is no table"
        return
    yield from _strangers(origin, tuple(ORIGIN), where)
    for key, kind in ORIGIN.items():
        if key in origin and type(origin[key]) is not kind:
            yield f"{where}: {key} is no {'text' if kind is str else 'whole number'}"


def _strangers(table: Mapping[str, Any], known: tuple[str, ...], where: str) -> Iterator[str]:
    """Yield the keys that nobody knows."""
    strange = (shortened(key, LONGEST_VALUE) for key in table if key not in known)
    yield from (f"{where}: {key!r} is no key{near_names(key, list(known))}" for key in strange)


def _is_number(value: object) -> bool:
    """Return True for a number that is no truth value and that a float can hold."""
    whole = isinstance(value, int) and not isinstance(value, bool) and abs(value) <= sys.float_info.max
    return whole or isinstance(value, float)


def _joint(path: Path, number: int, table: Mapping[str, Any]) -> JointModel | None:
    """Return the model of a joint from a table without faults; its values may still be beyond their bounds."""
    if "inertia_kg_m2" not in table:
        return None
    try:
        terms = tuple(_term(name, values) for name, values in table.get("terms", {}).items())
        origin = Provenance(**table.get("provenance", {}))
        held = tuple(table.get("held", ()))
        return JointModel(inertia_kg_m2=float(table["inertia_kg_m2"]), terms=terms, provenance=origin, held=held)
    except AnalysisError as error:
        raise InputError(f"{path}: joint {number}: {error}; correct the file") from error


def _term(name: str, values: Mapping[str, Any]) -> FittedTerm:
    """Return a term, its values in the order of its parameters."""
    term = next(term for term in terms() if term.name == name)
    # What may be missing was asked before: only optional numbers are.
    return FittedTerm(name, tuple(float(values.get(p.name, p.default)) for p in term.parameters))

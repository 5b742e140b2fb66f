"""JointModel: what is known of a joint, as inertia and a tuple of named terms; and their file ``model.toml``."""

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from math import isfinite
from pathlib import Path
from typing import Any, cast, get_type_hints

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect
from friction_audit.effects.registry import term_of, terms
from friction_audit.errors import AnalysisError, InputError, near_misses, shortened
from friction_audit.io.files import read_toml, whole_file
from friction_audit.joint_log import Float

REST = ("coulomb", "viscous")  # terms of ``Motion.rest`` besides the inertia

SCHEMA = "friction-audit/model/1"
JOINT = {"name": str, "inertia_kg_m2": float, "held": list, "provenance": dict, "terms": dict}  # keys of its table
KINDS = {str: "text", int: "whole number", float: "number", list: "list of names of terms", dict: "table"}
MOST_FAULTS, LONGEST_VALUE = 50, 80  # faults that a message names, and characters of a key or value in it


@dataclass(frozen=True, slots=True)
class FittedTerm:
    """A term with its numbers; AnalysisError if there is none, or values are missing, superfluous or out of bounds."""

    name: str
    values: tuple[float, ...]  # of the ``parameters`` of its effect, in order

    def __post_init__(self) -> None:
        parameters = self.effect.parameters
        if len(self.values) != len(parameters):
            names = ", ".join(parameter.name for parameter in parameters)
            raise AnalysisError(f"term {self.name}: {len(self.values)} values; expected {len(parameters)}: {names}")
        for parameter, value in zip(parameters, self.values, strict=True):
            if not parameter.allows(value):
                bounds = f"a number from {parameter.lower:g} to {parameter.upper:g}"
                raise AnalysisError(f"term {self.name}: {parameter.name} = {value:g}; expected {bounds}")

    @property
    def effect(self) -> Effect:
        """Its effect: names, bounds and formula."""
        return term_of(self.name)

    @property
    def numbers(self) -> dict[str, float]:
        """Its values by name."""
        return {one.name: value for one, value in zip(self.effect.parameters, self.values, strict=True)}

    def torque(self, motion: Motion) -> Float:
        """Return the torque. [N m], shape (n,)."""
        return self.effect.torque(motion, self.values)


@dataclass(frozen=True, kw_only=True, slots=True)
class Provenance:
    """Where a model comes from."""

    method: str = ""  # how it was found, e.g. ``energy``; empty if given by hand
    log: str = ""  # path of the log, as given
    sha256: str = ""  # digest of the log
    cycles: int = 0  # number of cycles it rests on


@dataclass(frozen=True, kw_only=True, slots=True)
class JointModel:
    """Model of one joint: F_m + u = B ddq + the sum of its terms, each at most once; those that are held are there."""

    # Behind the torque sensor; of a torque from which a rigid-body model has taken it out, what is left, about zero.
    inertia_kg_m2: float
    terms: tuple[FittedTerm, ...] = ()  # the other terms
    provenance: Provenance = field(default_factory=Provenance)
    held: tuple[str, ...] = ()  # terms whose numbers are known from elsewhere: a diagnosis does not fit them again

    def __post_init__(self) -> None:
        if not isfinite(self.inertia_kg_m2):
            raise AnalysisError(f"inertia_kg_m2 = {self.inertia_kg_m2:g}; expected a number")
        names = [term.name for term in self.terms]
        if "inertia" in names:
            raise AnalysisError("term inertia stands among the terms; expected it as inertia_kg_m2")
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise AnalysisError(f"term {', '.join(twice)} stands twice; expected each term once")
        absent = [name for name in self.held if name not in names]
        if absent:
            raise AnalysisError(f"held: {', '.join(absent)}; expected some of the joint's terms: {', '.join(names)}")

    def values(self, name: str) -> tuple[float, ...] | None:
        """Return the values of a term, or None where the model does not have it."""
        return next((term.values for term in self.terms if term.name == name), None)

    def torque(self, motion: Motion) -> Float:
        """Return the torque F_m + u that the motion takes. [N m], shape (n,)."""
        known = replace(motion, rest=self.rest(motion)) if motion.rest is None else motion
        return np.asarray(self.inertia_kg_m2 * motion.ddq + sum(term.torque(known) for term in self.terms))

    def rest(self, motion: Motion) -> Float:
        """Return the torque that inertia, Coulomb and viscous friction take. [N m], shape (n,)."""
        simple = sum(term.torque(motion) for term in self.terms if term.name in REST)
        return np.asarray(self.inertia_kg_m2 * motion.ddq + simple)


@dataclass(frozen=True, kw_only=True, slots=True)
class ArmModel:
    """Models of the joints of an arm; AnalysisError if there is no joint, or not one name per joint."""

    names: tuple[str, ...]  # of the joints
    joints: tuple[JointModel | None, ...]  # one per joint; None where the log did not allow one

    def __post_init__(self) -> None:
        if not self.joints or len(self.names) != len(self.joints):
            found = f"{len(self.names)} names for {len(self.joints)} joints"
            raise AnalysisError(f"{found}; expected one each, and a joint at least")


def simple_model(*, inertia_kg_m2: float, coulomb_nm: float, viscous_nms_per_rad: float) -> JointModel:
    """Return a model of inertia, Coulomb and viscous friction."""
    terms = (FittedTerm("coulomb", (coulomb_nm,)), FittedTerm("viscous", (viscous_nms_per_rad,)))
    return JointModel(inertia_kg_m2=inertia_kg_m2, terms=terms)


def save_model(model: ArmModel, path: Path, *, overwrite: bool = False) -> None:
    """Write a model, whole or not at all; UsageError if the file exists, or its folder cannot be written to."""
    with whole_file(path, overwrite=overwrite) as draft:
        draft.write_text("\n".join(_lines(model)) + "\n", encoding="utf-8")


def load_model(path: Path) -> ArmModel:
    """Read a model; InputError, which names all that is missing at once, if the file is none."""
    try:
        document = read_toml(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; give a file of a joint model") from error
    except ValueError as error:
        raise InputError(f"{path}: is no TOML: {error}; expected a model.toml") from error
    schema = document.get("schema")
    if schema != SCHEMA:
        found = shortened(repr(schema), LONGEST_VALUE)
        raise InputError(f"{path}: schema is {found}; expected {SCHEMA!r}; is it a file of a joint model?")
    tables = document.get("joint")
    if not isinstance(tables, list) or not tables or not all(isinstance(table, dict) for table in tables):
        raise InputError(f"{path}: no [[joint]] table; expected one per joint; write the model again")
    of_file = _faults(document, dict.fromkeys(("schema", "version", "joint"), object), (), "the file")
    of_joints = (fault for i, table in enumerate(tables) for fault in _joint_faults(table, f"joint {i + 1}"))
    faults = list(islice(chain(of_file, of_joints), MOST_FAULTS))
    if faults:
        raise InputError(f"{path}: {'; '.join(faults)}; correct the file or write the model again")
    joints = tuple(_joint(path, i + 1, table) for i, table in enumerate(tables))
    return ArmModel(names=tuple(table["name"] for table in tables), joints=joints)


def _lines(model: ArmModel) -> Iterator[str]:
    from friction_audit import __version__  # the package itself knows the simulator, which knows this module

    yield from (f"schema = {_text(SCHEMA)}", f"version = {_text(__version__)}")
    for name, joint in zip(model.names, model.joints, strict=True):
        yield from ("", "[[joint]]", f"name = {_text(name)}")
        if joint is None:
            continue
        yield f"inertia_kg_m2 = {float(joint.inertia_kg_m2)!r}"
        if joint.held:
            yield f"held = [{', '.join(_text(name) for name in joint.held)}]"
        origin = joint.provenance
        yield from ("", "[joint.provenance]")
        yield from (f"{key} = {_text(getattr(origin, key))}" for key in ("method", "log", "sha256"))
        yield f"cycles = {origin.cycles}"
        for term in joint.terms:
            yield from ("", f"[joint.terms.{term.name}]  # {term.effect.label}")
            for own, value in zip(term.effect.parameters, term.values, strict=True):
                if value != own.default or not own.optional:
                    yield f"{own.name} = {float(value)!r}  # {own.unit}, {own.meaning}"


def _text(text: str) -> str:
    """Return a basic string of TOML; JSON's escapes are a part of TOML's, which wants DEL escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _joint_faults(table: Mapping[str, Any], where: str) -> Iterator[str]:
    """Yield what is wrong with the table of a joint; its inertia may lack where nothing else is known."""
    found, origin = table.get("terms", {}), table.get("provenance", {})
    needed = ["name", *(["inertia_kg_m2"] if found or origin or table.get("held") else [])]
    yield from _faults(table, JOINT, needed, where)
    kinds = get_type_hints(Provenance)
    yield from _faults(origin if isinstance(origin, dict) else {}, kinds, (), f"{where}: provenance")
    known = {term.name: term for term in terms() if term.name != "inertia"}
    for name, values in (found if isinstance(found, dict) else {}).items():
        if name not in known:
            yield f"{where}: {name!r} is no term, expected {', '.join(known)}{near_misses(name, known)}"
            continue
        parameters = known[name].parameters
        needed = [one.name for one in parameters if not one.optional]
        yield from _faults(values, {one.name: float for one in parameters}, needed, f"{where}: {name}")


def _faults(table: object, kinds: Mapping[str, type], needed: Sequence[str], where: str) -> Iterator[str]:
    """Yield what is wrong with a table: keys that are strange, missing, or of the wrong type."""
    if not isinstance(table, dict):
        yield f"{where} is no table"
        return
    strange = (shortened(key, LONGEST_VALUE) for key in table if key not in kinds)
    yield from (f"{where}: {key!r} is no key{near_misses(key, kinds)}" for key in strange)
    if missing := [key for key in needed if key not in table]:
        yield f"{where}: {', '.join(missing)} missing"
    wrong = (key for key, kind in kinds.items() if key in table and not _is_of(table[key], kind))
    yield from (f"{where}: {key} is no {KINDS[kinds[key]]}" for key in wrong)


def _is_of(value: object, kind: type) -> bool:
    """Return True for a value of a kind; a number is none that no float can hold."""
    if kind is float:
        return isinstance(value, float) or (_is_of(value, int) and abs(cast("int", value)) <= sys.float_info.max)
    if kind is list:
        return isinstance(value, list) and all(isinstance(one, str) for one in value)
    return isinstance(value, kind) and not (kind is int and isinstance(value, bool))


def _joint(path: Path, number: int, table: Mapping[str, Any]) -> JointModel | None:
    """Return the model of a joint from a table without faults; its values may still be beyond their bounds."""
    if "inertia_kg_m2" not in table:
        return None
    try:
        # What may be missing was asked before: only optional numbers are.
        terms = tuple(
            FittedTerm(name, tuple(float(values.get(p.name, p.default)) for p in term_of(name).parameters))
            for name, values in table.get("terms", {}).items()
        )
        origin, held = Provenance(**table.get("provenance", {})), tuple(table.get("held", ()))
        return JointModel(inertia_kg_m2=float(table["inertia_kg_m2"]), terms=terms, provenance=origin, held=held)
    except AnalysisError as error:
        raise InputError(f"{path}: joint {number}: {error}; correct the file") from error

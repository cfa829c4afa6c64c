"""Members of a turbine's claim that no condition reads: they are refused, at every place.

An uncertainty or a filter that is passed over would stand in a claim that is PROVED.  So would a
delay of the turbine, or a limit of the law: these parts are looked at in the same way.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from copy import deepcopy
from functools import cache
from typing import Any

import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import read_text
from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.replay import claim_kinds
from takagi.certificates.checker.turbine import members as first
from takagi.certificates.checker.turbine.effort_sharing import inputs as effort_sharing
from takagi.certificates.checker.turbine.published import inputs as published
from tests.certificates.recorded import inputs
from tests.certificates.recorded.answers import recorded

Way = tuple[str, ...]
KINDS = sorted(claim_kinds.TURBINE_KINDS)
# Members that some claims leave out.
OPTIONAL: dict[str, set[Way]] = {
    "paper-loop": {("unproved", "wind"), ("unproved", "reason")},
}


def listed(kind: str) -> first.Members:
    found: first.Members = claim_kinds.class_of(kind).members
    return found


@cache
def claims() -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in inputs.LAWS:
        for claim in inputs.document(name)["claims"]:
            found.setdefault(claim["kind"], claim)
    for kind in sorted(set(KINDS) - set(found)):
        found[kind] = json.loads(next(recorded(kind))[1])["claims"][0]
    return found


def objects(value: Any, way: Way = ()) -> Iterator[tuple[Way, Any]]:
    if isinstance(value, list) and value:
        yield from objects(value[0], way)
    elif isinstance(value, dict):
        yield way, value
        for name, inner in value.items():
            yield from objects(inner, (*way, name))


def ways(known: first.Members, way: Way = ()) -> Iterator[Way]:
    for name, inner in known.items():
        yield (*way, name)
        if inner is None:
            yield (*way, name, "*")
        else:
            yield from ways(inner, (*way, name))


@pytest.mark.parametrize("kind", KINDS)
def test_a_claim_that_takagi_wrote_has_the_listed_members(kind: str) -> None:
    """All of them but those that some claims leave out: no name is listed that is not written."""
    claim = claims()[kind]
    first.refuse_further(listed(kind), claim, "claim")
    written = {(*way, name) for way, at in objects(claim) for name in at}
    missing = {way for way in ways(listed(kind)) if "*" not in way} - written
    assert missing == OPTIONAL.get(kind, set()) - written


@pytest.mark.parametrize("value", [0, None, {}, []], ids=str)
@pytest.mark.parametrize("kind", KINDS)
def test_a_further_member_is_refused_at_every_place(kind: str, value: Any) -> None:
    claim = claims()[kind]
    places = [way for way, _ in objects(claim) if "multipliers" not in way]
    assert places
    for way in places:
        changed = deepcopy(claim)
        next(at for here, at in objects(changed) if here == way)["further"] = value
        with pytest.raises(CertificateError, match="'further' is not known; leave it out"):
            first.refuse_further(listed(kind), changed, "claim")


def test_a_name_with_a_dot_is_a_name() -> None:
    claim = deepcopy(claims()["running-loop"])
    claim["observer.l1"] = 3.0
    with pytest.raises(CertificateError, match="not known"):
        first.refuse_further(listed("running-loop"), claim, "claim")


# In whole files.


# The parts that the claims are about.


def test_a_published_law_has_the_listed_members() -> None:
    data = inputs.read_law("paper")
    law = data["gains"]
    places = [way for way, _ in objects(law)]
    assert ("partial", "premises") in places
    claim = {"kind": "paper-loop", "name": "none"}
    first.refuse_unread(listed("paper-loop"), claim, data, "claim")
    for way in places:
        changed = deepcopy(law)
        next(at for here, at in objects(changed) if here == way)["further"] = None
        with pytest.raises(CertificateError, match="'further' is not known"):
            first.refuse_unread(listed("paper-loop"), claim, {**data, "gains": changed}, "claim")


# What a program of the gain file makes of the numbers.


def _with(law: Any, region: str, name: str, ends: tuple[str, str] | None) -> Any:
    changed = deepcopy(law)
    changed[region]["premises"].pop(name)
    if ends:
        changed[region]["premises"][name] = [*map(reader.Number, ends)]
    return changed


@pytest.mark.parametrize("region", ["partial", "full"])
def test_a_premise_has_a_range_in_floats(region: str) -> None:
    """In a program one whose ends are one float has the weight 0, whatever its value."""
    law = inputs.read_law("paper")["gains"]
    near, one = ("0.25", "0.250000000000001"), ("0.25", "0.25000000000000000001")
    published.PublishedLaw.read(_with(law, region, "a", near))
    with pytest.raises(CertificateError, match="premises: the numbers must increase"):
        published.PublishedLaw.read(_with(law, region, "a", one))


@pytest.mark.parametrize("region", ["partial", "full"])
def test_a_law_states_all_its_premises(region: str) -> None:
    """A program adds up the gains of all rules: without d those of both corners of d."""
    law = inputs.read_law("paper")["gains"]
    with pytest.raises(CertificateError, match="'d' is missing"):
        published.PublishedLaw.read(_with(law, region, "d", None))


@pytest.mark.parametrize(
    ("wind", "read"),
    [("25.0000000000001", True), ("25.000000000000000000001", False)],
)
def test_winds_of_the_law_differ_as_floats(wind: str, read: bool) -> None:
    """At the tables' end a program would divide by the width of an empty interval."""
    document = json.loads(next(recorded("running-loop"))[1])
    law = document["gains"]
    for name in set(effort_sharing.MEMBERS) & {key for key in law if isinstance(law[key], list)}:
        law[name].append(law[name][-1])
    law["wind"][-1] = "mine"
    written = json.dumps(document).replace('"mine"', wind)
    one = read_text(written, "mine")
    if read:
        assert effort_sharing.Law.read(one["gains"]).wind[-1] > 25
        return
    with pytest.raises(CertificateError, match="must increase, also as floats"):
        effort_sharing.Law.read(one["gains"])

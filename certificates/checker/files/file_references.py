"""The section ``[reference]`` of a plant file against the references of a certificate.

The file states which state or output follows which signal.  In the certificate the signal is a
disturbance, the integral a state, and h(x) - r the equation of the integral.  Here they are written
in the form of the file, so that the comparison is the same as for all other entries.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from takagi.certificates.checker.files.model_content import OtherModel
from takagi.certificates.checker.plant.reading import PlantNodes


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names)) or "none"


@dataclass(frozen=True)
class FileReferences:
    """Reference -> its entry in the file, and its integral in the certificate."""

    entries: Mapping[str, Mapping[str, Any]]
    integral: Mapping[str, str]
    path: Path

    @classmethod
    def of(cls, file: Mapping[str, Any], model: Any, path: Path) -> FileReferences:
        """Return both.

        Raises
        ------
        OtherModel : they are not those of one another, or a section is malformed.
        """
        given = file.get("reference", {})
        listed = model.get("references", [])
        if not isinstance(given, dict) or not all(isinstance(e, dict) for e in given.values()):
            raise OtherModel(
                f"{path}: not the certificate's plant: [reference] is no section there"
            )
        ours = listed if isinstance(listed, list) else []
        named = {
            str(one.get("reference")): str(one.get("integral"))
            for one in ours
            if isinstance(one, dict)
        }
        if sorted(given) != sorted(named):
            raise OtherModel(
                f"{path}: not the certificate's plant: references are {_listed(given)} there, "
                f"{_listed(named)} in the certificate"
            )
        return cls(given, named, path)

    @property
    def integrals(self) -> dict[str, Any]:
        """The integral states, in the format of the file: rest 0, no range."""
        return {self.integral[name]: {} for name in self.entries}

    def signals(
        self, states: Mapping[str, Any], outputs: Mapping[str, Any], plant: PlantNodes
    ) -> dict[str, Any]:
        """The signals, in the format of the file; each rests at the value of what follows it.

        The rest is that of the certificate, which proves that the integral is constant there.
        """
        rests = {v.name: plant.graph.value(v.rest) for v in plant.disturbances}
        found: dict[str, Any] = {}
        for name, entry in self.entries.items():
            followed = entry.get("follow")
            own = outputs.get(followed, states.get(followed)) if isinstance(followed, str) else None
            if not isinstance(own, dict):
                raise OtherModel(
                    f"{self.path}: not the certificate's plant: reference.{name}.follow is no "
                    "state or output there"
                )
            unit = entry.get("unit", own.get("unit", "-"))
            found[name] = {"unit": unit, "range": entry.get("range"), "si rest": rests.get(name)}
        return found

    def equations(self, outputs: Mapping[str, Any]) -> dict[str, str]:
        """The equations of the integrals."""
        found = {}
        for name, entry in self.entries.items():
            followed = str(entry["follow"])
            output = outputs.get(followed)
            h = output.get("expression") if isinstance(output, dict) else followed
            found[self.integral[name]] = f"({h}) - {name}"
        return found

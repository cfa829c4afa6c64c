"""The JSON Schema of plant files: ``python -m takagi.models.plant.schema`` prints it."""

from __future__ import annotations

import json
import sys

from takagi.models.plant.entries import plant_file_schema

if __name__ == "__main__":
    sys.stdout.write(json.dumps(plant_file_schema(), indent=2) + "\n")

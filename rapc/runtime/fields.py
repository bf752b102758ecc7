"""Tables of fields: what of an object of a run's state is saved, and as what.

Each state class has a table `FIELDS` with the type of each field; its slots are made
from the table, so that a field that is not in it cannot be set. `rapc.runtime.saving`
walks these tables.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final

import msgspec

Fields = Mapping[str, Any]
"""The fields of a class with their types."""

LEFT_OUT: Final = "left out"
"""Instead of a type: the field follows from others and is not saved."""

Natural = Annotated[int, msgspec.Meta(ge=0)]
"""A whole number from 0."""

Limit = Annotated[float, "perhaps infinite"]
"""A time, or infinity."""

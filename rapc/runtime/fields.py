"""Tables of fields: the saved fields of the state classes, with their types.

Each state class has a table `FIELDS` with the type of each field. The slots of the
class are made from the table: a field outside the table cannot be set.
`rapc.runtime.saving` traverses these tables.
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

Stamp = Annotated[float, "perhaps never"]
"""A time, or negative infinity: older than any time."""

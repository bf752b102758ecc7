"""A linked library: every definition of a set of files under its name, immutable.

Linking collects names and reports those defined twice. What a reference means, and
whether it means anything, is for `rapc.analysis` to say; finding and reading the
files is for `rapc.loader`.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from rapc.ir import nodes
from rapc.source import SourceFile


class Library(msgspec.Struct, frozen=True):
    """All definitions by name, in the order of the text; nothing changes afterwards.

    `files` holds every file read, by the name that spans carry.
    """

    raps: Mapping[str, nodes.DefineRap]
    propositions: Mapping[str, nodes.DeclareProposition]
    properties: Mapping[str, nodes.DeclareProperty]
    functions: Mapping[str, nodes.DeclareFunction]
    primitives: Mapping[str, nodes.DeclarePrimitive]
    data: Mapping[str, nodes.DeclareDatum]
    skills: Mapping[str, nodes.DeclareSkill]
    events: Mapping[str, nodes.DeclareEvent]
    indistinct: Mapping[str, nodes.DeclareIndistinctClass]
    comparators: tuple[nodes.DeclareComparator, ...]
    memory_rules: tuple[nodes.MemoryRule, ...]
    event_rules: tuple[nodes.EventRule, ...]
    files: Mapping[str, SourceFile]

"""Planar machines: rigid bodies with revolute and prismatic joints in any topology, each joint ideal or open."""

from ..programs import shared_by
from .build import (
    build,
    crank_speed,
    discontinuity_times,
    ideal,
    ideal_form,
    ideal_reactions,
    mount_channels,
    with_segments,
)
from .closure import ClosureError, MachineStates, MobilityError, Rivals
from .drives import direction_of, motion_at, motion_table, passage_time
from .form import STATIONS, as_empty_tuples, first_rate, line_of, problem_of_links
from .ideal import ideal_of, machine_key, rival_assemblies, slot_travel
from .reactions import levers, levers_of_support
from .stations import without_forces

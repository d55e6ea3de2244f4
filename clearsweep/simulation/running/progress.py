"""Progress of a case: the phases of an integration and of a life."""

import time
from typing import NamedTuple

from ...language import phases
from ...language.wording import quantity_text
from ..setup.scene import Scene


class Revolutions(phases.Phase):
    """The phase of an integration: its share of finished revolutions."""

    def __init__(self, scene: Scene):
        """Prepare for the integration of a scene."""
        super().__init__(self._text)
        self.revolutions = scene.case.simulate.revolutions if scene.mechanism.turns else None
        self.at_most_text = " at most" if scene.layout.until or scene.case.life else ""  # it may end earlier

    @property
    def turns(self) -> float:
        """Return the number of finished revolutions."""
        return (self.share or 0.0) * (self.revolutions or 0.0)

    def _text(self) -> str:
        if not self.revolutions or self.share is None:
            return "integrating"
        return f"revolution {self.turns:,.6g} of {self.revolutions:,.6g}{self.at_most_text}"


class LifeLimits(NamedTuple):
    """Settings that determine the time of a life."""

    limit: float  # m
    first_jump: float  # m, most wear in the first jump
    blocks: int  # at most
    min_revolutions: float  # revolutions of a block
    constant_rates: bool  # one block is enough
    further_lives: int = 0  # lives after this one, which take about as long


class Life(phases.Phase):
    """The phase of a life: its block, the limited wear (m), and the time of the remaining blocks."""

    def __init__(self, limits: LifeLimits, earlier_blocks: int, name: str = ""):
        """Prepare after `earlier_blocks` blocks in another process; `name` is that of a further life."""
        super().__init__(self._text, covers_nested=True)
        self.limits, self.earlier_blocks, self.name = limits, earlier_blocks, name
        self.block, self.worn, self.jump = 1, 0.0, limits.first_jump
        self.block_begin = self.begin  # s, start of the current block

    def _text(self) -> str:
        life = f"{self.name}, " if self.name else ""
        return f"{life}block {self.block}, {quantity_text(self.worn, 'm')} of {quantity_text(self.limits.limit, 'm')}"

    def reached(self, worn: float) -> None:
        """Record the end of a block, with the wear depth (m) that the limit refers to."""
        self.block, self.jump = self.block + 1, max(worn - self.worn, 0.0) or self.jump
        self.worn, self.block_begin, self.compile_time = worn, time.monotonic(), 0.0
        self.note(block=self.block, reached=worn, limit=self.limits.limit)

    def remaining_time(self, now: float) -> float | None:
        """Return the time (s) left, for jumps like the last one up to the limit."""
        block_time = self._block_seconds(now)
        if block_time is None:
            return None
        jumps = 0.0 if self.limits.constant_rates else max(self.limits.limit - self.worn, 0.0) / self.jump
        blocks = 1.0 + min(jumps, float(max(self.limits.blocks - self.block, 0)))
        remaining = max(block_time * blocks - (now - self.block_begin - self.compile_time), 0.0)
        return remaining + self.limits.further_lives * block_time * (self.block - 1 + blocks) or None

    def _block_seconds(self, now: float) -> float | None:
        """Return the time (s) of a block: the mean of finished blocks, or else the time of the shortest block."""
        finished_blocks = self.block - 1 - self.earlier_blocks
        if finished_blocks > 0:
            return (self.block_begin - self.begin) / finished_blocks
        integration_phase = phases.innermost_phase()
        if not isinstance(integration_phase, Revolutions) or not integration_phase.turns:
            return None
        return (now - integration_phase.begin - integration_phase.compile_time) * max(
            self.limits.min_revolutions / integration_phase.turns, 1.0
        )

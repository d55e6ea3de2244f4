"""Extrapolation of wear in jumps of many revolutions, from the rates of short blocks, up to a limit.

The worn state is a vector x. A block gives its rates r(x) per revolution, and dx/dn = r(x) is integrated by a predictor
and a corrector. The next block is run at the predicted x* = x + M r(x) and gives r(x*). Between the two, rates are
taken as linear in the limited quantity. The trapezoidal rule then gives x + M (r(x) + r') / 2, with r' = r + alpha
(r* - r) and alpha = 1 / (1 - (q* - q) / 2 q). Here q is the rate of the limited quantity; alpha is 1 if only the
sliding distance acts. The next jump starts with r', so each jump costs one block.

The length M follows from the share of a jump's wear that the rates before and after it distribute differently,
sum |r* - r| / sum (r* + r). Beyond the tolerance the jump is repeated at half the length, and the next is no longer. So
it is if the corrector moves a bin, against the others, by more than a quarter of the tolerance times the depth at the
end of the life: at an edge of a scar that widens, the trapezoidal rule errs by as much. The share grows with M, the
move with its square. Differences that the 95 % intervals of the rates explain do not count. (Jumps of adaptive length:
Mukras, Kim, Sawyer, Jackson & Bergquist 2009, Wear 266:822; predictor and corrector: Heun's method, of order two.)
"""

import itertools
import math
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...tracing import portable

SAFETY = 0.9  # safety factor on the jump whose error would equal the tolerance
MAX_JUMP_RATIO, MIN_JUMP_RATIO = 2.0, 0.5  # largest and smallest ratio of successive jumps
MIN_RELATIVE_GROWTH = 0.1  # of the mean rate of the limited quantity: slower rates are compared with this
OVERSHOOT = 1.1  # of the distance to the limit: the last jump must pass it
MAX_RATE_CORRECTION = 0.5  # largest correction of half the relative change of a rate
PROFILE_FACTOR = 4.0  # on the share of the depth at the end by which the corrector moves a bin, before it is compared
MAX_LIFE_FACTOR = 2.0**60  # times the first guess of the life: beyond it, the limit counts as never reached


class Block(Protocol):
    """Wear rates from a block of revolutions."""

    rate: np.ndarray  # (n,) per revolution
    width: np.ndarray  # (n,) half-width of their 95 % interval, inf where unknown
    turns: float  # revolutions over which the rates are averaged


class LimitedQuantity(Protocol):
    """The limited quantity as a function of the worn state."""

    def value(self, state: np.ndarray, /) -> float:
        """Return the quantity."""

    def slope(self, state: np.ndarray, /) -> np.ndarray:
        """Return the derivatives (n,) of the quantity with respect to the worn state."""

    def shape_error(self, state: np.ndarray, /) -> float:
        """Return the error of the quantity by smoothing and bins, in the quantity's unit."""

    def is_valid(self, state: np.ndarray, /) -> bool:
        """Return whether the model of contact is valid in the worn state."""


class StepControl(NamedTuple):
    """Limit and step control of an extrapolation."""

    limit: float
    tolerance: float
    blocks: int  # at most
    min_jump: float  # revolutions, shortest jump: one block
    max_jump: float
    max_first_growth: np.ndarray  # (n,) largest growth of each element in the first jump; inf: no bound
    groups: tuple[slice, ...]  # groups of elements whose distribution of wear is compared separately
    constant_rates: bool  # no rate depends on wear
    identical_blocks: bool  # all blocks have the same motion, so the errors of their rates are equal
    drifting_rates: bool = False  # rates drift during a block, so they apply to its middle


class Node(NamedTuple):
    """Worn state after a number of revolutions, and the rates there."""

    revolutions: float
    state: np.ndarray
    rate: np.ndarray  # (n,) per revolution
    block: Any  # the Block that gave the rates


class Life(NamedTuple):
    """History of a life, and the revolutions to its limit."""

    nodes: tuple[Node, ...]  # from 0 to the limit, or to the last block
    reached: bool
    low: float  # revolutions, lower end of the 95 % interval; inf: the limit is never reached
    high: float  # inf: unbounded
    jump_error: float  # relative change of the life without every other block; nan: limit not reached
    shape_error: float  # relative error of the life by smoothing and bins; nan as above
    blocks: int  # number of blocks run

    @property
    def revolutions(self) -> float:
        """Return the revolutions to the limit, or to the last node if it was not reached."""
        return self.nodes[-1].revolutions

    @property
    def unlimited(self) -> bool:
        """Return whether nothing wears towards the limit."""
        return math.isinf(self.low)

    @property
    def known_revolutions(self) -> float:
        """Return the revolutions to the limit; inf: it is never reached, nan: it was not reached."""
        return self.revolutions if self.reached else math.inf if self.unlimited else math.nan


def extrapolate_life(
    run_block: Callable[[np.ndarray], Any], criterion: LimitedQuantity, settings: StepControl, start: np.ndarray
) -> Life | None:
    """Return the life from the worn state `start`, (n,), to its limit, or None if a block failed.

    run_block : worn state -> Block run in this state, or None if it failed
    """
    first_block = run_block(start)
    if first_block is None:
        return None
    nodes, blocks = [Node(0.0, start, first_block.rate, first_block)], 1
    grows = first_block.rate > 0.0
    jump = float(np.min(settings.max_first_growth[grows] / first_block.rate[grows], initial=math.inf))
    is_repeated = False
    while settings.constant_rates or blocks < settings.blocks:
        node = nodes[-1]
        largest_rate = max(float(node.rate[group].max(initial=0.0)) for group in settings.groups)
        if largest_rate == 0.0:
            return _unreached(nodes, blocks, math.inf)
        remaining = revolutions_to(settings.limit, criterion, node, largest_rate)
        if settings.constant_rates:
            if math.isinf(remaining):
                return _unreached(nodes, blocks, math.inf)
            nodes.append(Node(remaining, node.state + remaining * node.rate, node.rate, first_block))
            return _interval(nodes, blocks, criterion, settings)
        jump = max(min(jump, settings.max_jump, OVERSHOOT * remaining), settings.min_jump)
        predicted = node.state + jump * node.rate
        next_block = run_block(predicted)
        blocks += 1
        if next_block is None:
            return None
        redistributed = redistributed_fraction(node, next_block, settings.groups)
        moved = PROFILE_FACTOR * moved_fraction(node, next_block, settings.groups, jump, remaining)
        if max(redistributed, moved) > settings.tolerance and jump > settings.min_jump:
            jump, is_repeated = MIN_JUMP_RATIO * jump, True
            continue
        # the motion is unchanged: only the sliding distance acts, and its prediction is exact
        rate = (
            next_block.rate
            if settings.identical_blocks
            else _corrected(node.rate, next_block.rate, criterion.slope(predicted))
        )
        next_node = Node(node.revolutions + jump, node.state + 0.5 * jump * (node.rate + rate), rate, next_block)
        is_last = criterion.value(next_node.state) >= settings.limit
        if is_last:
            next_node = _node_at_limit(settings.limit, criterion, node, next_node)
        if not criterion.is_valid(next_node.state):
            break
        nodes.append(next_node)
        if is_last:
            return _interval(nodes, blocks, criterion, settings, jump)
        allowed = SAFETY * settings.tolerance  # the share grows with the jump, the move with its square
        longest = min(
            1.0 if is_repeated else MAX_JUMP_RATIO,  # the length after a repeated jump has just been too long
            allowed / redistributed if redistributed else math.inf,
            math.sqrt(allowed / moved) if moved else math.inf,
        )
        jump, is_repeated = jump * longest, False
    return _unreached(nodes, blocks, nodes[-1].revolutions)


def _unreached(nodes: list[Node], blocks: int, low: float) -> Life:
    """Return a life that did not reach its limit; low : revolutions that it lasts at least."""
    return Life(
        tuple(nodes), reached=False, low=low, high=math.inf, jump_error=math.nan, shape_error=math.nan, blocks=blocks
    )


def _corrected(old_rate: np.ndarray, new_rate: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Return the rates at the corrected end of a jump, from those before and after the predicted jump.

    slope : (n,) derivatives of the limited quantity
    """
    rate_before, rate_after = float(portable.product(slope, old_rate)), float(portable.product(slope, new_rate))
    half_change = (
        min(max(0.5 * (rate_after - rate_before) / rate_before, -MAX_RATE_CORRECTION), MAX_RATE_CORRECTION)
        if rate_before > 0.0
        else 0.0
    )
    rate: np.ndarray = np.maximum(old_rate + (new_rate - old_rate) / (1.0 - half_change), 0.0)
    return rate


def _node_between(start: Node, end: Node, turns: float) -> Node:
    """Return the worn state `turns` revolutions into a jump, in which the rates change linearly."""
    fraction = turns / (end.revolutions - start.revolutions)
    rate = start.rate + fraction * (end.rate - start.rate)
    return Node(start.revolutions + turns, start.state + 0.5 * turns * (start.rate + rate), rate, end.block)


def _node_at_limit(limit: float, criterion: LimitedQuantity, start: Node, end: Node) -> Node:
    """Return the node at which the limit is reached, between two nodes."""
    jump = end.revolutions - start.revolutions
    return _node_between(
        start, end, _root(lambda turns: criterion.value(_node_between(start, end, turns).state) - limit, jump)
    )


def redistributed_fraction(node: Node, next_block: Block, groups: tuple[slice, ...]) -> float:
    """Return the share of the wear that two rates distribute differently, in the worst group."""
    shifted = _unexplained(next_block.rate - node.rate, node.block, next_block)
    fractions = [0.0]
    for group in groups:
        total = float((node.rate + next_block.rate)[group].sum())
        fractions.append(float(shifted[group].sum()) / total if total else 0.0)
    return max(fractions)


def moved_fraction(node: Node, next_block: Block, groups: tuple[slice, ...], jump: float, remaining: float) -> float:
    """Return by which share of the depth at the end the corrector moves a bin against the others, in the worst group.

    jump, remaining : revolutions to the next block, and to the end at the present rates
    """
    fractions = [0.0]
    for group in groups:
        rate, next_rate = node.rate[group], next_block.rate[group]
        last_depth = float((node.state[group] + remaining * rate).max(initial=0.0))
        if last_depth and next_rate.any():
            moved = next_rate * (rate.sum() / next_rate.sum()) - rate
            fractions.append(0.5 * jump * float(_unexplained(moved, node.block, next_block, group).max()) / last_depth)
    return max(fractions)


def _unexplained(difference: np.ndarray, block: Block, next_block: Block, group: slice = slice(None)) -> np.ndarray:
    """Return by how much a difference of the rates of two blocks exceeds that which their intervals explain."""
    widths = (np.where(np.isfinite(each.width[group]), each.width[group], 0.0) for each in (block, next_block))
    excess: np.ndarray = np.maximum(np.abs(difference) - np.hypot(*widths), 0.0)
    return excess


def revolutions_to(limit: float, criterion: LimitedQuantity, node: Node, largest_rate: float) -> float:
    """Return the revolutions to the limit at constant rates (largest: `largest_rate`), or inf if never."""

    def value(turns: float) -> float:
        return criterion.value(node.state + turns * node.rate)

    estimate = upper = (limit - value(0.0)) / largest_rate
    while value(upper) < limit:
        upper *= 2.0
        if upper > MAX_LIFE_FACTOR * estimate:
            return math.inf
    return _root(lambda turns: value(turns) - limit, upper)


def _root(function: Callable[[float], float], upper: float) -> float:
    """Return the zero of a function that is negative at 0 but not at `upper`."""
    from scipy.optimize import brentq

    return float(brentq(function, 0.0, upper, xtol=1e-14 * upper, rtol=1e-14))


def _interval(
    nodes: list[Node], blocks: int, criterion: LimitedQuantity, settings: StepControl, jump: float | None = None
) -> Life:
    """Return a life that reached its limit, in a `jump` that was extended, with its interval.

    With q the rate of the limited quantity, the life is the integral of dq / q.  A relative error of a rate is
    the same relative error of the revolutions to which it applies.  Relative errors within the intervals of rates are
    independent from block to block unless the blocks are alike.  The error of the jumps is the change without every
    other block; with one jump, it is the change by the rate after it.  The error of the shape is added, and the bias
    of rates that drift during a block.
    """
    total = nodes[-1].revolutions
    slopes = [criterion.slope(node.state) for node in (*nodes[1:], nodes[-1])]  # growth in each jump
    floor = MIN_RELATIVE_GROWTH * settings.limit / total
    growths = (float(portable.product(slope, node.rate)) for slope, node in zip(slopes, nodes, strict=True))
    growth_rates = [max(growth, floor) for growth in growths]
    weights: dict[int, float] = {}  # per block: revolutions to which its rate applies, times its relative error
    for index, turns in enumerate(_revolutions_by_block(nodes, jump)):
        block = nodes[index].block
        weights[id(block)] = (
            weights.get(id(block), 0.0) + turns * _rate_half_width(slopes[index], block) / growth_rates[index]
        )
    spread = (math.fsum(weights.values()) if settings.identical_blocks else math.hypot(*weights.values())) / total
    error = abs(_change_without_every_other(nodes, slopes, growth_rates)) / total
    half_width = math.hypot(spread, error)
    low, high = total / (1.0 + half_width), total / (1.0 - half_width) if half_width < 1.0 else math.inf
    bias = shape_error = criterion.shape_error(nodes[-1].state) / growth_rates[-1]
    if settings.drifting_rates:
        # Error (revolutions) of a life because mid-block rates are used at the start of a block
        changes = [
            0.5 * max(node.block.turns, next_node.block.turns) * abs(next_rate - rate)
            for (node, next_node), (rate, next_rate) in zip(
                itertools.pairwise(nodes), itertools.pairwise(growth_rates), strict=True
            )
        ]
        bias += math.fsum(changes) / growth_rates[-1]
    return Life(
        tuple(nodes),
        reached=True,
        low=max(low - bias, 0.0),
        high=high + bias,
        jump_error=error,
        shape_error=shape_error / total,
        blocks=blocks,
    )


def _revolutions_by_block(nodes: list[Node], jump: float | None) -> list[float]:
    """Return the revolutions to which each node's block applies; the last jump may have been longer."""
    turns_by_block = [0.0] * len(nodes)
    for index in range(len(nodes) - 1):
        turns = nodes[index + 1].revolutions - nodes[index].revolutions
        half_square = 0.5 * turns * turns / (jump if jump and index == len(nodes) - 2 else turns)
        turns_by_block[index] += turns - half_square
        turns_by_block[index + 1] += half_square
    return turns_by_block


def _rate_half_width(slope: np.ndarray, block: Block) -> float:
    """Return the half-width of the 95 % interval of the limited quantity's rate; bin errors are fully correlated."""
    contributes = slope != 0.0
    return float(portable.product(np.abs(slope[contributes]), block.width[contributes]))


def _change_without_every_other(nodes: list[Node], slopes: list[np.ndarray], growth_rates: list[float]) -> float:
    """Return the change (revolutions) of a life without every other node; for one jump, with the rate after it.

    slopes, growth_rates : derivatives of the limited quantity at the end of each jump, and its rate at each node
    """
    last_index = len(nodes) - 1
    remaining_nodes = sorted({0, *range(last_index, -1, -2)})
    total = 0.0
    for start, end in itertools.pairwise(remaining_nodes):
        node, next_node = nodes[start], nodes[end]
        rates = node.rate + (next_node.rate if last_index > 1 else node.rate)
        change = 0.5 * (next_node.revolutions - node.revolutions) * rates - (next_node.state - node.state)
        total += float(portable.product(slopes[end - 1], change)) / growth_rates[end]
    return total

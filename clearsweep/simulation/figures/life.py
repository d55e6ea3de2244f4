"""Figures of merit of a life; `life` computes them under these names."""

from ...contracts.catalogue import Entry, Figure

LIFE = (
    Figure(
        "life_revolutions",
        "1",
        "revolutions until `life.limit` is reached; null: not reached",
        of="joint",
        needs=("limited",),
        differs=False,
        tables=(
            Entry("wear", "life (rev.)", 1),
            Entry("sample", "life (rev.)", 7),
            Entry("effects", "life", 3),
        ),
    ),
    Figure(
        "life_hours",
        "h",
        "hours until `life.limit` is reached; null: not reached",
        of="joint",
        needs=("limited",),
        differs=False,
        tables=(Entry("wear", "life (hours)", 2),),
    ),
    Figure(
        "life_low",
        "1",
        "lower end of the 95 % interval of the life (numerics only), revolutions; without reaching the limit: the "
        "revolutions run",
        of="joint",
        needs=("limited",),
        differs=False,
        tables=(Entry("wear", "life, low (rev.)", 3),),
    ),
    Figure(
        "life_high",
        "1",
        "upper end of the same interval, revolutions; null: unbounded or unknown",
        of="joint",
        needs=("limited",),
        differs=False,
        tables=(Entry("wear", "life, high (rev.)", 4),),
    ),
    Figure(
        "life_low_uncertain",
        "1",
        "revolutions of the life with the uncertain wear coefficients at the upper ends of their 95 % intervals; null: "
        "that life did not reach the limit or failed (see `message`)",
        of="joint",
        needs=("limited", "uncertain"),
        differs=False,
        tables=(Entry("wear", "life, low, uncertain (rev.)", 4),),
    ),
    Figure(
        "life_high_uncertain",
        "1",
        "life with the uncertain wear coefficients at the lower ends of their 95 % intervals; null as above",
        of="joint",
        needs=("limited", "uncertain"),
        differs=False,
        tables=(Entry("wear", "life, high, uncertain (rev.)", 4),),
    ),
    Figure(
        "life_jump_error",
        "1",
        "relative change of the life with jumps twice as long (every other block); null: not reached",
        of="joint",
        needs=("limited",),
        differs=False,
        tables=(Entry("wear", "error of jumps", 72),),
    ),
    Figure(
        "life_blocks",
        "1",
        "blocks of revolutions of the life",
        of="joint",
        needs=("limited",),
        kind="int",
        differs=False,
        tables=(Entry("wear", "blocks", 73),),
    ),
    Figure(
        "life_shape_error",
        "1",
        "relative change of the life by smoothing the worn shapes and by bins twice as wide; 0 without `evolve`; null: "
        "not reached",
        of="joint",
        needs=("limited",),
        differs=False,
        tables=(Entry("wear", "error of shapes", 74, if_any=True),),
    ),
    Figure(
        "clearance_growth",
        "m",
        "largest increase, over directions, of the eccentricity at which the surfaces touch first, at the life's end",
        of="joint",
        needs=("wear", "life"),
        differs=False,
        tables=(Entry("wear", "clearance growth", 5),),
    ),
)

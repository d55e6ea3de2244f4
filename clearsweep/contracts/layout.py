"""Columns and time histories of the cases of a grid, with names, units and descriptions."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from .case import Case, column_name
from .catalogue import Catalogue, Channel, Figure, Mechanism, Outline, torsional_unit
from .vibration import FRAME, PlaceOutline, VibrationOutline

PRELOAD = "preload"  # the form of load that presses on a joint with clearance
FRICTION_POWER = "friction_power"  # the figure that a joint without clearance may also have
ORDER = "_order"  # in the name of a figure that each order of the crank speed has; its number follows
DIFFERENCE = "_difference"  # suffix of the column of an error check
CORNERS = 4  # of a guide's block
FLANKS = ("drive", "coast")  # of a gear or a coupling, in the order of their contacts
STOPS = ("upper", "lower")  # likewise of the stops of a pin or a guide
TORSIONAL = "torsional"  # feature of joints whose forces are torques and whose penetrations are angles
FEATURES_OF_FLANKED = {
    "gear": frozenset({"flanked"}),
    "coupling": frozenset({"flanked", TORSIONAL}),
    "stops": frozenset({TORSIONAL}),
    "guide_stops": frozenset[str](),
}
MAX_REVOLUTIONS = 1 << 17  # number of last revolutions whose peaks and sections are kept
SECTION_COUNT = "poincare/revolution"  # turns of the crank between sections
_SECTIONED = ("x", "y", "vx", "vy")  # channels of a joint stored at crank angle 0
WALLS, FLANGES = 2, 2  # contacts of a spatial joint, in this order
AUXILIARY_OF_GUIDE, AUXILIARY_OF_SPATIAL, AUXILIARY_OF_ROLLING = 1, 2, 2  # which only report; first: the resultant
#: Kind of a joint, as in JointSite -> its numbers of separate contacts and of auxiliary ones.
CONTACTS_OF_KIND = {
    **dict.fromkeys(("revolute", "slot", "line"), (0, 0)),
    **dict.fromkeys(FEATURES_OF_FLANKED, (len(FLANKS), 0)),
    "guide": (CORNERS, AUXILIARY_OF_GUIDE),
    "spatial": (WALLS + FLANGES, AUXILIARY_OF_SPATIAL),
    "through": (WALLS, AUXILIARY_OF_SPATIAL),
    "rolling": (0, AUXILIARY_OF_ROLLING),  # and its elements
}
TIME = "t"  # the abscissa of all other channels
ALWAYS_STORED = (TIME, "crank_angle")  # channels that are stored whatever `save.channels` lists


class Column(NamedTuple):
    """A figure of merit of one case (a column of the summary) or a time history (a channel of the orbits)."""

    name: str
    unit: str  # SI
    description: str
    kind: str = "float"  # 'float', 'int' or 'text'
    figure: str = ""  # name of its catalogue.Figure, or ''
    joint: str = ""  # column name of the figure's joint, or ''
    null: str = ""  # what a missing value of a finished case means: NOTHING, ENDLESS; '': unknown


class JointLayout(NamedTuple):
    """Properties of a clearance joint that determine its columns and channels."""

    name: str  # 'rod_slider': the name of the joint in columns and channels
    wear_bins: int = 0  # angular bins of each body; 0 where no wear is computed
    film: bool = False  # it has an oil film
    corners: int = 0  # contacts of a guide, a spatial joint or a rolling bearing; 0: a single contact
    auxiliary: int = 0  # auxiliary contacts after these
    wear_rows: int = 1  # wear bins along each body's length
    friction: bool = False  # it has friction
    strength: bool = False  # yield strength of its weaker body is known
    thermal: bool = False  # a heat balance of dry friction gives its temperature
    is_rolling: bool = False  # it is a rolling bearing
    dynamic: bool = False  # the dynamic load rating of its rolling bearing is known
    static: bool = False  # the static one is known
    flanked: str = ""  # one of FEATURES_OF_FLANKED: it touches on two sides

    @property
    def features(self) -> set[str]:
        """Return the features of the joint that figures require."""
        has_flanges = self.is_spatial and self.corners > WALLS
        present = {"wear": self.wear_bins, "film": self.film, "friction": self.friction, "guide": self.is_guide}
        present |= {
            "arc": self.wear_bins and not self.flanked,
            "spatial": self.is_spatial,
            "axial": has_flanges,
            "rolling": self.is_rolling,
        }
        present |= {"strength": self.strength, "thermal": self.thermal, "dynamic": self.dynamic, "static": self.static}
        names = {name for name, features in present.items() if features}
        return names | FEATURES_OF_FLANKED.get(self.flanked, frozenset())

    @property
    def is_guide(self) -> bool:
        """Return whether the joint is a block between walls."""
        return self.auxiliary == AUXILIARY_OF_GUIDE

    @property
    def is_spatial(self) -> bool:
        """Return whether the journal may tilt and shift along its axis."""
        return self.auxiliary == AUXILIARY_OF_SPATIAL and not self.is_rolling

    @property
    def contacts(self) -> tuple[str, ...]:
        """Return the names of its contacts in the list of events."""
        if self.flanked:
            return tuple(f"{self.name}_{side}" for side in (STOPS if "stops" in self.flanked else FLANKS))
        return tuple(f"{self.name}_{k + 1}" for k in range(self.corners + self.auxiliary)) or (self.name,)


class CaseFeatures(NamedTuple):
    """The properties of a case that determine its layout."""

    mechanism: str
    outline: Outline
    joints: tuple[JointLayout, ...]
    horizon: bool
    error_check: bool
    until: str  # simulate.until.figure
    life: str = ""  # column name of the joint in `life`
    uncertain: bool = False  # wear coefficients are uncertain
    preloads: tuple[str, ...] = ()  # clearance joints with a preload
    listed: tuple[str, ...] = ()  # save.channels


def features_of(case: Case) -> CaseFeatures:
    """Return the properties of a case that determine its layout."""
    simulate = case.simulate
    joints = tuple(
        JointLayout(
            joint.column,
            joint.wear.bins if joint.wear else 0,
            joint.film is not None,
            joint.rolling.elements if joint.rolling else CONTACTS_OF_KIND[joint.kind][0],
            CONTACTS_OF_KIND[joint.kind][1],
            joint.wear.length_bins if joint.wear else 1,
            joint.friction is not None,
            joint.strength is not None and joint.is_dry and not joint.is_guide and not joint.is_spatial,
            joint.thermal is not None,
            joint.rolling is not None,
            bool(joint.rolling and joint.rolling.capacity.dynamic),
            bool(joint.rolling and joint.rolling.capacity.static),
            joint.flanked,
        )
        for joint in case.joints
    )
    until = simulate.until.figure if simulate.until else ""
    life = case.life.column if case.life else ""
    return CaseFeatures(
        case.mechanism.type,
        case.outline,
        joints,
        simulate.horizon,
        simulate.error_check,
        until,
        life,
        bool(case.uncertain),
        tuple(column_name(load.values["on"]) for load in case.loads if load.form == PRELOAD),
        case.save.channels,
    )


class Layout(NamedTuple):
    """Joints, columns and channels of a scene; every case of a grid shares it."""

    mechanism: str
    turns: bool  # has a drive, and so revolutions
    output: str  # the output body, or ''
    joints: tuple[JointLayout, ...]  # clearance joints, in the order of the grid's keys
    columns: tuple[Column, ...]  # the figures of merit, in the order of the summary
    channels: tuple[Column, ...]  # the time histories, `t` first
    horizon: bool = False  # simulate.horizon
    error_check: bool = False  # simulate.error_check
    until: str = ""  # simulate.until.figure
    life: str = ""  # the joint in `life`
    frictions: tuple[str, ...] = ()  # the joint of each friction load, in the order of the loads
    listed: tuple[str, ...] = ()  # save.channels; (): all channels are stored

    @classmethod
    def of(cls, case: Case, catalogue: Catalogue) -> "Layout":
        """Return the layout of a case, which all cases of its grid share."""
        return cls.with_features(features_of(case), catalogue)

    def comparable(self, names: Iterable[str]) -> list[str]:
        """Return those of these columns that share a unit: forces before torques, lengths before angles."""
        units = {column.name: column.unit for column in self.columns}
        known = [name for name in names if name in units]
        return [name for name in known if units[name] == min(units[each] for each in known)]

    @classmethod
    def with_features(cls, features: "CaseFeatures", catalogue: Catalogue) -> "Layout":
        """Return the layout of cases with these properties."""
        mechanism = catalogue.with_outline(features.mechanism, features.outline)
        assert mechanism is not None, features.mechanism  # a case always has a known mechanism
        requested = {name for name in REQUESTED_COLUMNS if getattr(features, name)}
        frictions = (*rubbing_joints(features.outline), *features.preloads)
        joint_features = {joint.name: joint.features for joint in features.joints}
        if features.life in joint_features:
            joint_features[features.life] |= {"limited"}
        return cls(
            mechanism.name,
            mechanism.turns,
            mechanism.output.name if mechanism.output else "",
            features.joints,
            columns_of(catalogue, mechanism, joint_features, features.outline, requested, features.until),
            _channels(catalogue, mechanism, features),
            frictions=frictions,
            **{name: getattr(features, name) for name in ("horizon", "error_check", "until", "life", "listed")},
        )

    @property
    def rubbing(self) -> tuple[str, ...]:
        """Return the joints without clearance that have friction."""
        with_clearance = {joint.name for joint in self.joints}
        return tuple(name for name in dict.fromkeys(self.frictions) if name not in with_clearance)

    @property
    def stored(self) -> tuple[Column, ...]:
        """Return the channels that are stored of every case, `t` first."""
        stored_names = {*ALWAYS_STORED, *self.listed}
        return tuple(channel for channel in self.channels if not self.listed or channel.name in stored_names)

    @property
    def sections(self) -> tuple[tuple[str, str], ...]:
        """Return the values stored at crank angle 0 of every revolution: names of channels and datasets, or ().

        The first is 'joints/rod_slider/x', the second 'poincare/rod_slider/x'.
        """
        section_names = {f"joints/{joint.name}/{name}" for joint in self.joints for name in _SECTIONED if self.turns}
        names = [channel.name for channel in self.channels if channel.name in section_names]
        return tuple((name, name.replace("joints", "poincare", 1)) for name in names)

    @property
    def contacts(self) -> tuple[str, ...]:
        """Return the names of all contacts in the list of events."""
        return tuple(name for joint in self.joints for name in joint.contacts)

    @property
    def units(self) -> dict[str, str]:
        """Return name -> SI unit of every column and channel."""
        return {column.name: column.unit for column in (*self.columns, *self.channels)}

    def written(self) -> dict[str, Any]:
        """Return the layout as run.json contains it."""
        entries = {name: [entry._asdict() for entry in getattr(self, name)] for name in _LISTED}
        return self._asdict() | entries

    @classmethod
    def read(cls, written: Mapping[str, Any]) -> "Layout":
        """Return the layout from the result of `written`."""
        entries: dict[str, Any] = {
            name: tuple(kind(**entry) for entry in written[name]) for name, kind in _LISTED.items()
        }
        entries |= {name: tuple(written.get(name, ())) for name in ("frictions", "listed")}
        return cls(**(dict(written) | entries))


_LISTED = {"joints": JointLayout, "columns": Column, "channels": Column}


OF_PLACES = {"moves", "zones", "across", "rolling"}  # what figures of a place require
#: Optional computations of a case that figures require.
REQUESTED_COLUMNS = ("horizon", "error_check", "until", "life", "uncertain")


def columns_of(
    catalogue: Catalogue,
    mechanism: Mechanism,
    features_by_joint: Mapping[str, set],
    outline: Outline,
    requested: Collection[str] = (),
    until: str = "",
) -> tuple[Column, ...]:
    """Return the figures of merit of a case, in the order of the summary's columns.

    features_by_joint : clearance joint ('rod_slider') -> its features ('wear', 'film').  Joints without clearance among
    those of friction loads have a friction power.  requested : those of REQUESTED_COLUMNS; until : the figure in
    `simulate.until`
    """
    features = {*requested, "turns" if mechanism.turns else "rests", *(("free",) if mechanism.free else ())}
    asked = {"vibration": outline.vibration, "bends": outline.bending, "mounted": outline.mounts}
    features |= {name for name, section in asked.items() if section}
    columns: list[Column] = []
    for joint, joint_features in features_by_joint.items():
        joint_figures = (figure for figure in catalogue.figures if figure.of == "joint")
        joint_columns = [
            _column(figure, joint, mechanism)
            for figure in joint_figures
            if features | joint_features >= {*figure.needs}
        ]
        if TORSIONAL in joint_features:
            joint_columns = [column._replace(unit=torsional_unit(column.unit)) for column in joint_columns]
        columns += joint_columns
    rubbing = [joint for joint in dict.fromkeys(rubbing_joints(outline)) if joint not in features_by_joint]
    powers = [figure for figure in catalogue.figures if figure.name == FRICTION_POWER]
    columns += [_column(figure, joint, mechanism) for joint in rubbing for figure in powers]
    for figure in catalogue.figures:
        if figure.of in ("link", "mount"):
            links = [link.name for link in outline.bending if link.features >= {*figure.needs}]
            owners = links if figure.of == "link" else outline.mounts
            columns += [_column(figure, "", mechanism, {figure.of: owner}) for owner in owners]
            continue
        if figure.of == "joint" or not features >= {*figure.needs} - OF_PLACES:
            continue
        if figure.of == "output" and not mechanism.output:
            continue
        if figure.of in ("place", "order"):
            bearings = [joint for joint, has in features_by_joint.items() if "rolling" in has]
            columns += _vibration_columns(figure, mechanism, outline.vibration or VibrationOutline(), bearings)
            continue
        until_unit = {column.name: column.unit for column in columns}.get(until, "1")
        columns.append(_column(figure, "", mechanism, {"until": until, "until_unit": until_unit}))
    columns += [Column(figure.name, figure.unit, figure.text) for figure in outline.figures]
    if "error_check" not in requested:
        return tuple(columns)
    differing = {figure.name for figure in catalogue.figures if figure.differs}
    return tuple(
        new_column
        for column in columns
        for new_column in ((column, _difference_column(column)) if column.figure in differing else (column,))
    )


def _vibration_columns(
    figure: Figure, mechanism: Mechanism, vibration: VibrationOutline, bearings: list[str]
) -> list[Column]:
    """Return the columns of a figure that each place, with each rolling bearing, or each order of the force has."""
    numbers = [str(k) for k in range(1, vibration.orders + 1)] if ORDER in figure.name else [""]
    features = {
        place.column: {
            "moves": place.moves,
            "zones": vibration.has_zones,
            "across": not is_along_output(mechanism, place),
        }
        for place in vibration.places
    }
    places = [name for name, known in features.items() if all(known.get(need, True) for need in figure.needs)]
    owners = [(place, place) for place in places] if figure.of == "place" else [("", "")]
    if "rolling" in figure.needs:
        owners = [(place, f"{place}_{bearing}") for place in places for bearing in bearings]
    return [
        _column(figure, owner, mechanism, {"order": number, "place": place})
        for place, owner in owners
        for number in numbers
    ]


def is_along_output(mechanism: Mechanism, place: PlaceOutline) -> bool:
    """Return whether a place is the output of a mechanism, as is a slider, which is observed along its slide only."""
    output = mechanism.output
    is_output = output is not None and output.unit == "m" and (place.body or place.name) == output.name
    return is_output and place.is_whole


def rubbing_joints(outline: Outline) -> tuple[str, ...]:
    """Return the column name of the joint of each friction load."""
    return tuple(column_name(load.on) for load in outline.loads if load.form == "friction")


def _column(figure: Figure, joint: str, mechanism: Mechanism, words: Mapping[str, str] | None = None) -> Column:
    """Return the column of a figure; words : `until` and the unit of that figure, `order`, `place`, `link`, `mount`."""
    blank = dict.fromkeys(("until", "until_unit", "order", "place", "link", "mount"), "")
    output, words = mechanism.output, blank | {**(words or {})}
    owner = column_name(words["link"] or words["mount"]) or joint
    name = figure.column(output.name if output and figure.of == "output" else owner)
    name = name.replace(ORDER, f"{ORDER}_{words['order']}") if words["order"] else name
    text = figure.text.format(output=output.name if output else "", **words)
    unit = figure.unit.format(output=output.unit if output else "", until=words["until_unit"])
    return Column(name, unit, text, figure.kind, figure.name, "" if words["place"] else joint, figure.null)


def _difference_column(column: Column) -> Column:
    """Return the column of a figure's error check."""
    text = (
        f"absolute difference of {column.name} from a run at a tenth of the tolerance. Beyond the horizon of chaotic "
        "motion it compares two samples and does not check convergence"
    )
    return Column(f"{column.name}{DIFFERENCE}", column.unit, text)


def _channels(catalogue: Catalogue, mechanism: Mechanism, features: CaseFeatures) -> tuple[Column, ...]:
    """Return the time histories of a case in the order of its compiled form."""
    joint_channels = (
        channel._replace(name=f"joints/{joint.name}/{channel.name}")
        for joint in features.joints
        for channel in _joint_channels(catalogue, joint)
    )
    all_channels = (*mechanism.channels, *joint_channels, *_vibration_channels(catalogue, features.outline.vibration))
    return (Column(TIME, "s", "time"), *(Column(*channel) for channel in all_channels))


def _vibration_channels(catalogue: Catalogue, vibration: VibrationOutline | None) -> Iterator[Channel]:
    """Yield the time histories of the frame and of the places."""
    if vibration is None:
        return
    yield from catalogue.frame_channels
    for place in vibration.places:
        for name, unit, text in catalogue.place_channels if place.name != FRAME or place.body else ():
            yield Channel(name.format(place.column), unit, text.format(place.name))


def _joint_channels(catalogue: Catalogue, joint: JointLayout) -> Iterator[Channel]:
    """Yield the time histories of a joint."""
    of_contacts = catalogue.point_channels if joint.is_spatial else ()
    channels = catalogue.spatial_channels if joint.is_spatial else catalogue.joint_channels
    if joint.is_rolling:
        channels, of_contacts = catalogue.rolling_channels, catalogue.element_channels
    is_torsional = TORSIONAL in joint.features
    yield from (
        channel._replace(unit=torsional_unit(channel.unit)) if is_torsional else channel for channel in channels
    )
    yield from catalogue.film_channels if joint.film else ()
    for k in range(joint.corners):
        for name, unit, text in of_contacts:
            yield Channel(name.format(k + 1), unit, text.format(k + 1))


def converging_columns(catalogue: Catalogue, mechanism: Mechanism, *, settles: bool = True) -> tuple[str, ...]:
    """Return the columns that converge as a run grows longer, or the others, with every feature in every joint."""
    features_by_kind: dict[str, set] = {
        "guide": {"friction", "guide"},
        "slot": {"friction"},
        "rolling": {"friction", "rolling", "dynamic", "static"},
        "spatial": {"wear", "spatial", "axial", "friction"},
        "through": {"wear", "spatial", "friction"},
        **{kind: {*features} for kind, features in FEATURES_OF_FLANKED.items()},
    }
    revolute = {"wear", "arc", "film", "friction"}
    features_by_joint = {column_name(site.name): features_by_kind.get(site.kind, revolute) for site in mechanism.joints}
    figure_names = {figure.name for figure in catalogue.figures if figure.settles is settles}
    return tuple(
        column.name
        for column in columns_of(catalogue, mechanism, features_by_joint, Outline())
        if column.figure in figure_names
    )

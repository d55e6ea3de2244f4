"""The command line: each verb parses, calls one function and prints; slow imports are inside the verbs."""

import contextlib
import itertools
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import clearsweep

from . import exit_codes
from . import sweeping as sweep_options
from .language.errors import InputError, convert_write_errors, escape_control_characters
from .language.wording import SYSTEMS
from .language.wording import unit_system as shown_in
from .sweeping.pool import system

if TYPE_CHECKING:
    from .report.documents.page import Page  # loads what draws

RESULTS = Path("results")
VERSION_HELP = "Print the versions, the processor level and the directory of compiled code."


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit: 0 done, 1 internal error, 2 bad input, 3 some cases failed, 4 storage failed or
    scheduler lost, 129 hung up, 130 interrupted, 143 terminated."""
    exit_codes.survive_closed_streams()
    code = exit_codes.run(verbs, arguments)
    sys.stdout.flush()
    sys.exit(code)


class _Verb(click.Command):
    """A verb that is refused at once if its modules cannot be loaded."""

    def parse_args(self, context: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments; where one is missing, say if an option with an optional value took it."""
        given = list(args)
        try:
            return super().parse_args(context, args)
        except click.MissingParameter as error:
            optional = {name for option in self.params if _takes_optional_value(option) for name in option.opts}
            taken = [pair for pair in itertools.pairwise(given) if pair[0] in optional and pair[1][:1] != "-"]
            for option, value in taken:
                text = f"{option} took {value!r} as its value; write the option last, as in {value} {option}"
                raise click.MissingParameter(text, error.ctx, error.param) from None
            raise

    def invoke(self, context: click.Context) -> Any:
        """Run the verb with its parsed options."""
        from .language import phases

        system.check_space()
        with phases.show_progress():
            return super().invoke(context)


def _takes_optional_value(option: click.Parameter) -> bool:
    """Return whether an option of a verb may be written with or without a value."""
    return isinstance(option, click.Option) and not option.is_flag and isinstance(option.flag_value, str)


#: Names of other programs for what a verb does, which an error suggests.
SYNONYMS = {
    **dict.fromkeys(("sweep", "simulate", "start", "resume", "solve", "optimise", "optimize", "seek"), "run"),
    **dict.fromkeys(("compare", "diff", "plot", "html", "export"), "report"),
    **dict.fromkeys(("animate", "case"), "show"),
    **dict.fromkeys(("validate", "lint"), "run GRID --dry-run"),
    **dict.fromkeys(("help", "explain", "info"), "list"),
    **dict.fromkeys(("new", "create"), "init"),
}


class _Verbs(click.Group):
    """All verbs."""

    command_class = _Verb

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return a verb and its arguments; an error suggests the verb for a name of other programs."""
        if args[0] in SYNONYMS:
            ctx.fail(f"No such command '{args[0]}'. Did you mean '{SYNONYMS[args[0]]}'?")
        return super().resolve_command(ctx, args)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a verb; `laws` is the former name of `list`."""
        return super().get_command(ctx, "list" if cmd_name == "laws" else cmd_name)


def _show_version(context: click.Context, _: click.Parameter, requested: bool) -> None:
    """Print the versions, the level of the processor and the directory of compiled code; then exit."""
    if not requested or context.resilient_parsing:
        return
    from .tracing import cache, objects

    print(f"clearsweep, version {clearsweep.__version__}, model version {clearsweep.MODEL_VERSION}")
    print(f"processor level: {objects.level()}")
    print(f"compiled code: {escape_control_characters(str(cache.prepare_cache()))}")
    context.exit()


_PATH = click.Path(path_type=Path)
_directory = click.argument("directory", type=_PATH, metavar="DIR")
_json = click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
_summary_json = click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON, in SI units.")
_units = click.option(
    "--units", type=click.Choice(SYSTEMS), default=SYSTEMS[0], help="Units of quantities in the output."
)


def _run_options(command: Callable) -> Callable:
    """Add the options of a sweep to a verb."""
    for name, flag in reversed(sweep_options.flags().items()):
        kind = sweep_options.flag_type(name)
        if flag.names and kind is bool:
            command = click.option(*flag.names, name, is_flag=True, help=flag.help)(command)
        elif flag.names:
            value = click.IntRange(min=flag.least) if flag.least is not None else kind
            texts: dict[str, Any] = {"metavar": flag.metavar, "help": flag.help, "show_default": flag.show_default}
            texts |= {"is_flag": False, "flag_value": flag.bare} if flag.bare else {}
            default = sweep_options.Options._field_defaults[name]
            command = click.option(*flag.names, name, type=value, default=default, **texts)(command)
    return command


@click.group(cls=_Verbs, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option("--version", is_flag=True, is_eager=True, expose_value=False, callback=_show_version, help=VERSION_HELP)
def verbs() -> None:
    """Simulate mechanisms with joint clearance over a grid of parameters: forces, wear and position errors."""


@verbs.command()
@click.argument("grid", type=_PATH)
@click.option(
    "--out",
    type=_PATH,
    metavar="DIR",
    help="Directory of the results; default: results/NAME, where NAME is that of the grid.",
)
@click.option("--set", "fixed", multiple=True, metavar="PATH=VALUE", help="Override a value of GRID; may be repeated.")
@click.option(
    "--sweep", "swept", multiple=True, metavar="PATH=A,B,C", help="Sweep PATH over these values; may be repeated."
)
@_run_options
@click.option("--dry-run", is_flag=True, help="Only count the cases, and estimate their time and disk space.")
@click.option(
    "--fail-on-limits",
    is_flag=True,
    help="Exit with code 5 if a case exceeds a limit or is undecided, or a search has no answer.",
)
@click.option(
    "--watch", is_flag=True, help="Rewrite the report while cases finish; a browser with the page reloads it."
)
@_units
@_summary_json
def run(  # noqa: PLR0913 - one argument per option
    grid: Path,
    out: Path | None,
    fixed: tuple[str, ...],
    swept: tuple[str, ...],
    dry_run: bool,
    fail_on_limits: bool,
    watch: bool,
    units: str,
    as_json: bool,
    **arguments: Any,
) -> int:
    """Run the cases of a grid and store their results. A second run computes only the missing cases.

    Where results/NAME contains the run of another grid, that run is moved aside to results/NAME-2.

    \b
    Examples:
      clearsweep run machine.yaml --dry-run
      clearsweep run machine.yaml --set simulate.revolutions=50
      clearsweep run machine.yaml --sweep "drive.speed=20 rpm,40 rpm"
    """
    from . import grid as grids
    from .sweeping import summary
    from .sweeping.sweep import Options, check, load, sweep

    system.collect_as_usual()
    overrides = grids.read_options(grids.SET_OPTION, fixed), grids.read_options(grids.SWEEP_OPTION, swept)
    source = grids.OverriddenGrid(grid, *overrides)
    if fail_on_limits:
        with grids.allowing(arguments["trust_laws"]):
            summary.require_judgement(load(source))
    if dry_run:
        from .sweeping.estimate import estimate

        check(options := Options(**arguments))
        with grids.allowing(options.trust_laws):
            estimated = estimate(source, out, jobs=options.jobs, shard=options.shard, no_effects=options.no_effects)
        facts = estimated._asdict()
        click.echo(json.dumps(facts, indent=2) if as_json else escape_control_characters(summary.estimate_text(facts)))
        return 0
    with _watching(source, out, arguments["shard"], units) if watch else contextlib.nullcontext():
        result = sweep(source, out, **arguments)
    with shown_in(units):
        facts = summary.of_run(result)
        click.echo(json.dumps(facts, indent=2) if as_json else escape_control_characters(summary.run_text(facts)))
    if fail_on_limits and (reason := summary.limits_failure(facts)):
        click.echo(escape_control_characters(f"--fail-on-limits: {reason}"), err=True)
        return result.exit_code or exit_codes.LIMITS
    return result.exit_code


@contextlib.contextmanager
def _watching(source: Any, out: Path | None, shard: str | None, units: str) -> Iterator[None]:
    """Keep the report of a run up to date while the run lasts, and write the final one at its end."""
    from . import report as reports
    from .sweeping.sweep import Shard, directory_of, load

    directory = directory_of(load(source), out, Shard.read(shard) if shard else None).path
    page = directory / "report.html"
    click.echo(escape_control_characters(f"watch {page}: a browser with this page reloads it"), err=True)
    with reports.live_page(directory, page, units):
        yield
    with convert_write_errors(), shown_in(units):
        reports.write(reports.open(directory), page)


@verbs.command()
@click.argument("directories", nargs=-1, required=True, type=_PATH, metavar="DIR...")
@click.option("--out", required=True, type=_PATH, metavar="OUT", help="Directory of the merged results.")
@click.option("--partial", is_flag=True, help="Merge even if shards or cases are missing.")
@_summary_json
def merge(directories: tuple[Path, ...], out: Path, partial: bool, as_json: bool) -> int:
    """Merge runs of one grid, for example its shards. OUT receives the same results as one run of the whole grid."""
    from .sweeping import merge, summary

    facts = summary.of_run(result := merge.merge(directories, out, partial=partial))
    click.echo(json.dumps(facts, indent=2) if as_json else escape_control_characters(summary.run_text(facts)))
    return result.exit_code


@verbs.command()
@click.argument("directories", nargs=-1, type=_PATH, metavar="[DIR [OTHER]]")
@click.option("--out", type=_PATH, metavar="FILE", help="Output page; default: DIR/report.html.")
@click.option(
    "--tables", type=_PATH, metavar="OUT", help="Also write every table to this directory, as CSV and Markdown."
)
@click.option("--figures", type=_PATH, metavar="OUT", help="Also write each figure to its own file in this directory.")
@click.option("--format", "form", type=click.Choice(["svg", "pdf", "png"]), default="svg", help="Format of --figures.")
@click.option("--width", type=click.Choice(["85", "170", "auto"]), default="auto", help="Width of --figures in mm.")
@click.option(
    "--overlay", type=_PATH, metavar="CSV", help="Compare the measured signals of this file with the computed ones."
)
@click.option(
    "--median", is_flag=True, help="In maps, show the median of the cases in each cell instead of the worst case."
)
@click.option("--all", "all_cases", is_flag=True, help="Report all cases in DIR, including those of earlier grids.")
@click.option("--partial", is_flag=True, help="Report the finished cases of a run that is not finished.")
@_units
@click.option("--json", "as_json", is_flag=True, help="Print the names of the written files as JSON.")
def report(  # noqa: PLR0913 - one argument per option
    directories: tuple[Path, ...],
    out: Path | None,
    overlay: Path | None,
    median: bool,
    all_cases: bool,
    partial: bool,
    units: str,
    **arguments: Any,
) -> None:
    """Write the report of a run as one offline HTML page.

    DIR is the directory of the run, or its grid file; default: the newest in results/. With OTHER, the page
    OTHER/compared.html compares both runs case by case.

    \b
    Examples:
      clearsweep report results/machine --figures figures --format pdf --width 85
      clearsweep report results/machine results/machine-with-new-rod
    """
    from . import report as reports
    from . import store

    if len(directories) > 2 or (len(directories) == 2 and (all_cases or overlay)):
        message = "report: takes one run (with or without --all, --overlay), or two runs to compare; remove the others"
        raise InputError(message)
    directories = tuple(map(_run_directory, directories))
    if len(directories) == 2:
        with convert_write_errors(), shown_in(units):
            first, second = (reports.open(directory, partial=partial) for directory in directories)
            _write(reports.compared(first, second), out or second.directory / "compared.html", **arguments)
        return
    directory = directories[0] if directories else store.newest_run(RESULTS)
    opened: contextlib.AbstractContextManager[Any]
    if all_cases:
        from .sweeping.merge import complete_run

        opened = complete_run(directory)
    else:
        opened = contextlib.nullcontext(reports.open(directory, partial=partial))
    with opened as stored, convert_write_errors(), shown_in(units):
        page = reports.page_of(stored, typical=median, measured=overlay)
        _write(page, out or directory / "report.html", **arguments)


def _run_directory(path: Path) -> Path:
    """Return a directory as it is, or that of the latest run of a grid file; say if the file has changed since."""
    if path.suffix not in (".yaml", ".yml") or not path.is_file():
        return path
    from .sweeping.sweep import latest_run

    directory, changed = latest_run(path)
    if changed:
        click.echo(escape_control_characters(changed), err=True)
    return directory


def _write(page: "Page", out: Path, *, tables: Path | None, figures: Path | None, as_json: bool, **style: str) -> None:
    """Write a page with its tables and figures, and print the files; `style`: their format and width."""
    from .report.documents.paper import FigureOptions

    files = page.write_all(out, tables, FigureOptions(figures, **style) if figures else None)
    lines = [files["report"], *files.get("figures", []), *([files["tables"]] if "tables" in files else [])]
    click.echo(json.dumps(files, indent=2) if as_json else "\n".join(lines))


@verbs.command()
@_directory
@click.option("--verify", "every_file", is_flag=True, help="Read every file of the run and verify its checksum.")
@_json
def status(directory: Path, every_file: bool, as_json: bool) -> int:
    """Print the progress, active processes and damaged files of a run. A damaged file gives exit code 2."""
    from . import store

    facts = store.status(directory, every_file=every_file)
    click.echo(json.dumps(facts, indent=2) if as_json else escape_control_characters(store.status_text(facts)))
    for sentence in facts["damage"]:
        click.echo(escape_control_characters(sentence), err=True)
    return exit_codes.BAD_INPUT if facts["damage"] else 0


@verbs.command()
@_directory
@click.option("--batches", is_flag=True, help="Also remove the batches of a finished run, after checking its files.")
@click.option("--dry-run", is_flag=True, help="Only print what would be removed.")
@_json
def clean(directory: Path, batches: bool, dry_run: bool, as_json: bool) -> None:
    """Remove the files that a run no longer needs. Print their number and size."""
    from . import store

    facts = store.clean(directory, batches=batches, dry_run=dry_run)
    click.echo(json.dumps(facts, indent=2) if as_json else escape_control_characters(store.clean_text(facts)))


@verbs.command()
@click.option("--quick", is_flag=True, help="Use fewer problems and tolerances; this takes about two minutes.")
@click.option("--json", "as_json", is_flag=True, help="Print the tables as JSON.")
@click.option("--write", is_flag=True, help=f"Also write the tables, with figures, to {RESULTS}/.")
@click.option("--measured", is_flag=True, help="Compare the model with measurements and published solutions instead.")
def verify(quick: bool, as_json: bool, write: bool, measured: bool) -> None:
    """Measure error and run time on problems with known answers. Test the stability of extreme cases."""
    from . import verify as verification
    from .verify import measured as comparison

    (comparison if measured else verification).main(json=as_json, quick=quick, directory=RESULTS if write else None)


@verbs.command("check")
@click.argument("grid", type=_PATH)
@click.option(
    "--case",
    "selection",
    multiple=True,
    metavar="ID|worst|median|first",
    help="Case to check; may be repeated. Default: the worst, the median and the first.",
)
@click.option("--cases", "count", type=click.IntRange(1, 3), default=3, help="Check only the first N of these three.")
@click.option(
    "--seconds",
    type=click.FloatRange(min=0.0, min_open=True),
    default=60.0,
    show_default=True,
    help="Stop measuring after this time.",
)
@click.option("--rivals", is_flag=True, help="Compare with scipy's DOP853 and LSODA on the same equations.")
@click.option("--out", type=_PATH, metavar="DIR", help="Directory of the page; default: results/NAME-check.")
@_json
def check_(  # noqa: PLR0913 - one argument per option
    grid: Path, selection: tuple[str, ...], count: int, seconds: float, rivals: bool, out: Path | None, as_json: bool
) -> None:
    """Measure the error, the stability and the cost of the cases of a grid.

    A second check continues where the first stopped.

    \b
    Examples:
      clearsweep check machine.yaml
      clearsweep check machine.yaml --case worst --rivals
    """
    from .verify import check

    with convert_write_errors():
        text = check.check_grid(grid, selection or count, RESULTS, out, seconds=seconds, rivals=rivals, as_json=as_json)
    click.echo(text)


@verbs.command("list")
@click.argument("name", required=False)
@click.option("--for", "grid", type=_PATH, metavar="GRID", help="Assess which laws are valid in each joint of GRID.")
def list_(name: str | None, grid: Path | None) -> None:
    """Print all mechanisms, drives, loads and laws, or explain NAME.

    NAME is a mechanism, drive, load, law, material, oil, wear pair or bearing, or a key of a grid. The names
    `materials`, `oils`, `pairs` and `bearings` print the libraries.

    \b
    Examples:
      clearsweep list joints.rod-slider.clearance
      clearsweep list flores --for machine.yaml
    """
    from . import simulation

    click.echo(escape_control_characters(simulation.advice_text(grid, name)) if grid else simulation.laws_text(name))


@verbs.command()
@click.argument("grid", type=_PATH)
@click.option("--out", type=_PATH, metavar="FILE", help="SVG or PNG file; default: GRID.svg in the current directory.")
def draw(grid: Path, out: Path | None) -> None:
    """Draw the mechanism of a grid in its initial position. Label its bodies, joints and loads."""
    from . import report as reports

    with convert_write_errors():
        page = reports.draw_grid(grid, out or Path(f"{grid.stem}.svg"))
    click.echo(page)


@verbs.command()
@_directory
@click.argument("case_id")
@click.option(
    "--out",
    type=_PATH,
    metavar="FILE",
    help="Output file: a page (.html), the drawings (.svg, .png), the motion (.gif, .webp) or the forces (.csv). "
    "Default: DIR/CASE_ID.html.",
)
def show(directory: Path, case_id: str, out: Path | None) -> None:
    """Simulate one case again and draw its orbit, force and events. A unique prefix of CASE_ID is enough."""
    from . import report as reports
    from . import store

    stored = store.open(directory)
    case_id = stored.full_id(case_id)
    try:
        with convert_write_errors():
            page = reports.show(stored, case_id, out or stored.directory / f"{case_id}.html")
    except InputError as error:
        raise InputError(str(error).replace("clearsweep trust DIR", f"clearsweep trust {directory}")) from None
    click.echo(page)


@verbs.command()
@click.argument("series", type=_PATH, metavar="SERIES.csv")
@click.option(
    "--coefficient",
    required=True,
    metavar="K",
    help="Wear coefficient, such as '2e-14 m^2/N'. With --hardness, a number without a unit is dimensionless.",
)
@click.option("--hardness", metavar="H", help="Hardness of the softer body, such as '2 GPa'.")
@click.option(
    "--area", metavar="A", help="Contact area, such as '100 mm^2'. A series with a pressure column does not need it."
)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON, in SI units.")
def wear(series: Path, coefficient: str, hardness: str | None, area: str | None, as_json: bool) -> None:
    """Integrate Archard's wear law over a measured series. If it has a wear column, compare the depth with it."""
    from . import series as prescribed

    value, number = prescribed.read_coefficient(coefficient, hardness)
    size = prescribed.read_positive("--area", area, "m^2") if area else None
    worn = prescribed.compute_wear(prescribed.read_series(series), value, size)
    click.echo((prescribed.wear_json if as_json else prescribed.wear_text)(worn, number))


@verbs.command()
@click.argument("file", required=False, type=_PATH)
@click.option(
    "--type",
    "kind",
    type=click.Choice(["slider-crank", "four-bar", "planar", "press"]),
    default="slider-crank",
    show_default=True,
    help="Mechanism in the starter grid.",
)
def init(file: Path | None, kind: str) -> None:
    """Write a commented starter grid to FILE, and its schema for editors next to it; without FILE, print the grid."""
    from . import grid, simulation

    if file is None:
        click.echo(grid.starter(kind), nl=False)
        return
    grid.write_starter(file, kind, simulation.catalogue())
    click.echo(f"{file}\nNext: clearsweep run {file} --dry-run")


@verbs.command()
@click.argument("file", required=False, type=_PATH)
@click.option("--list", "lists", is_flag=True, help="Print the files that are trusted.")
@click.option("--revoke", is_flag=True, help="Stop trusting FILE.")
def trust(file: Path | None, lists: bool, revoke: bool) -> None:
    """Let grids run a law file of yours. Read it first: its text can do whatever you can.

    Prints what FILE contains, and remembers its path, its content, and the content of the libraries and tables that it
    names. A change of any of these needs trust again. If FILE is the directory of a run, `show` may run its laws.
    """
    from . import grid as grids
    from . import store

    if lists == (file is not None) or (revoke and file is None):
        raise InputError("trust: expected FILE, --revoke FILE or --list")
    if file is None:
        click.echo(escape_control_characters(grids.list_text()))
    elif revoke:
        click.echo(f"{grids.revoke(file)} contents of {escape_control_characters(str(file))} are no longer trusted")
    else:
        recorded = store.read_record(file).get("laws", ()) if file.is_dir() else None
        click.echo(escape_control_characters(grids.trust(file, recorded)))


@verbs.command()
@click.option("--markdown", is_flag=True, help="Print all keys as a Markdown page.")
def schema(markdown: bool) -> None:
    """Print the JSON Schema of grid files, for editors."""
    from . import grid, simulation

    catalogue = simulation.catalogue()
    click.echo(grid.markdown(catalogue) if markdown else json.dumps(grid.schema(catalogue), indent=0), nl=not markdown)

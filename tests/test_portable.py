"""Constants and set-up do not depend on the code that numpy and OpenBLAS choose for the processor."""

import itertools
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import portable_bits
import pytest

import clearsweep
from clearsweep import grid
from clearsweep.mechanics.machines.planar import free_crank
from clearsweep.mechanics.solver import collocation
from clearsweep.simulation import catalogue
from clearsweep.simulation.setup import scene
from clearsweep.tracing import objects, portable

PROGRAM = Path(__file__).parent / "portable_bits.py"
#: As on a processor without fused operations; names of its kernels differ between versions of the libraries.
OLDER = {"OPENBLAS_CORETYPE": "Sandybridge", "NPY_DISABLE_CPU_FEATURES": "X86_V3,X86_V4"}
NAMES = "slider_crank lubricated four_bar spatial_four_bar bending_rod press_joint_life until bearing_class"
GRIDS = [f"{name}.yaml" for name in NAMES.split()]


def bits(cache, environment, level=None):
    """Return what the program prints with further environment variables, for a level of processors.

    cache : directory of its machine code, which contains constants that the program computes
    """
    if level in objects.LEVELS and objects.level() not in objects.LEVELS:
        pytest.skip(f"{objects.level()} does not run code for {level}")
    command = [sys.executable, str(PROGRAM), level or objects.level(), *GRIDS]
    environment = os.environ | environment | {"CLEARSWEEP_CACHE_DIR": str(cache)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def own_bits(tmp_path_factory):
    return bits(tmp_path_factory.mktemp("own"), {})


@pytest.mark.slow
def test_an_older_processor_multiplies_matrices_with_other_bits():
    """So equal bits below are not for want of a difference."""
    sums = "import numpy as np; x = np.linspace(0.1, 1.0, 400).reshape(20, 20); print((x @ x / 3.0).tobytes().hex())"
    products = {
        subprocess.run([sys.executable, "-c", sums], env=os.environ | extra, capture_output=True, check=True).stdout
        for extra in ({}, OLDER)
    }
    assert len(products) == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("environment", "level"),
    [
        (OLDER, None),
        ({"OPENBLAS_CORETYPE": "Haswell"}, None),
        ({"NPY_DISABLE_CPU_FEATURES": "X86_V4"}, "x86-64-v3"),
        (OLDER, "x86-64-v2"),
    ],
    ids=[
        "libraries of an older processor",
        "libraries of another maker's",
        "four numbers in a register",
        "two numbers and no fused operations",
    ],
)
def test_every_processor_gives_the_same_bits(environment, level, own_bits, tmp_path):
    """Of the levels below this machine's; `test_recorded_bits` has the bits of all files of `configs/`."""
    assert bits(tmp_path, environment, level) == own_bits


@pytest.mark.parametrize("count", [2, 5, 8, 40])
def test_gauss_and_lobatto_rules_are_exact_for_their_degree(count):
    for (nodes, weights), degree in (
        (portable.gauss_rule(count), 2 * count - 1),
        (portable.lobatto_rule(count), 2 * count - 3),
    ):
        for power in range(degree + 1):
            exact = (1.0 - (-1.0) ** (power + 1)) / (power + 1)
            assert np.sum(weights * nodes**power) == pytest.approx(exact, abs=1e-14)
        assert np.sum(weights * nodes ** (degree + 1)) != pytest.approx(2.0 / (degree + 2), abs=1e-14) or count == 40


def test_exact_inverses_are_those_of_linear_algebra():
    drawn = np.random.default_rng(3).normal(size=(6, 6))
    inverse = portable.inverse(portable.exact(drawn)).rounded()
    assert np.allclose(inverse, np.linalg.inv(drawn), rtol=1e-12, atol=0.0)
    fitted = portable.least_squares(portable.exact(drawn[:, :3])).rounded()
    assert np.allclose(fitted, np.linalg.pinv(drawn[:, :3]), rtol=1e-12, atol=1e-15)
    through = portable.coefficients_through(drawn[0]).rounded()
    assert np.allclose(through, np.linalg.inv(np.vander(drawn[0], increasing=True)), rtol=1e-10, atol=1e-12)


def test_products_and_solutions_are_those_of_linear_algebra():
    rng = np.random.default_rng(5)
    a, b, x = rng.normal(size=(3, 4, 5)), rng.normal(size=(5, 6)), rng.normal(size=5)
    for left, right in ((a, b), (a, x), (x, b), (x, x), (a + 1j, x - 1j)):
        assert np.allclose(portable.product(left, right), left @ right, rtol=1e-14, atol=1e-14)
    matrix = np.array([[0.0, 2.0, 1.0], [1e-3, 1.0, 0.0], [3.0, 1.0, 5.0]])  # needs pivots
    assert np.allclose(portable.solve(matrix, x[:3]), np.linalg.solve(matrix, x[:3]), rtol=1e-13, atol=0.0)


def test_an_inverse_is_rounded_once():
    """Hilbert's matrix of order 12 has a condition of 1e16; floats lose all digits of its inverse."""
    rows = [[1.0 / (1.0 + i + j) for j in range(12)] for i in range(12)]
    matrix = portable.exact(rows)
    product = portable.inverse(matrix) @ matrix
    assert np.array_equal(product.rounded(), np.eye(12))


def test_the_integrals_of_the_free_crank_are_those_of_the_solver():
    assert np.array_equal(free_crank.A, collocation.A)


def test_a_polynomial_through_points_is_the_function_there():
    coefficients = portable.polynomial_through(portable.exp, 9)
    places = np.linspace(0.0, 1.0, 101)
    assert np.abs(np.polynomial.polynomial.polyval(places, coefficients) - np.exp(places)).max() < 1e-11


def test_a_line_through_points_has_the_least_weighted_squares():
    x, y, weights = np.random.default_rng(4).uniform(1.0, 2.0, size=(3, 20))
    slope, start = portable.line_through(x, y, weights)
    assert (slope, start) == pytest.approx(tuple(np.polyfit(x, y, 1, w=np.sqrt(weights))), rel=1e-12)


# ---------------------------------------------------------------------------------------------- columns that converge


ALL_GRIDS = sorted(path.name for path in portable_bits.CONFIGS.glob("*.yaml"))
TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
SAME_MOTION = 1e-4  # of the range of each position: largest difference of two runs whose columns are compared
ALLOWED = 0.02  # of a column
#: Of the share of time with narrow arcs: their width is straight between the nodes of a step, which no onset is.
OF_NARROW_ARCS = 1e-3
OF_A_LIFE = 0.05  # of the limit of a life: some blocks have all its columns, and each takes minutes at 1e-11
#: Left out: at no two tolerances is their short motion the same, so that nothing would be compared. Blocks of lives are
#: longer than their motion is known, and the block of the engine's guide turns by rounding alone.
IRREGULAR = (
    "engine.yaml",
    "press_joint_life.yaml",
    "press_life.yaml",
    "spatial_four_bar.yaml",
    "spatial_slider_crank.yaml",
)
COMPARED = [name for name in ALL_GRIDS if name not in IRREGULAR]
#: Parts of the names of columns that describe the computation: its cost, its errors, its message, what its tolerance
#: defines.
OF_THE_COMPUTATION = (
    "horizon",
    "steps",
    "evaluations",
    "_time_wall",
    "tolerance",
    "residual",
    "message",
    "status",
    "_difference",
)


def runs_of(name):
    """Return the positions (channels, samples), the figures and the duration (s) at each tolerance."""
    case = portable_bits.shortened(grid.load(portable_bits.CONFIGS / name, catalogue()).case(0))
    case = case._replace(save=case.save._replace(orbits="all"))
    if case.life:
        case = case._replace(life=case.life._replace(limit=OF_A_LIFE * case.life.limit))
    runs = []
    for tolerance in TOLERANCES:
        built = scene.build(case._replace(simulate=case.simulate._replace(tolerance=tolerance)))
        path = clearsweep.simulate(built)
        if path.status == "ok":
            channels = [path[key] for key in sorted(path.channels) if key.endswith(("/x", "/y", "/angle", "/place"))]
            runs.append((channels, path.summary, path.t[-1] - path.t[0]))
    return runs


def apart(first, second):
    """Return the largest difference of the positions of two runs over their range; inf if they differ in length."""
    if any(a.shape != b.shape for a, b in zip(first, second, strict=True)):
        return np.inf
    return max((np.max(np.abs(a - b)) / (np.ptp(b) or 1.0) for a, b in zip(first, second, strict=True)), default=0.0)


def astray(first, second, duration):
    """Return what does not agree in the figures of two runs of the same motion: column -> both values.

    duration : s; the growth of a disturbance over it is known to a factor e, as an impact changes its size at once
    """
    columns = {}
    for key in first.keys() & second.keys():
        a, b = first[key], second[key]
        if any(part in key for part in OF_THE_COMPUTATION) or key in portable_bits.TIMINGS or a == b:
            continue
        numbers = isinstance(a, int | float) and isinstance(b, int | float)
        floor = 1.0 if isinstance(a, int) and isinstance(b, int) else 0.0
        floor = OF_NARROW_ARCS if key.endswith("wear_narrow_arcs") else floor
        floor = 1.0 / duration if key == "lyapunov_exponent" else floor
        if not (numbers and abs(a - b) <= max(ALLOWED * max(abs(a), abs(b)), floor)):
            columns[key] = (a, b)
    return columns


def columns_astray(name):
    """Return the columns of a file that differ between two tolerances at which its motion is the same.

    None: at no two tolerances is the motion the same, so that no columns were compared.
    """
    same = [
        astray(coarse, fine, duration)
        for (slower, coarse, duration), (finer, fine, *_) in itertools.pairwise(runs_of(name))
        if apart(slower, finer) < SAME_MOTION
    ]
    return dict(itertools.chain.from_iterable(columns.items() for columns in same)) if same else None


@pytest.mark.slow
@pytest.mark.parametrize("name", COMPARED)
def test_columns_converge_where_the_motion_does(name):
    assert columns_astray(name) == {}


if __name__ == "__main__":
    for name in sys.argv[1:] or ALL_GRIDS:
        print(name, flush=True)
        for key, values in sorted((columns_astray(name) or {}).items()):
            print(f"  {key}: {values[0]} at a larger tolerance, {values[1]} at a smaller one", flush=True)

"""The report in a real browser: laid out, used, read aloud, printed, in any width and either colour scheme."""

import base64
import hashlib
import html
import http.server
import importlib.util
import json
import os
import re
import shutil
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest
from fake_physics import grid, sweep
from fake_runs import RPM, Run

import clearsweep
from clearsweep import report
from clearsweep.language import wording

pytestmark = pytest.mark.heavy

SWEEP = {
    "joints.rod-slider.clearance": [5e-5, 1e-4, 2e-4, 5e-4],
    "joints.rod-slider.contact.law": ["flores", "hertz"],
    "drive.speed": [1000 * RPM, 3000 * RPM, 5000 * RPM],
}
PAIR = {path: SWEEP[path] for path in ("joints.rod-slider.clearance", "drive.speed")}
RUNS = {
    "laws": {"sweep": SWEEP},
    "pair": {"sweep": PAIR},
    "joints": {"joints": ("ground_crank", "crank_rod", "rod_slider")},
}
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-default-apps",
    "--disable-extensions",
    "--disable-dev-shm-usage",
    "--proxy-bypass-list=<-loopback>",
    "--virtual-time-budget=20000",
)
#: Runs `probe`, which a test writes, when all is there, and leaves in the page what it returns, with the page's errors.
AROUND = """
const errors = [];
addEventListener("error", event => errors.push(event.message));
addEventListener("securitypolicyviolation", event => errors.push(`${event.violatedDirective} ${event.blockedURI}`));
addEventListener("load", async () => {
  const frame = () => new Promise(done => setTimeout(done, 50));
  const all = selector => [...document.querySelectorAll(selector)];
  const size = selector => all(selector).map(e => { const r = e.getBoundingClientRect(); return [r.width, r.height]; });
  let found = {};
  try {
    await frame();
    await frame();
    found = await (async () => { %s })();
  } catch (error) { errors.push(String(error)); }
  found = {...found, errors, page: document.documentElement.scrollWidth, window: innerWidth,
           fetched: performance.getEntriesByType("resource").map(e => e.name)};
  document.body.setAttribute("data-probe", JSON.stringify(found));
});
"""


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Return name -> the page of each run, written when it is first asked for."""
    directory = tmp_path_factory.mktemp("pages")

    class Pages(dict):
        def __missing__(self, name):
            self[name] = report.write(Run(**RUNS[name]), directory / name).read_text(encoding="utf-8")
            return self[name]

    return Pages()


@pytest.fixture
def proxy():
    """Return a server that every request of a browser goes through: (port, pages by address, addresses asked for)."""
    served, asked = {}, []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            asked.append(self.path)
            body = served.get(self.path)
            self.send_response(404 if body is None else 200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            self.wfile.write(body or b"")

        def do_CONNECT(self):
            self.send_error(502)  # the browser's own services, which are kept from the network here

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield server.server_address[1], served, asked
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture
def browse(proxy, tmp_path):
    """Return what runs a probe in a page and returns what it found; the page's security policy stays in force."""
    browser = shutil.which("chromium")
    if browser is None and not os.environ.get("CI"):
        pytest.skip("chromium is not installed")
    assert browser, "chromium is not installed: apt-get install chromium"
    port, served, _ = proxy

    def run(page: str, probe: str = "return {};", *, width: int = 1280, flags: tuple = (), first: str = "") -> dict:
        script = first + AROUND % probe
        allowed = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        page = re.sub(r"script-src ('sha256-[^']*')", rf"script-src \1 'sha256-{allowed}'", page)
        served["http://report.test/"] = page.replace("</head>", f"<script>{script}</script></head>").encode()
        done = subprocess.run(
            [
                *(browser, *FLAGS, *flags, "--dump-dom", f"--proxy-server=http://127.0.0.1:{port}"),
                *(f"--user-data-dir={tmp_path / 'profile'}", f"--window-size={width},900", "http://report.test/"),
            ],
            capture_output=True,
            text=True,
            timeout=120,
            check=True,
        )
        return json.loads(html.unescape(re.search(r'data-probe="([^"]*)"', done.stdout)[1]))

    return run


LAID_OUT = """
  const folded = all("#setup table").every(each => !each.checkVisibility());
  all("details").forEach(part => part.open = true);
  await frame();
  const letters = all("figure svg").map(each => {
    const text = each.querySelector("text");
    return text ? text.getBoundingClientRect().height / 1.2 : 99;
  });
  return {svg: size("svg"), section: size("section"), table: size("table"), canvas: size("canvas"), folded,
          smallest: Math.min(...letters)};
"""


@pytest.mark.few("laws-1600")
@pytest.mark.parametrize(("name", "width"), [("laws", 1600), ("laws", 500), ("joints", 800)])
def test_page_is_laid_out_and_fetches_nothing(pages, browse, proxy, name, width):
    result = browse(pages[name], LAID_OUT, width=width)
    assert result["errors"] == []
    assert result["fetched"] == []
    assert [address for address in proxy[2] if ".test" in address] == ["http://report.test/"]
    assert len(result["svg"]) == pages[name].count("<svg ") > 20
    assert len(result["canvas"]) >= 4
    for kind in ("svg", "section", "table", "canvas"):
        assert all(wide > 50 and high > 20 for wide, high in result[kind])
    assert result["folded"]  # the setup, until it is opened
    assert result["smallest"] > 5.5  # px, of the first letters of every figure
    assert result["page"] <= result["window"]  # nothing makes the page scroll sideways


@pytest.mark.slow
def test_a_wide_page_has_two_columns_and_a_narrow_one_does_not_scroll(pages, browse):
    high = """
      const place = id => document.getElementById(id).getBoundingClientRect();
      return {high: document.documentElement.scrollHeight, left: place("cases").right, right: place("drivers").left,
              tops: ["verdict", "drivers"].map(id => document.querySelector(`#${id} h2`).getBoundingClientRect().top)};
    """
    wide, usual = (browse(pages["laws"], high, width=width) for width in (1600, 1280))
    assert wide["left"] < wide["right"]
    assert abs(wide["tops"][0] - wide["tops"][1]) < 2
    assert usual["left"] > usual["right"]  # one below the other
    assert wide["high"] < 0.75 * usual["high"]
    assert wide["high"] < 2600
    inner = json.dumps(pages["laws"]).replace("<", "\\u003c")
    frame = """
      const narrow = element("iframe", {style: "width: 360px", srcdoc: SOURCE});
      document.body.replaceChildren(narrow);
      await new Promise(done => narrow.onload = done);
      for (let k = 0; k < 10; k++) await frame();
      const root = narrow.contentDocument.documentElement;
      const cut = [...root.querySelectorAll(".scroll")].filter(box => box.scrollWidth > box.clientWidth + 1);
      const shades = cut.map(box => getComputedStyle(box).backgroundImage.split("linear-gradient").length - 1);
      return {inner: root.clientWidth, across: root.scrollWidth, shades};
    """
    narrow = browse(pages["laws"], frame.replace("SOURCE", inner))
    assert 300 < narrow["inner"] <= 360
    assert narrow["across"] <= narrow["inner"]
    assert narrow["shades"]
    assert {*narrow["shades"]} == {4}  # a table that is cut shows that it continues


def test_browser_would_notice_a_fetch_and_a_script_that_is_not_the_pages(pages, browse, proxy):
    page = '<html><head></head><body><img src="http://elsewhere.test/x.png"></body></html>'
    assert "http://elsewhere.test/x.png" in browse(page)["fetched"]
    assert "http://elsewhere.test/x.png" in proxy[2]
    strange = pages["laws"].replace("</body>", "<script>document.title = 'strange'</script></body>")
    assert any("script-src" in error for error in browse(strange)["errors"])


USED = """
  all("details").forEach(part => part.open = true);
  await frame();
  const column = name => all(".explorer thead tr:first-child th").findIndex(e => e.textContent.startsWith(name));
  const cells = place => all(".explorer tbody:last-child tr").filter(row => row.children.length > 4)
    .map(row => row.children[place].textContent);
  const said = () => all(".explorer .tools .note")[0].textContent;
  const write = async (name, text) => {
    const field = all(".explorer .filters td")[column(name)].firstChild;
    field.value = text;
    field.dispatchEvent(new Event("input"));
    await frame();
  };
  const found = {first: cells(column("force peak")), cases: said()};
  all(".explorer thead button")[column("clearance") - 1].click();
  found.sorted = cells(column("clearance"));
  await write("clearance", "0.05..0.1");
  found.filtered = [said(), [...new Set(cells(column("clearance")))]];
  await write("contact law", "hertz");
  found.words = [said(), [...new Set(cells(column("contact law")))]];
  all(".explorer .tools button")[0].click();
  found.cleared = said();

  const lines = all(".lines canvas")[0], box = lines.getBoundingClientRect(), axes = all(".filters input").length;
  const point = (type, share) => lines.dispatchEvent(new PointerEvent(type, {pointerId: 1, bubbles: true,
    clientX: box.left + 0.5 * box.width / axes, clientY: box.top + 44 + share * (box.height - 64)}));
  lines.setPointerCapture = () => {};
  point("pointerdown", 1); point("pointermove", 0.95); point("pointermove", 0.85); point("pointerup", 0.85);
  found.brushed = [said(), all(".filters input")[0].value];
  all(".explorer .tools button")[0].click();

  all(".explorer tbody tr").filter(row => row.children.length > 4)[2].click();
  found.chosen = [all(".case h3 .id")[0].textContent, all(".explorer tr.selected").length];

  const dots = all(".dots canvas")[0], area = dots.getBoundingClientRect();
  const tip = all(".tip")[0];
  for (let x = 60; x < area.width && tip.hidden; x += 6) {
    for (let y = 10; y < 290 && tip.hidden; y += 6) {
      dots.dispatchEvent(new PointerEvent("pointermove", {clientX: area.left + x, clientY: area.top + y}));
    }
  }
  found.tip = tip.textContent;
  return found;
"""


def test_cases_are_sorted_filtered_brushed_and_followed(pages, browse):
    result = browse(pages["laws"], USED)
    assert result["errors"] == []
    run = Run(**RUNS["laws"]).summary
    forces = sorted(run["rod_slider_force_peak"], reverse=True)
    assert [float(text) for text in result["first"]] == pytest.approx([force / 1e3 for force in forces][:20], rel=1e-3)
    assert result["cases"] == "24 cases."
    assert result["sorted"] == [text for text in ("0.05", "0.1", "0.2", "0.5") for _ in range(6)][:20]
    assert result["filtered"] == ["12 of 24 cases.", ["0.05", "0.1"]]
    assert result["words"] == ["6 of 24 cases.", ["hertz"]]
    assert result["cleared"] == "24 cases."
    low, high = map(float, result["brushed"][1].split(".."))
    assert result["brushed"][0] == "6 of 24 cases."
    assert 0.05 <= low < high < 0.1
    assert result["chosen"][0] in set(run["case_id"])
    assert result["chosen"][1] == 1
    assert "force peak" in result["tip"]


BRUSHED = """
  const lines = all("#explore .lines canvas")[0], box = lines.getBoundingClientRect();
  const names = all("#explore .filters input").map(field => field.getAttribute("aria-label").slice(7));
  const said = () => all("#explore .tools .note")[0].textContent;
  const colours = () => {
    const context = lines.getContext("2d"), there = context.getImageData(0, 0, lines.width, lines.height).data;
    let marked = 0;
    for (let k = 0; k < there.length; k += 4) marked += there[k] > there[k + 2] + 60 && there[k + 3] > 200;
    return marked;
  };
  const place = names.findIndex(name => name.startsWith("miss"));
  const drag = (type, share) => lines.dispatchEvent(new PointerEvent(type, {pointerId: 1, bubbles: true,
    clientX: box.left + (place + 0.5) * box.width / names.length, clientY: box.top + 44 + share * (box.height - 64)}));
  lines.setPointerCapture = () => {};
  const seen = {names, before: said(), marked: colours(),
    chosen: [...all("#explore label > select")].map(each => each.selectedOptions[0].textContent)};
  drag("pointerdown", 0.5); drag("pointermove", 0.2); drag("pointerup", 0);
  return {...seen, after: said(), range: all("#explore .filters input")[place].value, left: colours()};
"""


@pytest.mark.slow
def test_cases_of_an_optimisation_are_brushed_and_the_best_are_marked(tmp_path, browse):
    over = {f"mechanism.{body}.mass": ["0.1 kg", "0.9 kg"] for body in ("slider", "rod")}
    aims = {"figures": {"miss": "abs(rod_slider_force_peak - '0.4 N')"}}
    section = {"over": over, "minimise": ["miss", "rod_slider_force_peak"], "cases": 32}
    source = {key: part for key, part in grid(1, orbits="none").items() if key != "sweep"} | aims
    sweep(source | {"optimise": section}, tmp_path / "run", executor="serial", show_progress=False)
    run = clearsweep.open(tmp_path / "run")
    seen = browse(report.write(run, tmp_path / "page.html").read_text(encoding="utf-8"), BRUSHED)
    assert seen["errors"] == seen["fetched"] == []
    assert [name.split(" [")[0] for name in seen["names"]] == [
        *("slider mass", "rod mass", "miss", "rod_slider_force_peak")
    ]
    assert [name.split(" [")[0] for name in seen["chosen"]] == ["miss", "rod_slider_force_peak", "slider mass"]
    assert seen["before"] == "32 cases."
    low, high = map(float, seen["range"].split(".."))
    miss, best = run.summary.set_index("case_id")["miss"], run.optimise["miss"]
    kept, left = ((values >= low) & (values <= high) for values in (miss, best))
    assert seen["after"] == f"{kept.sum()} of 32 cases. {left.sum()} of {len(best)} marked."
    assert 0 < left.sum() < len(best)
    assert 0 < seen["left"] < seen["marked"]


FOLLOWED = """
  const cell = all("svg a:has(.spot)").find(link => link.closest("figure").textContent.includes("Force peak"));
  location.hash = cell.getAttribute("href");
  await new Promise(done => addEventListener("hashchange", () => frame().then(done)));
  const values = Object.fromEntries(all(".case tr").map(row => [...row.children].map(cell => cell.textContent)));
  return {hash: location.hash, id: all(".case h3 .id")[0].textContent, said: cell.querySelector("title").textContent,
          clearance: values["clearance [mm]"], speed: values["crank speed [rpm]"], force: values["force peak [kN]"]};
"""


def test_cell_of_a_map_says_its_value_and_leads_to_its_case(pages, browse):
    result = browse(pages["pair"], FOLLOWED)
    assert result["errors"] == []
    assert result["hash"] == f"#case-{result['id']}"
    force, place = result["said"].split(": ")
    assert place.replace("\u00a0", " ") == f"clearance {result['clearance']} mm, crank speed {result['speed']} rpm"
    row = Run(**RUNS["pair"]).summary.set_index("case_id").loc[result["id"]]
    assert row["rod_slider_force_peak"] == pytest.approx(1e3 * float(result["force"]), rel=1e-3)
    assert force == wording.Scale(1e3, "kN").text(row["rod_slider_force_peak"])


PLAYED = """
  const player = all(".player")[0], slider = player.querySelector("input[type=range]");
  const picture = () => [...player.querySelectorAll("canvas")].slice(0, 2).map(canvas => canvas.toDataURL());
  const before = picture();
  slider.value = Math.round(slider.max / 3);
  slider.dispatchEvent(new Event("input"));
  const moved = picture(), at = player.querySelector("output").textContent;
  const marker = player.querySelector(".marker").style.left, said = player.querySelector(".said").textContent;
  let clock = performance.now();  // frames, which do not come by themselves without a screen, not the first either
  window.requestAnimationFrame = next => setTimeout(() => next(clock += 16), 16);
  player.querySelector("button").click();
  const wait = () => new Promise(done => setTimeout(done, 200));
  const begun = Number(slider.value);
  for (let k = 0; k < 50 && Number(slider.value) === begun; k++) await wait();
  const playing = Number(slider.value);
  player.querySelector("button").click();
  const paused = Number(slider.value);
  await wait();
  return {changed: before.map((url, k) => url !== moved[k]), at, marker, said, third: Math.round(slider.max / 3),
          playing, paused, still: Number(slider.value), curves: player.querySelectorAll(".uplot").length};
"""


def test_motion_plays_steps_and_pauses(pages, browse):
    result = browse(pages["laws"], PLAYED)
    assert result["errors"] == []
    assert result["changed"] == [True, True]
    assert result["marker"].startswith("33.3")
    assert re.fullmatch(r"[\d.]+°", result["at"])
    assert "ideal" in result["said"]
    assert result["playing"] > result["third"]
    assert result["still"] == result["paused"]
    assert result["curves"] == 3


@pytest.mark.slow
def test_page_is_dark_where_that_is_preferred(pages, browse):
    colours = (
        "return {ink: getComputedStyle(document.body).color, paper: getComputedStyle(document.body).backgroundColor};"
    )
    light, dark = (browse(pages["laws"], colours, flags=flags) for flags in ((), ("--force-dark-mode",)))
    assert light["paper"] == "rgb(255, 255, 255)"
    assert dark["paper"] == "rgb(20, 25, 30)"


@pytest.mark.slow
def test_page_has_no_serious_barrier(pages, browse):
    axe = Path(importlib.util.find_spec("axe_core_python").origin).with_name("axe.min.js").read_text(encoding="utf-8")
    looked = """
      const result = await axe.run(document, {resultTypes: ["violations"]});
      return {barriers: result.violations.filter(each => ["serious", "critical"].includes(each.impact))
        .map(each => `${each.id}: ${each.nodes[0].html}`), passed: result.passes.length};
    """
    result = browse(pages["laws"], looked, first=axe)
    assert result["errors"] == []
    assert result["passed"] > 20
    assert result["barriers"] == []


SEEN = """
  return {figures: all("figure").filter(each => each.checkVisibility()).length, whole: all("figure").length,
          height: document.documentElement.scrollHeight};
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["slider_crank", "until"])  # that of the README, and one with many remarks
def test_a_page_is_two_screens_and_six_printed_pages(browse, tmp_path, name):
    result = clearsweep.sweep(Path(__file__).parents[1] / f"configs/{name}.yaml", tmp_path / "run", show_progress=False)
    page = report.write(result.open(), tmp_path / "page.html")
    seen = browse(page.read_text(encoding="utf-8"), SEEN, width=1600)
    assert seen["figures"] <= 12 < seen["whole"]
    assert seen["height"] <= 2200  # px: two screens of 1100
    printed = tmp_path / "page.pdf"
    command = [shutil.which("chromium"), *FLAGS, f"--print-to-pdf={printed}", f"--user-data-dir={tmp_path / 'profile'}"]
    subprocess.run([*command, f"file://{page}"], check=True, capture_output=True, timeout=120)
    assert 1 < len(re.findall(rb"/Type\s*/Page\b", printed.read_bytes())) <= 6


CHOSEN = """
  const worn = all(".worn")[0], choice = worn.querySelector("select");
  const seen = () => [...worn.querySelectorAll("canvas")].map(canvas => canvas.toDataURL());
  const said = () => [...worn.querySelectorAll("figcaption span")].map(each => each.textContent);
  const first = {drawn: seen(), said: said()};
  choice.selectedIndex = choice.length - 1;
  choice.dispatchEvent(new Event("change"));
  return {first, last: {drawn: seen(), said: said()}, cases: choice.length};
"""


@pytest.mark.slow
def test_the_wear_of_a_case_that_is_chosen_is_drawn(monkeypatch, tmp_path, browse):
    run, ends = Run(**RUNS["pair"]), {}
    order = run.summary.sort_values("rod_slider_wear_depth_max", ascending=False)["case_id"].tolist()
    for place, case_id in ((0, order[0]), (90, order[-1])):
        depth = np.zeros(360)
        depth[place] = 1e-9 * (1 + place)
        ends[case_id] = {"rod_slider": (depth, 0.5 * depth)}
    monkeypatch.setattr(run, "wear", lambda case_id: ends.get(case_id, ends[order[0]]))
    result = browse(report.write(run, tmp_path / "page.html").read_text(encoding="utf-8"), CHOSEN)
    assert result["errors"] == []
    assert result["cases"] == len(order) - 1  # the first has pictures of its own
    assert [text.replace("\u00a0", " ").split(" at ")[0] for text in result["last"]["said"]] == [
        "deepest 91.0 nm",
        "deepest 45.5 nm",
    ]
    assert not set(result["first"]["drawn"]) & set(result["last"]["drawn"])


AS_PRINTED = """
  const screen = all(".player .curves canvas").map(each => each.getBoundingClientRect().width);
  for (const sheet of document.styleSheets) {
    for (const rule of sheet.cssRules) {
      if (rule instanceof CSSMediaRule && rule.media.mediaText === "print") rule.media.mediaText = "all";
    }
  }
  document.body.style.width = "340px";
  await frame();
  const room = all(".player .curves")[0].getBoundingClientRect();
  const boxes = all(".player .curves canvas").map(each => each.getBoundingClientRect());
  return {screen, right: room.right, edges: boxes.map(box => box.right), heights: boxes.map(box => box.height)};
"""


@pytest.mark.slow
def test_curves_of_the_player_fit_a_sheet_of_paper(pages, browse):
    result = browse(pages["pair"], AS_PRINTED, width=1600)
    assert result["errors"] == []
    assert len(result["edges"]) == len(result["screen"]) >= 2
    assert min(result["screen"]) > 340.0  # wider than the sheet before
    assert max(result["edges"]) <= result["right"] + 1.0
    assert min(result["heights"]) > 15.0


MAP_LETTERS = """
  const box = text => text.getBoundingClientRect();
  return {sizes: all("#verdict figure svg text").map(text => Math.min(box(text).height, box(text).width * 9) / 1.2),
          axes: all(".player .said strong").map(each => each.textContent)};
"""


@pytest.mark.slow
def test_letters_of_the_map_are_readable_and_curves_have_units(pages, browse):
    result = browse(pages["pair"], MAP_LETTERS, width=1600)
    assert result["errors"] == []
    assert len(result["sizes"]) > 10
    assert min(result["sizes"]) > 9.5  # px
    assert result["axes"]
    assert all("[" in text for text in result["axes"])

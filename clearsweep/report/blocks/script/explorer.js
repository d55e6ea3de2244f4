// All cases: parallel coordinates with brushes, one figure over another, and a table; one filter holds in all three.
// A filter is what stands in the field below a column's head: 5..20, >=3, words with | between; a brush writes it there.

/** Return what tells whether a value (number or word) passes a filter's text; null where the text says nothing. */
function passes(text) {
  const wanted = text.trim().replaceAll("−", "-").replace(",", ".");
  if (!wanted) return null;
  const span = wanted.match(/^(-?[\d.]+(?:e-?\d+)?)?\s*\.\.\s*(-?[\d.]+(?:e-?\d+)?)?$/i);
  if (span) {
    const low = span[1] === undefined ? -Infinity : Number(span[1]);
    const high = span[2] === undefined ? Infinity : Number(span[2]);
    return value => value >= low && value <= high;
  }
  const compared = wanted.match(/^(<=|>=|<|>|=)\s*(-?[\d.]+(?:e-?\d+)?)$/i);
  if (compared) {
    const bound = Number(compared[2]);
    return {
      "<": value => value < bound,
      ">": value => value > bound,
      "<=": value => value <= bound,
      ">=": value => value >= bound,
      "=": value => Math.abs(value - bound) <= 1e-6 * Math.abs(bound),
    }[compared[1]];
  }
  const words = wanted.toLowerCase().split("|").map(word => word.trim());
  return (value, shown) => words.some(word => shown.toLowerCase().includes(word));
}

class Explorer {
  constructor(root) {
    const data = dataOf(root.dataset.source);
    this.root = root;
    this.ids = data.ids.match(/.{16}/g) || [];
    this.show = data.show;
    this.columns = data.columns.map((column, place) => ({...column, place, values: unpacked(column.values), filter: ""}));
    this.order = this.ids.map((_, i) => i);
    this.marked = new Set(data.marked || []);
    this.points = data.points;
    this.many = data.rows || 20;
    this.note = data.note || "";
    const lead = this.columns.find(column => column.lead) || this.columns[0];
    this.sorted = {column: lead, falling: !lead.rising};
    this.page = 0;
    this.selected = -1;
    this.build();
    this.sort();
    addEventListener("hashchange", () => this.follow());
    this.follow();
  }

  /** Return a case's value in a column as text. */
  text(column, i) {
    return column.words ? column.words[column.values[i]] ?? "–" : numberText(column.values[i]);
  }

  /** Return the name of a column with its unit. */
  label(column) {
    return column.unit ? `${column.name} [${column.unit}]` : column.name;
  }

  /** Return whether a case is in no filter's way. */
  kept(i) {
    return this.tests.every(([column, test]) => test(column.values[i], this.text(column, i)));
  }

  build() {
    const shown = this.columns.filter(column => column.drawn);
    this.choice = element("details", {class: "choice"}, element("summary", {}, "Columns"));
    for (const column of this.columns) {
      const box = element("input", {type: "checkbox", checked: shown.includes(column), change: () => {
        column.drawn = box.checked;
        this.head();
        this.update();
      }});
      this.choice.append(element("label", {}, box, ` ${this.label(column)}`));
    }
    this.count = element("p", {class: "note", role: "status"});
    this.clear = element("button", {type: "button", click: () => this.unfilter()}, "Show all cases");
    this.lines = element("canvas", {role: "img", "aria-label":
      "Parallel coordinates: each line is a case, each axis a column. The table below has the same filters."});
    this.linesRoom = element("div", {class: "lines"}, this.lines);
    this.dots = element("canvas", {role: "img", "aria-label": "Each point is a case; the table below has the same cases."});
    this.tip = element("div", {class: "tip", hidden: true});
    this.pickers = ["across", "up", "coloured by"].map((name, which) => {
      const select = element("select", {change: () => this.drawDots()});
      for (const column of this.columns) select.append(new Option(this.label(column), column.place));
      return [name, select, which];
    });
    const figures = this.columns.filter(column => !column.axis), axes = this.columns.filter(column => column.axis);
    const first = [axes[0] || figures[1] || figures[0], this.sorted.column, axes[1] || axes[0] || figures[0]];
    this.pickers.forEach(([, select], which) => (select.value = this.points ? this.points[which] : first[which].place));
    this.dotsRoom = element("div", {class: "dots"}, this.dots, this.tip);
    this.detail = element("div", {class: "case note", tabindex: "-1"}, "No case is selected.");
    this.table = element("table");
    this.turn = element("p", {class: "turn"});
    this.root.append(
      element("p", {class: "note"}, "Drag along an axis to select a range, or write one below a column's header: ",
        element("code", {}, "5..20"), ", ", element("code", {}, ">=3"), ", a word. Click a line, a point or a row to show its case. ", this.note),
      element("div", {class: "tools"}, this.count, this.clear, this.choice),
      this.linesRoom,
      element("div", {class: "beside"},
        element("div", {}, element("p", {class: "tools"},
          ...this.pickers.map(([name, select]) => element("label", {}, `${name} `, select))), this.dotsRoom),
        this.detail),
      element("div", {class: "scroll", role: "region", "aria-label": "All cases", tabindex: "0"}, this.table),
      this.turn,
    );
    this.head();
    this.listen();
    redrawn(this.linesRoom, () => this.drawLines());
    redrawn(this.dotsRoom, () => this.drawDots());
  }

  /** Write the head of the table: names that sort, fields that filter. */
  head() {
    const names = element("tr", {}, element("th", {scope: "col"}, "case"));
    const filters = element("tr", {class: "filters"}, element("td"));
    for (const column of this.columns.filter(each => each.drawn)) {
      column.button = element("button", {type: "button", click: () => {
        this.sorted = {column, falling: this.sorted.column === column ? !this.sorted.falling : !column.axis};
        this.sort();
      }}, column.name);
      column.cell = element("th", {scope: "col", class: column.words ? null : "n"}, column.button);
      if (column.unit) column.cell.append(element("small", {}, column.unit));
      column.field = element("input", {value: column.filter, "aria-label": `filter ${this.label(column)}`, size: 7,
        input: () => {
          column.filter = column.field.value;
          this.page = 0;
          this.update();
        }});
      names.append(column.cell);
      filters.append(element("td", {class: column.words ? null : "n"}, column.field));
    }
    this.body = element("tbody");
    this.table.replaceChildren(element("thead", {}, names, filters), this.body);
  }

  unfilter() {
    for (const column of this.columns) {
      column.filter = "";
      if (column.field) column.field.value = "";
    }
    this.update();
  }

  sort() {
    const {column, falling} = this.sorted, sign = falling ? -1 : 1;
    const key = column.words ? i => this.text(column, i) : i => column.values[i];
    const last = value => typeof value === "number" && !Number.isFinite(value);
    this.order = this.ids.map((_, i) => i).sort((a, b) => {
      const [x, y] = [key(a), key(b)];
      if (last(x) || last(y)) return last(x) - last(y) || a - b;
      return sign * (x < y ? -1 : x > y ? 1 : 0) || a - b;
    });
    this.page = 0;
    this.update();
  }

  update() {
    this.tests = this.columns.map(column => [column, passes(column.filter)]).filter(([, test]) => test);
    this.keeps = this.order.filter(i => this.kept(i));
    const left = this.keeps.filter(i => this.marked.has(i)).length;
    this.count.textContent = (this.keeps.length === this.ids.length
      ? `${this.ids.length} cases.` : `${this.keeps.length} of ${this.ids.length} cases.`)
      + (this.marked.size && this.tests.length ? ` ${left} of ${this.marked.size} marked.` : "");
    this.clear.hidden = !this.tests.length;
    for (const column of this.columns.filter(each => each.drawn)) {
      const way = this.sorted.falling ? "descending" : "ascending";
      column.cell.setAttribute("aria-sort", this.sorted.column === column ? way : "none");
      column.field.setAttribute("aria-invalid", String(column.filter !== "" && !this.keeps.length));
    }
    this.rows();
    this.drawLines();
    this.drawDots();
  }

  rows() {
    const many = this.many, pages = Math.max(Math.ceil(this.keeps.length / many), 1);
    this.page = Math.min(this.page, pages - 1);
    const shown = this.columns.filter(column => column.drawn);
    this.body.replaceChildren(...this.keeps.slice(many * this.page, many * (this.page + 1)).map(i =>
      element("tr", {class: i === this.selected ? "selected" : null, click: () => this.select(i)},
        element("td", {class: "id"}, element("button", {type: "button"}, this.ids[i].slice(0, 8))),
        ...shown.map(column => element("td", {class: column.words ? null : "n"}, this.text(column, i))))));
    const step = (text, by) => element("button", {type: "button", disabled: this.page + by < 0 || this.page + by >= pages,
      click: () => {
        this.page += by;
        this.rows();
      }}, text);
    this.turn.replaceChildren(step("Previous", -1), ` page ${this.page + 1} of ${pages} `, step("Next", 1));
  }

  /** Show a case beside the points. */
  select(i) {
    this.selected = i;
    const rows = this.columns.map(column => element("tr", {}, element("th", {scope: "row"}, this.label(column)),
      element("td", {class: "n"}, this.text(column, i))));
    this.detail.replaceChildren(
      element("h3", {}, "Case ", element("span", {class: "id"}, this.ids[i])),
      element("p", {}, ...this.motion(this.ids[i])),
      element("div", {class: "scroll", role: "region", "aria-label": "Figures of the case", tabindex: "0"},
        element("table", {}, element("tbody", {}, ...rows))));
    this.detail.classList.remove("note");
    this.rows();
    this.drawLines();
    this.drawDots();
  }

  /** Return where the motion of a case is to be seen. */
  motion(id) {
    const here = document.getElementById(`motion-${id}`);
    const again = element("code", {}, this.show.replace("CASE", id));
    return here ? [element("a", {href: `#motion-${id}`}, "Its motion"), " is on this page."] : ["Its motion: ", again];
  }

  /** Show the case that the address names, as a cell of a map does. */
  follow() {
    const wanted = location.hash.match(/^#case-([0-9a-f]+)$/);
    const i = wanted ? this.ids.indexOf(wanted[1]) : -1;
    if (i >= 0) {
      this.select(i);
      this.root.scrollIntoView();
      this.detail.focus({preventScroll: true});
    }
  }

  /** Return where a value stands between the ends of its column: 0 to 1. */
  share(column, i) {
    const value = column.values[i];
    if (column.words) return column.words.length > 1 ? value / (column.words.length - 1) : 0.5;
    const [low, high] = this.ends(column), scaled = column.wide ? Math.log : Number;
    return high > low ? (scaled(value) - scaled(low)) / (scaled(high) - scaled(low)) : 0.5;
  }

  /** Return the value that stands at a share of a column. */
  at(column, share) {
    const [low, high] = this.ends(column);
    return column.wide ? low * (high / low) ** share : low + (high - low) * share;
  }

  ends(column) {
    if (!column.ends) {
      const known = column.values.filter(Number.isFinite);
      column.ends = [known.reduce((a, b) => Math.min(a, b), Infinity), known.reduce((a, b) => Math.max(a, b), -Infinity)];
    }
    return column.ends;
  }

  drawLines() {
    const width = this.linesRoom.clientWidth, shown = this.columns.filter(column => column.drawn);
    if (!width || !this.keeps) return;
    const least = 92, span = Math.max(width, least * shown.length), height = 300, top = 44, bottom = 20;
    const context = sharp(this.lines, span, height), step = span / shown.length;
    this.places = shown.map((column, k) => ({column, x: (k + 0.5) * step, top, high: height - top - bottom}));
    const path = i => {
      let drawing = false;
      for (const {column, x, high} of this.places) {
        const share = this.share(column, i);
        if (!Number.isFinite(share)) { drawing = false; continue; }
        const y = top + (1 - share) * high;
        if (drawing) context.lineTo(x, y); else context.moveTo(x, y);
        drawing = true;
      }
    };
    const draw = (which, style, alpha, thick) => {
      context.strokeStyle = style;
      context.globalAlpha = alpha;
      context.lineWidth = thick;
      for (const i of which) { context.beginPath(); path(i); context.stroke(); }
    };
    if (this.tests.length) draw(thinned(this.order), colour("line"), 0.5, 1);
    draw(thinned(this.keeps), colour("accent"), Math.min(Math.max(60 / this.keeps.length, 0.05), 0.7), 1);
    draw(this.keeps.filter(i => this.marked.has(i)), colour("mark"), 0.9, 1.5);
    if (this.selected >= 0) draw([this.selected], colour("mark"), 1, 3);
    context.globalAlpha = 1;
    context.textAlign = "center";
    for (const {column, x, high} of this.places) {
      context.strokeStyle = context.fillStyle = colour("soft");
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(x, top);
      context.lineTo(x, top + high);
      context.stroke();
      const [low, most] = column.words ? [column.words[0], column.words.at(-1)] : this.ends(column).map(numberText);
      context.fillText(most, x, top - 6, step - 4);
      context.fillText(low, x, height - 5, step - 4);
      context.fillStyle = colour("ink");
      context.fillText(column.name, x, 13, step - 6);
      context.fillStyle = colour("soft");
      context.fillText(column.unit, x, 26, step - 6);
      if (column.brush) {
        context.fillStyle = colour("accent");
        context.globalAlpha = 0.25;
        const [a, b] = column.brush;
        context.fillRect(x - 8, top + (1 - b) * high, 16, (b - a) * high);
        context.globalAlpha = 1;
      }
      if (!column.filter) column.brush = null;
    }
  }

  drawDots() {
    const width = this.dotsRoom.clientWidth;
    if (!width || !this.keeps) return;
    const height = 320, left = 62, bottom = 40, [across, up, tint] = this.pickers.map(([, select]) => this.columns[select.value]);
    const context = sharp(this.dots, width, height), room = [width - left - 14, height - bottom - 14];
    const place = i => [left + this.share(across, i) * room[0], 10 + (1 - this.share(up, i)) * room[1]];
    context.strokeStyle = colour("line");
    context.fillStyle = colour("soft");
    for (let k = 0; k <= 4; k++) {
      const x = left + (k / 4) * room[0], y = 10 + (1 - k / 4) * room[1];
      context.strokeRect(left, y, room[0], 0);
      context.textAlign = "right";
      context.fillText(this.tick(up, k / 4), left - 6, y + 4, left - 8);
      context.textAlign = k === 4 ? "right" : "center";
      context.fillText(this.tick(across, k / 4), x, height - bottom + 14);
    }
    context.textAlign = "center";
    context.fillStyle = colour("ink");
    context.fillText(this.label(across), left + room[0] / 2, height - 6);
    context.save();
    context.rotate(-Math.PI / 2);
    context.fillText(this.label(up), -(10 + room[1] / 2), 11);
    context.restore();
    this.spots = thinned(this.keeps).map(i => [i, ...place(i)]).filter(([, x, y]) => Number.isFinite(x + y));
    for (const [i, x, y] of this.spots) {
      context.strokeStyle = colour(this.marked.has(i) ? "mark" : "soft");
      context.lineWidth = this.marked.has(i) ? 2.5 : 0.5;
      context.fillStyle = viridis(this.share(tint, i));
      context.beginPath();
      context.arc(x, y, this.spots.length > 500 ? 2.5 : 4, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
    if (this.selected >= 0) {
      context.strokeStyle = colour("mark");
      context.lineWidth = 2;
      context.beginPath();
      context.arc(...place(this.selected), 7, 0, 2 * Math.PI);
      context.stroke();
    }
  }

  tick(column, share) {
    if (!column.words) return numberText(Number(this.at(column, share).toPrecision(3)));
    const place = share * (column.words.length - 1);
    return Number.isInteger(place) ? column.words[place] : "";
  }

  listen() {
    let begun = null;
    const found = event => {
      const box = this.lines.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
      const near = this.places.reduce((a, b) => (Math.abs(a.x - x) < Math.abs(b.x - x) ? a : b));
      return {x, y, near, share: Math.min(Math.max(1 - (y - near.top) / near.high, 0), 1)};
    };
    this.lines.addEventListener("pointerdown", event => {
      const at = found(event);
      if (Math.abs(at.near.x - at.x) < 14) {
        begun = at;
        this.lines.setPointerCapture(event.pointerId);
      } else this.pick(at);
    });
    this.lines.addEventListener("pointermove", event => {
      const at = found(event);
      this.lines.style.cursor = Math.abs(at.near.x - at.x) < 14 ? "ns-resize" : "pointer";
      if (begun) this.brush(begun.near.column, begun.share, found(event).share);
    });
    this.lines.addEventListener("pointerup", event => {
      if (begun) this.brush(begun.near.column, begun.share, found(event).share);
      begun = null;
    });
    const over = event => {
      const box = this.dots.getBoundingClientRect();
      return nearest(this.spots || [], event.clientX - box.left, event.clientY - box.top, 12);
    };
    this.dots.addEventListener("pointermove", event => {
      const i = over(event);
      this.tip.hidden = i < 0;
      if (i < 0) return;
      const columns = new Set([...this.columns.filter(column => column.axis),
        ...this.pickers.map(([, select]) => this.columns[select.value])]);
      this.tip.replaceChildren(...[...columns].map(column => element("div", {}, `${column.name} `,
        element("b", {}, `${this.text(column, i)} ${column.words ? "" : column.unit}`))));
      const [, x, y] = this.spots.find(spot => spot[0] === i);
      this.tip.style.left = `${Math.min(x + 12, this.dotsRoom.clientWidth - this.tip.offsetWidth - 4)}px`;
      this.tip.style.top = `${y + 12}px`;
    });
    this.dots.addEventListener("pointerleave", () => (this.tip.hidden = true));
    this.dots.addEventListener("click", event => {
      const i = over(event);
      if (i >= 0) this.select(i);
    });
  }

  /** Keep what lies between two shares of a column; a click without a way lets all pass. */
  brush(column, from, to) {
    const [low, high] = [Math.min(from, to), Math.max(from, to)];
    column.brush = high - low > 0.01 ? [low, high] : null;
    if (column.words) {
      const names = column.words.filter((_, k) => k / Math.max(column.words.length - 1, 1) >= low - 1e-9
        && k / Math.max(column.words.length - 1, 1) <= high + 1e-9);
      column.filter = column.brush ? names.join(" | ") : "";
    } else {
      const text = share => this.at(column, share).toPrecision(5).replace(/e\+?/, "e");
      column.filter = column.brush ? `${text(low)}..${text(high)}` : "";
    }
    if (column.field) column.field.value = column.filter;
    this.page = 0;
    this.update();
  }

  /** Select the line that passes nearest between two axes. */
  pick(at) {
    const [a, b] = this.places.findLast(place => place.x <= at.x) === undefined
      ? [this.places[0], this.places[0]]
      : [this.places.findLast(place => place.x <= at.x), this.places.find(place => place.x > at.x) || this.places.at(-1)];
    const share = b.x > a.x ? (at.x - a.x) / (b.x - a.x) : 0;
    const spots = this.keeps.map(i => [i, at.x,
      a.top + (1 - (1 - share) * this.share(a.column, i) - share * this.share(b.column, i)) * a.high]);
    const i = nearest(spots.filter(spot => Number.isFinite(spot[2])), at.x, at.y, 10);
    if (i >= 0) this.select(i);
  }
}

/** Return the first of [i, x, y] that is nearest to a place, -1 where none is within `reach`. */
function nearest(spots, x, y, reach) {
  let best = -1, least = reach * reach;
  for (const [i, a, b] of spots) {
    const square = (a - x) ** 2 + (b - y) ** 2;
    if (square < least) [best, least] = [i, square];
  }
  return best;
}

/** Return at most 5,000 of many, evenly taken. */
function thinned(many) {
  const step = Math.ceil(many.length / 5000);
  return step > 1 ? many.filter((_, k) => k % step === 0) : many;
}

const VIRIDIS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

/** Return a colour of viridis at a share. */
function viridis(share) {
  const x = 4 * Math.min(Math.max(Number.isFinite(share) ? share : 0, 0), 1), k = Math.min(Math.floor(x), 3);
  return `rgb(${VIRIDIS[k].map((from, c) => Math.round(from + (x - k) * (VIRIDIS[k + 1][c] - from))).join()})`;
}

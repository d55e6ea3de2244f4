// One case in motion: the mechanism, the journals in their bearings, and histories under one cursor.

class Player {
  constructor(root) {
    const data = dataOf(root.dataset.source);
    this.root = root;
    this.angle = unpacked(data.angle);
    this.time = data.time && unpacked(data.time);  // of a start-up, whose histories are over time
    this.along = this.time || this.angle;
    this.walls = data.walls;
    this.ground = data.ground.map(support => support.x ? {...support, x: unpacked(support.x), y: unpacked(support.y)} : support);
    this.bodies = data.bodies.map(body => ({...body, x: unpacked(body.x), y: unpacked(body.y), angle: unpacked(body.angle),
      bend: body.bend && {...body.bend, deflection: unpacked(body.bend.deflection)}}));
    this.joints = data.joints.map(joint => ({...joint, x: unpacked(joint.x), y: unpacked(joint.y), force: unpacked(joint.force),
      walls: joint.walls && {...joint.walls, tilt: unpacked(joint.walls.tilt)},
      elements: joint.elements && {...joint.elements, angle: unpacked(joint.elements.angle), loads: joint.elements.loads.map(unpacked)}}));
    this.charts = data.charts.map(chart => ({...chart, lines: chart.lines.map(line => ({...line, values: unpacked(line.values)}))}));
    this.now = 0;
    this.build();
    redrawn(this.stage, () => this.resize());
  }

  build() {
    this.play = element("button", {type: "button", click: () => this.toggle()}, "Play");
    this.slider = element("input", {type: "range", min: 0, max: this.angle.length - 1, value: 0, step: 1,
      "aria-label": this.time ? "time" : "crank angle", input: () => this.go(Number(this.slider.value))});
    const step = by => element("button", {type: "button", "aria-label": by < 0 ? "one sample back" : "one sample on",
      click: () => this.go(this.now + by)}, by < 0 ? "◀" : "▶");
    this.pace = element("select", {"aria-label": "pace"},
      ...[4, 10, 30].map(seconds => new Option(this.time ? `${seconds} s in all` : `${seconds} s a turn`, seconds)));
    this.where = element("output");
    this.picture = element("canvas", {role: "img", "aria-label": "The mechanism in motion"});
    this.stage = element("div", {class: "stage"}, this.picture, ...this.bodies.filter(body => body.bend).map(body =>
      element("span", {}, `Deflection of ${body.bend.name} drawn ${numberText(body.bend.magnified)} times as large`)),
      ...this.ground.filter(support => support.x).map(support =>
      element("span", {}, `Motion of the housing of ${support.name} drawn ${numberText(support.magnified)} times as large`)));
    this.rings = this.joints.map(joint => {
      const canvas = element("canvas", {role: "img", "aria-label": joint.walls ? `Joint ${joint.name} between its walls` : `Journal of ${joint.name} in its bearing`});
      const said = joint.elements ? "loads of the elements, the largest as long as an element is wide"
        : `clearance ${joint.said}${joint.magnified > 1 ? `; penetration drawn ${numberText(joint.magnified)} times as deep` : ""}`;
      return element("figure", {"aria-label": `${joint.walls ? "Joint" : "Journal of"} ${joint.name}`}, element("figcaption", {},
        element("strong", {}, joint.name), element("span", {}, said)), canvas);
    });
    this.curves = element("div", {class: "curves"});
    this.root.append(element("p", {class: "tools"}, this.play, step(-1), step(1), this.slider, this.pace, this.where),
      element("div", {class: "moving"}, this.stage, ...this.rings), this.curves);
  }

  toggle() {
    this.playing = !this.playing;
    this.play.textContent = this.playing ? "Pause" : "Play";
    if (!this.playing) return;
    let before = null, place = this.along[this.now];
    const pace = this.time ? this.along.at(-1) - this.along[0] : 360;
    const next = moment => {
      if (!this.playing) return;
      if (before !== null) place += ((moment - before) / 1000 / Number(this.pace.value)) * pace;
      before = moment;
      if (place >= this.along.at(-1)) place = this.along[0];
      let shown = place < this.along[this.now] ? 0 : this.now;
      while (this.along[shown + 1] <= place) shown++;
      this.go(shown);
      requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
  }

  /** Show a sample. */
  go(place) {
    this.now = Math.min(Math.max(Math.round(place), 0), this.angle.length - 1);
    this.slider.value = this.now;
    const angle = `${numberText(Math.round(this.angle[this.now] * 1e6) / 1e6)}°`;
    this.where.textContent = this.time ? `${numberText(this.time[this.now])} s, ${angle}` : angle;
    this.slider.setAttribute("aria-valuetext", this.where.textContent);
    this.drawMechanism();
    this.joints.forEach((joint, j) => {
      const canvas = this.rings[j].querySelector("canvas");
      if (joint.walls) this.drawBetweenWalls(joint, canvas);
      else if (joint.elements) this.drawElements(joint, canvas);
      else this.drawJournal(joint, canvas);
    });
    this.mark();
    (this.said || []).forEach((said, k) => {
      const chart = this.charts[k];
      said.replaceChildren(element("strong", {}, capital(chart.name) + (chart.unit ? ` [${chart.unit}]` : "")), ...chart.lines.flatMap(line =>
        [" ", element("span", {style: `border-bottom: 2px solid ${colour(line.colour)}`}, line.name), ` ${numberText(line.values[this.now])} ${chart.unit}`]));
    });
  }

  resize() {
    if (!this.stage.clientWidth) return;
    for (const {plot} of this.plots || []) plot.destroy();
    this.curves.replaceChildren();
    const width = this.curves.clientWidth, line = {stroke: colour("line"), width: 1};
    const axis = {stroke: colour("ink"), grid: line, ticks: line, font: "12px system-ui, sans-serif"};
    const height = Math.min(Math.max(Math.round(ROOM / this.charts.length), SMALLEST), LARGEST);
    this.said = [];
    this.plots = this.charts.map(chart => {
      const said = element("p", {class: "said"});
      this.curves.append(said);
      this.said.push(said);
      const marker = element("div", {class: "marker"});
      const plot = new uPlot({
        width, height,
        scales: {x: {time: false}},
        legend: {show: false},
        cursor: {y: false, drag: {x: true, y: false}, sync: {key: this.root.dataset.source}},
        axes: [this.time ? {...axis, size: 34, values: (_, ticks) => ticks.map(tick => `${numberText(tick)} s`)}
          : {...axis, size: 34, incrs: [15, 30, 45, 90, 180, 360, 720, 1440], values: (_, ticks) => ticks.map(tick => `${tick}°`)},
          {...axis, size: 56, space: 20, values: (_, ticks) => ticks.map(numberText)}],
        series: [{}, ...chart.lines.map(each => ({width: 1.25, stroke: colour(each.colour), dash: each.dashed ? [6, 4] : undefined}))],
        hooks: {setCursor: [plot => {
          if (plot.cursor.event && plot.cursor.idx != null && plot.cursor.left >= 0) this.go(plot.cursor.idx);
        }], setScale: [() => this.mark()]},
      }, [this.along, ...chart.lines.map(each => each.values)], this.curves);
      plot.over.append(marker);
      return {plot, marker};
    });
    this.go(this.now);
  }

  /** Put the markers of the curves where the shown sample is. */
  mark() {
    const first = this.along[0], share = (this.along[this.now] - first) / (this.along.at(-1) - first || 1);
    for (const {plot, marker} of this.plots || []) {
      const {min, max} = plot.scales.x, zoomed = min != null && max > min;
      const place = zoomed ? (this.along[this.now] - min) / (max - min) : share;
      marker.hidden = place < 0 || place > 1;
      marker.style.left = `${100 * place}%`;
    }
  }

  /** Return points of a body at a sample, in m: those of its joints, or others of its drawing at the start. */
  points(body, k, those = body.points) {
    const turn = body.angle[k] - body.began, c = Math.cos(turn), s = Math.sin(turn);
    return those.map(([x, y]) => [body.x[k] + c * x - s * y, body.y[k] + s * x + c * y]);
  }

  /** Return points of the line of a link that bends, its deflection magnified. */
  bent(body) {
    const [[x, y], [farX, farY]] = this.points(body, this.now, body.bend.ends), steps = 24;
    const length = Math.hypot(farX - x, farY - y) || 1, most = body.bend.magnified * body.bend.deflection[this.now];
    return Array.from({length: steps + 1}, (_, k) => {
      const share = k / steps, off = (most * Math.sin(Math.PI * share)) / length;
      return [x + share * (farX - x) - off * (farY - y), y + share * (farY - y) + off * (farX - x)];
    });
  }

  drawMechanism() {
    if (!this.limits) {
      const all = this.bodies.flatMap(body => Array.from(this.angle, (_, k) =>
        this.points(body, k, [...body.points, ...body.walls.flat()])).flat()).concat(this.walls.flat());
      const xs = all.map(point => point[0]), ys = all.map(point => point[1]);
      const least = values => values.reduce((a, b) => Math.min(a, b)), most = values => values.reduce((a, b) => Math.max(a, b));
      this.limits = [least(xs), most(xs), least(ys), most(ys)];
    }
    const [left, right, low, high] = this.limits, width = this.stage.clientWidth, margin = 24;
    const scale = Math.min((width - 2 * margin) / (right - left || 1), 240 / (high - low || 1e-9));
    const height = Math.max((high - low) * scale + 2 * margin, 90), context = sharp(this.picture, width, height);
    const at = ([x, y]) => [margin + (x - left) * scale, height - margin - (y - low) * scale];
    context.lineCap = context.lineJoin = "round";
    for (const support of this.ground) {
      const moved = support.x ? support.magnified : 0, [restX, restY] = support.place;
      const [x, y] = at(moved ? [restX + moved * support.x[this.now], restY + moved * support.y[this.now]] : support.place);
      context.fillStyle = colour(moved ? "mark" : "line");
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(x - 10, y + 16);
      context.lineTo(x + 10, y + 16);
      context.fill();
    }
    const outline = (wall, stroke) => {
      context.strokeStyle = stroke;
      context.lineWidth = 1.5;
      context.beginPath();
      wall.map(at).forEach(point => context.lineTo(...point));
      context.stroke();
    };
    this.walls.forEach(wall => outline(wall, colour("ink")));
    this.bodies.forEach((body, number) => {
      body.walls.forEach(wall => outline(this.points(body, this.now, wall), BODY_COLOURS[number % BODY_COLOURS.length]));
      const points = this.points(body, this.now).map(at);
      context.strokeStyle = context.fillStyle = BODY_COLOURS[number % BODY_COLOURS.length];
      context.lineWidth = 5;
      context.beginPath();
      (body.bend ? this.bent(body).map(at) : points).forEach(point => context.lineTo(...point));
      if (points.length > 2 && !body.bend) context.closePath();
      if (points.length > 1) context.stroke();
      else context.fillRect(points[0][0] - 14, points[0][1] - 9, 28, 18);
      for (const point of points) {
        context.beginPath();
        context.arc(...point, 4, 0, 2 * Math.PI);
        context.fillStyle = colour("paper");
        context.fill();
        context.lineWidth = 1.5;
        context.strokeStyle = colour("ink");
        context.stroke();
        context.strokeStyle = context.fillStyle = BODY_COLOURS[number % BODY_COLOURS.length];
      }
    });
  }

  /** Draw a block in a guide, or a pin in a slot, between walls a clearance apart from its middle on each side. */
  drawBetweenWalls(joint, canvas) {
    const width = Math.min(canvas.parentElement.clientWidth, 260), height = 0.6 * width, context = sharp(canvas, width, height);
    const half = joint.walls.half_length, gap = 0.3 * height, middle = height / 2;
    const left = joint.x.reduce((a, b) => Math.min(a, b)) - half, right = joint.x.reduce((a, b) => Math.max(a, b)) + half;
    const across = y => {
      const beyond = Math.max(Math.abs(y) - joint.clearance, 0);
      return middle - (Math.sign(y) * (Math.min(Math.abs(y), joint.clearance) + joint.magnified * beyond) / joint.clearance) * gap;
    };
    const along = x => 8 + ((x - left) / (right - left || 1)) * (width - 16);
    const line = (from, to, stroke, thickness) => {
      context.strokeStyle = stroke;
      context.lineWidth = thickness;
      context.beginPath();
      for (let k = from; k <= to; k++) context.lineTo(along(joint.x[k]), across(joint.y[k]));
      context.stroke();
    };
    context.strokeStyle = colour("ink");
    context.lineWidth = 1;
    context.beginPath();
    for (const wall of [middle - gap, middle + gap]) {
      context.moveTo(0, wall);
      context.lineTo(width, wall);
    }
    context.stroke();
    line(0, this.angle.length - 1, colour("soft"), 0.6);
    line(Math.max(this.now - 60, 0), this.now, colour("accent"), 2);
    const x = joint.x[this.now], y = joint.y[this.now], rise = half * Math.sin(joint.walls.tilt[this.now]);
    context.strokeStyle = context.fillStyle = joint.force[this.now] > 0 ? colour("mark") : colour("accent");
    context.lineWidth = 5;
    context.beginPath();
    context.moveTo(along(x - half), across(y - rise));
    context.lineTo(along(x + half), across(y + rise));
    context.stroke();
    context.beginPath();
    context.arc(along(x), across(y), 5, 0, 2 * Math.PI);
    context.fill();
    this.drawForce(joint, context, height);
  }

  /** Draw a rolling bearing with its elements where the cage has turned them, and their loads as bars inward. */
  drawElements(joint, canvas) {
    const size = Math.min(canvas.parentElement.clientWidth, 260), context = sharp(canvas, size, size);
    const {angle, loads, share} = joint.elements, middle = size / 2, pitch = (0.44 * size) / (1 + share), half = share * pitch;
    const circle = (x, y, radius, stroke) => {
      context.strokeStyle = stroke;
      context.lineWidth = 1.2;
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      context.stroke();
    };
    circle(middle, middle, pitch + half, colour("ink"));
    circle(middle, middle, pitch - half, colour("ink"));
    loads.forEach((load, i) => {
      const turn = angle[this.now] + (2 * Math.PI * i) / loads.length, c = Math.cos(turn), s = -Math.sin(turn);
      circle(middle + pitch * c, middle + pitch * s, half, colour(load[this.now] > 0 ? "accent" : "soft"));
      const inner = pitch - half, end = inner - 2 * half * load[this.now];
      context.strokeStyle = colour("mark");
      context.lineWidth = 3;
      context.beginPath();
      context.moveTo(middle + inner * c, middle + inner * s);
      context.lineTo(middle + end * c, middle + end * s);
      context.stroke();
    });
    this.drawForce(joint, context, size);
  }

  drawForce(joint, context, height) {
    context.fillStyle = colour("soft");
    context.textAlign = "left";
    context.fillText(`${numberText(joint.force[this.now])} ${joint.unit}`, 4, height - 6);
  }

  drawJournal(joint, canvas) {
    const size = Math.min(canvas.parentElement.clientWidth, 260), context = sharp(canvas, size, size);
    const middle = size / 2, stretched = out =>
      (Math.min(out, joint.clearance) + joint.magnified * Math.max(out - joint.clearance, 0)) / joint.clearance;
    joint.reach ??= joint.x.reduce((most, x, k) => Math.max(most, stretched(Math.hypot(x, joint.y[k]))), 1.25);
    const radius = 0.45 * size / joint.reach;
    const drawn = k => {
      const out = Math.hypot(joint.x[k], joint.y[k]) || 1e-30, length = stretched(out);
      return [middle + (joint.x[k] / out) * length * radius, middle - (joint.y[k] / out) * length * radius];
    };
    context.strokeStyle = colour("ink");
    context.lineWidth = 1;
    context.beginPath();
    context.arc(middle, middle, radius, 0, 2 * Math.PI);
    context.stroke();
    context.strokeStyle = colour("soft");
    context.lineWidth = 0.6;
    context.beginPath();
    for (let k = 0; k < this.angle.length; k++) context.lineTo(...drawn(k));
    context.stroke();
    context.strokeStyle = colour("accent");
    context.lineWidth = 2;
    context.beginPath();
    for (let k = Math.max(this.now - 60, 0); k <= this.now; k++) context.lineTo(...drawn(k));
    context.stroke();
    const [x, y] = drawn(this.now), most = joint.most || 1;
    context.fillStyle = joint.force[this.now] > 0 ? colour("mark") : colour("accent");
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fill();
    if (joint.force[this.now] > 0) {
      const out = Math.hypot(x - middle, y - middle) || 1, long = 0.3 * size * (joint.force[this.now] / most);
      context.strokeStyle = colour("mark");
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(x - ((x - middle) / out) * long, y - ((y - middle) / out) * long);
      context.stroke();
    }
    this.drawForce(joint, context, size);
  }
}

function capital(text) {
  return text[0].toUpperCase() + text.slice(1);
}

const ROOM = 402, SMALLEST = 88, LARGEST = 134;  // px, height of all curves together, and of each
const BODY_COLOURS = ["#0072B2", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#8C6D31"];

// Wear round the bodies of a joint, of the case that is chosen.

class Worn {
  constructor(root) {
    const data = dataOf(root.dataset.source);
    const shares = text => Array.from(atob(text), char => char.charCodeAt(0) / 255);
    this.cases = data.cases.map(each => ({...each, depths: each.depths.map(shares)}));
    this.choice = element("select", {"aria-label": "case", change: () => this.draw()},
      ...this.cases.map((each, place) => new Option(each.name, place)));
    this.bodies = data.bodies.map((name, place) => ({
      colour: ["accent", "mark"][place],
      words: element("span"),
      canvas: element("canvas", {role: "img", "aria-label": `Wear depth: ${name}`}),
      name,
    }));
    const tools = element("p", {class: "tools"}, element("label", {}, data.title, this.choice));
    root.append(tools,
      element("div", {class: "grid"}, ...this.bodies.map(body => element("figure", {"aria-label": body.name},
        element("figcaption", {}, element("strong", {}, body.name), body.words), body.canvas))));
    redrawn(tools, () => this.draw()); // its height does not change with what is drawn
  }

  draw() {
    const chosen = this.cases[Number(this.choice.value)];
    this.bodies.forEach((body, place) => {
      body.words.textContent = chosen.said[place];
      this.round(body, chosen.depths[place], chosen.mean[place], chosen.most);
    });
  }

  /** Draw the depths round a body, over the depth `most` for which the rim stands. */
  round(body, depth, mean, most) {
    const size = Math.min(body.canvas.parentElement.clientWidth, 320);
    if (size < 100) return; // it is not laid out
    const middle = size / 2, reach = middle - 26, turn = 2 * Math.PI / depth.length;
    const pen = sharp(body.canvas, size, size), ink = colour("ink"), soft = colour("soft"), line = colour("line");
    const at = (angle, r) => [middle + r * Math.cos(angle), middle - r * Math.sin(angle)];
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    const ring = (r, style, dashes) => {
      pen.strokeStyle = style;
      pen.setLineDash(dashes);
      pen.beginPath();
      pen.arc(middle, middle, r, 0, 2 * Math.PI);
      pen.stroke();
    };
    for (let k = 1; k <= 4; k++) ring(reach * k / 4, line, []);
    for (let k = 0; k < 8; k++) {
      pen.beginPath();
      pen.moveTo(middle, middle);
      pen.lineTo(...at(k * Math.PI / 4, reach));
      pen.stroke();
      pen.fillStyle = soft;
      pen.fillText(`${45 * k}°`, ...at(k * Math.PI / 4, reach + 15));
    }
    if (mean > 0) {
      const shape = new Path2D(), deepest = depth.indexOf(Math.max(...depth));
      depth.forEach((share, k) => shape.lineTo(...at((k + 0.5) * turn, reach * share)));
      shape.closePath();
      pen.fillStyle = pen.strokeStyle = colour(body.colour);
      pen.globalAlpha = 0.25;
      pen.fill(shape);
      pen.globalAlpha = 1;
      pen.stroke(shape);
      pen.beginPath();
      pen.arc(...at((deepest + 0.5) * turn, reach * depth[deepest]), 3.5, 0, 2 * Math.PI);
      pen.fill();
      ring(reach * mean, ink, [2, 3]);
      pen.setLineDash([]);
    }
    pen.fillStyle = ink;
    pen.fillText(most, ...at(Math.PI * 0.375, reach - 8));
  }
}

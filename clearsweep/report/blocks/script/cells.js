// Cells of a map that lead to their cases: Tab reaches the first, the arrow keys reach the others.

const DIRECTIONS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};

class Cells {
  constructor(map) {
    this.links = [...map.querySelectorAll("a:has(.spot)")];
    this.links.forEach((link, place) => link.setAttribute("tabindex", place ? -1 : 0));
    map.addEventListener("keydown", event => {
      const here = event.target.closest("a"), way = DIRECTIONS[event.key];
      const next = way && here && this.next(here, way);
      if (!next) return;
      event.preventDefault();
      here.setAttribute("tabindex", -1);
      next.setAttribute("tabindex", 0);
      next.focus();
    });
  }

  /** Return the nearest cell in a direction, undefined at the edge of the map. */
  next(here, [across, down]) {
    const middle = link => { const box = link.getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]; };
    const [x, y] = middle(here);
    const candidates = this.links.map(link => {
      const [toX, toY] = middle(link), forward = across * (toX - x) + down * (toY - y);
      return {link, forward, aside: Math.abs(across ? toY - y : toX - x)};
    }).filter(each => each.forward > 1);
    return candidates.sort((a, b) => a.forward + 10 * a.aside - b.forward - 10 * b.aside)[0]?.link;
  }
}

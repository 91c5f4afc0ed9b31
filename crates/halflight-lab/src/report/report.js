"use strict";
// Sortable tables.
for (const table of document.querySelectorAll("table.sortable")) {
  const value = (row, column) => {
    const text = row.cells[column].textContent.replace(/[,‡]/g, "").trim();
    return text !== "" && !isNaN(text) ? Number(text) : text;
  };
  table.querySelectorAll("th").forEach((head, column) => head.addEventListener("click", () => {
    const up = !head.classList.contains("up");
    table.querySelectorAll("th").forEach(other => other.classList.remove("up", "down"));
    head.classList.add(up ? "up" : "down");
    const order = (a, b) => typeof a === typeof b ? (a < b ? -1 : a > b ? 1 : 0) : typeof a === "number" ? -1 : 1;
    const body = table.tBodies[0];
    const rows = [...body.rows].sort((a, b) => order(value(a, column), value(b, column)) * (up ? 1 : -1));
    body.append(...rows);
  }));
}

// A viewer a setting: two images at the same place, one of them visible.
const LAYERS = ["picture", "fragments", "error", "squared error", "failures"];
let active = null;

function element(name, parent, text = "") {
  const made = document.createElement(name);
  made.textContent = text;
  parent.append(made);
  return made;
}

class Viewer {
  constructor(root) {
    this.root = root;
    this.setting = SETTINGS[root.dataset.setting];
    this.table = document.querySelector(`table[data-setting="${root.dataset.setting}"]`);
    this.side = 0;
    this.layer = 0;
    this.scale = 1;
    this.x = this.y = 0;
    this.chosen = this.firstChoice();
    const bar = element("div", root);
    bar.className = "bar";
    this.which = element("button", bar, "A");
    this.which.className = "which";
    this.which.title = "switch between A and B (x, or click the picture)";
    this.which.onclick = () => this.toggle();
    this.selects = ["A", "B"].map((name, side) => {
      const select = element("select", element("label", bar, name + " "));
      this.choices().forEach((choice, index) => element("option", select, choice).value = index);
      select.onchange = () => this.choose(side, Number(select.value));
      return select;
    });
    this.layers = LAYERS.filter(name => this.setting.rows.some(row => name in row.files));
    this.buttons = this.layers.map((name, layer) => {
      const button = element("button", bar, `${layer + 1} ${name}`);
      button.onclick = () => { this.layer = layer; this.show(); };
      return button;
    });
    for (const [text, factor] of [["−", 0.5], ["+", 2]]) {
      element("button", bar, text).onclick = () => this.zoom(factor, this.stage.clientWidth / 2, this.stage.clientHeight / 2);
    }
    element("button", bar, "1:1").onclick = () => { this.scale = 1; this.x = this.y = 0; this.place(); };
    element("span", bar, `click or x: A/B · 1–${this.layers.length}: layer · wheel or +/−: zoom · drag: move`);
    this.stage = element("div", root);
    this.stage.className = "stage";
    this.stage.style.width = Math.max(this.setting.width, 640) + "px";
    this.stage.style.height = Math.min(Math.max(this.setting.height, 480), 960) + "px";
    if (this.setting.width < 640) this.scale = Math.floor(640 / this.setting.width);
    this.images = [0, 1].map(() => element("img", this.stage));
    this.listen();
    this.show();
  }
  // The most accurate row that is not Monte Carlo, and the reference.
  firstChoice() {
    const rows = this.setting.rows.map((row, index) => ({ index: index + 1, error: row.error, perPixel: row.row.startsWith("per-pixel") }));
    const best = rows.sort((a, b) => a.perPixel - b.perPixel || a.error - b.error)[0];
    return [best.index, 0];
  }
  choices() {
    return ["reference", ...this.setting.rows.map(row => `${row.label} (${row.error.toExponential(2)}, ${row.ms.toFixed(1)} ms)`)];
  }
  choose(side, index) {
    this.chosen[side] = index;
    this.side = side;
    this.show();
  }
  file(side) {
    const index = this.chosen[side];
    if (index === 0) return this.setting.reference;
    const files = this.setting.rows[index - 1].files;
    return files[this.layers[this.layer]] ?? files.picture;
  }
  toggle() { this.side = 1 - this.side; this.show(); }
  show() {
    active = this;
    this.images.forEach((image, side) => {
      if (image.getAttribute("src") !== this.file(side)) image.src = this.file(side);
      image.classList.toggle("hidden", side !== this.side);
      this.selects[side].value = this.chosen[side];
    });
    this.root.classList.toggle("b", this.side === 1);
    this.which.textContent = "AB"[this.side];
    this.buttons.forEach((button, layer) => button.classList.toggle("on", layer === this.layer));
    for (const row of this.table.tBodies[0].rows) {
      const index = 1 + this.setting.rows.findIndex(other => other.row === row.dataset.row);
      row.classList.toggle("a", index === this.chosen[0]);
      row.classList.toggle("b", index === this.chosen[1]);
    }
    this.place();
  }
  place() {
    for (const image of this.images) image.style.transform = `translate(${this.x}px, ${this.y}px) scale(${this.scale})`;
  }
  zoom(factor, x, y) {
    const scale = Math.min(Math.max(this.scale * factor, 0.25), 32);
    this.x = x - (x - this.x) * scale / this.scale;
    this.y = y - (y - this.y) * scale / this.scale;
    this.scale = scale;
    this.place();
  }
  listen() {
    const stage = this.stage;
    let moved = 0;
    stage.addEventListener("pointerdown", event => { moved = 0; active = this; stage.setPointerCapture(event.pointerId); });
    stage.addEventListener("pointermove", event => {
      if (event.buttons === 0) return;
      moved += Math.abs(event.movementX) + Math.abs(event.movementY);
      this.x += event.movementX;
      this.y += event.movementY;
      this.place();
    });
    stage.addEventListener("pointerup", () => { if (moved < 4) this.toggle(); });
    stage.addEventListener("pointerenter", () => active = this);
    stage.addEventListener("wheel", event => {
      event.preventDefault();
      const box = stage.getBoundingClientRect();
      this.zoom(event.deltaY < 0 ? 2 : 0.5, event.clientX - box.left, event.clientY - box.top);
    }, { passive: false });
    this.table.tBodies[0].addEventListener("click", event => {
      const row = event.target.closest("tr");
      const index = 1 + this.setting.rows.findIndex(other => other.row === row.dataset.row);
      this.choose(event.shiftKey ? 1 : 0, index);
    });
  }
}

document.querySelectorAll(".viewer").forEach(root => new Viewer(root));
document.addEventListener("keydown", event => {
  if (active === null || event.target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey) return;
  const layer = "12345".indexOf(event.key);
  if (event.key === "x") active.toggle();
  else if (event.key === "+" || event.key === "-") active.zoom(event.key === "+" ? 2 : 0.5, active.stage.clientWidth / 2, active.stage.clientHeight / 2);
  else if (layer >= 0 && layer < active.buttons.length) { active.layer = layer; active.show(); }
});

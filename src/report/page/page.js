// Wires plots, ribbons, picture and list together.
const model = JSON.parse(document.getElementById("model").textContent);
const axes = axesOf(model);
const view = { frames: model.frames, lo: -0.5, hi: Math.max(model.frames, 2) - 0.5, frame: 0, held: false, axis: axes[0], hidden: new Set() };
const host = document.getElementById("charts");

/** Stretches of each status but tracked: {c: [[first, last], …], …}. */
function stretches(status) {
  const found = {};
  for (let i = 0; i < status.length; ) {
    let j = i;
    while (j + 1 < status.length && status[j + 1] === status[i]) j++;
    (found[status[i]] ??= []).push([i, j]);
    i = j + 1;
  }
  return found;
}

const html = (tag, properties = {}, ...children) => {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
};

const BAR = { s: 3, t: 7, c: 12, l: 18, u: 18 }; // heights, so that statuses stay apart in greyscale
const MEANING = { s: "not found yet", t: "seen in the frame", c: "not seen, predicted", l: "no value", u: "no picture" };

class RibbonPlot {
  constructor(ribbon) {
    this.ribbon = ribbon;
    this.found = stretches(ribbon.status);
    this.svg = element("svg", { class: "chart", role: "img", "aria-label": `Status of ${ribbon.name}` });
  }
  draw(width, view) {
    const [left, right] = [MARGIN.left, width - MARGIN.right];
    const place = abscissa(view, left, right);
    const x = (frame) => Math.min(Math.max(place.x(frame), left), right);
    Object.assign(this, { x, left, right });
    this.svg.replaceChildren();
    this.svg.setAttribute("viewBox", `0 0 ${width} 22`);
    this.svg.setAttribute("height", 22);
    for (const status of "tscul") {
      const shapes = (this.found[status] ?? []).filter(([a, b]) => b >= view.lo && a <= view.hi).map(([a, b]) => {
        const from = x(a - 0.5), to = Math.max(x(b + 0.5), from + (status === "t" ? 0 : 1.5));
        return `M${from.toFixed(1)},20V${20 - BAR[status]}H${to.toFixed(1)}V20Z`;
      });
      if (shapes.length) this.svg.append(element("path", { class: status, d: shapes.join("") }));
    }
    this.cursor = element("path", { class: "cursor", d: "" });
    this.svg.append(this.cursor);
  }
  setCursor(view) {
    const visible = view.frame >= view.lo && view.frame <= view.hi;
    this.cursor.setAttribute("d", visible ? `M${this.x(view.frame)},0V22` : "");
  }
}

function save(name, content, type) {
  const url = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  html("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

function savePng(name, svgText) {
  const url = URL.createObjectURL(new Blob([svgText], { type: "image/svg+xml" }));
  const image = new Image();
  image.onload = () => {
    const canvas = html("canvas", { width: image.width * 3, height: image.height * 3 });
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
    canvas.toBlob((blob) => save(name, blob));
    URL.revokeObjectURL(url);
  };
  image.src = url;
}

/** The key of a curve: where there are several, a switch that hides it in every plot and in the picture. */
function key(series, several, ...more) {
  const sample = element("path", { class: `curve ${series.look}${series.dots ? " dots" : ""}`, d: keyPath(series, 0, 5), fill: "none" });
  const content = [element("svg", { class: "chart", width: 26, height: 10, style: "display:inline;width:26px" }, sample), `${series.name} `, ...more];
  if (!several) return html("span", {}, ...content);
  const button = html("button", { type: "button", className: "key", title: "Show or hide" }, ...content);
  button.dataset.look = series.look;
  button.setAttribute("aria-pressed", true);
  button.onclick = () => toggle(series.look);
  return button;
}

function toggle(look) {
  if (!view.hidden.delete(look)) view.hidden.add(look);
  for (const button of document.querySelectorAll(".key")) button.setAttribute("aria-pressed", !view.hidden.has(button.dataset.look));
  soon(draw);
}

function statusKeys(statuses) {
  return [..."tclsu"].filter((letter) => statuses.includes(letter)).map((letter) => html("span", {},
    element("svg", { width: 12, height: 14 },
      element("rect", { class: letter, width: 12, height: (BAR[letter] * 14) / 18, y: 14 - (BAR[letter] * 14) / 18 })), `${STATUS[letter]}: ${MEANING[letter]}`));
}

const plots = [];
const readouts = [];
const diagnostics = html("details", { className: "diagnostics" }, html("summary", { textContent: "Diagnostics: how the method worked" }));

function mount(plot, title, keys, saveable) {
  const heading = html("header", {}, html("h2", { textContent: title }), html("div", { className: "keys" }, ...keys));
  if (saveable) {
    const name = `seamtrack-${plot.spec.id}`;
    heading.append(html("div", { className: "save" },
      html("button", { type: "button", textContent: "SVG", onclick: () => save(`${name}.svg`, Chart.prototype.standalone.call(plot, view), "image/svg+xml") }),
      html("button", { type: "button", textContent: "PNG", onclick: () => savePng(`${name}.png`, Chart.prototype.standalone.call(plot, view)) })));
  }
  const note = plot.spec?.note ? [html("p", { className: "note", textContent: plot.spec.note })] : [];
  const place = html("div", { className: "plot", id: `plot-${plot.spec?.id ?? "status"}` }, heading, ...note, plot.svg);
  (plot.spec?.diagnostic ? diagnostics : host).append(place);
  plots.push(plot);
}

function draw() {
  const width = host.clientWidth;
  for (const plot of plots) plot.draw(width, view);
  const out = document.getElementById("zoom-out");
  out.hidden = view.lo === -0.5 && view.hi === Math.max(view.frames, 2) - 0.5;
  out.textContent = `frames ${Math.ceil(view.lo)}–${Math.floor(view.hi)} · show all`;
  cursor();
}

function cursor() {
  for (const plot of plots) plot.setCursor?.(view);
  for (const [node, chart, series] of readouts) node.textContent = chart.value(series, view.frame);
  for (const button of document.querySelectorAll("#places button")) button.setAttribute("aria-pressed", view.held && Number(button.dataset.frame) === view.frame);
  viewer.show(view.frame);
  player.show();
}

/** Redraw before the next paint, once: plots and cursor, or the cursor alone. */
let pending = null;
function soon(what) {
  if (!pending) requestAnimationFrame(() => { const due = pending; pending = null; due(); });
  if (pending !== draw) pending = what;
}

function goTo(frame, held) {
  view.frame = Math.min(Math.max(Math.round(frame), 0), view.frames - 1);
  view.held = held;
  const span = view.hi - view.lo;
  if (view.frame < view.lo || view.frame > view.hi) zoom(view.frame - span / 2, view.frame + span / 2);
  else soon(cursor);
}

function zoom(lo, hi) {
  const whole = Math.max(view.frames, 2);
  const span = Math.min(Math.max(hi - lo, 8), whole);
  view.lo = Math.min(Math.max((lo + hi - span) / 2, -0.5), whole - 0.5 - span);
  view.hi = view.lo + span;
  soon(draw);
}

function listen(plot) {
  let from = null;
  const svg = plot.svg;
  // Only the plot's own area zooms: labels outside it stay selectable.
  const inside = (event) => {
    const box = svg.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    return x >= plot.left && x <= plot.right && y <= (plot.bottom ?? box.height);
  };
  svg.onmousedown = (event) => { if (inside(event)) event.preventDefault(); };
  svg.onpointerdown = (event) => { if (event.button === 0 && inside(event)) { from = { px: event.clientX, frame: frameUnder(plot, event, view) }; svg.setPointerCapture(event.pointerId); } };
  svg.onpointermove = (event) => {
    const frame = frameUnder(plot, event, view);
    if (from && Math.abs(event.clientX - from.px) > 5) {
      const [a, b] = [plot.x(Math.min(from.frame, frame)), plot.x(Math.max(from.frame, frame))];
      for (const [name, value] of [["x", a], ["width", b - a]]) plot.zoomBox?.setAttribute(name, value);
    } else if (!view.held) goTo(frame, false);
  };
  svg.onpointerup = (event) => {
    const start = from;
    from = null;
    if (!start) return;
    const frame = frameUnder(plot, event, view);
    if (Math.abs(event.clientX - start.px) > 5) zoom(Math.min(start.frame, frame), Math.max(start.frame, frame));
    else { player.stop(); goTo(frame, !(view.held && Math.round(frame) === view.frame)); }
  };
  svg.ondblclick = () => zoom(-0.5, view.frames - 0.5);
}

const viewer = new Viewer(document.getElementById("viewer"), model, view);
const player = new Player(document.querySelector("#viewer .player"), view, model.time_s, goTo);
for (const ribbon of model.ribbons) {
  const plot = new RibbonPlot(ribbon);
  mount(plot, model.ribbons.length > 1 ? ribbon.name : "Status", plots.length ? [] : statusKeys(model.ribbons.map((r) => r.status).join("")), false);
  listen(plot);
}
const gaps = model.ribbons.length === 1 ? stretches(model.ribbons[0].status) : {};
delete gaps.t;
for (const spec of model.charts) {
  const chart = new Chart(spec, gaps);
  const keys = spec.series.map((series) => {
    const value = html("b");
    if (series.look !== "sigma") readouts.push([value, chart, series]);
    return key(series, spec.series.length > 1, ...(series.look === "sigma" ? [] : [value]));
  });
  mount(chart, spec.title, keys, true);
  listen(chart);
}
for (const chart of plots.filter((plot) => plot.spec?.histogram)) {
  const histogram = new Histogram(chart);
  const { series } = histogram.spec;
  mount(histogram, histogram.spec.title, series.map((s) => key({ ...s, dots: false }, series.length > 1)), true);
}
if (diagnostics.children.length > 1) host.append(diagnostics);

if (axes.length > 1) document.getElementById("axes").append("x axis: ", ...axes.map((axis) => {
  const button = html("button", { type: "button", textContent: axis.name });
  const press = () => { for (const other of document.querySelectorAll("#axes button")) other.setAttribute("aria-pressed", other.textContent === view.axis.name); };
  button.setAttribute("aria-pressed", axis === view.axis);
  button.onclick = () => { view.axis = axis; press(); soon(draw); };
  return button;
}));

const list = document.querySelector("#places .list");
for (const { first, last, frame, why } of model.places) {
  const where = first === last ? `${first}` : `${first}–${last}`;
  const button = html("button", { type: "button", onclick: () => { player.stop(); goTo(frame, true); } }, html("b", { textContent: where }), why);
  button.dataset.frame = frame;
  list.append(button);
}
if (model.more_places) list.append(html("p", { className: "note", textContent: `and ${model.more_places} more of less weight` }));
const everTracked = model.ribbons.some((ribbon) => ribbon.status.includes("t"));
if (!model.places.length) list.textContent = everTracked ? "None: no loss, no jump, no large error." : "None: no seam was found.";

document.getElementById("zoom-out").onclick = () => zoom(-0.5, view.frames - 0.5);
document.addEventListener("keydown", (event) => {
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key] * (event.shiftKey ? 10 : 1);
  if (event.key === "Escape") { view.held = false; zoom(-0.5, view.frames - 0.5); }
  else if (event.key === " " && !event.target.closest("button, input, summary, a")) { event.preventDefault(); player.toggle(); }
  else if (step && !event.target.closest("pre, .scroll, input")) { event.preventDefault(); player.stop(); goTo(view.frame + step, true); }
});
new ResizeObserver(() => soon(draw)).observe(host);
view.frame = model.places[0]?.frame ?? 0;
draw();
player.follow();
document.documentElement.dataset.ready = "true";

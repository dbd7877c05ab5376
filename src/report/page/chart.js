// One plot over the frames, drawn as SVG. All plots of a page share a view: the visible frames and the cursor.
const SMALLEST = 0.01; // what a logarithmic ordinate still shows
const MARGIN = { left: 58, right: 14, top: 8, bottom: 20 };

function element(name, attributes = {}, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

/** Round numbers that divide lo..hi into about `count` steps. */
function ticks(lo, hi, count) {
  const raw = (hi - lo) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const steps = [0.5, 1, 2, 5, 10].map((m) => m * power);
  const inside = (s) => Math.floor(hi / s + 1e-9) - Math.ceil(lo / s - 1e-9) + 1;
  const fit = steps.findIndex((s) => s >= raw * 0.999);
  const step = inside(steps[fit]) < 3 ? steps[fit - 1] : steps[fit];
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const list = [];
  for (let k = Math.ceil(lo / step - 1e-9); k * step <= hi + step * 1e-9; k++) {
    list.push([k * step, (k * step).toFixed(decimals)]);
  }
  return list;
}

/** Decades between 10^lo and 10^hi. */
function decades(lo, hi) {
  const list = [];
  for (let k = Math.ceil(lo); k <= hi; k++) list.push([k, k < 0 ? (10 ** k).toFixed(-k) : String(10 ** k)]);
  return list;
}

/** Points [frame, value] of y between two frames, at most a minimum and a maximum a pixel column, null at a gap. */
function thinned(y, first, last, columns) {
  const points = [];
  const step = Math.max(1, (last - first + 1) / columns);
  if (step <= 2) {
    for (let i = first; i <= last; i++) points.push(y[i] === null ? null : [i, y[i]]);
    return points;
  }
  for (let c = 0; c < columns; c++) {
    const end = Math.min(last + 1, Math.floor(first + (c + 1) * step));
    let low = -1, high = -1;
    for (let i = Math.floor(first + c * step); i < end; i++) {
      if (y[i] === null) continue;
      if (low < 0 || y[i] < y[low]) low = i;
      if (high < 0 || y[i] > y[high]) high = i;
    }
    if (low < 0) points.push(null);
    else for (const i of low < high ? [low, high] : low > high ? [high, low] : [low]) points.push([i, y[i]]);
  }
  return points;
}

/** A path of line segments; a single point between gaps becomes a dot. */
function linePath(points, x, y) {
  let path = "", drawing = false;
  for (let k = 0; k < points.length; k++) {
    const point = points[k];
    if (!point) { drawing = false; continue; }
    const at = `${x(point[0]).toFixed(1)},${y(point[1]).toFixed(1)}`;
    path += drawing ? `L${at}` : points[k + 1] ? `M${at}` : `M${at}h0.8`;
    drawing = true;
  }
  return path;
}

const dotPath = (points, x, y) =>
  points.map((point) => (point ? `M${x(point[0]).toFixed(1)},${y(point[1]).toFixed(1)}h0` : "")).join("");

/** Outlines of y ± half, one for each stretch without a gap. */
function bandPath(series, first, last, columns, x, y) {
  const upper = series.y.map((v, i) => (v === null || series.band[i] === null ? null : v + series.band[i]));
  const lower = series.y.map((v, i) => (v === null || series.band[i] === null ? null : v - series.band[i]));
  const step = Math.max(1, Math.floor((last - first + 1) / columns));
  let path = "", top = [], bottom = [];
  const close = () => {
    if (top.length) path += `M${top.join("L")}L${bottom.reverse().join("L")}Z`;
    top = []; bottom = [];
  };
  for (let i = first; i <= last; i += step) {
    let high = -Infinity, low = Infinity;
    for (let j = i; j < Math.min(i + step, last + 1); j++) {
      if (upper[j] === null) continue;
      high = Math.max(high, upper[j]); low = Math.min(low, lower[j]);
    }
    if (high < low) { close(); continue; }
    top.push(`${x(i).toFixed(1)},${y(high).toFixed(1)}`);
    bottom.push(`${x(i).toFixed(1)},${y(low).toFixed(1)}`);
  }
  close();
  return path;
}

class Chart {
  constructor(spec, gaps) {
    this.spec = spec;
    this.gaps = gaps;
    this.height = spec.id === "path" ? 216 : 128;
    this.svg = element("svg", { class: "chart", role: "img", "aria-label": spec.title });
    if (spec.log) for (const s of spec.series) {
      s.raw = s.y;
      s.y = s.y.map((v) => (v === null ? null : Math.log10(Math.max(v, SMALLEST))));
    }
    this.limits = spec.limits.map(([value, name]) => [spec.log ? Math.log10(value) : value, name]);
  }

  /** The ordinate's range over the visible frames. */
  range(first, last, hidden) {
    let lo = Infinity, hi = -Infinity;
    const shown = this.spec.series.filter((s) => !hidden.has(s.look));
    const fitting = shown.filter((s) => s.fits);
    for (const s of fitting.length ? fitting : shown) {
      for (let i = first; i <= last; i++) {
        const v = s.y[i];
        if (v === null || v === undefined) continue;
        const half = s.band?.[i] ?? 0;
        if (v - half < lo) lo = v - half;
        if (v + half > hi) hi = v + half;
      }
    }
    const { tolerance } = this.spec;
    if (tolerance) { lo = Math.min(lo, -tolerance); hi = Math.max(hi, tolerance); }
    for (const [value] of this.limits) { lo = Math.min(lo, value); hi = Math.max(hi, value); }
    if (!(lo <= hi)) return [0, 1];
    const pad = (hi - lo || Math.abs(hi) || 1) * 0.06;
    return [lo - pad, hi + pad];
  }

  /** Draw into `svg` (the page's own by default) at a width, for the visible frames lo..hi. */
  draw(width, view, svg = this.svg, top = MARGIN.top) {
    const height = this.height + top - MARGIN.top;
    const [left, right, bottom] = [MARGIN.left, width - MARGIN.right, height - MARGIN.bottom];
    const first = Math.max(0, Math.ceil(view.lo)), last = Math.min(view.frames - 1, Math.floor(view.hi));
    const [lo, hi] = this.range(first, last, view.hidden);
    const { x } = abscissa(view, left, right);
    const shown = this.spec.series.filter((s) => !view.hidden.has(s.look));
    const y = (value) => bottom - ((value - lo) / (hi - lo)) * (bottom - top);
    Object.assign(this, { x, left, right, top, bottom });
    svg.replaceChildren();
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    const clip = `clip-${this.spec.id}`;
    svg.append(element("clipPath", { id: clip },
      element("rect", { x: left, y: top, width: right - left, height: bottom - top })));
    const plot = element("g", { "clip-path": `url(#${clip})` });
    for (const [status, list] of Object.entries(this.gaps)) {
      const path = list.map(([a, b]) => `M${x(a - 0.5).toFixed(1)},${top}H${(Math.max(x(b + 0.5), x(a - 0.5) + 1)).toFixed(1)}V${bottom}H${x(a - 0.5).toFixed(1)}Z`);
      plot.append(element("path", { class: `gap ${status}`, d: path.join("") }));
    }
    const { tolerance } = this.spec;
    if (tolerance) plot.append(element("rect", { class: "tolerance", x: left - 1, y: y(tolerance), width: right - left + 2, height: y(-tolerance) - y(tolerance) }));
    this.axes(svg, view, [lo, hi], y);
    if (tolerance) svg.append(element("text", { class: "limit-name", x: left + 6, y: Math.max(y(tolerance) - 4, top + 9) }, `tolerance ±${tolerance}`));
    const columns = Math.max(1, Math.floor(right - left));
    for (const s of shown) {
      if (s.band) plot.append(element("path", { class: `band ${s.look}`, d: bandPath(s, first, last, columns, x, y) }));
    }
    for (const s of shown) {
      const points = thinned(s.y, first, last, columns);
      const path = s.dots ? dotPath(points, x, y) : linePath(points, x, y);
      plot.append(element("path", { class: `curve ${s.look}${s.dots ? " dots" : ""}${points.length > columns ? " dense" : ""}`, d: path }));
    }
    svg.append(plot);
    this.limits.forEach(([value, name], k) => {
      svg.append(element("path", { class: "limit", d: `M${left},${y(value)}H${right}` }));
      // Lines that lie close together carry their names on their outer sides.
      const below = this.limits[k + 1] && y(value) - y(this.limits[k + 1][0]) < 16 ? 13 : -4;
      svg.append(element("text", { class: "limit-name", x: right - 4, y: Math.max(y(value) + below, top + 9), "text-anchor": "end" }, name));
    });
    this.zoomBox = element("rect", { class: "zoom", y: top, height: bottom - top, width: 0 });
    this.cursor = element("path", { class: "cursor", d: "" });
    if (svg === this.svg) svg.append(this.zoomBox, this.cursor);
  }

  axes(svg, view, [lo, hi], y) {
    const { left, right, top, bottom } = this;
    const ordinates = this.spec.log ? decades(lo, hi) : ticks(lo, hi, (bottom - top) / 34);
    for (const [value, label] of ordinates) {
      svg.append(element("path", { class: "grid", d: `M${left},${y(value)}H${right}` }));
      svg.append(element("text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, label));
    }
    const { of, range } = abscissa(view, left, right);
    const room = 16 + 6 * view.axis.unit.length;
    for (const [value, label] of ticks(...range, (right - left) / 90)) {
      if (of(value) > right - room || (view.axis.unit === "frame" && value % 1)) continue;
      svg.append(element("path", { class: "grid", d: `M${of(value)},${bottom}v4` }));
      svg.append(element("text", { x: of(value), y: bottom + 15, "text-anchor": "middle" }, label));
    }
    svg.append(element("text", { x: right, y: bottom + 15, "text-anchor": "end" }, view.axis.unit));
    const middle = (top + bottom) / 2;
    svg.append(element("text", { x: 11, y: middle, "text-anchor": "middle", transform: `rotate(-90 11 ${middle})` }, this.spec.unit));
    svg.append(element("path", { class: "frame", d: `M${left},${top}V${bottom}H${right}` }));
  }

  setCursor(view) {
    const visible = view.frame >= view.lo && view.frame <= view.hi;
    this.cursor.setAttribute("d", visible ? `M${this.x(view.frame)},${this.top}V${this.bottom}` : "");
    this.cursor.classList.toggle("held", view.held);
  }

  /** The value of a series at a frame, as text. */
  value(series, frame) {
    const v = (series.raw ?? series.y)[frame];
    return v === null || v === undefined ? "–" : v.toFixed(this.spec.decimals);
  }

  /** The plot as a stand-alone SVG text with title and keys, in the light colours. */
  standalone(view, width = 900) {
    const svg = element("svg", { class: "chart", xmlns: "http://www.w3.org/2000/svg", width });
    this.draw(width, view, svg, 34);
    svg.append(element("text", { class: "title", x: MARGIN.left, y: 18 }, this.spec.title));
    let x = width - MARGIN.right;
    for (const s of this.spec.series.filter((s) => !view.hidden.has(s.look)).reverse()) {
      const length = s.name.length * 6.5;
      svg.append(element("text", { x: x - length, y: 18 }, s.name));
      svg.append(element("path", { class: `curve ${s.look}${s.dots ? " dots" : ""}`, d: keyPath(s, x - length - 32, 14) }));
      x -= length + 48;
    }
    const light = [...document.styleSheets[0].cssRules].find((rule) => rule.selectorText === ":root").style;
    const style = document.getElementById("chart-style").textContent
      .replace(/var\((--\w+)\)/g, (_, name) => light.getPropertyValue(name).trim());
    svg.prepend(element("style", {}, style), element("rect", { width: "100%", height: "100%", fill: "#fff" }));
    this.draw(this.svg.clientWidth, view);
    this.setCursor?.(view);
    return new XMLSerializer().serializeToString(svg);
  }
}

/** A short sample of a series' curve. */
const keyPath = (series, x, y) =>
  series.look === "sigma" ? `M${x},${y - 4}h26M${x},${y + 4}h26` : series.dots ? [3, 12, 21].map((dx) => `M${x + dx},${y}h0`).join("") : `M${x},${y}h26`;

// The stored frame nearest to the cursor with the tracker's marks.
const STATUS = { s: "seeking", t: "tracked", c: "coasting", l: "lost", u: "unreadable" };

const SHAPES = {
  cross: (u, v, r) => `M${u - r},${v - r}L${u + r},${v + r}M${u - r},${v + r}L${u + r},${v - r}`,
  circle: (u, v, r) => `M${u - r},${v}a${r},${r} 0 1 0 ${2 * r},0a${r},${r} 0 1 0 ${-2 * r},0M${u},${v - 2 * r}V${v - r}M${u},${v + r}V${v + 2 * r}`,
  diamond: (u, v, r) => `M${u},${v - 0.7 * r}L${u + 0.7 * r},${v}L${u},${v + 0.7 * r}L${u - 0.7 * r},${v}Z`,
};

/** A mark over a dark outline of itself, which keeps it apart from glare. */
const outlined = (name, attributes) => ["halo", attributes.class].map((look) => element(name, { ...attributes, class: look }));

class Viewer {
  constructor(figure, model, view) {
    Object.assign(this, { model, view, viewer: model.viewer, closeUp: false, marked: true });
    const has = this.viewer.images.length > 0;
    this.caption = figure.querySelector("figcaption");
    this.picture = element("svg", { class: "picture", role: "img", "aria-label": "Stored frame with marks" });
    const plus = this.viewer.axis === "horizontal" ? "+ →" : "+ ↓";
    const node = (tag, properties, ...children) => {
      const made = Object.assign(document.createElement(tag), properties);
      made.append(...children);
      return made;
    };
    if (has) figure.prepend(node("div", { className: "frame" }, this.picture, node("span", { className: "plus", textContent: plus, title: "The way in which positions grow" })));
    this.now = node("div", { className: "now" });
    this.note = node("span", { className: "note" });
    const tools = node("div", { className: "tools" });
    if (has) tools.append(
      this.toggle("Close-up", (on) => { this.closeUp = on; }, false),
      this.toggle("Marks", (on) => { this.marked = on; }, true),
      ...this.viewer.points.map((p) => this.key(p)));
    tools.append(this.note);
    this.caption.append(node("div", { className: "player" }), this.now, tools);
  }

  toggle(name, set, on) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = name;
    button.setAttribute("aria-pressed", on);
    button.onclick = () => {
      on = !on;
      button.setAttribute("aria-pressed", on);
      set(on);
      this.show(this.frame);
    };
    return button;
  }

  key(points) {
    const key = document.createElement("span");
    key.className = "note mark-key";
    const shapes = outlined("path", { class: `mark ${points.look}`, d: SHAPES[points.shape](8, 8, 4) });
    key.append(element("svg", { class: "swatch", width: 16, height: 16 }, ...shapes), points.name);
    return key;
  }

  /** The stored frame nearest to `frame`. */
  nearest(frame) {
    const images = this.viewer.images;
    let lo = 0, hi = images.length - 1;
    while (lo < hi) {
      const middle = (lo + hi) >> 1;
      if (images[middle].frame < frame) lo = middle + 1; else hi = middle;
    }
    const before = images[lo - 1];
    return before && frame - before.frame <= Math.abs(images[lo].frame - frame) ? before : images[lo];
  }

  show(frame) {
    this.frame = frame;
    const text = (tag, content) => Object.assign(document.createElement(tag), { textContent: content });
    const status = this.model.ribbons.map((ribbon) => STATUS[ribbon.status[frame]]);
    this.now.replaceChildren(
      text("b", `Frame ${frame}`), text("span", `${(this.model.time_s[frame] ?? 0).toFixed(3)} s`),
      text("span", [...new Set(status)].join(" / ")), text("span", this.model.file[frame] ?? ""));
    const stored = this.nearest(frame);
    if (!stored) { this.note.textContent = "No frames were stored with this run."; return; }
    this.note.textContent = stored.frame === frame ? "" : `picture: frame ${stored.frame}, the nearest stored`;
    this.picture.dataset.frame = stored.frame;
    this.draw(stored);
  }

  draw(stored) {
    const { width, height, points } = this.viewer;
    const [u0, v0, w, h] = this.closeUp ? this.window(stored) : [0, 0, width, height];
    // Pixel centres are integers: the picture begins half a pixel before the origin.
    this.picture.setAttribute("viewBox", `${u0 - 0.5} ${v0 - 0.5} ${w} ${h}`);
    this.picture.style.aspectRatio = `${width} / ${height}`;
    const image = element("image", { x: -0.5, y: -0.5, width, height, href: `data:image/jpeg;base64,${stored.jpeg}`, preserveAspectRatio: "none" });
    this.picture.replaceChildren(image);
    if (!this.marked) return;
    if (stored.roi) {
      const [x, y, roiWidth, roiHeight] = stored.roi;
      this.picture.append(...outlined("rect", { class: "roi", x, y, width: roiWidth, height: roiHeight }));
    }
    // Without an outline, which would cover the stripe.
    this.picture.append(element("polyline", { class: "stripe", points: stored.stripe.map((p) => p.join(",")).join(" ") }));
    points.forEach((p, k) => {
      if (!stored.points[k] || this.view.hidden.has(p.look)) return;
      const [u, v] = stored.points[k];
      this.picture.append(...outlined("path", { class: `mark ${p.look}`, d: SHAPES[p.shape](u, v, w / 55) }));
    });
  }

  /** A window round the seam in which single pixels can be seen. */
  window(stored) {
    const { width, height } = this.viewer;
    const [cu, cv] = stored.points.findLast((point) => point) ?? (stored.roi ? [stored.roi[0] + stored.roi[2] / 2, stored.roi[1] + stored.roi[3] / 2] : [width / 2, height / 2]);
    const w = Math.min(width, 150), h = (w * height) / width;
    return [cu - w / 2, cv - h / 2, w, h];
  }
}

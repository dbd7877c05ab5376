// The stored frame nearest to the cursor with the tracker's marks.
const STATUS = { s: "seeking", t: "tracked", c: "coasting", l: "lost", u: "unreadable" };

const SHAPES = {
  cross: (u, v, r) => `M${u - r},${v - r}L${u + r},${v + r}M${u - r},${v + r}L${u + r},${v - r}`,
  circle: (u, v, r) => `M${u - r},${v}a${r},${r} 0 1 0 ${2 * r},0a${r},${r} 0 1 0 ${-2 * r},0M${u},${v - 2 * r}V${v - r}M${u},${v + r}V${v + 2 * r}`,
  diamond: (u, v, r) => `M${u},${v - 0.7 * r}L${u + 0.7 * r},${v}L${u},${v + 0.7 * r}L${u - 0.7 * r},${v}Z`,
};

class Viewer {
  constructor(figure, model) {
    this.model = model;
    this.viewer = model.viewer;
    this.caption = figure.querySelector("figcaption");
    this.picture = element("svg", { class: "picture", role: "img", "aria-label": "Stored frame with marks" });
    if (this.viewer.images.length) figure.prepend(this.picture);
    this.closeUp = false;
    this.marked = true;
    this.now = document.createElement("div");
    this.now.className = "now";
    const tools = document.createElement("div");
    tools.className = "tools";
    this.note = document.createElement("span");
    this.note.className = "note";
    tools.append(
      this.toggle("Close-up", (on) => { this.closeUp = on; }, false),
      this.toggle("Marks", (on) => { this.marked = on; }, true),
      ...(this.viewer.images.length ? this.viewer.points.map((p) => this.key(p)) : []), this.note);
    this.caption.append(this.now, tools);
    if (!this.viewer.images.length) tools.replaceChildren(this.note);
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
    key.className = "note";
    key.style.margin = "0";
    const shape = element("path", { class: `mark ${points.look}`, d: SHAPES[points.shape](8, 8, 4), fill: "none" });
    key.append(element("svg", { class: "swatch", width: 16, height: 16, style: "vertical-align:-4px;background:#222;border-radius:3px;margin-right:4px" }, shape), points.name);
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
      this.picture.append(element("rect", { class: "roi", x, y, width: roiWidth, height: roiHeight }));
    }
    this.picture.append(element("polyline", { class: "stripe", points: stored.stripe.map((p) => p.join(",")).join(" ") }));
    points.forEach((p, k) => {
      if (!stored.points[k]) return;
      const [u, v] = stored.points[k];
      this.picture.append(element("path", { class: `mark ${p.look}`, d: SHAPES[p.shape](u, v, w / 55) }));
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

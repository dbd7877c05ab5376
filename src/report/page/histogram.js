// Histograms of a chart's series over the visible frames.
class Histogram {
  constructor(chart) {
    this.chart = chart;
    this.spec = { id: `${chart.spec.id}-histogram`, title: `Histogram: ${chart.spec.title.toLowerCase()}`, diagnostic: true, note: "Of the visible frames: zoom to see others.", series: chart.spec.series.filter((s) => s.look !== "sigma") };
    this.svg = element("svg", { class: "chart", role: "img", "aria-label": this.spec.title });
  }

  /** Shares of the visible frames in bins over ±reach and beyond it [%]. */
  counts(shown, view, reach, bins) {
    const first = Math.max(0, Math.ceil(view.lo)), last = Math.min(view.frames - 1, Math.floor(view.hi));
    return shown.map((series) => {
      const shares = new Array(bins).fill(0);
      let total = 0, beyond = 0;
      for (let i = first; i <= last; i++) {
        const v = series.y[i];
        if (v === null || v === undefined) continue;
        total++;
        const bin = Math.floor(((v + reach) / (2 * reach)) * bins);
        if (bin >= 0 && bin < bins) shares[bin]++; else beyond++;
      }
      const percent = (n) => (total ? (100 * n) / total : 0);
      return { shares: shares.map(percent), beyond: percent(beyond) };
    });
  }

  draw(width, view, svg = this.svg, top = MARGIN.top) {
    const height = 128 + top - MARGIN.top;
    const [left, right, bottom] = [MARGIN.left, width - MARGIN.right, height - MARGIN.bottom];
    const first = Math.max(0, Math.ceil(view.lo)), last = Math.min(view.frames - 1, Math.floor(view.hi));
    const [lo, hi] = this.chart.range(first, last, view.hidden);
    const shown = this.spec.series.filter((s) => !view.hidden.has(s.look));
    const reach = Math.max(Math.abs(lo), Math.abs(hi), 1e-6);
    const bins = 61;
    const all = this.counts(shown, view, reach, bins);
    const highest = Math.max(1, ...all.flatMap((one) => one.shares)) * 1.05;
    const x = (mm) => left + ((mm + reach) / (2 * reach)) * (right - left);
    const y = (share) => bottom - (share / highest) * (bottom - top);
    svg.replaceChildren();
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    for (const [share, label] of ticks(0, highest, 3)) {
      svg.append(element("path", { class: "grid", d: `M${left},${y(share)}H${right}` }));
      svg.append(element("text", { x: left - 6, y: y(share) + 4, "text-anchor": "end" }, label));
    }
    for (const [mm, label] of ticks(-reach, reach, (right - left) / 90)) {
      if (x(mm) > right - 34) continue;
      svg.append(element("path", { class: "grid", d: `M${x(mm)},${bottom}v4` }));
      svg.append(element("text", { x: x(mm), y: bottom + 15, "text-anchor": "middle" }, label));
    }
    svg.append(element("path", { class: "limit", d: `M${x(0)},${top}V${bottom}` }));
    svg.append(element("text", { x: right, y: bottom + 15, "text-anchor": "end" }, this.chart.spec.unit));
    const middle = (top + bottom) / 2;
    svg.append(element("text", { x: 11, y: middle, "text-anchor": "middle", transform: `rotate(-90 11 ${middle})` }, "% of frames"));
    const outside = all.map((one, k) => [one.beyond, shown[k].name]).filter(([share]) => share >= 0.05);
    if (outside.length) {
      const text = `off the axis: ${outside.map(([share, name]) => `${name} ${share.toFixed(1)} %`).join(", ")}`;
      svg.append(element("text", { class: "limit-name", x: right - 4, y: top + 12, "text-anchor": "end" }, text));
    }
    all.forEach(({ shares }, k) => {
      const at = (b) => x(-reach + (2 * reach * b) / bins).toFixed(1);
      const path = shares.map((share, b) => `${b ? "L" : "M"}${at(b)},${y(share).toFixed(1)}H${at(b + 1)}`).join("");
      svg.append(element("path", { class: `curve ${shown[k].look}`, d: path }));
    });
    svg.append(element("path", { class: "frame", d: `M${left},${top}V${bottom}H${right}` }));
  }
}

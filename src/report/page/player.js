// Play, slider, and the address of a frame (#frame=134).
const RATES = { least: 2, most: 30 }; // frames a second at which a recording is played; its own rate between them

class Player {
  constructor(place, view, times, goTo) {
    Object.assign(this, { view, goTo, timer: null });
    const period = times.length > 1 ? (times.at(-1) - times[0]) / (times.length - 1) : 0;
    this.pauseMs = 1000 / Math.min(Math.max(period > 0 ? 1 / period : 10, RATES.least), RATES.most);
    this.button = Object.assign(document.createElement("button"), { type: "button", onclick: () => this.toggle() });
    this.slider = Object.assign(document.createElement("input"), { type: "range", min: 0, max: view.frames - 1, step: 1 });
    this.slider.setAttribute("aria-label", "Frame");
    this.slider.oninput = () => { this.stop(); goTo(Number(this.slider.value), true); };
    place.append(this.button, this.slider);
    this.stop();
    addEventListener("hashchange", () => this.follow());
  }

  toggle() {
    if (this.timer) { this.stop(); return; }
    this.label("❚❚", "Pause");
    if (this.view.frame >= this.view.frames - 1) this.goTo(0, true);
    this.timer = setInterval(() => {
      if (this.view.frame >= this.view.frames - 1) this.stop(); else this.goTo(this.view.frame + 1, true);
    }, this.pauseMs);
  }

  stop() {
    clearInterval(this.timer);
    this.timer = null;
    this.label("▶", "Play");
  }

  label(sign, word) {
    this.button.textContent = sign;
    this.button.setAttribute("aria-label", word);
  }

  /** Show the frame; one that is held becomes the page's address, so that it can be passed on. */
  show() {
    this.slider.value = this.view.frame;
    if (this.view.held && !this.timer) history.replaceState(null, "", `#frame=${this.view.frame}`);
  }

  /** Go to the frame that the address names, if it names one. */
  follow() {
    const frame = /^#frame=(\d+)$/.exec(location.hash);
    if (frame) this.goTo(Number(frame[1]), true);
    return Boolean(frame);
  }
}

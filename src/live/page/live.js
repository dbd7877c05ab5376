"use strict";
// What the program sends, ten times a second, as it is: nothing is computed here but the chart's scale.
const at = id => document.getElementById(id);
const kinds = {OK: "good", COAST: "check", LOST: "bad", STOP: "bad"};
const fixed = (value, digits) => value === null || value === undefined ? "–" : value.toFixed(digits);
const MINUTE = 600;
let minute = [], heard = 0, shown = 0;

function show(now) {
  at("state").textContent = now.state; at("state").className = kinds[now.state] || "";
  at("why").textContent = now.why === "fine" ? "" : now.why;
  const digits = {path_mm: 1, remaining_mm: 3, total_mm: 3, gap_mm: 2, age_ms: 0, latency_ms: 1, step_ms: 1};
  for (const [id, count] of Object.entries(digits)) at(id).textContent = fixed(now[id], count);
  const names = ["seeking", "tracked", "coasting", "lost"];
  at("counters").textContent = "frames: " + names.map((name, i) => `${name} ${now.frames[i]}`).join(", ")
    + ` · passed over ${now.passed_over} · late packets ${now.late} · holes in the record ${now.holes} · cycles ${now.cycle}`;
  document.title = `${now.state} · seamtrack live`;
}

function draw() {
  const values = minute.flatMap(s => [s.total_mm, s.remaining_mm]).filter(v => v !== null && v !== undefined);
  const most = Math.max(0.5, ...values.map(Math.abs)) * 1.1;
  const line = key => minute.map((s, i) => s[key] === null || s[key] === undefined ? null
    : `${1000 - (minute.length - 1 - i) * 1000 / (MINUTE - 1)},${100 - 100 * s[key] / most}`);
  for (const key of ["total", "remaining"]) {
    const group = at(key); group.replaceChildren();
    let run = [];
    for (const point of [...line(key + "_mm"), null]) {
      if (point) { run.push(point); continue; }
      if (run.length > 1) {
        const part = document.createElementNS("http://www.w3.org/2000/svg", "polyline");
        part.setAttribute("points", run.join(" ")); part.setAttribute("class", key); group.append(part);
      }
      run = [];
    }
  }
  at("scale").textContent = `± ${most.toFixed(2)} mm`;
}

const events = new EventSource("events");
events.addEventListener("minute", e => { minute = JSON.parse(e.data); draw(); });
events.addEventListener("now", e => {
  const now = JSON.parse(e.data); heard = Date.now(); shown += 1;
  minute.push(now); if (minute.length > MINUTE) minute.shift();
  show(now); if (shown % 5 === 1) draw();
  document.documentElement.dataset.shown = shown;
});
setInterval(() => document.body.classList.toggle("silent", Date.now() - heard > 2000), 500);

// The next picture is asked for when this one is there: who is slow sees fewer.
const picture = at("picture");
let number = 0;
const next = wait => setTimeout(() => { number += 1; picture.src = "picture.jpg?" + number; }, wait);
picture.onload = () => {
  document.documentElement.dataset.pictures = number; document.documentElement.dataset.width = picture.naturalWidth; next(66);
};
picture.onerror = () => next(1000);
next(0);

for (const order of ["reset", "stop"]) {
  const button = at(order);
  if (button) button.onclick = () => fetch(order, {method: "POST", headers: {Authorization: "Bearer " + at("token").value}})
    .then(answer => { at("said").textContent = answer.ok ? "done" : "refused: is the token right?"; })
    .catch(() => { at("said").textContent = "no answer"; });
}

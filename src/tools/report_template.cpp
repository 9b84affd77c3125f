#include "tools/report_template.hpp"

namespace matchbox_slam {

const char* const kReportPageBegin = R"html(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>map_bag</title>
<style>
:root { color-scheme: light dark; --page: #f6f7f9; --card: #ffffff; --text: #1c2430; --faint: #5a6473;
  --rule: #d5d9e0; --line: #2b5fb8; --under: #dee1e5; --picked: #101418; }
@media (prefers-color-scheme: dark) {
  :root { --page: #14171c; --card: #1d2229; --text: #e6e9ee; --faint: #9aa4b2; --rule: #363d48;
    --line: #7fb0ff; --under: #b9bdc3; --picked: #ffffff; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 16px 20px; max-width: 1500px; background: var(--page);
  color: var(--text); font: 14px/1.45 system-ui, sans-serif; }
h1 { font-size: 20px; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 15px; margin: 0 0 6px; }
section { background: var(--card); border: 1px solid var(--rule); border-radius: 8px;
  padding: 12px 14px; margin-top: 12px; }
.faint { color: var(--faint); }
.warning { color: #c2410c; font-weight: 600; }
dl { display: grid; grid-template-columns: repeat(auto-fill, minmax(215px, 1fr)); gap: 10px 18px;
  margin: 0; }
dt { color: var(--faint); font-size: 12px; }
dd { margin: 0; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
canvas { display: block; width: 100%; border-radius: 4px; touch-action: none; }
#map { display: block; max-width: 100%; }
#view { height: 560px; cursor: grab; background: var(--under); }
#chart { height: 230px; cursor: crosshair; }
.bar { display: flex; flex-wrap: wrap; gap: 4px 16px; align-items: center; margin: 6px 0;
  font-size: 12px; color: var(--faint); }
.bar button { font: inherit; padding: 2px 10px; }
.swatch { display: inline-block; width: 12px; height: 12px; border-radius: 3px; margin-right: 5px;
  vertical-align: -2px; }
#ramp { display: inline-block; width: 150px; height: 10px; border-radius: 3px; margin: 0 6px; }
#told { min-height: 1.45em; font-variant-numeric: tabular-nums; }
.rows { max-height: 420px; overflow: auto; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; padding: 4px 10px 4px 0; border-bottom: 1px solid var(--rule);
  vertical-align: top; }
th { font-size: 12px; color: var(--faint); font-weight: 600; position: sticky; top: 0;
  background: var(--card); }
td.what { white-space: nowrap; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
tbody tr { cursor: pointer; }
tbody tr:hover, tbody tr.picked { background: var(--page); }
</style>
</head>
<body>
<h1 id="title">map_bag</h1>
<div class="faint" id="about"></div>
<div id="incidents"></div>
<section><dl id="facts"></dl></section>
<section>
<h2>Map</h2>
<canvas id="view" hidden></canvas>
<img id="map" alt="The map with the way of the robot" src=")html";

const char* const kReportPageMiddle = R"html(">
<div class="bar"><button id="whole" type="button">Whole map</button>
<span>wheel or two fingers: zoom; drag: move</span>
<span id="scale"></span></div>
<div id="outside" class="faint" hidden>The picture is large and not in this page: keep map.png beside it.</div>
</section>
<section>
<h2>How sure the robot was of its place, when each scan came</h2>
<canvas id="chart"></canvas>
<div class="bar"><span id="legend"></span><button id="all" type="button">Whole drive</button>
<span>point: shows where on the map; click: keeps it there; wheel: zoom</span></div>
<div id="told"></div>
<div id="thinned" class="faint"></div>
</section>
<section>
<h2 id="doubted">Scans that were doubted</h2>
<div class="rows"><table id="stretches" hidden><thead><tr><th class="number">since start [s]</th>
<th class="number">stamp [s]</th><th class="number">how long [s]</th><th class="number">scans</th>
<th>what</th><th>why</th></tr></thead><tbody></tbody></table></div>
<div id="omitted" class="faint"></div>
</section>
<noscript><p>Maps to zoom, charts and tables need JavaScript; report.json has the figures.</p></noscript>
<script type="application/json" id="data">)html";

const char* const kReportPageEnd = R"html(</script>
<script>
'use strict';
const data = JSON.parse(document.getElementById('data').textContent);
const report = data.report, points = data.points, frame = data.picture;
const count = points.time.length;
const kinds = {
  lost: {name: 'lost', color: '#c1121f', why: 'Nothing in the map fitted any more, or a drive began somewhere unknown. What was seen was mapped apart, and searched for in the map.'},
  doubt: {name: 'doubt', color: '#e69f00', why: 'Another place, or one that is not known, might have been right as well. The map grew meanwhile.'},
  recovered: {name: 'recovered', color: '#56b4e9', why: 'The lost robot was found; what it had mapped apart was being joined to the map.'},
  overtaken: {name: 'overtaken', color: '#b5468f', why: 'Another hypothesis than the one that led before fitted better, and took its place.'},
  unmatched: {name: 'unmatched', color: '#7a5230', why: 'No match near was likelier, though what the scan saw was mapped: the pose is the predicted one.'},
  new_ground: {name: 'new ground', color: '#009e73', why: 'Most of what the scan saw was not mapped yet: the pose is the predicted one.'}
};
const byId = id => document.getElementById(id);
const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const element = (name, text, parent, className) => {
  const made = document.createElement(name);
  made.textContent = text;
  if (className) made.className = className;
  parent.appendChild(made);
  return made;
};
const grouped = value => Number(value).toLocaleString('en');
const words = text => text.replace(/_/g, ' ');
const lengthText = metres => metres === null ? 'unknown' : metres >= 1 ? metres.toPrecision(3) + ' m' :
  metres >= 0.01 ? (100 * metres).toPrecision(3) + ' cm' : (1000 * metres).toPrecision(2) + ' mm';
const listed = counts => Object.entries(counts).map(([name, n]) => words(name) + ' ' + grouped(n)).join(', ');

// --- the head ---
const names = report.bags.map(path => path.split('/').pop());
byId('title').textContent = names.join(', ');
byId('title').title = report.bags.join('\n');
document.title = names.join(', ') + ' – map_bag';
byId('about').textContent = 'mapped by matchbox_slam ' + report.version + ' (' + report.commit + ') on ' +
  report.date + ', scan topic ' + report.scan_topic;
const incident = text => element('div', text, byId('incidents'), 'warning');
if (report.damage) incident('The bag is damaged: ' + report.damage);
if (report.interrupted) incident('Interrupted: this is the part of the bag up to there.');
if (report.scans.maps_apart) incident('Maps of a lost robot that were found nowhere in the map: ' + report.scans.maps_apart);
const fact = (name, text) => { element('dt', name, byId('facts').appendChild(document.createElement('div'))); element('dd', text, byId('facts').lastChild); };
const scans = report.scans, map = report.map, ms = value => value.toFixed(value < 10 ? 2 : 1) + ' ms';
fact('scans', grouped(scans.received) + ' received, ' + grouped(scans.used) + ' used');
fact('skipped', scans.skipped_total ? grouped(scans.skipped_total) + ': ' + listed(scans.skipped) : 'none');
fact('matches', listed(scans.matches));
fact('state after a scan', listed(scans.state));
fact('loops', grouped(report.loops.closed) + ' closed, ' + grouped(report.loops.refused) + ' refused' +
  (report.loops.closed_before ? ', ' + grouped(report.loops.closed_before) + ' in the map before' : ''));
fact('matcher', report.matcher);
fact('CPU', (scans.used ? ms(1000 * report.cpu_s / scans.used) + ' a scan, ' : '') + report.cpu_s.toFixed(1) + ' s in all');
fact('time of a scan', 'median ' + ms(report.scan_ms.p50) + ', 95 % ' + ms(report.scan_ms.p95) + ', most ' + ms(report.scan_ms.max));
fact('map', (map.width * map.resolution).toFixed(1) + ' m × ' + (map.height * map.resolution).toFixed(1) + ' m, cells of ' +
  lengthText(map.resolution) + ', ' + map.memory_mb.toFixed(1) + ' MB in memory');
fact('bag', report.bag_s.toFixed(1) + ' s, mapped in ' + report.wall_s.toFixed(1) + ' s');

// --- colours by how sure ---
const sigmas = points.sigma.filter(value => value > 0).sort((a, b) => a - b);
// A lost robot may be anywhere: by its sigma all others would look the same.
const known = points.sigma.filter((value, i) => value > 0 && points.reason[i] !== 'lost').sort((a, b) => a - b);
const at = share => known.length ? known[Math.min(known.length - 1, Math.floor(share * known.length))] : 0.01;
const surest = at(0.02), widest = Math.max(at(0.995), 2 * surest);
const stops = [[38, 108, 224], [128, 72, 208], [214, 48, 120], [240, 110, 20]];
const rampColor = share => {
  const place = Math.max(0, Math.min(1, share)) * (stops.length - 1);
  const stop = Math.min(stops.length - 2, Math.floor(place));
  const mixed = stops[stop].map((low, i) => Math.round(low + (place - stop) * (stops[stop + 1][i] - low)));
  return 'rgb(' + mixed.join(',') + ')';
};
const colorOf = sigma => rampColor(sigma > 0 ? Math.log(sigma / surest) / Math.log(widest / surest) : sigma === null ? 1 : 0);
const scale = byId('scale');
element('span', 'path, by standard deviation of the position: ' + lengthText(surest), scale);
element('span', '', scale).id = 'ramp';
byId('ramp').style.background = 'linear-gradient(to right,' + [0, 1, 2, 3].map(i => rampColor(i / 3)).join(',') + ')';
element('span', lengthText(widest) + ' and more', scale);
const used = Object.keys(kinds).filter(kind => data.stretches.some(row => row.reason === kind));
for (const kind of used) {
  const entry = element('span', '', byId('legend'));
  element('span', '', entry, 'swatch').style.background = kinds[kind].color;
  entry.appendChild(document.createTextNode(kinds[kind].name + '\u2003'));
}

// --- drawing ---
const prepared = canvas => {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext('2d');
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return {pen, width, height};
};
let picked = null, isKept = false, asked = false;
const redraw = () => {
  if (!asked) {
    asked = true;
    requestAnimationFrame(() => { asked = false; if (zoom !== null) drawMap(); drawChart(); tell(); });
  }
};

// --- the map ---
const image = byId('map'), view = byId('view');
let zoom = null, shift = [0, 0];
const showWhole = () => {
  zoom = Math.min(view.clientWidth / frame.width, view.clientHeight / frame.height);
  shift = [(view.clientWidth - zoom * frame.width) / 2, (view.clientHeight - zoom * frame.height) / 2];
  redraw();
};
const onView = i => points.x[i] === null ? null :
  [shift[0] + zoom * (frame.left + points.x[i] * frame.pixels_per_metre),
   shift[1] + zoom * (frame.top - points.y[i] * frame.pixels_per_metre)];
const goesOn = i => i > 0 && points.x[i] !== null && points.x[i - 1] !== null &&
  Math.hypot(points.x[i] - points.x[i - 1], points.y[i] - points.y[i - 1]) < longestStep;
// Where the robot was carried there is no way.
const steps = [];
for (let i = 1; i < count; ++i) {
  if (points.x[i] !== null && points.x[i - 1] !== null) {
    steps.push(Math.hypot(points.x[i] - points.x[i - 1], points.y[i] - points.y[i - 1]));
  }
}
steps.sort((a, b) => a - b);
const longestStep = Math.max(3, 10 * (steps[Math.floor(steps.length / 2)] || 0));
const drawMap = () => {
  const {pen, width, height} = prepared(view);
  pen.imageSmoothingEnabled = zoom < 1;
  pen.imageSmoothingQuality = 'high';
  pen.drawImage(image, shift[0], shift[1], zoom * frame.width, zoom * frame.height);
  pen.lineCap = 'round';
  const thick = Math.max(2.5, Math.min(5, 3.5 * zoom));
  const segment = (i, color, size) => {
    const to = onView(i), from = goesOn(i) ? onView(i - 1) : to;
    pen.strokeStyle = color;
    pen.lineWidth = size;
    pen.beginPath();
    pen.moveTo(from[0], from[1]);
    pen.lineTo(to[0], to[1] + (from === to ? 0.01 : 0));
    pen.stroke();
  };
  pen.globalAlpha = 0.55;
  for (let i = 0; i < count; ++i) {
    if (points.reason[i] && points.x[i] !== null) segment(i, kinds[points.reason[i]].color, thick + 9);
  }
  pen.globalAlpha = 1;
  for (let i = 0; i < count; ++i) {
    if (points.x[i] !== null) segment(i, colorOf(points.sigma[i]), thick);
  }
  if (picked !== null && onView(picked)) {
    const [x, y] = onView(picked);
    pen.lineWidth = 5;
    pen.strokeStyle = '#ffffff';
    pen.beginPath(); pen.arc(x, y, 10, 0, 2 * Math.PI); pen.stroke();
    pen.lineWidth = 2.5;
    pen.strokeStyle = '#101418';
    pen.beginPath(); pen.arc(x, y, 10, 0, 2 * Math.PI); pen.stroke();
  }
};
// The place that is pointed at stays where it is.
const zoomBy = (factor, x, y) => {
  const least = 0.5 * Math.min(view.clientWidth / frame.width, view.clientHeight / frame.height);
  const next = Math.max(least, Math.min(20, zoom * factor));
  shift = [x - next / zoom * (x - shift[0]), y - next / zoom * (y - shift[1])];
  zoom = next;
  redraw();
};
view.addEventListener('wheel', event => {
  event.preventDefault();
  zoomBy(Math.exp(-0.0015 * event.deltaY), event.offsetX, event.offsetY);
}, {passive: false});
const fingers = new Map();  // or the mouse while it is pressed: where they are
view.addEventListener('pointerdown', event => {
  view.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
});
for (const end of ['pointerup', 'pointercancel']) {
  view.addEventListener(end, event => fingers.delete(event.pointerId));
}
view.addEventListener('pointermove', event => {
  const before = fingers.get(event.pointerId), now = [event.offsetX, event.offsetY];
  if (!before) return;
  fingers.set(event.pointerId, now);
  shift = [shift[0] + (now[0] - before[0]) / fingers.size, shift[1] + (now[1] - before[1]) / fingers.size];
  const other = [...fingers.keys()].find(id => id !== event.pointerId);
  if (other !== undefined) {
    const there = fingers.get(other);
    const apart = place => Math.max(20, Math.hypot(place[0] - there[0], place[1] - there[1]));
    zoomBy(apart(now) / apart(before), (now[0] + there[0]) / 2, (now[1] + there[1]) / 2);
  }
  redraw();
});
byId('whole').addEventListener('click', showWhole);

// --- the chart ---
const chart = byId('chart'), edge = {left: 62, right: 12, top: 8, bottom: 40};
const last = Math.max(count ? points.time[count - 1] : 0, 1e-3);
let span = [0, last];
const lowest = Math.pow(10, Math.floor(Math.log10(Math.max(1e-4, sigmas[0] || 0.001))));
const highest = Math.max(10 * lowest, 1.3 * (sigmas[sigmas.length - 1] || 0.01));
const chartX = time => edge.left + (time - span[0]) / (span[1] - span[0]) * (chart.clientWidth - edge.left - edge.right);
const chartY = sigma => chart.clientHeight - edge.bottom - (chart.clientHeight - edge.top - edge.bottom) *
  Math.max(0, Math.log(Math.max(sigma, lowest) / lowest) / Math.log(highest / lowest));
const drawChart = () => {
  const {pen, width, height} = prepared(chart);
  const bottom = height - edge.bottom, right = width - edge.right;
  pen.font = '12px system-ui, sans-serif';
  pen.fillStyle = style('--faint');
  pen.strokeStyle = style('--rule');
  pen.lineWidth = 1;
  pen.textBaseline = 'middle';
  pen.textAlign = 'right';
  for (let power = Math.round(Math.log10(lowest)); Math.pow(10, power) <= highest; ++power) {
    const y = Math.round(chartY(Math.pow(10, power))) + 0.5;
    pen.beginPath(); pen.moveTo(edge.left, y); pen.lineTo(right, y); pen.stroke();
    pen.fillText(power >= 0 ? Math.pow(10, power) + ' m' : power >= -2 ? Math.pow(10, power + 2) + ' cm' :
      Math.pow(10, power + 3) + ' mm', edge.left - 6, y);
  }
  pen.textAlign = 'center';
  pen.textBaseline = 'top';
  const rough = (span[1] - span[0]) / 8, power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = [1, 2, 5, 10].map(factor => factor * power).find(one => one >= rough);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  for (let k = Math.ceil(span[0] / step); k * step <= span[1]; ++k) {
    const x = Math.round(chartX(k * step)) + 0.5;
    pen.beginPath(); pen.moveTo(x, bottom); pen.lineTo(x, bottom + 5); pen.stroke();
    pen.fillText((k * step).toFixed(digits), x, bottom + 8);
  }
  pen.fillText('time since the first scan [s]', (edge.left + right) / 2, bottom + 24);
  pen.save();
  pen.translate(12, (edge.top + bottom) / 2);
  pen.rotate(-Math.PI / 2);
  pen.fillText('standard deviation', 0, -6);
  pen.restore();
  pen.save();
  pen.beginPath();
  pen.rect(edge.left, 0, right - edge.left, height);
  pen.clip();
  for (const row of data.stretches) {
    const from = chartX(row.from), wide = Math.max(2, chartX(row.to) - from);
    pen.fillStyle = kinds[row.reason].color;
    pen.globalAlpha = 0.22;
    pen.fillRect(from, edge.top, wide, bottom - edge.top);
    pen.globalAlpha = 1;
    pen.fillRect(from, bottom - 5, wide, 5);
  }
  pen.strokeStyle = style('--line');
  pen.lineWidth = 1.5;
  pen.lineJoin = 'round';
  pen.beginPath();
  for (let i = 0; i < count; ++i) {
    if (points.sigma[i] !== null) pen.lineTo(chartX(points.time[i]), chartY(points.sigma[i]));
  }
  pen.stroke();
  if (picked !== null) {
    const x = chartX(points.time[picked]);
    pen.strokeStyle = style('--picked');
    pen.lineWidth = 1;
    pen.beginPath(); pen.moveTo(x, edge.top); pen.lineTo(x, bottom); pen.stroke();
    if (points.sigma[picked] !== null) {
      pen.fillStyle = style('--picked');
      pen.beginPath(); pen.arc(x, chartY(points.sigma[picked]), 4, 0, 2 * Math.PI); pen.fill();
    }
  }
  pen.restore();
};
const timeAt = x => span[0] + (x - edge.left) / (chart.clientWidth - edge.left - edge.right) * (span[1] - span[0]);
const nearest = time => {
  let best = 0;
  for (let i = 1; i < count; ++i) {
    if (Math.abs(points.time[i] - time) < Math.abs(points.time[best] - time)) best = i;
  }
  return best;
};
const tell = () => {
  byId('told').textContent = picked === null ? '' : points.time[picked].toFixed(2) + ' s: ' +
    (points.x[picked] === null ? 'in a map apart, not on this one' :
      'x ' + points.x[picked].toFixed(2) + ' m, y ' + points.y[picked].toFixed(2) + ' m') +
    ', standard deviation ' + lengthText(points.sigma[picked]) +
    (points.reason[picked] ? ', ' + kinds[points.reason[picked]].name : '');
};
chart.addEventListener('pointermove', event => {
  if (!isKept && count) { picked = nearest(timeAt(event.offsetX)); redraw(); }
});
chart.addEventListener('pointerleave', () => { if (!isKept) { picked = null; redraw(); } });
chart.addEventListener('click', event => {
  if (count) { picked = nearest(timeAt(event.offsetX)); isKept = !isKept; redraw(); }
});
chart.addEventListener('wheel', event => {
  event.preventDefault();
  const middle = timeAt(event.offsetX), factor = Math.exp(0.0015 * event.deltaY);
  const wide = Math.max(last / 1e4, Math.min(last, factor * (span[1] - span[0])));
  const from = Math.max(0, Math.min(last - wide, middle - (middle - span[0]) * wide / (span[1] - span[0])));
  span = [from, from + wide];
  redraw();
}, {passive: false});
byId('all').addEventListener('click', () => { span = [0, last]; picked = null; isKept = false; redraw(); });
if (count < data.scans) {
  byId('thinned').textContent = grouped(count) + ' of ' + grouped(data.scans) +
    ' scans are drawn: both ends of each doubted stretch, and the least sure of those between. scans.csv has all.';
}

// --- the table ---
const table = byId('stretches'), body = table.querySelector('tbody');
table.hidden = !data.stretches.length;
if (!data.stretches.length) element('div', 'None: each pose is that of a match, with nothing else in question.', byId('omitted'));
for (const row of data.stretches) {
  const line = element('tr', '', body);
  element('td', row.from.toFixed(2), line, 'number');
  element('td', row.stamp.toFixed(3), line, 'number');
  element('td', (row.to - row.from).toFixed(2), line, 'number');
  element('td', grouped(row.scans), line, 'number');
  const what = element('td', '', line, 'what');
  element('span', '', what, 'swatch').style.background = kinds[row.reason].color;
  what.appendChild(document.createTextNode(kinds[row.reason].name));
  element('td', kinds[row.reason].why + (row.reason !== 'unmatched' && row.unmatched ?
    ' ' + grouped(row.unmatched) + ' of these scans were not matched.' : ''), line);
  line.addEventListener('click', () => {
    body.querySelectorAll('.picked').forEach(one => one.classList.remove('picked'));
    line.classList.add('picked');
    picked = nearest(row.from);
    isKept = true;
    redraw();
  });
}
if (data.stretches.length < data.stretches_in_all) {
  byId('omitted').textContent = grouped(data.stretches_in_all - data.stretches.length) +
    ' more stretches, of fewer scans, are left out here; scans.csv has them.';
}

byId('outside').hidden = frame.inside;
const begin = () => { image.style.display = 'none'; view.hidden = false; showWhole(); };
drawChart();
if (image.complete && image.naturalWidth) begin(); else image.addEventListener('load', begin);
window.addEventListener('resize', () => { if (zoom !== null) showWhole(); });
window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
</script>
</body>
</html>
)html";

}  // namespace matchbox_slam

"use strict";
const $ = (id) => document.getElementById(id);
const token = new URLSearchParams(location.search).get("token");
const withToken = (url) => token ? url + (url.includes("?") ? "&" : "?") + "token=" + encodeURIComponent(token) : url;
const fixed = (value, digits) => value === null || value === undefined ? "–" : value.toFixed(digits);
const kPollMs = 1000;

const details = {
  waiting: (s) => s.links.every((l) => l.connected) ? "for the first frame" : "for a tracker",
  live: () => "",
  stale: (s) => "no frame for " + ago(s.frame_age_s),
  disconnected: (s) => s.links.filter((l) => l.came && !l.connected && !l.ended).map((l) => l.name).join(", ") + " is gone",
  ended: () => "the source has ended",
  finishing: (s) => doneOf(s, "image"),
  refining: (s) => doneOf(s, "the mesh: step"),
  saving: (s) => doneOf(s, "the model: part"),
  judging: (s) => doneOf(s, "on held-out views: picture"),
  failed: () => "see below",
  stalled: (s) => "no news from the reconstructor for " + ago(s.published_age_s),
};

// What a person needs to know first, and how urgent it is: the tone of the traffic light.
const toldFirst = {
  waiting: (s) => ["idle", s.links.every((l) => l.connected) ? "The tracker is here. Waiting for its first image." : "Waiting for a tracker."],
  live: (s) => s.tracker.trouble ? ["bad", "The latest images cannot be used."] : ["good", progressOf(s)],
  stale: () => ["warn", "The camera sends nothing at the moment."],
  disconnected: (s) => ["bad", "The connection is lost: " + details.disconnected(s) + "."],
  ended: (s) => ["good", "All images have come. " + progressOf(s)],
  finishing: (s) => ["busy", "The last images are being added."],
  refining: () => ["busy", "The mesh is being improved a last time."],
  saving: () => ["busy", "The model is being saved."],
  judging: () => ["busy", "The model is saved. It is being compared with the views kept aside."],
  failed: () => ["bad", "The capture has stopped. What was stored is safe."],
  stalled: () => ["warn", "The reconstructor has fallen silent."],
};
function doneOf(s, what) {
  return s.ending.total ? what + " " + s.ending.done + " of " + s.ending.total : "";
}
function progressOf(s) {
  if (s.well_known) return "All of it is well known.";
  if (!s.surface || !s.surface.seen) return "Images arrive.";
  return Math.floor(100 * s.surface.seen) + " % of the surface is seen.";
}

// Where to go, or why that is not said: what the model has to say is old while images wait.
function nextOf(s) {
  if (s.ending) return "";
  if (s.next_view) return (s.well_known ? "Done: " : "Next: ") + s.next_view;
  return s.frames.waiting > 5 ? "The model catches up: " + s.frames.waiting + " images wait." : "";
}

// The rest in a line: how many, how good, what waits.
function countsOf(s) {
  const f = s.frames, last = s.held_out_curve[s.held_out_curve.length - 1], words = [];
  if (f.accepted) words.push(f.accepted + (f.accepted === 1 ? " image" : " images") + " in the model");
  if (last && last.psnr_db !== null) words.push(last.psnr_db.toFixed(1) + " dB on views it never saw");
  if (f.waiting > 1) words.push(f.waiting + " wait to be added");
  if (f.sequence_gaps) words.push(f.sequence_gaps + " lost on the way");
  return words.join(" · ");
}

function tell(tone, sentence) {
  document.body.dataset.tone = tone;
  if ($("sentence").textContent !== sentence) text("sentence", sentence);  // read out once
}

function ago(seconds) {
  if (seconds === null) return "–";
  if (seconds < 90) return Math.round(seconds) + " s";
  return seconds < 5400 ? Math.round(seconds / 60) + " min" : (seconds / 3600).toFixed(1) + " h";
}

function bytes(n) {
  const units = ["B", "KB", "MB", "GB"];
  let u = 0;
  while (n >= 1000 && u < units.length - 1) { n /= 1000; ++u; }
  return n.toFixed(u === 0 ? 0 : 1) + " " + units[u];
}

function text(id, value) { $(id).textContent = value; }

// rows: {name, value, shown, tone, scale}; bars share one scale unless a row brings its own (a queue's bound).
function bars(id, rows, none) {
  const box = $(id);
  box.replaceChildren();
  const greatest = Math.max(...rows.map((r) => r.value), 1e-12);
  for (const row of rows) {
    const name = document.createElement("span"), track = document.createElement("div");
    const fill = document.createElement("div"), value = document.createElement("span");
    name.className = "name"; name.textContent = name.title = row.name;
    track.className = "track"; fill.className = "fill " + (row.tone || "");
    fill.style.width = Math.min(100, 100 * row.value / (row.scale || greatest)) + "%";
    track.append(fill);
    value.className = "value"; value.textContent = row.shown;
    box.append(name, track, value);
  }
  if (rows.length === 0) {
    const empty = document.createElement("span");
    empty.className = "empty"; empty.textContent = none;
    box.append(empty);
  }
}

// Round steps for about n grid lines.
function ticks(low, high, n) {
  const raw = (high - low) / n, base = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].map((f) => f * base).find((s) => s >= raw);
  const out = [];
  for (let v = Math.ceil(low / step) * step; v <= high + 1e-9; v += step) out.push(v);
  return out;
}

function drawCurve(curve) {
  if (!$("details").open) return;
  const canvas = $("curve"), style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const scale = window.devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
  canvas.width = Math.round(w * scale); canvas.height = Math.round(h * scale);
  const g = canvas.getContext("2d");
  g.scale(scale, scale);
  g.font = "12px system-ui, sans-serif";
  g.fillStyle = colour("--soft");
  const points = curve.filter((p) => p.psnr_db !== null);
  if (points.length === 0) {
    g.textAlign = "center";
    g.fillText("The curve begins with the first held-out views", w / 2, h / 2);
    return;
  }
  const values = points.flatMap((p) => p.constant_psnr_db === null ? [p.psnr_db] : [p.psnr_db, p.constant_psnr_db]);
  const low = Math.floor(Math.min(...values) - 0.5), high = Math.ceil(Math.max(...values) + 0.5);
  const first = points[0].images, last = Math.max(points[points.length - 1].images, first + 1);
  const left = 46, right = w - 10, top = 8, bottom = h - 24;
  const x = (images) => left + (images - first) / (last - first) * (right - left);
  const y = (db) => bottom - (db - low) / (high - low) * (bottom - top);

  g.strokeStyle = colour("--line"); g.lineWidth = 1;
  g.textAlign = "right"; g.textBaseline = "middle";
  for (const db of ticks(low, high, 6)) {
    g.beginPath(); g.moveTo(left, y(db)); g.lineTo(right, y(db)); g.stroke();
    g.fillText(db + " dB", left - 6, y(db));
  }
  g.textAlign = "center"; g.textBaseline = "alphabetic";
  for (const n of ticks(first, last, Math.min(8, w / 90)))
    if (Number.isInteger(n)) g.fillText(n, Math.min(x(n), right - 8), h - 6);

  const line = (key) => {
    g.beginPath();
    points.filter((p) => p[key] !== null).forEach((p, i) => g[i ? "lineTo" : "moveTo"](x(p.images), y(p[key])));
  };
  g.lineJoin = "round";
  line("constant_psnr_db"); g.strokeStyle = colour("--idle"); g.lineWidth = 1.5; g.setLineDash([5, 4]); g.stroke();
  g.setLineDash([]);
  line("psnr_db"); g.strokeStyle = colour("--accent"); g.lineWidth = 2.5; g.stroke();
  const end = points[points.length - 1];
  g.beginPath(); g.arc(x(end.images), y(end.psnr_db), 4, 0, 7); g.fillStyle = colour("--accent"); g.fill();
}

// Effort, time and memory against what was asked for, and how soundly the model holds what it was given.
function tradeRows(t) {
  const part = (value) => value === null ? "–" : (value >= 0.1 ? (100 * value).toFixed(0) : (100 * value).toPrecision(2)) + " %";
  const against = (name, value, limit, kept, shown) => ({
    name: name, value: value || 0, scale: limit || value || 1, tone: kept === null ? "idle" : kept ? "good" : "bad",
    shown: (value === null ? "–" : shown(value)) + (limit === null ? "" : " of " + shown(limit)) +
      (kept === null ? "" : kept ? ", kept" : ", NOT KEPT")});
  const full = t.effort_level === 0 && t.update_fraction === 1;
  const left = t.effort_levels > 1 ? 1 - t.effort_level / t.effort_levels : 1;
  return [
    {name: "effort", value: left, scale: 1, tone: full ? "good" : "warn",
      shown: t.effort_level === 0 ? "full" : "level " + t.effort_level + " of " + (t.effort_levels - 1)},
    {name: "of each image", value: t.update_fraction, scale: 1, tone: t.update_fraction === 1 ? "good" : "warn",
      shown: part(t.update_fraction)},
    against("time per image", t.image_s, t.budget_s, t.budget_kept, (s) => fixed(1000 * s, 1) + " ms"),
    against("memory grown", t.grown_bytes, t.memory_bytes, t.memory_kept, bytes),
    {name: "energy lost", value: t.energy_lost || 0, scale: 1, tone: "idle", shown: part(t.energy_lost)},
    {name: "orthogonality lost", value: 0, scale: 1, tone: "idle",
      shown: t.orthogonality_lost === null ? "–" : t.orthogonality_lost.toExponential(1)},
  ];
}

const shownPictures = {preview: -1, shape: -1, camera: -1};
function picture(name, version) {
  if (shownPictures[name] === version) return;
  shownPictures[name] = version;
  $(name).hidden = version === 0;
  $(name + "-none").hidden = version !== 0;
  if (version > 0) $(name).src = withToken(name + ".jpg?v=" + version);
}

// The model itself in place of its picture: whoever asks for it gets a page within this one.
let turned = null;
$("turn").onclick = () => {
  if (turned) turned.remove();
  turned = turned ? null : document.createElement("iframe");
  $("turn").ariaPressed = String(turned !== null);
  $("model").classList.toggle("turned", turned !== null);
  if (!turned) return;
  turned.src = withToken("model/");
  turned.title = "The model, to be turned by hand";
  $("model").prepend(turned);
};

const history = [];  // of counts, for the rate at which frames arrive
function arrivalRate(received) {
  const now = performance.now() / 1000;
  if (history.length > 0 && received < history[history.length - 1][1]) history.length = 0;
  history.push([now, received]);
  while (history.length > 2 && now - history[0][0] > 10) history.shift();
  const span = now - history[0][0];
  return span > 0.5 ? (received - history[0][1]) / span : null;
}

function show(s) {
  document.body.dataset.state = s.state;
  document.title = s.state.toUpperCase() + " · Sheen";
  text("state-name", s.state);
  text("state-detail", details[s.state](s));
  text("session", s.session_folder);
  $("ending").hidden = !s.ending;
  if (s.ending) {
    const percent = 100 * s.ending.done / Math.max(1, s.ending.total);
    $("ending").ariaValueNow = Math.round(percent);
    $("ending").firstElementChild.style.width = percent + "%";
  }
  const paused = s.paused && !s.ending && s.state !== "failed";
  const begins = s.doing && ["waiting", "ended"].includes(s.state);
  tell(...(begins ? ["busy", s.doing] : paused ? ["warn", "Paused: images are stored, but not added to the model."] : toldFirst[s.state](s)));
  $("pause").dataset.what = paused ? "go-on" : "pause";
  text("pause", paused ? "Go on" : "Pause");
  text("counts", countsOf(s));
  $("steering").hidden = !s.may_steer || Boolean(s.ending) || s.state === "failed";
  if (s.steering) text("steered", s.steering);
  $("error").hidden = !s.error; text("error", s.error);
  text("next-view", nextOf(s));
  $("next-view").hidden = !$("next-view").textContent;
  $("next-view").classList.toggle("done", s.well_known);
  $("hint").hidden = !s.hint; $("hint").firstElementChild.textContent = s.hint;

  $("warnings").hidden = !s.warnings.length; text("warnings", s.warnings.join("\n"));
  $("trouble").hidden = !s.tracker.trouble; text("trouble", s.tracker.trouble);

  const f = s.frames, curve = s.held_out_curve, last = curve[curve.length - 1];
  const refused = Object.entries(f.refused), allRefused = refused.reduce((sum, r) => sum + r[1], 0);
  text("accepted", f.accepted);
  text("accepted-detail", f.received + " received, " + allRefused + " refused" + (f.waiting ? ", " + f.waiting + " waiting" : ""));
  text("psnr", last ? fixed(last.psnr_db, 2) : "–");
  text("psnr-detail", last && last.psnr_db !== null && last.constant_psnr_db !== null
    ? (last.psnr_db >= last.constant_psnr_db ? "+" : "−") +
      Math.abs(last.psnr_db - last.constant_psnr_db).toFixed(2) + " dB over constant colour" : "");
  text("ssim", last ? fixed(last.ssim, 4) : "–");
  text("ssim-detail", f.held_out + " views held out");
  text("rate", s.ingest_images_per_s ? fixed(s.ingest_images_per_s, 1) : "–");
  const arriving = arrivalRate(f.received);
  text("rate-detail", arriving === null ? "" : arriving.toFixed(1) + " arriving");
  text("latency", s.latency_s.count ? fixed(1000 * s.latency_s.p95, 0) : "–");
  text("latency-detail", s.latency_s.count
    ? "p50 " + fixed(1000 * s.latency_s.p50, 0) + ", p99 " + fixed(1000 * s.latency_s.p99, 0) : "");
  text("picture-latency", s.picture_latency_s.count ? fixed(1000 * s.picture_latency_s.p50, 0) : "–");
  text("picture-latency-detail", s.model_latency_s.count
    ? "p50; " + fixed(1000 * s.model_latency_s.p50, 0) + " to the model" : "");
  text("curve-detail", last ? "over " + last.images + " images" : "");
  drawCurve(curve);

  bars("frames", [
    {name: "accepted", value: f.accepted, shown: f.accepted, tone: "good"},
    {name: "held out", value: f.held_out, shown: f.held_out},
    {name: "taken back", value: f.withdrawn, shown: f.withdrawn},
    {name: "waiting", value: f.waiting, shown: f.waiting, tone: "idle"},
    ...refused.sort((a, b) => b[1] - a[1]).map(([reason, n]) => (
      {name: reason.replaceAll("_", " "), value: n, shown: n, tone: "warn"})),
    ...Object.entries(s.tracker.refused).sort((a, b) => b[1] - a[1]).map(([reason, n]) => (
      {name: "tracker: " + reason.replaceAll("_", " "), value: n, shown: n + " of " + s.tracker.judged, tone: "warn"})),
    {name: "lost on the way", value: f.sequence_gaps, shown: f.sequence_gaps, tone: "bad"},
  ]);
  bars("queues", Object.entries(s.queues).map(([name, q]) => ({
    name: name, value: q.depth, scale: q.capacity, shown: q.capacity ? q.depth + " of " + q.capacity : q.depth,
    tone: q.capacity && q.depth >= q.capacity ? "bad" : q.capacity && q.depth > q.capacity / 2 ? "warn" : ""})),
    "Nothing waits");
  bars("stages", Object.entries(s.stage_s).map(([name, t]) => (
    {name: name.replaceAll("_", " "), value: t || 0, shown: t === null ? "–" : fixed(1000 * t, 1)})),
    "No image yet");
  bars("ranks", s.rank_histogram.map((n, rank) => (
    {name: "rank " + rank, value: n, shown: n, tone: rank === 0 ? "idle" : ""})), "No patches yet");
  text("bytes", s.model_bytes ? bytes(s.model_bytes) : "");

  bars("trade", tradeRows(s.trade));
  text("trade-detail", (s.trade.favour ? "favours " + s.trade.favour + "; " : "") + (s.trade.resident_bytes ? "process: " + bytes(s.trade.resident_bytes) : ""));

  $("links").replaceChildren(...s.links.map((l) => {
    const item = document.createElement("li"), dot = document.createElement("span");
    const name = document.createElement("b"), where = document.createElement("code");
    const how = document.createElement("span");
    item.className = l.connected ? "connected" : l.came && !l.ended ? "gone" : "";
    dot.className = "dot"; name.textContent = l.name; where.textContent = l.endpoint;
    how.textContent = (l.connected ? "connected" : l.ended ? "has ended" : l.came ? "gone" : "not there yet") + (l.encrypted ? ", encrypted" : "");
    item.append(dot, name, where, how);
    if (l.last_error) {
      const trouble = document.createElement("span");
      trouble.className = "trouble"; trouble.textContent = l.last_error;
      item.append(trouble);
    }
    return item;
  }));
  picture("preview", s.pictures.preview);
  text("preview-note", s.pictures.preview_note);
  $("turn").hidden = !s.pictures.model_page;
  $("shape-figure").hidden = !s.shape || !s.pictures.shape;
  if (s.shape) {
    picture("shape", s.pictures.shape);
    const shares = $("shape-shares").querySelectorAll("b");
    [s.shape.seen, s.shape.outlined, s.shape.guessed].forEach((share, i) => shares[i].textContent = Math.round(100 * share) + " %");
  }
  picture("camera", s.pictures.camera);
  text("photometric", s.photometric ? "light: " + s.photometric : "");
  text("version", "Sheen " + s.version);
  latest = s;
}

let latest = null;
async function poll() {
  try {
    const answer = await fetch(withToken("status.json"), {cache: "no-store", signal: AbortSignal.timeout(4000)});
    if (!answer.ok) throw new Error(answer.status === 401 ? "the token is wrong or missing" : answer.status === 429 ? "too many wrong tokens" : "HTTP " + answer.status);
    show(await answer.json());
  } catch (error) {
    document.body.dataset.state = "unreachable";
    document.title = "UNREACHABLE · Sheen";
    text("state-name", "unreachable");
    text("state-detail", error.name === "Error" ? error.message : "the reconstructor does not answer");
    tell("bad", error.name === "Error" ? "This page gets no answer: " + error.message + "." : "The reconstructor does not answer.");
  }
  setTimeout(poll, kPollMs);
}
for (const link of document.querySelectorAll("footer a")) link.href = withToken(link.getAttribute("href"));
// Only who has the token for steering sees the buttons; the server asks for it again, in a header that no link can set.
const questions = {
  undo: () => confirm("Take the last image back? It stays in the session, and the model forgets it.") && "",
  "hold-out": () => "",
  pause: () => "",
  "go-on": () => "",
  note: () => prompt("A note for this capture:"),
  finish: () => confirm("Finish the capture? The waiting images are added and the model is saved.") && "",
};
async function steer(what) {
  const answer = questions[what]();
  if (answer === null || answer === false || (what === "note" && !answer.trim())) return;
  try {
    const said = await fetch("steer?what=" + what + "&text=" + encodeURIComponent(answer),
      {method: "POST", headers: {Authorization: "Bearer " + token}, signal: AbortSignal.timeout(4000)});
    text("steered", said.ok ? "Asked for; it is done within a second." : await said.text());
  } catch {
    text("steered", "Not asked for: the reconstructor does not answer.");
  }
}
for (const button of document.querySelectorAll("#steering button")) button.onclick = () => steer(button.dataset.what);

// Whoever opened the details finds them open again.
$("details").open = location.hash === "#details" || sessionStorage.getItem("details") === "open";
$("details").addEventListener("toggle", () => {
  sessionStorage.setItem("details", $("details").open ? "open" : "");
  if (latest) drawCurve(latest.held_out_curve);
});
window.addEventListener("resize", () => { if (latest) drawCurve(latest.held_out_curve); });
poll();

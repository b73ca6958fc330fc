// The operator's page: shows the state that the server sends, and sends what operators want.
"use strict";

const at = (id) => document.getElementById(id);
const RECONNECT_MS = 700;
const LONGEST_TEXT = 1900; // of an answer in one's own words: a message has 4096 characters
const BUTTONS_AT_MOST = 25; // a finer scale is typed
let socket = null;
let state = null;
let shownQuestion = "";
let correcting = null; // name of the item that is asked again
let pictureUrl = null;
let arrivedMs = 0; // when the state came
let pageId = 0;
const mine = new Set(); // ids of messages whose answer has not come
const prefix = Math.random().toString(36).slice(2);

function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function make(tag, text, attributes = {}) {
  const element = document.createElement(tag);
  element.textContent = text;
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

function connect() {
  socket = new WebSocket(`ws://${location.host}/session`);
  socket.binaryType = "blob";
  socket.onopen = () => { put(at("link"), "Connected."); watch(); mark(); };
  socket.onclose = () => {
    if (state && state.ended) return put(at("link"), "The session has ended; this page can be closed.");
    put(at("link"), "Not connected; the session goes on. Trying again …");
    mark("lost");
    setTimeout(connect, RECONNECT_MS);
  };
  socket.onmessage = (message) => {
    if (typeof message.data !== "string") return showPicture(message.data);
    const content = JSON.parse(message.data);
    if (content.kind === "you") put(at("you"), content.operator);
    else if (content.kind === "reply") put(at("refusal"), content.refusal);
    else show(content);
  };
}

function send(action, more = {}) {
  if (socket === null || socket.readyState !== WebSocket.OPEN) {
    put(at("refusal"), "Not connected: nothing was sent. It can be asked for again in a moment.");
    return;
  }
  const id = `${prefix}-${pageId += 1}`;
  if (action !== "watch") mine.add(id);
  const step = state && state.step ? state.step.number : 0;
  socket.send(JSON.stringify({ id, action, step, ...more }));
}

function watch() {
  const looks = at("look").checked && !document.hidden;
  if (socket.readyState === WebSocket.OPEN) send("watch", { value: looks ? 1 : 0 });
}

function showPicture(blob) {
  if (pictureUrl) URL.revokeObjectURL(pictureUrl);
  pictureUrl = URL.createObjectURL(blob);
  at("eyes").src = pictureUrl;
  if (state && state.step) showEyes();
}

function show(now) {
  state = now;
  arrivedMs = performance.now();
  if (state.step) {
    const depth = state.depth ? `, depth ${state.depth.replace("_", "-")}` : "";
    put(at("who"), `${state.participant}, session ${state.session}, order ${state.sequence}${depth}`);
    showStep();
    showSessionLeft();
    showEyes();
    showQuestion(state.question || null);
    showRatings();
    showFrames(state.frame);
    showTimeline();
    mark();
  }
  showLines();
  for (const [id, refusal] of state.replies) {
    if (mine.delete(id)) put(at("refusal"), refusal);
  }
  if (!state.pictures) {
    at("look").disabled = true;
    put(at("eyes-words"), "Pictures are not available in this session.");
  }
}

// One word for the style sheet: the colour of the state line, and what keeps its place.
function mark(word = "") {
  if (!state || !state.step) { document.body.dataset.state = word; return; }
  const scene = ["training", "exposure"].includes(state.step.kind);
  const runs = scene || state.step.kind === "rest";
  const now = state.ended ? "ended" : state.paused ? "paused" : state.question ? "asking" : runs ? "running" : "waiting";
  document.body.dataset.state = word || now;
  document.body.dataset.view = scene && state.pictures && at("look").checked ? "on" : "off";
  document.body.dataset.rates = scene && state.step.kind === "exposure" && asksHere ? "yes" : "no";
}
let asksHere = false; // whether questions come to this page in an exposure: their place is kept then

function showStep() {
  const paused = state.paused ? " — paused" : "";
  const words = state.ended ? `The session has ended: ${state.ended}` : state.step.words + paused;
  put(at("step"), words.charAt(0).toUpperCase() + words.slice(1));
  const timed = ["training", "exposure", "rest"].includes(state.step.kind) && state.total > 0;
  at("progress").max = state.total || 1;
  at("progress").value = state.done || 0;
  const left = Math.max(state.total - state.done, 0);
  const count = state.total ? `${state.done} of ${state.total}` : "";
  put(at("left"), timed ? `${clock(left)} left of ${clock(state.total)}` : count);
  for (const button of document.querySelectorAll(".actions button")) {
    const action = button.dataset.action;
    const meant = state.allowed.includes(action);
    const turn = action === "pause" ? !state.paused : action === "go_on" ? state.paused : true;
    const hidden = !meant || !turn;
    if (button.hidden !== hidden) {
      const focused = document.activeElement === button;
      button.hidden = hidden;
      if (focused) at("actions").focus(); // to another button, Enter would do another thing
    }
  }
  const asks = state.withdrawing && !state.ended;
  if (at("withdrawing").hidden === asks) {
    at("withdrawing").hidden = !asks;
    if (asks) at("withdrawing-why").focus();
  }
}

// A question may stand for long without news: meanwhile the page counts by itself.
function showSessionLeft() {
  if (!state || !state.step) return;
  const stands = state.paused || state.step.kind === "ready";
  const since = stands ? 0 : (performance.now() - arrivedMs) / 1000;
  const left = about(Math.max(state.remaining_s - since, 0));
  put(at("session-left"), state.ended ? "" : `About ${left} left of the session (an estimate).`);
}

function about(seconds) {
  if (seconds >= 90) return `${Math.round(seconds / 60)} min`;
  return `${Math.max(Math.round(seconds / 10) * 10, 10)} s`;
}

// Between exposures, and in a pause, the last picture would be one of what is gone.
function showEyes() {
  const scene = ["training", "exposure"].includes(state.step.kind) && !state.paused && !state.ended;
  at("eyes").hidden = !at("look").checked || !scene || pictureUrl === null;
  const why = !at("look").checked ? "Pictures are switched off below." : scene ? "" : "The participant sees no scene now.";
  if (state.pictures) put(at("eyes-words"), why);
}

function clock(seconds) {
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

function showQuestion(question) {
  const text = JSON.stringify(question);
  if (text === shownQuestion) return;
  const before = shownQuestion ? JSON.parse(shownQuestion) : null;
  shownQuestion = text;
  at("question").hidden = question === null;
  if (question === null || before === null || before.title !== question.title) correcting = null;
  if (question === null) return;
  if (question.action === "rate") asksHere = true;
  if (before === null || before.title !== question.title) beep();
  put(at("question-title"), question.title);
  put(at("instruction"), question.instruction);
  const items = question.items;
  const again = items.findIndex((item) => item.name === correcting);
  const place = again < 0 ? question.current : again;
  showItem(question, items[place], place);
  at("items").replaceChildren(...(items.length > 1 ? items.map(itemLine) : []));
  at("confirm").hidden = question.action !== "answer" || items.some((item) => !item.answered);
  if (!at("confirm").hidden && again < 0 && mayTakeFocus()) at("confirm").focus();
}

// Whoever has gone to a button or is typing is about to use it: what appears leaves them there.
function mayTakeFocus() {
  if (at("ask").open || !at("withdrawing").hidden) return false;
  const now = document.activeElement;
  return now === null || now === document.body || now === at("actions") || at("question").contains(now);
}

let audio = null;
function beep() {
  if (!at("sound").checked) return;
  try {
    audio = audio || new AudioContext();
    const tone = audio.createOscillator(), level = audio.createGain();
    level.gain.setValueAtTime(0.15, audio.currentTime);
    level.gain.exponentialRampToValueAtTime(0.001, audio.currentTime + 0.25);
    tone.frequency.value = 880;
    tone.connect(level).connect(audio.destination);
    tone.start();
    tone.stop(audio.currentTime + 0.25);
  } catch { /* a page without sound is a page all the same */ }
}

function itemLine(item) {
  const line = make("li", `${item.text}: ${said(item)} `);
  if (item.answered) {
    const change = make("button", "Change", { "aria-label": `Change ${item.text}` });
    change.onclick = () => { correcting = item.name; shownQuestion = ""; showQuestion(state.question); };
    line.append(change);
  }
  return line;
}

function said(item) {
  if (!item.answered) return "–";
  if (item.answer === null) return "rather not say";
  const label = item.labels[item.values.indexOf(item.answer)];
  return label ? `${item.answer} ${label}` : String(item.answer);
}

function showItem(question, item, place) {
  const group = at("answers");
  if (item === undefined) {
    put(at("item"), "All questions are answered. Look through the answers with the participant.");
    group.replaceChildren();
    return;
  }
  put(at("item"), question.items.length > 1 ? `${place + 1}. ${item.text}` : item.text);
  const give = (value) => { correcting = null; send(question.action, { text: item.name, value }); };
  const parts = question.action === "write" ? written(item) : item.values.length <= BUTTONS_AT_MOST ? item.values.map((value, index) => {
    const label = item.labels[index] || "";
    const button = make("button", `${value} ${label}`.trim(), { "data-value": value });
    button.onclick = () => give(value);
    return button;
  }) : typed(item, give);
  if (item.ends.length) {
    parts.unshift(make("span", `${item.ends[0]} `));
    parts.push(make("span", ` ${item.ends[1]}`));
  }
  if (question.action === "answer") {
    const declined = make("button", "Rather not say", { "data-value": "" });
    declined.onclick = () => give(null);
    parts.push(declined);
  }
  group.replaceChildren(...parts);
  const first = group.querySelector("textarea, button, input");
  if (first && mayTakeFocus()) first.focus();
}

function written(item) {
  const area = make("textarea", "", { rows: 4, maxlength: LONGEST_TEXT, "aria-label": item.text });
  const button = make("button", "Enter");
  button.onclick = () => send("write", { text: area.value });
  return [area, button];
}

function typed(item, give) {
  const [low, high] = [item.values[0], item.values[item.values.length - 1]];
  const input = make("input", "", { type: "number", min: low, max: high, step: item.values[1] - low,
    "aria-label": `${item.text}: ${low} to ${high}` });
  const button = make("button", "Enter");
  button.onclick = () => give(input.value === "" ? null : Number(input.value));
  input.onkeydown = (event) => { if (event.key === "Enter") button.click(); };
  return [input, button];
}

const SVG = "http://www.w3.org/2000/svg";
function shape(tag, attributes, text = "") {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.textContent = text;
  return element;
}

// One curve per instrument on its own scale's range; a dashed line is the answer that ends exposures.
function showRatings() {
  const points = state.ratings, scales = state.scales || [];
  const names = [...new Set([...points.map(([name]) => name), ...scales.map((each) => each.instrument)])];
  const words = names.map((name) => ratingWords(name, points.filter(([of]) => of === name))).filter(Boolean).join(" ");
  const text = words || "None yet.";
  const longest = Math.max(state.total || 1, ...points.map(([, s]) => s));
  const drawn = JSON.stringify([text, longest, scales]);
  put(at("curve-words"), text);
  if (at("curve").dataset.drawn === drawn) return;
  at("curve").dataset.drawn = drawn;
  const highest = Math.max(...scales.map((each) => each.high), ...points.map(([, , value]) => value || 0), 1);
  const lowest = Math.min(...scales.map((each) => each.low), 0);
  const x = (s) => 30 + 350 * s / longest;
  const y = (value) => 145 - 130 * (value - lowest) / (highest - lowest);
  const rules = scales.filter((each) => each.stop_at !== null).flatMap((each) => {
    const often = each.in_a_row > 1 ? `, ${each.in_a_row} in a row` : "";
    return [
      shape("line", { class: "stop", x1: 30, y1: y(each.stop_at), x2: 390, y2: y(each.stop_at) }),
      shape("text", { class: "stop-words", x: 390, y: y(each.stop_at) - 4, "text-anchor": "end" }, `${each.instrument} stops at ${each.stop_at}${often}`),
    ];
  });
  const curves = names.flatMap((name) => {
    const own = points.filter(([of]) => of === name);
    const given = own.filter(([, , value]) => value !== null);
    const stop = (scales.find((each) => each.instrument === name) || {}).stop_at ?? Infinity;
    const line = given.map(([, s, value], n) => `${n ? "L" : "M"}${x(s)} ${y(value)}`).join(" ");
    const last = given[given.length - 1];
    return [
      shape("path", { class: "curve", d: line || "M0 0" }),
      ...given.map(([, s, value]) => shape("circle", { cx: x(s), cy: y(value), r: 4, class: value >= stop ? "high" : "" })),
      ...own.filter(([, , value]) => value === null).map(([, s]) => shape("text", { x: x(s) - 3, y: 143 }, "×")),
      ...(last ? [shape("text", { x: Math.min(x(last[1]) + 7, 350), y: y(last[2]) - 6 }, `${name} ${last[2]}`)] : []),
    ];
  });
  at("curve").replaceChildren(
    ...[0.25, 0.5, 0.75, 1].map((part) => shape("line", { class: "grid", x1: 30, x2: 390, y1: 145 - 130 * part, y2: 145 - 130 * part })),
    shape("line", { x1: 30, y1: 145, x2: 390, y2: 145 }),
    shape("text", { x: 4, y: 19 }, String(highest)),
    shape("text", { x: 4, y: 149 }, String(lowest)),
    shape("text", { x: 352, y: 162 }, clock(longest)),
    ...rules,
    ...curves,
  );
}

function ratingWords(name, points) {
  if (points.length === 0) return "";
  const given = points.filter(([, , value]) => value !== null);
  const said = given.map(([, s, value]) => `${value} at ${clock(s)}`).join(", ") || "none answered";
  const missed = points.length - given.length;
  return `${name}: ${said}${missed ? `; ${missed} missed` : ""}.`;
}

function showFrames(frame) {
  const rows = [];
  at("frames-part").hidden = !frame;
  if (frame) {
    const [x, y, z, w] = frame.head_turn;
    const deg = (radians) => `${(radians * 180 / Math.PI).toFixed(0)}°`;
    const pitch = deg(Math.asin(Math.max(-1, Math.min(1, 2 * (w * x - y * z)))));
    const yaw = deg(Math.atan2(2 * (x * z + w * y), 1 - 2 * (x * x + y * y)));
    const roll = deg(Math.atan2(2 * (x * y + w * z), 1 - 2 * (x * x + z * z)));
    rows.push(["Position", frame.head_m.map((m) => (Math.round(m * 100) / 100 + 0).toFixed(2)).join(", ") + " m"]);
    rows.push(["Orientation", `yaw ${yaw}, pitch ${pitch}, roll ${roll}`]);
    rows.push(["Tracked", frame.tracked ? "yes" : "no"]);
    rows.push(["Focus distance", frame.focus_m === null ? "–" : `${frame.focus_m.toFixed(2)} m`]);
    rows.push(["Largest blur", frame.max_blur_px === null ? "–" : `${frame.max_blur_px.toFixed(1)} px`]);
    rows.push(["Frames", String(frame.frames)]);
    rows.push(["Dropped", String(frame.dropped)]);
    rows.push(["Untracked", String(frame.untracked)]);
    rows.push(["Frozen", `${frame.frozen_s.toFixed(2)} s`]);
  }
  at("frames").replaceChildren(...rows.flatMap(([name, value]) => [make("dt", name), make("dd", value)]));
}

function showTimeline() {
  const list = at("timeline"), text = JSON.stringify([state.timeline, state.position]);
  if (list.dataset.shown === text) return;
  list.dataset.shown = text;
  list.replaceChildren(...state.timeline.map((name, index) =>
    make("li", name, index + 1 === state.position ? { "aria-current": "step" } : {})));
  const now = list.querySelector("[aria-current]");
  if (now) list.scrollTop = now.offsetTop - list.offsetTop - list.clientHeight / 2;
}

function showLines() {
  const list = at("lines");
  const last = state.lines[state.lines.length - 1] || "";
  if (list.dataset.last === last && list.children.length === state.lines.length) return;
  list.dataset.last = last;
  list.replaceChildren(...state.lines.map((line) => make("li", line)));
  list.scrollTop = list.scrollHeight;
}

// What needs words is asked for first; it is meant for the step in which that was opened.
const ASKS = { note: "Note", abort: "Why is the session stopped? It can be resumed." };
function askAndSend(action) {
  if (action === "withdraw_surely") return send(action, { text: at("withdrawing-why").value });
  if (!ASKS[action]) return send(action);
  put(at("ask-title"), ASKS[action]);
  at("ask-text").value = "";
  const step = state && state.step ? state.step.number : 0;
  at("ask").onclose = () => {
    if (at("ask").returnValue === "yes") send(action, { step, text: at("ask-text").value });
    at("ask").returnValue = "";
  };
  at("ask").showModal();
  at("ask-text").focus();
}

document.addEventListener("click", (event) => {
  const button = event.target.closest("button[data-action]");
  if (!button) return;
  // It has been pressed: left there, the next Enter would do it again, whatever is asked by then.
  if (at("actions").contains(button)) at("actions").focus();
  askAndSend(button.dataset.action);
});
document.addEventListener("keydown", (event) => {
  const typing = /^(INPUT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "checkbox";
  if (typing || !at("keys").checked || event.ctrlKey || event.metaKey || event.altKey) return;
  if (at("ask").open || state === null) return;
  const key = event.key.toLowerCase();
  if (key === "p" && state.allowed.includes("pause")) askAndSend(state.paused ? "go_on" : "pause");
  else if (key === "n" && state.allowed.includes("note")) askAndSend("note");
  else if (/^[0-9]$/.test(key)) {
    const button = at("answers").querySelector(`button[data-value="${key}"]`);
    const longer = at("answers").querySelector('button[data-value="10"]'); // 1 may begin 12
    if (!button || longer) return;
    button.click();
  } else return;
  event.preventDefault();
});
at("look").addEventListener("change", () => {
  if (state && state.step) { showEyes(); mark(); }
  watch();
});
document.addEventListener("visibilitychange", watch);
setInterval(showSessionLeft, 1000);
connect();

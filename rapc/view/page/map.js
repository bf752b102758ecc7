// The drawing of a picture beside what the robot believes: the functions of
// rapc/view/scene.py. The tests compare the shapes of both.

const ACROSS = 124, DOWN = 104, SIDE = 66, TOP = 30;
const BOX = 11, IN_ROW = 8, WIDE = 760, LETTER = 6.0, BOLD = 7.2;

const LOOKS = {
  red: "#d73027", blue: "#3a6fd8", yellow: "#f2c81e", green: "#35a35c", white: "#ffffff",
  black: "#222222", orange: "#f08a24", brown: "#8a5a33", purple: "#8e4bb0", grey: "#8b919b",
};

const TURNS = {
  north: 0, northeast: 45, east: 90, southeast: 135,
  south: 180, southwest: 225, west: 270, northwest: 315,
};

const FACT_WORD = /"(?:[^"\\]|\\.)*"|[^\s()"]*\([^()]*\)|[^\s()"]+/g;

/** The number of pictures before a picture that give the path of the robot. */
const PATH = 20;

const own = (object, key) => (Object.hasOwn(object, key) ? object[key] : undefined);

/** Return the object after a JSON merge patch (RFC 7396). */
function mergePatch(before, patch) {
  const found = { ...before };
  for (const [key, value] of Object.entries(patch)) {
    if (value === null) delete found[key];
    else if (typeof value === "object" && !Array.isArray(value)) {
      const old = own(found, key);
      const whole = old && typeof old === "object" && !Array.isArray(old);
      found[key] = mergePatch(whole ? old : {}, value);
    } else found[key] = value;
  }
  return found;
}

/** The pictures of a run: each with the index of its event, and its change. */
class Pictures {
  constructor(changes) {
    this._at = [];
    this._all = [];
    this.append(changes);
  }

  /** Add the next changes. */
  append(changes) {
    for (const [at, change] of changes) {
      if (change === null || typeof change !== "object") continue;
      this._all.push(mergePatch(this._all.at(-1) || {}, change));
      this._at.push(at);
    }
  }

  get size() {
    return this._all.length;
  }

  /** Return the pictures up to a moment: the last `most`, the latest last. */
  upTo(at, most) {
    const last = search(this._at.length, (index) => this._at[index] > at);
    return this._all.slice(Math.max(last - most, 0), last);
  }
}

/** The words of each fact that has been read. */
const wordsRead = new Map();

/** Return the words of a fact that is given as text; null without any. */
function wordsOf(text) {
  if (!wordsRead.has(text)) wordsRead.set(text, text.slice(1, -1).match(FACT_WORD));
  return wordsRead.get(text);
}

/** The facts of memory at a moment. */
class Beliefs {
  /**
   * @param facts pairs of a fact as text and the time of its last assertion
   * @param now the time of the moment
   */
  constructor(facts, now) {
    this._now = now;
    this._facts = new Map();
    for (const [text, since] of facts) {
      const words = wordsOf(text);
      if (!words) continue;
      if (!this._facts.has(words[0])) this._facts.set(words[0], []);
      this._facts.get(words[0]).push([words, since]);
    }
  }

  find(pattern) {
    const wanted = pattern.map((one) => (one === null ? null : wordOf(one)));
    return (this._facts.get(wanted[0]) || [])
      .filter(([words]) => words.length === wanted.length
        && wanted.every((one, at) => one === null || one === words[at]))
      .map(([words, since]) => [words, this._now - since]);
  }

  last(prefix, more) {
    const found = this.find([...prefix, ...Array(more).fill(null)]);
    return found.length ? found.at(-1)[0].slice(prefix.length) : null;
  }

  contents(look) {
    const valuesOf = (name) =>
      new Map(this.find([name, null, null]).map(([words]) => [words[1], words[2]]));
    const [places, looks] = [valuesOf("location"), valuesOf(look)];
    const found = new Map();
    const seen = new Set();
    for (const [[, item, kind]] of this.find(["class", null, null, "true"])) {
      if (!places.has(item) || seen.has(item)) continue;
      seen.add(item);
      const at = outermost(places.get(item), places);
      if (!found.has(at)) found.set(at, new Contents());
      found.get(at).add(kind, looks.get(item) || "");
    }
    return found;
  }

  places() {
    const found = new Set(this.find(["location", null, null]).map(([words]) => words[2]));
    found.delete("unknown");
    return [...found].sort(byCode);
  }

  roads(places) {
    const known = new Set(places);
    const found = new Map();
    for (const facts of this._facts.values())
      for (const [words] of facts) {
        const pair = words.slice(1).filter((one) => known.has(one)).sort(byCode);
        if (pair.length === 2 && pair[0] !== pair[1]) found.set(pair.join(" "), pair);
      }
    return [...found.values()].sort((a, b) => byCode(a[0], b[0]) || byCode(a[1], b[1]));
  }
}

/** Compare two texts by their code points, as Python does. */
function byCode(one, other) {
  const [a, b] = [[...one], [...other]];
  for (let at = 0; at < Math.min(a.length, b.length); at += 1)
    if (a[at] !== b[at]) return a[at].codePointAt(0) - b[at].codePointAt(0);
  return a.length - b.length;
}

function outermost(place, places) {
  const passed = new Set([place]);
  while (places.has(place) && !passed.has(places.get(place))) {
    place = places.get(place);
    passed.add(place);
  }
  return place;
}

/** Return an atom of a picture as the word of a fact. */
function wordOf(atom) {
  if (atom !== null && typeof atom === "object") return `"${own(atom, "value") ?? ""}"`;
  return String(atom);
}

/** Return a word, with at most three decimals in a number. */
function shortWord(text) {
  const numbers = numbersOf([text]);
  return numbers === null ? text : String(Math.floor(numbers[0] * 1000 + 0.5) / 1000);
}

/** The number of things of a class with a look. */
class Contents {
  constructor(things = []) {
    this._rows = new Map();
    for (const thing of things) this.add(thing.kind, thing.look == null ? "" : wordOf(thing.look));
  }

  add(kind, look) {
    const key = JSON.stringify([kind, look]);
    this._rows.set(key, [kind, look, (this._rows.get(key) || [0, 0, 0])[2] + 1]);
  }

  get rows() {
    return [...this._rows.values()].sort((a, b) => byCode(a[0], b[0]) || byCode(a[1], b[1]));
  }

  get size() {
    return this.rows.reduce((sum, row) => sum + row[2], 0);
  }

  get words() {
    const parts = this.rows.map(([kind, look, count]) =>
      [count > 1 ? String(count) : "", look, kind].filter(Boolean).join(" "));
    return parts.join(", ") || "nothing";
  }

  equals(other) {
    return JSON.stringify(this.rows) === JSON.stringify(other.rows);
  }
}

/** Return a picture of the places that memory knows; null without places. */
function believedPicture(beliefs) {
  const places = beliefs.places();
  if (!places.length) return null;
  const wide = Math.ceil(Math.sqrt(places.length));
  const spots = places.map((name, at) =>
    ({ name, at: [at % wide, Math.floor(at / wide)], things: [], note: "" }));
  return { here: "", spots, roads: beliefs.roads(places), look: "color" };
}

/** Return the drawing of a picture, or of memory alone; null if there is nothing to draw. */
function sceneOf(picture, beliefs, before = []) {
  if (picture === null) {
    const only = believedPicture(beliefs);
    return only && mapScene(only, beliefs, [], true);
  }
  if (picture.plan) return planScene(picture, beliefs, before);
  return mapScene(picture, beliefs, before, false);
}

// --- a map of spots and roads ---------------------------------------------------------

/** A spot with its contents, true and believed; `alone` if there is no truth to compare. */
class Sight {
  constructor(spot, believed, alone) {
    this.spot = spot;
    this.truth = new Contents(spot.things);
    this.believed = believed || new Contents();
    this.alone = alone;
    this.wrong = !alone && !this.truth.equals(this.believed);
    this.shown = alone ? this.believed : this.truth;
  }

  get hint() {
    if (this.alone && !this.believed.size) return this.spot.name;
    const said = `${this.spot.name}: ${this.shown.words}`;
    return this.wrong ? `${said}; believed: ${this.believed.words}` : said;
  }

  get height() {
    const rows = (contents) => Math.ceil(contents.size / IN_ROW);
    return BOX * (rows(this.shown) + (this.wrong ? Math.max(rows(this.believed), 1) : 0));
  }
}

function mapScene(picture, beliefs, before, alone) {
  const believed = beliefs.contents(wordOf(picture.look ?? ""));
  const sights = picture.spots.map((spot) => new Sight(spot, believed.get(spot.name), alone));
  for (const spot of picture.spots) believed.delete(spot.name);
  const around = sights.filter((sight) => sight.spot.at);
  const [across, down] = stepsOf(around.map((sight) => sight.spot.at));
  const left = around.length ? Math.min(...around.map((sight) => sight.spot.at[0])) : 0;
  const top = around.length ? Math.min(...around.map((sight) => sight.spot.at[1])) : 0;
  const placed = (spot) => [SIDE + (spot.at[0] - left) * across, TOP + (spot.at[1] - top) * down];
  const at = new Map(around.map((sight) => [sight.spot.name, placed(sight.spot)]));
  let width = 2 * SIDE;
  for (const { spot } of around) {
    const [x] = at.get(spot.name);
    width = Math.max(width, x + SIDE, Math.min(x + 13 + lengthOf(spot.note ?? "") * LETTER, WIDE));
  }
  const lowest = Math.max(...[...at.values()].map(([, y]) => y), TOP);
  const shapes = [];
  for (const [one, other] of picture.roads || [])
    if (at.has(one) && at.has(other)) shapes.push(lineShape("m-road", at.get(one), at.get(other)));
  const path = [];
  for (const one of [...before, picture])
    for (const spot of one.spots) if (spot.name === one.here && spot.at) path.push(placed(spot));
  if (path.length > 1) shapes.push(polyShape("polyline", "m-path", path));
  const kinds = new Set(sights.flatMap((sight) =>
    [...sight.truth.rows, ...sight.believed.rows].map((row) => row[0])));
  const letters = lettersOf(kinds);
  let bottom = lowest + 20;
  for (const sight of around) {
    const [x, y] = at.get(sight.spot.name);
    shapes.push(...spotShapes(sight, picture, letters, [x, y]));
    bottom = Math.max(bottom, y + 26 + sight.height);
  }
  width = Math.max(width, 360);
  let y = bottom + 14;
  const aboard = sights.filter((sight) => !sight.spot.at);
  const longest = Math.max(...aboard.map((sight) => lengthOf(calledSpot(sight.spot))), 0);
  const column = 30 + longest * BOLD;
  for (const sight of aboard) {
    shapes.push(...carriedShapes(sight, letters, [column, y]));
    y += 18;
  }
  const texts = wordsBelow(picture, beliefs, alone ? new Map() : believed, letters);
  return withText(shapes, texts, width, y);
}

const lengthOf = (text) => [...text].length;

/** Return the length of a step across and down, so that no spots touch. */
function stepsOf(points) {
  let [beside, below] = [Infinity, Infinity];
  points.forEach((a, index) => {
    for (const b of points.slice(0, index)) {
      const [dx, dy] = [Math.abs(a[0] - b[0]), Math.abs(a[1] - b[1])];
      if (dy < 0.5 && dx >= 0.25) beside = Math.min(beside, dx);
      if (dy >= 0.25) below = Math.min(below, dy);
    }
  });
  return [ACROSS / (beside === Infinity ? 1 : beside), DOWN / (below === Infinity ? 1 : below)];
}

/** Return a letter of each kind of thing, different if possible. */
function lettersOf(kinds) {
  const found = new Map();
  for (const kind of [...kinds].sort(byCode)) {
    const used = new Set(found.values());
    const letters = [...kind];
    const free = letters.find((one) => /[\p{L}\p{N}]/u.test(one) && !used.has(one));
    found.set(kind, free ?? letters[0] ?? "?");
  }
  return found;
}

function spotShapes(sight, picture, letters, [x, y]) {
  const { name, note } = sight.spot;
  const here = name === picture.here;
  const { hint } = sight;
  const looks = here ? "m-place m-here" : "m-place";
  const shapes = [shape("circle", looks, hint, { cx: x, cy: y, r: 8 })];
  const turn = own(TURNS, picture.heading);
  if (here && turn !== undefined) shapes.push(arrowShape(x, y, turn));
  shapes.push(textShape("m-name m-mid", name, x, y - 13));
  if (note) shapes.push(textShape("m-dim", note, x + 13, y + 4));
  const west = x - (BOX * IN_ROW) / 2;
  shapes.push(...boxShapes(sight.shown, letters, [west, y + 14], "", hint));
  if (sight.wrong) {
    const below = y + 14 + BOX * Math.ceil(sight.truth.size / IN_ROW);
    shapes.push(textShape("m-wrong", "≠", west - 11, below + 11));
    shapes.push(...boxShapes(sight.believed, letters, [west, below + 2], " m-unsure", hint));
  }
  return shapes;
}

/** Return an arrow beside a spot, in a direction: degrees clockwise from north. */
function arrowShape(x, y, turn) {
  const angle = (turn * Math.PI) / 180;
  const ahead = [Math.sin(angle), -Math.cos(angle)];
  const aside = [Math.cos(angle), Math.sin(angle)];
  return polyShape("polyline", "m-arrow", [
    [x + 14 * ahead[0] + 4 * aside[0], y + 14 * ahead[1] + 4 * aside[1]],
    [x + 19 * ahead[0], y + 19 * ahead[1]],
    [x + 14 * ahead[0] - 4 * aside[0], y + 14 * ahead[1] - 4 * aside[1]],
  ]);
}

function boxShapes(contents, letters, [x, y], extra, hint) {
  const shapes = [];
  let place = 0;
  for (const [kind, look, count] of contents.rows)
    for (let one = 0; one < count; one += 1, place += 1) {
      const left = x + (place % IN_ROW) * BOX;
      const above = y + Math.floor(place / IN_ROW) * BOX;
      const size = { x: left, y: above, width: BOX - 2, height: BOX - 2 };
      const fill = own(LOOKS, look);
      if (fill) shapes.push(shape("rect", `m-thing${extra}`, hint, { fill, ...size }));
      else shapes.push(shape("rect", `m-thing${extra} m-plain`, hint, size));
      shapes.push(textShape("m-letter", letters.get(kind), left + 4.5, above + 7.5));
    }
  return shapes;
}

const calledSpot = (spot) => (spot.note ? `${spot.name} (${spot.note})` : spot.name);

function carriedShapes(sight, letters, [x, y]) {
  const shapes = [textShape("m-name", calledSpot(sight.spot), 12, y)];
  shapes.push(...boxShapes(sight.shown, letters, [x, y - 9], "", sight.hint));
  const { size, words } = sight.shown;
  const after = x + BOX * Math.min(size, IN_ROW) + (size ? 6 : 0);
  shapes.push(textShape("m-dim", words, after, y));
  const last = after + 10 + lengthOf(words) * LETTER;
  if (sight.wrong) shapes.push(textShape("m-wrong", `≠ ${sight.believed.words}`, last, y));
  return shapes;
}

/** Return the lines of text below a drawing, each with its class. */
function wordsBelow(picture, beliefs, elsewhere, letters) {
  const texts = [];
  for (const gauge of picture.gauges || []) {
    const value = wordOf(gauge.value);
    const last = beliefs.last(gauge.believed, 1);
    const believed = last === null ? "unknown" : shortWord(last[0]);
    const line = `${gauge.name}: ${shortWord(value)}`;
    if (last === null || (last[0] !== value && believed !== shortWord(value)))
      texts.push(["m-wrong", `${line} ≠ ${believed}`]);
    else texts.push(["", line]);
  }
  if (picture.said) texts.push(["", `says “${picture.said}”`]);
  for (const [place, contents] of [...elsewhere].sort((a, b) => byCode(a[0], b[0])))
    texts.push(["m-dim", `believed at ${place}: ${contents.words}`]);
  if (letters.size) {
    const told = [...letters].map(([kind, letter]) => `${letter} ${kind}`).join(", ");
    texts.push(["m-dim", `boxes: ${told}; the colour is the look`]);
    if (picture.here)
      texts.push(["m-dim", "≠ and dashed boxes: what the robot believes instead"]);
  }
  return texts;
}

/** Return a scene with lines of text below its shapes. */
function withText(shapes, texts, width, y) {
  let x = 12;
  for (const [kind, text] of texts) {
    const needed = lengthOf(text) * LETTER + 24;
    if (x > 12 && x + needed > width) [x, y] = [12, y + 16];
    shapes.push(textShape(kind, text, x, y));
    x += needed;
    width = Math.max(width, Math.min(needed, WIDE));
  }
  return { width: tenths(width), height: tenths(y + 12), shapes };
}

// --- a floor true to scale ------------------------------------------------------------

function planScene(picture, beliefs, before) {
  const { plan } = picture;
  const boxes = plan.areas.map((area) => area.box);
  const ends = plan.walls.flat();
  const xs = [...ends.map(([x]) => x), ...boxes.flatMap((box) => [box[0], box[2]])];
  const ys = [...ends.map(([, y]) => y), ...boxes.flatMap((box) => [box[1], box[3]])];
  const [west, east] = xs.length ? [Math.min(...xs), Math.max(...xs)] : [0, 1];
  const [south, north] = ys.length ? [Math.min(...ys), Math.max(...ys)] : [0, 0];
  const scale = Math.min((WIDE - 24) / Math.max(east - west, 1), 620 / Math.max(north - south, 1));
  const at = ([x, y]) => [12 + (x - west) * scale, 12 + (north - y) * scale];
  const shapes = [];
  const reckoning = plan.reckoning || null;
  const space = reckoning && beliefs.last(reckoning.area, 1);
  for (const area of plan.areas)
    shapes.push(...areaShapes(area, at, scale, space !== null && space[0] === area.name));
  for (const [left, low, right, high] of plan.blocks || []) {
    const [x, y] = at([left, high]);
    const size = { width: (right - left) * scale, height: (high - low) * scale };
    shapes.push(shape("rect", "m-block", "obstacle", { x, y, ...size }));
  }
  for (const [one, other] of plan.walls) shapes.push(lineShape("m-wall", at(one), at(other)));
  const places = new Set(plan.areas.map((area) => area.name));
  const { robot } = plan;
  if (robot) {
    const here = at(robot);
    for (const end of plan.echoes || []) shapes.push(lineShape("m-echo", here, at(end)));
    const path = before
      .filter((one) => one.plan && one.plan.robot && places.has(one.here))
      .map((one) => at(one.plan.robot));
    if (path.length) shapes.push(polyShape("polyline", "m-path", [...path, here]));
  }
  const origin = reckoning && beliefs.last(reckoning.origin, 4);
  for (const mark of plan.marks || [])
    shapes.push(markShape(mark, at(mark.at), beliefs, origin !== null && origin[0] === mark.name));
  for (const door of plan.doors || []) shapes.push(...doorShapes(door, at(door.at), beliefs));
  for (const other of plan.others || []) {
    const [x, y] = at(other);
    shapes.push(shape("circle", "m-other", "somebody", { cx: x, cy: y, r: 5 }));
  }
  const reckoned = believedPose(reckoning, beliefs);
  if (robot) shapes.push(pointerShape("m-robot", at(robot), robot[2], `robot in ${picture.here}`));
  if (reckoned) {
    if (robot) shapes.push(lineShape("m-off", at(robot), at(reckoned)));
    const said = "where the robot believes to be";
    shapes.push(pointerShape("m-reckoned", at(reckoned), reckoned[2], said));
  }
  const texts = [
    ...wordsBelow(picture, beliefs, new Map(), new Map()),
    ["m-dim", "▲ robot; outlined: where it believes to be"],
    ["m-dim", "■ known mark, □ unknown, ◆ counted from"],
    ["m-dim", "× closed door: green known, red unknown, dashed believed wrongly"],
  ];
  const wide = 24 + Math.max((east - west) * scale, 336);
  return withText(shapes, texts, wide, 24 + (north - south) * scale + 10);
}

function areaShapes(area, at, scale, believed) {
  const [left, low, right, high] = area.box;
  const [x, y] = at([left, high]);
  const [width, height] = [(right - left) * scale, (high - low) * scale];
  const hint = believed ? `${area.name}: the robot believes to be here` : area.name;
  const looks = believed ? "m-area m-believed-area" : "m-area";
  const shapes = [shape("rect", looks, hint, { x, y, width, height })];
  const letters = [...area.name];
  const upright = width < height && letters.length * 5.2 > width;
  const most = Math.trunc((upright ? height : width) / 5.2);
  if (most < letters.length && most < 5) return shapes;
  const shown = letters.length <= most ? area.name : `${letters.slice(0, most - 1).join("")}…`;
  const middle = x + width / 2;
  const centre = height > 40 && !upright ? y + 11 : y + height / 2;
  const turn = upright ? { transform: `rotate(-90 ${tenths(middle)} ${tenths(centre)})` } : {};
  shapes.push(textShape("m-label", shown, middle, centre + 3, turn));
  return shapes;
}

function markShape(mark, [x, y], beliefs, isOrigin) {
  if (isOrigin) {
    const points = [[x - 5.5, y], [x, y - 5.5], [x + 5.5, y], [x, y + 5.5]];
    return polyShape("polygon", "m-origin", points, `${mark.name}: counted from`);
  }
  const known = !(mark.believed && mark.believed.length) || beliefs.find(mark.believed).length > 0;
  const hint = known ? mark.name : `${mark.name}: unknown to the robot`;
  const size = { x: x - 3.5, y: y - 3.5, width: 7, height: 7 };
  return shape("rect", known ? "m-known" : "m-unknown", hint, size);
}

function doorShapes(door, [x, y], beliefs) {
  const counts = door.counts ?? null;
  const found = door.believed && door.believed.length ? beliefs.find(door.believed) : [];
  const believed = found.some(([, age]) => counts === null || age <= counts);
  if (!door.closed && !believed) return [];
  let [kind, said] = ["m-closed-wrongly", "open, and believed closed"];
  if (door.closed) [kind, said] = ["m-closed", "closed, which the robot does not know"];
  if (door.closed && believed) [kind, said] = ["m-closed-known", "closed"];
  const hint = `${door.name}: ${said}`;
  return [
    lineShape(kind, [x - 4.5, y - 4.5], [x + 4.5, y + 4.5], hint),
    lineShape(kind, [x - 4.5, y + 4.5], [x + 4.5, y - 4.5], hint),
  ];
}

function pointerShape(kind, [x, y], heading, hint) {
  const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
  const corners = [[11, 0], [-11 * 0.7, 7.5], [-11 * 0.7, -7.5]];
  const points = corners.map(([ahead, aside]) =>
    [x + cos * ahead - sin * aside, y - sin * ahead - cos * aside]);
  return polyShape("polygon", kind, points, hint);
}

/** Return the robot's believed position on a plan; null if it is unknown. */
function believedPose(reckoning, beliefs) {
  if (!reckoning) return null;
  const place = beliefs.last(reckoning.place, 3);
  const origin = beliefs.last(reckoning.origin, 4);
  const space = beliefs.last(reckoning.area, 1);
  if (!place || !origin || !space) return null;
  const stand = reckoning.stands.findLast((one) =>
    one.landmark === origin[0] && one.space === space[0]);
  const [counted, now] = [numbersOf(origin.slice(1)), numbersOf(place)];
  if (!stand || !counted || !now) return null;
  const [x, y, heading] = stand.pose;
  const turned = heading - counted[2];
  const [cos, sin] = [Math.cos(turned), Math.sin(turned)];
  const [dx, dy] = [now[0] - counted[0], now[1] - counted[1]];
  return [x + cos * dx - sin * dy, y + sin * dx + cos * dy, now[2] + turned];
}

function numbersOf(words) {
  return words.every((one) => /^-?[0-9.]+(e-?[0-9]+)?$/.test(one)) ? words.map(Number) : null;
}

// --- shapes ---------------------------------------------------------------------------

const tenths = (value) => Math.floor(value * 10 + 0.5) / 10;

/** Return a shape: tag, attributes, and a text, which is a hint except for `text`. */
function shape(tag, kind, hint, more) {
  const numbers = Object.entries(more).map(([key, value]) =>
    [key, typeof value === "string" ? value : tenths(value)]);
  return [tag, { class: kind, ...Object.fromEntries(numbers) }, hint];
}

function lineShape(kind, [x1, y1], [x2, y2], hint = "") {
  return shape("line", kind, hint, { x1, y1, x2, y2 });
}

function polyShape(tag, kind, points, hint = "") {
  const pairs = points.map(([x, y]) => `${tenths(x)},${tenths(y)}`);
  return [tag, { class: kind, points: pairs.join(" ") }, hint];
}

function textShape(kind, text, x, y, more = {}) {
  return ["text", { class: kind, x: tenths(x), y: tenths(y), ...more }, text];
}

const SVG = "http://www.w3.org/2000/svg";

/** Return shapes with the letters of each line as one text: browsers draw it faster. */
function lettersJoined(shapes) {
  const found = [];
  const lines = new Map();
  for (const one of shapes) {
    const [tag, { class: kind, x, y }, text] = one;
    const line = lines.get(y);
    if (tag !== "text" || kind !== "m-letter" || text.length !== 1) found.push(one);
    else if (line) line.push([x, text]);
    else lines.set(y, [[x, text]]);
  }
  for (const [y, letters] of lines) {
    const x = letters.map(([one]) => one).join(" ");
    found.push(["text", { class: "m-letter", x, y }, letters.map(([, text]) => text).join("")]);
  }
  return found;
}

/** An SVG element with the drawing of a picture. */
class Drawing {
  constructor() {
    this.svg = document.createElementNS(SVG, "svg");
    this.svg.setAttribute("class", "map");
    this.svg.setAttribute("role", "img");
    this.svg.setAttribute("aria-labelledby", "h-map");
    /** Whether the last drawing is much wider than high. */
    this.isWide = false;
    /** The elements by the text of their shape, in the order of the drawing. */
    this._drawn = new Map();
  }

  /**
   * Draw a picture; return whether there is something to draw.
   *
   * The elements of shapes that are drawn already stay.
   *
   * @param picture the picture, or null: then what memory believes
   * @param options `facts`: pairs of a fact and the time of its assertion; `now`: the
   *   time; `before`: the pictures before, for the path
   */
  draw(picture, { facts = [], now = 0, before = [] } = {}) {
    const scene = sceneOf(picture, new Beliefs(facts, now), before);
    if (scene === null) return false;
    const { shapes, width, height } = scene;
    const next = new Map();
    for (const one of lettersJoined(shapes)) {
      let key = JSON.stringify(one);
      while (next.has(key)) key += " ";
      next.set(key, this._drawn.get(key) || elementOf(one));
    }
    for (const [key, element] of this._drawn) if (!next.has(key)) element.remove();
    let here = this.svg.firstElementChild;
    for (const element of next.values())
      if (element === here) here = here.nextElementSibling;
      else this.svg.insertBefore(element, here);
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.isWide = width > 1.5 * height;
    this._drawn = next;
    return true;
  }
}

/** Return the element of a shape. */
function elementOf([tag, attributes, text]) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  if (tag === "text") element.textContent = visible(text);
  else if (text) {
    const title = document.createElementNS(SVG, "title");
    title.textContent = visible(text);
    element.append(title);
  }
  return element;
}

// Elements and texts. Text of a trace enters the page only here, as text.

/** The number of characters of a text that are shown. */
const LONGEST = 400;

/** Return a text that is safe to show: without control characters, of limited length. */
function visible(text) {
  const all = text.length > LONGEST ? `${text.slice(0, LONGEST)}…` : text;
  return all.replace(/[\p{C}\p{Zl}\p{Zp}]/gu, "\ufffd");
}

/** Return the text of embedded data: gzip in base64; or of a file, gzip or not. */
async function inflated(bytes) {
  const packed = bytes[0] === 0x1f && bytes[1] === 0x8b;
  let stream = new Blob([bytes]).stream();
  if (packed) stream = stream.pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}

/** Return the text of an embedded element; null if the page has none of the name. */
async function embedded(id) {
  const element = byId(`data-${id}`);
  if (element === null) return null;
  const text = element.textContent;
  const bytes = Uint8Array.fromBase64
    ? Uint8Array.fromBase64(text)
    : Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
  element.remove();
  return inflated(bytes);
}

/** Switch between light and dark. */
function switchTheme() {
  const root = document.documentElement;
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const now = root.dataset.theme || (dark ? "dark" : "light");
  root.dataset.theme = now === "dark" ? "light" : "dark";
}

/** Return a number or a time of a trace with at most six decimals. */
function readable(value) {
  return Number.isFinite(value) ? String(Number(value.toFixed(6))) : visible(asText(value));
}

/** Return the age of something as text. */
function ageText(now, then) {
  return now === then ? "now" : `${readable(now - then)} ago`;
}

/** Return a number with a noun, which is in the plural unless the number is 1. */
function plural(count, noun) {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}

/** Return the last part of a path. */
function lastPart(path) {
  return path.replace(/^.*[/\\](?=[^/\\]+[/\\]?$)/, "");
}

/** Return an element by its id. */
function byId(id) {
  return document.getElementById(id);
}

/**
 * Return a new element.
 *
 * @param tag the name of the element, with classes: `li.first`
 * @param props attributes; a function is a listener of the event of its name
 * @param children elements, and texts
 */
function el(tag, props = {}, ...children) {
  const [name, ...classes] = tag.split(".");
  const made = document.createElement(name);
  if (classes.length) made.className = classes.join(" ");
  for (const [key, value] of Object.entries(props)) {
    if (typeof value === "function") made.addEventListener(key, value);
    else if (value !== undefined && value !== null && value !== false)
      made.setAttribute(key, value === true ? "" : value);
  }
  for (const child of children.flat(Infinity)) {
    if (child === null || child === undefined || child === "") continue;
    made.append(typeof child === "object" ? child : visible(String(child)));
  }
  return made;
}

/** Return a button that looks like a link. */
function link(text, act, title) {
  return el("button.link", { type: "button", title, click: act }, text);
}

/** What to do when all panels are written: it needs the layout, which is made once. */
let pending = [];

/** Call two functions after the page is written: what the first returns goes to the second. */
function whenWritten(read, write) {
  if (!pending.length) queueMicrotask(settle);
  pending.push([read, write]);
}

/** Make the layout, and do what waits for it: all that reads before all that writes. */
function settle() {
  const acts = pending;
  pending = [];
  const found = acts.map(([read]) => read());
  acts.forEach(([, write], index) => write(found[index]));
}

/** Replace the children of an element, and keep its focused row. */
function fill(parent, children) {
  const key = parent.contains(document.activeElement) && document.activeElement.dataset.key;
  parent.replaceChildren(...children);
  if (!key) return;
  const rows = [...parent.querySelectorAll("[data-key]")];
  const found = rows.find((one) => one.dataset.key === key) || rows[0];
  if (found) whenWritten(() => found, () => found.focus({ preventScroll: true }));
}

/** Scroll an element into view within its panel, if it is not visible. */
function reveal(parent, element) {
  if (!element) return;
  const topOf = () => {
    const outer = parent.getBoundingClientRect();
    const inner = element.getBoundingClientRect();
    if (inner.top >= outer.top && inner.bottom <= outer.bottom) return null;
    return parent.scrollTop + inner.top - outer.top - outer.height / 3;
  };
  whenWritten(topOf, (top) => {
    if (top !== null) parent.scrollTop = top;
  });
}

/** Let the arrow keys move the focus between the rows of an element. */
function moveWithArrows(parent, selector = "[data-key]") {
  parent.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step || event.altKey || event.ctrlKey || event.metaKey) return;
    const rows = [...parent.querySelectorAll(selector)];
    const at = rows.indexOf(document.activeElement);
    const next = rows[at < 0 ? 0 : at + step];
    if (!next) return;
    event.preventDefault();
    next.focus();
  });
}

/** Return the properties of a row that can be chosen with mouse and keys. */
function choosable(role, key, selected, act) {
  return {
    role,
    tabindex: selected ? 0 : -1,
    "data-key": key,
    "aria-selected": role === "button" ? undefined : String(selected),
    click: act,
    keydown: (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      act(event);
    },
  };
}

/** Return the text of a row on one line; the whole text is its title. */
function oneLine(...parts) {
  const made = el("span.text", {}, ...parts);
  made.title = made.textContent;
  return made;
}

/** Return a list of rows that can be chosen, with its name. */
function listbox(name, rows) {
  return el("div", { role: "listbox", "aria-label": visible(name) }, rows);
}

/** Let at least one row of an element be reached with Tab. */
function reachable(rows) {
  if (rows.length && !rows.some((row) => row.tabIndex === 0)) rows[0].tabIndex = 0;
  return rows;
}

/** The sign and the words of each state of a task: told apart without colour. */
const SIGNS = {
  new: ["·", "has not been selected"],
  selected: ["▷", "selected"],
  ready: ["▷", "ready"],
  active: ["▶", "method under way"],
  acting: ["▶", "acting"],
  sensing: ["◉", "sensing"],
  waiting: ["◷", "waiting"],
  suspended: ["‖", "suspended"],
  succeeded: ["✓", "succeeded"],
  failed: ["✕", "failed"],
  removed: ["–", "removed"],
  unfinished: ["○", "unfinished"],
};

/** Return the sign of a state as an element with its words. */
function signOf(kind) {
  const [sign, words] = SIGNS[kind] || ["·", kind];
  return el(`span.sign.${kind}`, { title: words, role: "img", "aria-label": words }, sign);
}

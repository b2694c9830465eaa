/* The page: one throw or two, settings, a link that brings all of it back. */

import { ask, askJson, ProblemError } from "./api.js";
import { startFiles, listJobs } from "./files.js";
import { METERS, shown, unitOf } from "./sliders.js";
import { Panel } from "./panel.js";

const byId = (id) => document.getElementById(id);
const FIRST = {
  crank_radius: 0.17, main_journal_diameter: 0.22, pin_diameter: 0.18, main_journal_length: 0.12,
  pin_length: 0.139, web_width: 0.285, web_thickness: 0.068, fillet_radius: 0.012,
};
/* Of a counterweight where none is given: a sector that reaches into the web. */
const WEIGHT = { outer_radius: 1.5 * FIRST.crank_radius, angle: (2 * Math.PI) / 3 };
const FORCE = [0, -1e5, 0]; // on the pin, towards the shaft [N]
const panels = [];
const described = {};
let fields = [];

const settings = {
  unit: "mm",
  source: "law",
  steel: null, // of the service, for throws without a material
  sourceName: () => (settings.source === "law" ? "Law" : settings.source),
  /* Values with their bands by the law, or by a model. */
  async estimate(question) {
    if (settings.source === "law") {
      return askJson("/api/throws/law", { ...question, pin_force: FORCE, ranges: true });
    }
    const path = `/api/models/${settings.source}/lookup`;
    // A model may know compliances without reactions.
    const found = await askJson(path, { ...question, pin_force: FORCE }).catch(() => askJson(path, question));
    const values = {};
    const remarks = new Set();
    for (const [name, one] of Object.entries(found.responses)) {
      values[one.support === "pinned" && !name.endsWith("_pinned") ? `${name}_pinned` : name] = one;
      one.remarks.forEach((remark) => remarks.add(remark));
    }
    const { ranges, fixed } = await (described[settings.source] ??= askJson(`/api/models/${settings.source}`));
    const ends = {};
    for (const field of fields.filter(({ name }) => name in ranges || name in fixed)) {
      const [low, high] = ranges[field.name] ?? [fixed[field.name], fixed[field.name]];
      const told = (value, end) => `${shown(value, field, settings.unit)} ${unitOf(field, settings.unit)} is ${end} of its study`;
      ends[field.name] = { low, low_limit: told(low, low < high ? "the least" : "the only one"), high, high_limit: told(high, "the largest") };
    }
    return { values, remarks: [...remarks], reactions: found.reactions, ranges: ends };
  },
};

/* The fields of a throw and of its counterweights from the description of the API; other parts are left to files. */
async function readFields() {
  const { CrankThrow } = (await askJson("/api/openapi.json")).components.schemas;
  const sector = CrankThrow.properties.counterweight.anyOf.find((kind) => kind.properties);
  const weight = fieldsOf(sector, "counterweight.", WEIGHT).map((field) => ({ ...field, required: false }));
  return [...fieldsOf(CrankThrow, "", FIRST), ...weight];
}

function fieldsOf(record, before, usual) {
  const found = [];
  for (const [name, field] of Object.entries(record.properties)) {
    const kinds = field.anyOf.flatMap((kind) => kind.anyOf || [kind]);
    const number = kinds.find((kind) => kind.type === "number");
    const choices = kinds.find((kind) => kind.enum)?.enum;
    if (!number && !choices) {
      continue;
    }
    found.push({
      name: before + name,
      symbol: (number && field.title) || "",
      meaning: field.description.replace(/ \[(m|rad)\]$/, ""),
      angle: field.description.endsWith("[rad]"),
      required: record.required.includes(name),
      minimum: number?.minimum,
      maximum: number?.maximum,
      usual: usual[name] ?? FIRST.crank_radius / 2,
      start: usual[name],
      choices,
    });
  }
  return found;
}

/* A part of a throw in a link, such as its counterweight; the service says what is wrong with any other text. */
function partOf(text) {
  try {
    return /^[[{]/.test(text) ? JSON.parse(text) : text;
  } catch {
    return text;
  }
}

function readLink() {
  const given = new URLSearchParams(location.hash.slice(1));
  const throws = { a: {}, b: null };
  for (const [key, text] of given) {
    const [name, field] = key.split(".");
    if (field && (name === "a" || name === "b")) {
      const number = Number(text);
      throws[name] ??= {};
      throws[name][field] = text.trim() && Number.isFinite(number) ? number : partOf(text);
    }
  }
  if (METERS[given.get("unit")]) {
    settings.unit = given.get("unit");
  }
  settings.source = given.get("from") || "law";
  return throws;
}

let writing = null;
function writeLink() {
  clearTimeout(writing);
  writing = setTimeout(() => history.replaceState(null, "", linkOf()), 150);
}

function linkOf() {
  const given = new URLSearchParams();
  for (const panel of panels) {
    for (const [field, value] of Object.entries(panel.values())) {
      given.set(`${panel.name}.${field}`, typeof value === "object" ? JSON.stringify(value) : value);
    }
  }
  given.set("unit", settings.unit);
  given.set("from", settings.source);
  return `#${given}`;
}

function add(name, values) {
  const title = name === "a" ? "Throw" : "Second throw";
  const panel = new Panel(name, title, fields, values, settings, writeLink);
  panels.push(panel);
  byId("throws").append(panel.root);
  byId("throws").classList.toggle("two", panels.length > 1);
  byId("compare").setAttribute("aria-pressed", String(panels.length > 1));
  return panel.update();
}

function startSettings() {
  byId("unit").value = settings.unit;
  byId("unit").addEventListener("change", () => {
    settings.unit = byId("unit").value;
    panels.forEach((panel) => panel.sliders.setUnit(settings.unit));
    writeLink();
  });
  byId("source").addEventListener("change", () => {
    settings.source = byId("source").value;
    panels.forEach((panel) => panel.update());
    writeLink();
  });
  byId("compare").addEventListener("click", () => {
    if (panels.length === 1) {
      add("b", panels[0].values());
    } else {
      panels.pop().root.remove();
      byId("throws").classList.remove("two");
      byId("compare").setAttribute("aria-pressed", "false");
    }
    writeLink();
  });
  byId("link").addEventListener("click", async () => {
    history.replaceState(null, "", linkOf());
    try {
      await navigator.clipboard.writeText(location.href);
      byId("told").textContent = "Copied.";
    } catch {
      byId("told").textContent = "The link is in the address line.";
    }
  });
}

async function listSources() {
  const { models } = await askJson("/api/models");
  const known = new Set(["law", ...models]);
  if (!known.has(settings.source)) {
    settings.source = "law";
  }
  byId("source").replaceChildren(...[...known].map((name) => new Option(name === "law" ? "the law" : name, name)));
  byId("source").value = settings.source;
}

async function start() {
  const given = readLink();
  fields = await readFields();
  settings.steel = (await askJson("/api/throws/validate", { throw: FIRST })).material;
  await listSources();
  startSettings();
  startFiles();
  listJobs();
  await add("a", Object.keys(given.a).length ? given.a : FIRST);
  if (given.b) {
    await add("b", given.b);
  }
  document.body.dataset.ready = "yes";
}

/* The throw of a file that was dropped, and its material. */
document.addEventListener("throw-read", (event) => panels[0]?.set(event.detail));
document.addEventListener("key-needed", () => {
  byId("session").hidden = false;
});
document.addEventListener("models-changed", () => listSources().catch(() => null));
byId("session").addEventListener("submit", async (event) => {
  event.preventDefault();
  try {
    await ask("/api/session", { key: byId("key").value });
    location.reload();
  } catch (error) {
    byId("session-told").textContent = error.message;
  }
});

start().catch((error) => {
  byId("told").textContent = error instanceof ProblemError ? error.message : `The page cannot start: ${error}`;
});

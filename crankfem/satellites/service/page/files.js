/* Engine files: dropped, checked field by field, run; and the jobs of this service, found again. */

import { announce, ask, askJson, askText, drawPlot, follow, ProblemError } from "./api.js";

const byId = (id) => document.getElementById(id);
const following = new Set();
const FIRST_SCREEN = "first_screen.json";

function made(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

function button(text, act) {
  const element = made("button", { type: "button", textContent: text });
  element.addEventListener("click", act);
  return element;
}

export function startFiles() {
  // Anywhere on the page, where a browser would else leave it for the file.
  for (const kind of ["dragover", "dragleave", "drop"]) {
    document.addEventListener(kind, (event) => {
      if (!event.dataTransfer.types.includes("Files")) {
        return; // text goes into the field where it is dropped
      }
      event.preventDefault();
      byId("drop").classList.toggle("over", kind === "dragover");
      if (kind === "drop") {
        byId("engine").scrollIntoView({ block: "nearest" });
        check([...event.dataTransfer.files]);
      }
    });
  }
  byId("file").addEventListener("change", () => {
    const files = [...byId("file").files];
    byId("file").value = ""; // the same file, changed, can be chosen again
    check(files);
  });
  document.addEventListener("jobs-changed", listJobs);
}

async function check(files) {
  const place = byId("checked");
  const engines = files.filter((file) => /\.(toml|step|stp)$/i.test(file.name));
  if (engines.length !== 1) {
    const names = files.map((file) => file.name).join(", ");
    place.textContent = `Given: ${names || "no file"}; allowed is one engine file, which ends in .toml, with the tables that it names, or one STEP file.`;
    return;
  }
  const [engine] = engines;
  place.textContent = `Checking ${engine.name} …`;
  const tables = {};
  for (const file of files.filter((one) => one !== engine)) {
    tables[file.name] = await file.text();
  }
  const question = { name: engine.name, text: await engine.text(), tables };
  if (/[\0\uFFFD]/.test(question.text)) {
    place.textContent = `${engine.name}: given a file that is no text in UTF-8; allowed is an engine file, which is TOML.`;
    return;
  }
  try {
    const found = await askJson("/api/files/check", question);
    if (found.kind === "crankshaft") {
      showThrows(place, engine.name, found);
      return;
    }
    const kinds = [["run", "/api/engines", "Run: vibration, verdict, report"], ["doe", "/api/studies", "Run the study alone"]];
    if (found.throw) {
      document.dispatchEvent(new CustomEvent("throw-read", { detail: { ...found.throw, material: found.material } }));
    }
    const several = Object.keys(found.record.throws ?? {}).length > 1;
    const taken = found.throw ? ` The sliders have its ${several ? "first " : ""}throw, and its material counts.` : "";
    place.replaceChildren(
      made("p", { textContent: `${engine.name} is a valid ${found.kind} file.${taken}` }),
      ...[...found.warnings, ...found.remarks].map((remark) => made("p", { className: "remarks", textContent: remark })),
      made(
        "div",
        { className: "bar" },
        ...kinds
          .filter(([command]) => found.commands.includes(command))
          .map(([, path, text]) => button(text, () => run(path, question)))
      )
    );
  } catch (error) {
    refuse(place, engine.name, error);
  }
}

/* The throws of a crankshaft from CAD. */
function showThrows(place, name, found) {
  const heads = ["Throw", "Angle [deg]", "Length [mm]", "Mass [kg]", "Like throw"];
  const number = (value) => `${Number(value.toPrecision(5))}`;
  const rows = found.record.throws.map((one) =>
    made("tr", {}, made("th", { scope: "row", textContent: one.number }),
      ...[number(one.angle_deg), number(1e3 * one.length), number(one.mass), one.like === one.number ? "" : `${one.like}, ${one.change}`]
        .map((text) => made("td", { textContent: text }))));
  const head = made("tr", {}, ...heads.map((text) => made("th", { scope: "col", textContent: text })));
  place.replaceChildren(
    made("p", { textContent: `${name} has a crankshaft of ${rows.length === 1 ? "one throw" : `${rows.length} throws`}, here of steel; crankfem cad ${name} --engine mine.toml makes an engine file of it.` }),
    made("table", {}, made("thead", {}, head), made("tbody", {}, ...rows)),
    ...found.remarks.map((remark) => made("p", { className: "remarks", textContent: remark }))
  );
}

/* Show each error at its field. */
function refuse(place, name, error) {
  const errors = error instanceof ProblemError ? error.errors : [];
  const rows = errors.map(({ field, message }) =>
    made("tr", {}, made("th", { scope: "row", textContent: field || name }), made("td", { textContent: message.replace(`${field}: `, "") }))
  );
  const head = made("tr", {}, made("th", { scope: "col", textContent: "Field" }), made("th", { scope: "col", textContent: "What is wrong" }));
  place.replaceChildren(
    made("p", { textContent: rows.length ? `${name} cannot be used yet.` : error.message }),
    ...(rows.length ? [made("table", {}, made("thead", {}, head), made("tbody", {}, ...rows))] : [])
  );
}

async function run(path, question) {
  try {
    const job = await askJson(path, question);
    const place = byId("checked");
    place.textContent = `${question.name} is queued: see Jobs below.`;
    show(job);
    await follow(job.id, (now) => (place.textContent = `${question.name}: ${words(now)}`));
    const done = await askJson(`/api/jobs/${job.id}`);
    if (done.files.includes(FIRST_SCREEN)) {
      await showVerdict(done);
    }
  } catch (error) {
    refuse(byId("checked"), question.name, error);
  }
}

/* The first screen of an engine's report: verdict, tiles, what decides. */
async function showVerdict(job) {
  const first = await askJson(`/api/jobs/${job.id}/files/${FIRST_SCREEN}`);
  const cards = first.tiles.map(({ label, value, details, mark }) =>
    made("div", { className: `card ${mark}` },
      made("dt", { textContent: label }), made("dd", { className: "value", textContent: value }),
      ...details.map((line) => made("dd", { textContent: line }))));
  const findings = first.findings.map(([label, line]) => made("li", {}, made("b", { textContent: `${label}: ` }), line));
  const figure = made("figure", { className: "deciding" });
  byId("verdict").replaceChildren(
    made("h2", { id: "verdict-title", className: first.status, textContent: `${job.title}: ${first.headline}` }),
    made("div", { className: "first" }, made("dl", { className: "cards" }, ...cards), figure),
    made("ul", {}, ...findings)
  );
  byId("verdict").hidden = false;
  const plot = first.plot.map((name) => `results/pictures/${name}.json`).find((name) => job.files.includes(name));
  if (plot) {
    await drawPlot(figure, "deciding", await askText(`/api/jobs/${job.id}/files/${plot}`), "what decides, over the speed");
  }
  byId("verdict").scrollIntoView({ block: "start" });
}

let listing = null;
export function listJobs() {
  listing ??= askJson("/api/jobs")
    .then(({ jobs }) => {
      byId("no-jobs").hidden = jobs.length > 0;
      // What is followed is told by its events alone: a list on its way may be older than they are.
      jobs.slice(0, 20).reverse().filter(({ id }) => !following.has(id)).forEach(show);
    })
    .catch(() => null)
    .finally(() => {
      listing = null;
    });
  return listing;
}

const waits = (job) => ["queued", "running"].includes(job.state);

function show(job) {
  let row = byId(`job-${job.id}`);
  if (!row) {
    row = made("li", { id: `job-${job.id}`, tabIndex: -1 }, made("span", { className: "what" }));
    byId("job-list").prepend(row);
    byId("no-jobs").hidden = true;
  }
  const when = new Date(1000 * job.created).toLocaleTimeString();
  row.querySelector(".what").textContent = `${job.title} (${job.kind}, ${when}): ${words(job)}`;
  const told = waits(job) ? "waits" : `${job.state} ${job.files.length}`;
  if (row.dataset.told !== told) {
    const focused = row.contains(document.activeElement);
    [...row.children].slice(1).forEach((part) => part.remove());
    row.append(...(waits(job) ? active(job, row) : results(job, row, when)));
    row.dataset.told = told;
    if (focused) {
      row.focus();
    }
  }
  // The bar and the button stay: a click ends where it began, and the focus is kept.
  if (waits(job)) {
    Object.assign(row.querySelector("progress"), { hidden: !job.total, max: job.total || 1, value: job.finished });
  }
  if (waits(job) && !following.has(job.id)) {
    following.add(job.id);
    follow(job.id, show).then(() => document.dispatchEvent(new Event("models-changed")));
  }
}

/* A button that changes a job; a refusal is told in its row. */
function change(text, job, row, method, path, changed) {
  return button(text, () =>
    askJson(`/api/jobs/${job.id}${path}`, undefined, { method }).then(changed, (error) => {
      row.querySelector(".what").textContent += ` ${error.message}`;
    })
  );
}

function active(job, row) {
  const bar = made("progress", { ariaLabel: `designs of ${job.title}` });
  return [bar, change("Cancel", job, row, "POST", "/cancel", (now) => waits(now) || announce(now))];
}

function results(job, row, when) {
  const found = [];
  const files = { "results/report.html": "Report", "throw_drawing.svg": "Report", "result.json": "JSON", "model.json": "Model", "throw.step": "STEP" };
  for (const [file, name] of Object.entries(files)) {
    if (job.files.includes(file)) {
      found.push(made("a", { href: `/api/jobs/${job.id}/${name === "Report" ? "report" : `files/${file}`}`, target: "_blank", rel: "noopener", textContent: name, ariaLabel: `${name} of ${job.title}, ${when}` }));
    }
  }
  if (job.files.includes(FIRST_SCREEN)) {
    found.push(button("Verdict", () => showVerdict(job)));
  }
  found.push(
    change("Remove", job, row, "DELETE", "", () => {
      row.remove();
      listJobs();
    })
  );
  return found;
}

function words(job) {
  if (job.state === "failed") {
    return `failed. ${job.problem?.detail ?? ""}`;
  }
  if (job.state !== "running") {
    return { queued: "queued", done: "done", canceled: "canceled" }[job.state];
  }
  return job.total ? `${job.step} (${job.finished} of ${job.total} designs)` : job.step || "starts";
}

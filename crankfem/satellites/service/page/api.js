/* Requests to the service. Refusals become errors with sentences by field. */

export class ProblemError extends Error {
  constructor(problem) {
    super(problem.detail);
    this.status = problem.status;
    this.errors = problem.errors || [];
  }
}

async function refused(response) {
  let problem = { status: response.status, detail: `The service answered ${response.status}.` };
  try {
    problem = await response.json();
  } catch {
    /* The status is all there is. */
  }
  if (response.status === 401) {
    document.dispatchEvent(new Event("key-needed"));
  }
  return new ProblemError(problem);
}

export async function ask(path, question, options = {}) {
  const given = question === undefined ? {} : {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(question),
  };
  let response;
  try {
    response = await fetch(path, { ...given, ...options });
  } catch (error) {
    if (error.name === "AbortError") {
      throw error;
    }
    throw new ProblemError({ status: 0, detail: "The service cannot be reached." });
  }
  if (!response.ok) {
    throw await refused(response);
  }
  return response;
}

export async function askJson(path, question, options) {
  return (await ask(path, question, options)).json();
}

export async function askText(path, question, options) {
  return (await ask(path, question, options)).text();
}

// Streams of progress that are open at a time: browsers keep six connections to a service, and requests need some.
const MOST_STREAMS = 3;
const ENDED = ["done", "failed", "canceled"];
// By the followed job: who is told of it, its last record, its stream. Jobs run in this order.
const followed = new Map();

/* Follow a job until it has ended; `tell` receives each change. */
export function follow(id, tell) {
  return new Promise((resolve) => {
    const job = followed.get(id) ?? { tellers: [], last: null, stream: null };
    followed.set(id, job);
    job.tellers.push({ tell, resolve });
    if (job.last) {
      tell(job.last);
    }
    openStreams();
  });
}

/* Tell who follow a job of its record. */
export function announce(record) {
  const job = followed.get(record.id);
  if (!job) {
    return;
  }
  job.last = record;
  const over = ENDED.includes(record.state);
  if (over) {
    forget(record.id);
  }
  for (const { tell, resolve } of job.tellers) {
    tell(record);
    if (over) {
      resolve(record);
    }
  }
}

function forget(id) {
  followed.get(id)?.stream?.close();
  followed.delete(id);
  openStreams();
}

function openStreams() {
  for (const [id, job] of [...followed].slice(0, MOST_STREAMS)) {
    job.stream ??= opened(id, job);
  }
}

function opened(id, job) {
  const stream = new EventSource(`/api/jobs/${id}/events`);
  stream.addEventListener("job", (event) => announce(JSON.parse(event.data)));
  // The browser asks again by itself, also after the service was started anew; but not after a refusal.
  stream.addEventListener("error", async () => {
    if (stream.readyState !== EventSource.CLOSED || followed.get(id) !== job) {
      return;
    }
    const gone = await askJson(`/api/jobs/${id}`).then(() => false, (error) => error.status === 404);
    if (gone) {
      forget(id);
    } else {
      setTimeout(() => {
        job.stream = null;
        openStreams();
      }, 2000);
    }
  });
  return stream;
}

export function save(name, content, type) {
  const place = URL.createObjectURL(new Blob([content], { type }));
  const link = Object.assign(document.createElement("a"), { href: place, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(place), 1000);
}

let drawing = null;

/* Load the scripts of the interactive view, plotly first. */
export function loadDrawing() {
  drawing ??= ["plotly.js", "interactive.js"].reduce(
    (before, name) =>
      before.then(
        () =>
          new Promise((resolve, reject) => {
            const script = document.createElement("script");
            script.src = `/page/${name}`;
            script.onload = resolve;
            script.onerror = reject;
            document.head.append(script);
          })
      ),
    Promise.resolve()
  );
  return drawing;
}

/* Draw an interactive plot in a figure, as reports do. */
export async function drawPlot(place, name, content, label) {
  await loadDrawing();
  const data = Object.assign(document.createElement("script"), { type: "application/json", id: `plot-${name}`, textContent: content });
  const holder = Object.assign(document.createElement("div"), { className: "interactive", hidden: true });
  Object.assign(holder.dataset, { plot: name, label });
  place.replaceChildren(data, holder);
  place.hidden = false;
  window.drawInteractivePlot(holder);
}

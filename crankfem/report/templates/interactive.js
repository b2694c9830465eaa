/* Draws the report's interactive plots where scripts run, beside pictures that stay where they do not.

A plot NAME has a holder <div class="interactive" data-plot="NAME" hidden> in a <figure> with its static
picture, if there is one, and its data in <script id="plot-NAME">. It is drawn when it comes near the screen;
until then, on paper, and if anything fails, the picture is there. Without one, a still for paper is made of the
same data while the browser has nothing else to do. Nothing is fetched: what is of the type "application/gzip"
is packed in the page, also the pictures <img data-packed="ID"> and the library "plotly". */
(function () {
  "use strict";

  var NARROW = 600; // pixels
  var LEGEND = 100; // pixels, of a legend below a narrow diagram before its entries are known
  var SQUARE = 440; // pixels, height of a narrow diagram with equal scales
  var LINE = 15; // pixels, of a small title
  var PAPER = 480; // pixels, width of a still; paper shows it in 590, or two beside each other
  var TURN = Math.PI / 12;
  var ZOOM = 1.2;
  var CONFIG = {
    displaylogo: false,
    // The width is given with each change of the page's, below.
    responsive: false,
    showSendToCloud: false,
    showEditInChartStudio: false,
    showLink: false,
    plotlyServerURL: "",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "tableRotation", "resetCameraLastSave3d"],
    doubleClick: "reset",
  };
  var STYLE =
    ".interactive .plot-tools{display:flex;flex-wrap:wrap;gap:.4rem .8rem;align-items:center;margin:0 0 .4rem}" +
    ".interactive .plot-tools label{display:flex;gap:.4rem;align-items:center;max-width:100%}" +
    ".interactive .plot-tools [role=group]{display:flex;flex-wrap:wrap;gap:.25rem}" +
    ".interactive .plot-tools button,.interactive .plot-tools select{font:inherit;font-size:.9rem;" +
    "min-height:2rem;padding:.2rem .6rem;border:1px solid #7b8794;border-radius:4px;background:#fff;" +
    "color:#1d2733;max-width:100%;min-width:0}" +
    ".interactive .plot-tools button{cursor:pointer}" +
    ".interactive .plot-tools button[aria-pressed=true]{background:#1f5f99;border-color:#1f5f99;color:#fff}" +
    ".interactive .plot-tools :focus-visible,.interactive .modebar-btn:focus-visible{outline:3px solid " +
    "#d9822b;outline-offset:1px}" +
    // However wide a plot was drawn, it does not keep the page from growing narrow.
    ".interactive .plot-area{contain:inline-size;overflow:hidden}" +
    ".interactive.waiting{position:absolute;visibility:hidden}" +
    "@media screen{.plot-drawn>.plot-still,.for-paper{display:none!important}" +
    ".only-interactive,.awaited{min-height:var(--room)}.plot-drawn{min-height:0}}" +
    ".unseen{position:absolute;left:-9999px}" +
    "@media print{.interactive{display:none!important}}" +
    "@media (prefers-reduced-motion:reduce){.interactive *{transition:none!important;" +
    "animation:none!important}}";

  var Plotly = window.Plotly;
  var library = null;

  /* The text of a script element, unpacked where it is packed. */
  function content(id) {
    var holder = document.getElementById(id);
    if (holder.type !== "application/gzip") {
      return Promise.resolve(holder.textContent);
    }
    if (!window.DecompressionStream) {
      return Promise.reject(new Error("the browser cannot unpack"));
    }
    var bytes = Uint8Array.from(atob(holder.textContent), function (one) { return one.charCodeAt(0); });
    var unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(unpacked).text();
  }

  /* What draws is unpacked for the first plot that is. */
  function ready() {
    library = library || (Plotly ? Promise.resolve() : content("plotly").then(function (text) {
      document.head.appendChild(element("script", {}, text));
      Plotly = window.Plotly;
    }));
    return library;
  }

  /* What differs from the figure's own layout on a narrow screen, and what brings that back.

  There the legend stands below the diagram, so many pixels high. */
  function fitting(own, width, below) {
    var isNarrow = width < NARROW;
    var legend = own.legend || {};
    var margin = own.margin || {};
    if (own.scene) {
      return { width: width, height: isNarrow ? 400 : own.height };
    }
    if (!isNarrow) {
      return {
        width: width,
        height: own.height,
        "legend.orientation": "v",
        "legend.traceorder": legend.traceorder || "normal",
        "legend.x": 1.02,
        "legend.xanchor": "left",
        "legend.y": 1,
        "legend.yanchor": "top",
        "legend.yref": "paper",
        "legend.maxheight": legend.maxheight || 0.95,
        "margin.l": margin.l,
        "margin.b": margin.b,
        "margin.t": margin.t,
        "title.font.size": 15,
        "title.pad.t": ((own.title || {}).pad || {}).t || 10,
        "font.size": 13,
      };
    }
    return {
      width: width,
      height: own.yaxis.scaleanchor ? SQUARE : own.height + 24 + below,
      "legend.orientation": "h",
      "legend.traceorder": "grouped",
      "legend.x": 0,
      "legend.xanchor": "left",
      "legend.y": 0,
      "legend.yanchor": "bottom",
      "legend.yref": "container",
      "legend.maxheight": 0.6,
      "margin.l": 48,
      "margin.b": margin.b + below,
      // Under the bar of buttons, which is always there where fingers point.
      "margin.t": margin.t + 24,
      "title.font.size": 12,
      "title.pad.t": 36,
      "font.size": 11,
    };
  }

  /* Fit a drawn plot to a width; a legend below the diagram gets the height that all its entries need. */
  function fit(plot, own, width) {
    var hasLegend = own.showlegend !== false && !own.scene;
    return Plotly.relayout(plot, fitting(own, width, hasLegend ? LEGEND : 0)).then(function () {
      var legend = width < NARROW && hasLegend && plot.querySelector(".legend .bg");
      // What scrolls is as high as its window: all entries count.
      var entries = legend ? Array.prototype.slice.call(plot.querySelectorAll(".legend .legendtoggle")) : [];
      var edges = entries.map(function (entry) { return entry.getBoundingClientRect(); });
      if (!edges.length) {
        return plot;
      }
      var top = Math.min.apply(null, edges.map(function (one) { return one.top; }));
      var bottom = Math.max.apply(null, edges.map(function (one) { return one.bottom; }));
      return Plotly.relayout(plot, fitting(own, width, Math.ceil(bottom - top) + 12));
    });
  }

  /* Entries without a group of their own stand below each other; in groups they flow in rows. */
  function grouped(traces) {
    traces.forEach(function (trace) {
      if (!trace.legendgroup && trace.name && trace.showlegend !== false) {
        trace.legendgroup = trace.name;
      }
    });
  }

  function copy(content) {
    return JSON.parse(JSON.stringify(content));
  }

  function element(name, attributes, text) {
    var made = document.createElement(name);
    Object.keys(attributes).forEach(function (key) {
      made.setAttribute(key, attributes[key]);
    });
    if (text) {
      made.textContent = text;
    }
    return made;
  }

  /* plotly's own menus are pictures without a keyboard: the page gets real ones in their place. */
  function menu(tools, plot, given, label) {
    function choose(place) {
      var change = given.buttons[place].args;
      Plotly.update(plot, change[0] || {}, change[1] || {}, change[2]);
    }
    if (given.type === "dropdown") {
      var wrap = element("label", {}, given.name + " ");
      var select = element("select", {});
      given.buttons.forEach(function (button) {
        select.appendChild(element("option", {}, button.label));
      });
      select.addEventListener("change", function () {
        choose(select.selectedIndex);
      });
      wrap.appendChild(select);
      tools.appendChild(wrap);
      return;
    }
    var group = element("div", { role: "group", "aria-label": given.name + ": " + label });
    given.buttons.forEach(function (button, place) {
      var made = element("button", { type: "button", "aria-pressed": String(place === 0) }, button.label);
      made.addEventListener("click", function () {
        Array.prototype.forEach.call(group.children, function (other) {
          other.setAttribute("aria-pressed", String(other === made));
        });
        choose(place);
      });
      group.appendChild(made);
    });
    tools.appendChild(group);
  }

  /* Buttons that do what dragging and the wheel do, for the keyboard and where there is no wheel. */
  function turning(tools, plot, label) {
    var start = copy({
      "scene.camera": plot.layout.scene.camera,
      "scene.aspectratio": plot.layout.scene.aspectratio,
    });
    var group = element("div", { role: "group", "aria-label": "view of " + label });
    function turn(around, above) {
      var camera = copy(plot.layout.scene.camera);
      var eye = camera.eye;
      var size = Math.sqrt(eye.x * eye.x + eye.y * eye.y + eye.z * eye.z);
      var limit = 0.49 * Math.PI;
      var height = Math.max(-limit, Math.min(limit, Math.asin(eye.y / size) + above));
      var angle = Math.atan2(eye.x, eye.z) + around;
      camera.eye = {
        x: size * Math.cos(height) * Math.sin(angle),
        y: size * Math.sin(height),
        z: size * Math.cos(height) * Math.cos(angle),
      };
      camera.up = { x: 0, y: 1, z: 0 };
      Plotly.relayout(plot, { "scene.camera": camera });
    }
    /* Without perspective the scene's lengths magnify, not the distance of the eye. */
    function magnify(factor) {
      var lengths = plot.layout.scene.aspectratio;
      Plotly.relayout(plot, {
        "scene.aspectratio": { x: factor * lengths.x, y: factor * lengths.y, z: factor * lengths.z },
      });
    }
    [
      ["\u25c0", "turn to the left", turn, -TURN, 0],
      ["\u25b6", "turn to the right", turn, TURN, 0],
      ["\u25b2", "look from further above", turn, 0, TURN],
      ["\u25bc", "look from further below", turn, 0, -TURN],
      ["+", "closer", magnify, ZOOM],
      ["\u2212", "further away", magnify, 1 / ZOOM],
    ].forEach(function (one) {
      var made = element("button", { type: "button", "aria-label": one[1], title: one[1] }, one[0]);
      made.addEventListener("click", function () {
        one[2](one[3], one[4]);
      });
      group.appendChild(made);
    });
    var back = element("button", { type: "button" }, "first view");
    back.addEventListener("click", function () {
      Plotly.relayout(plot, copy(start));
    });
    group.appendChild(back);
    tools.appendChild(group);
  }

  /* Two fingers magnify, which plotly does not know; the wheel does once the plot was clicked, so that
  it does not hold up who scrolls past. */
  function touching(plot) {
    var apart = 0;
    var lengths = null;
    var wanted = null;
    var chosen = false;
    function distance(touches) {
      return Math.hypot(touches[0].clientX - touches[1].clientX, touches[0].clientY - touches[1].clientY);
    }
    function two(event) {
      if (event.touches.length !== 2) {
        return;
      }
      event.preventDefault();
      event.stopPropagation();
      if (event.type === "touchstart" || !apart) {
        keepCamera(plot);
        apart = distance(event.touches);
        lengths = copy(plot.layout.scene.aspectratio);
        return;
      }
      var factor = distance(event.touches) / apart;
      if (!wanted) {
        window.requestAnimationFrame(function () {
          Plotly.relayout(plot, { "scene.aspectratio": wanted });
          wanted = null;
        });
      }
      wanted = { x: factor * lengths.x, y: factor * lengths.y, z: factor * lengths.z };
    }
    plot.addEventListener("touchstart", two, { capture: true, passive: false });
    plot.addEventListener("touchmove", two, { capture: true, passive: false });
    plot.addEventListener("touchend", function (event) {
      apart = 0;
      if (!event.touches.length) {
        keepCamera(plot);
      }
    });
    plot.addEventListener("pointerdown", function () {
      chosen = true;
    });
    plot.addEventListener("pointerleave", function () {
      chosen = false;
    });
    plot.addEventListener(
      "wheel",
      function (event) {
        if (!chosen) {
          event.stopPropagation();
        }
      },
      { capture: true, passive: true }
    );
  }

  /* What a finger has turned, plotly keeps to itself: the next change of the layout would turn it back. */
  function keepCamera(plot) {
    var scene = (plot._fullLayout.scene || {})._scene;
    if (scene && scene.getCamera) {
      plot.layout.scene.camera = copy(scene.getCamera());
      plot._fullLayout.scene.camera = copy(plot.layout.scene.camera);
    }
  }

  /* Names for what plotly draws: its picture, and the buttons of its bar. */
  function named(plot, label) {
    var first = true;
    plot.querySelectorAll("svg.main-svg").forEach(function (svg) {
      if (first) {
        svg.setAttribute("role", "img");
        svg.setAttribute("aria-label", label);
        first = false;
      } else {
        svg.setAttribute("aria-hidden", "true");
      }
    });
    plot.querySelectorAll("canvas").forEach(function (canvas) {
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", label);
    });
    plot.querySelectorAll(".modebar-btn").forEach(function (button) {
      var name = button.getAttribute("data-title") || button.getAttribute("aria-label") || "plot";
      button.setAttribute("aria-label", name);
      if (button.tagName === "BUTTON") {
        return;
      }
      button.setAttribute("role", "button");
      button.setAttribute("tabindex", "0");
      if (!button.getAttribute("data-keys")) {
        button.setAttribute("data-keys", "1");
        button.addEventListener("keydown", function (event) {
          if (event.key === "Enter" || event.key === " ") {
            event.preventDefault();
            button.click();
          }
        });
      }
    });
  }

  function hasWebGL() {
    try {
      var context = document.createElement("canvas").getContext("webgl");
      if (!context) {
        return false;
      }
      var lose = context.getExtension("WEBGL_lose_context");
      if (lose) {
        lose.loseContext();
      }
      return true;
    } catch (error) {
      return false;
    }
  }

  /* Back to the picture, whatever was drawn. */
  function giveUp(holder) {
    var plot = holder.querySelector(".plot-area");
    if (plot) {
      try {
        Plotly.purge(plot);
      } catch (error) {
        /* It is taken away in any case. */
      }
    }
    holder.textContent = "";
    holder.hidden = true;
    holder.classList.remove("waiting");
    holder.parentNode.classList.remove("plot-drawn");
    var still = holder.parentNode.querySelector("img");
    if (still) {
      still.classList.remove("for-paper");
    }
    // A figure without a picture has nothing left to show.
    holder.parentNode.hidden = !still;
    holder.parentNode.style.setProperty("--room", 0);
  }

  /* Draw again where the figure has grown wider or narrower; unseen, as on paper, it has no width. */
  function follow(holder, plot, own, drawn) {
    var waiting = false;
    function again() {
      waiting = false;
      var width = holder.hidden ? 0 : holder.clientWidth;
      if (width && width !== drawn) {
        drawn = width;
        fit(plot, own, width);
      }
    }
    if (window.ResizeObserver) {
      new window.ResizeObserver(function () {
        if (!waiting) {
          waiting = true;
          window.requestAnimationFrame(again);
        }
      }).observe(holder.parentNode);
    }
  }

  function draw(holder, figure) {
    var still = holder.parentNode.querySelector("img");
    var label = holder.getAttribute("data-label") || (still && still.getAttribute("alt")) || "plot";
    if (figure.layout.scene && !hasWebGL()) {
      giveUp(holder);
      return null;
    }
    var menus = figure.layout.updatemenus || [];
    var box = window.getComputedStyle(holder.parentNode);
    var width =
      holder.parentNode.clientWidth - (parseFloat(box.paddingLeft) || 0) - (parseFloat(box.paddingRight) || 0);
    delete figure.layout.updatemenus;
    if (window.matchMedia && window.matchMedia("(pointer: coarse)").matches && !figure.layout.scene) {
      // A finger that moves shall scroll the page; one that taps is told the numbers.
      figure.layout.dragmode = false;
    }
    var tools = element("div", { class: "plot-tools" });
    var plot = element("div", { class: "plot-area" });
    var own = copy(figure.layout);
    holder.textContent = "";
    holder.appendChild(tools);
    holder.appendChild(plot);
    holder.setAttribute("role", "group");
    holder.setAttribute("aria-label", label);
    // There, but unseen, until it is complete: plotly needs a width, the reader a picture.
    holder.classList.add("waiting");
    holder.style.width = width + "px";
    figure.layout.width = width;
    holder.hidden = false;
    grouped(figure.data);
    return Plotly.newPlot(plot, figure.data, figure.layout, CONFIG)
      .then(function () {
        return fit(plot, own, width);
      })
      .then(function () {
        menus.forEach(function (given) {
          menu(tools, plot, given, label);
        });
        if (own.scene) {
          turning(tools, plot, label);
          touching(plot);
          plot.on("plotly_webglcontextlost", function () {
            giveUp(holder);
          });
        }
        if (!tools.children.length) {
          tools.hidden = true;
        }
        named(plot, label);
        plot.on("plotly_afterplot", function () {
          named(plot, label);
        });
        if (still) {
          still.classList.add("plot-still");
        }
        holder.classList.remove("waiting");
        holder.style.width = "";
        holder.parentNode.classList.add("plot-drawn");
        follow(holder, plot, own, width);
      });
  }

  function attempt(holder) {
    ready()
      .then(function () { return content("plot-" + holder.getAttribute("data-plot")); })
      .then(function (text) { return draw(holder, JSON.parse(text)); })
      .catch(function () { giveUp(holder); });
  }

  /* Write what the menus choose below the title: on paper there are none. */
  function told(layout) {
    (layout.updatemenus || []).forEach(function (menu) {
      layout.title.text += "<br>" + menu.buttons[menu.active].label;
      layout.margin.t += LINE;
      layout.height += LINE;
    });
    delete layout.updatemenus;
  }

  /* Make what is printed of a plot without a picture; views in three dimensions have none. */
  function still(holder) {
    return ready()
      .then(function () { return content("plot-" + holder.getAttribute("data-plot")); })
      .then(function (text) {
        var figure = JSON.parse(text);
        if (figure.layout.scene) {
          return null;
        }
        var plot = element("div", { class: "unseen" });
        figure.layout.width = PAPER;
        // One panel above another needs room for the titles of both axes.
        var stacked = figure.layout.yaxis2 && !figure.layout.yaxis2.overlaying;
        figure.layout.height = Math.min(figure.layout.height, (stacked ? 1 : 0.65) * PAPER);
        told(figure.layout);
        var own = copy(figure.layout);
        // On paper nothing can be switched on.
        figure.data = figure.data.filter(function (trace) { return trace.visible !== "legendonly"; });
        grouped(figure.data);
        document.body.appendChild(plot);
        return Plotly.newPlot(plot, figure.data, figure.layout, { staticPlot: true })
          .then(function () { return fit(plot, own, PAPER); })
          .then(function () {
            var size = { width: PAPER, height: plot._fullLayout.height };
            return Plotly.toImage(plot, Object.assign({ format: "svg" }, size)).then(function (source) {
              var given = { class: "for-paper", src: source, alt: holder.getAttribute("data-label") };
              holder.parentNode.insertBefore(element("img", Object.assign(given, size)), holder);
              holder.parentNode.classList.replace("only-interactive", "awaited");
            });
          })
          .finally(function () {
            Plotly.purge(plot);
            plot.remove();
          });
      })
      .catch(function () {});
  }

  /* One after the other, each when the browser has time; then the page says that it can be printed. */
  function stills(holders) {
    if (!holders.length) {
      document.documentElement.setAttribute("data-printable", "");
      return;
    }
    (window.requestIdleCallback || window.setTimeout)(function () {
      still(holders[0]).then(function () { stills(holders.slice(1)); });
    });
  }

  document.head.appendChild(element("style", {}, STYLE));
  // For pages that get plots later.
  window.drawInteractivePlot = attempt;
  document.querySelectorAll("img[data-packed]").forEach(function (still) {
    content(still.getAttribute("data-packed")).then(function (text) {
      still.src = "data:image/svg+xml," + encodeURIComponent(text);
    }, function () {});
  });
  var seen = new IntersectionObserver(
    function (entries) {
      entries.forEach(function (entry) {
        if (entry.isIntersecting) {
          seen.unobserve(entry.target);
          attempt(entry.target.querySelector(".interactive"));
        }
      });
    },
    { rootMargin: "300px 0px" }
  );
  document.querySelectorAll(".interactive[data-plot]").forEach(function (holder) {
    // The figure is observed: what is hidden never comes near the screen.
    seen.observe(holder.parentNode);
    if (holder.getAttribute("data-room")) {
      holder.parentNode.style.setProperty("--room", holder.getAttribute("data-room") + "px");
    }
  });
  stills(Array.from(document.querySelectorAll(".only-interactive > .interactive[data-plot]")));
})();

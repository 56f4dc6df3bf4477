// The page itself: figures, folded sections, light and dark, printing, explanations.
//
// For the scripts of sections:
//   grainfitData(key)               data of the section of that key, or null
//   grainfitFigure(key)             a figure as the section gave it: {data, layout}, or null
//   grainfitDraw(element, figure)   draw {data, layout} there in the page's theme, again if need be
//   grainfitTheme()                 colours of now by the names of the CSS variables
//   grainfitPlotly()                Plotly, loaded when it is first needed
//   grainfitWhenSeen(element, draw) call draw(element) once, when no fold hides the element
//   grainfitScrolls(element)        let the keyboard reach what scrolls in an element
//   event "grainfit:drawn"          on an element whose figure was drawn for the first time (bubbles)
//   event "grainfit:theme"          on the document, when the colours have changed
(() => {
  "use strict";

  const root = document.documentElement;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const touch = matchMedia("(pointer: coarse)");
  // After Okabe & Ito: distinct in any kind of colour blindness, on light and on dark paper.
  const COLOURS = [
    "#1f83c4", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999", "#f0e442",
  ];
  const VARIABLES = [
    "ink", "quiet-ink", "paper", "card", "line", "accent", "good", "warn", "bad",
  ];

  const known = new Map();
  const json = (id) => {
    if (!known.has(id)) {
      const element = document.getElementById(id);
      known.set(id, element ? JSON.parse(element.textContent) : null);
    }
    return known.get(id);
  };
  window.grainfitData = (key) => json(`data-${key}`);
  window.grainfitFigure = (key) => json(`figure-${key}`);

  const onPaper = () => root.classList.contains("printing");

  window.grainfitTheme = () => {
    const style = getComputedStyle(root);
    return Object.fromEntries(
      VARIABLES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]),
    );
  };

  window.grainfitPlotly = () => {
    if (!window.Plotly) {
      const script = document.createElement("script");
      script.textContent = document.getElementById("plotly-source").textContent;
      document.head.append(script);
    }
    return window.Plotly;
  };

  // --- Figures ---------------------------------------------------------------------------------

  // Settings of the page, by Plotly's paths; they override those of a section's layout.
  const themed = (layout) => {
    const theme = window.grainfitTheme();
    const paths = {
      "font.family": getComputedStyle(document.body).fontFamily,
      "font.size": 13,
      "font.color": theme.ink,
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      "legend.bgcolor": "rgba(0,0,0,0)",
      "hoverlabel.bgcolor": theme.card,
      "hoverlabel.bordercolor": theme.line,
      "hoverlabel.font.color": theme.ink,
      "modebar.bgcolor": "rgba(0,0,0,0)",
      "modebar.color": theme["quiet-ink"],
      "modebar.activecolor": theme.accent,
    };
    const axes = Object.keys(layout).filter((key) => /^[xy]axis\d*$/.test(key));
    const scenes = Object.keys(layout).filter((key) => /^scene\d*$/.test(key));
    for (const scene of scenes) {
      axes.push(`${scene}.xaxis`, `${scene}.yaxis`, `${scene}.zaxis`);
    }
    for (const axis of axes) {
      paths[`${axis}.title.font.size`] = 13;
    paths[`${axis}.gridcolor`] = theme.line;
      paths[`${axis}.zerolinecolor`] = theme.line;
      paths[`${axis}.linecolor`] = theme["quiet-ink"];
      paths[`${axis}.tickcolor`] = theme["quiet-ink"];
    }
    return paths;
  };

  const put = (target, path, value) => {
    const keys = path.split(".");
    const last = keys.pop();
    let place = target;
    for (const key of keys) {
      if (typeof place[key] !== "object" || place[key] === null) {
        place[key] = {};
      }
      place = place[key];
    }
    place[last] = value;
  };

  const wholeLayout = (layout, height) => {
    const whole = structuredClone(layout);
    if (!Object.keys(whole).some((key) => /^(scene|polar|ternary)/.test(key))) {
      whole.xaxis ??= {};
      whole.yaxis ??= {};
    }
    for (const key of Object.keys(whole).filter((name) => /^[xy]axis\d*$/.test(name))) {
      whole[key] = { automargin: true, ticks: "outside", ticklen: 4, ...whole[key] };
    }
    for (const [path, value] of Object.entries(themed(whole))) {
      put(whole, path, value);
    }
    whole.margin = { l: 56, r: 16, t: 28, b: 48, ...whole.margin };
    whole.legend = { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", ...whole.legend };
    whole.colorway ??= COLOURS;
    whole.hovermode ??= "closest";
    whole.uirevision ??= "kept";
    whole.autosize = true;
    whole.height = height;
    if (touch.matches) {
      // A finger on a figure must still scroll the page.
      whole.dragmode = false;
    }
    return whole;
  };

  const CONFIG = {
    responsive: true,
    displaylogo: false,
    // Fingers have gestures, and where nothing hovers the buttons would cover the figure.
    displayModeBar: touch.matches ? false : "hover",
    // Above all the button that sends the figure to Plotly's cloud: the report stays local.
    modeBarButtonsToRemove: [
      "sendChartToCloud", "select2d", "lasso2d", "autoScale2d", "zoomIn2d", "zoomOut2d",
    ],
  };
  const drawn = new Set();
  // On the screen, by element.
  const heights = new Map();

  // On paper, figures are flatter: their width is that of the page.
  const FLATTER = 0.5;
  const FLATTEST = 165;
  const sizeOnPaper = (element) => ({
    width: element.clientWidth,
    height: Math.max(FLATTEST, FLATTER * heights.get(element)),
  });
  // Legend and titles keep their heights on paper: what is left must do for the axes.
  const LEAST_AXES = 150;
  const fitPaper = (element) => {
    const { width, height } = sizeOnPaper(element);
    // As high as on the screen first: in a flat figure, Plotly squeezes what is around the axes.
    const whole = heights.get(element);
    window.Plotly.relayout(element, { width, height: whole });
    const axes = element._fullLayout._size.h;
    window.Plotly.relayout(element, {
      width,
      height: Math.max(height, Math.min(whole, whole - axes + LEAST_AXES)),
    });
  };

  window.grainfitDraw = (element, figure) => {
    const height = figure.height ?? (Number.parseFloat(element.style.minHeight) || 420);
    heights.set(element, height);
    const layout = wholeLayout(figure.layout ?? {}, height);
    if (onPaper() || figure.onPaper) {
      Object.assign(layout, sizeOnPaper(element));
    }
    const done = window
      .grainfitPlotly()
      .react(element, structuredClone(figure.data), layout, CONFIG);
    if (!drawn.has(element)) {
      drawn.add(element);
      element.on("plotly_click", ({ points: [point] }) => {
        const [, number] = /^run (\d+)$/.exec(point.data.meta?.runs?.[point.pointNumber]) ?? [];
        if (number) {
          location.hash = `run-${number}`;
        }
      });
      element.dispatchEvent(new CustomEvent("grainfit:drawn", { bubbles: true }));
    }
    return done;
  };

  const index = json("figure-index") ?? {};
  const places = [...document.querySelectorAll("[data-figure]")];
  for (const place of places) {
    const about = index[place.dataset.figure];
    if (!about) {
      continue;
    }
    place.classList.add("figure");
    place.style.minHeight = `${about.height}px`;
    place.setAttribute("role", "figure");
    place.setAttribute("aria-label", about.description);
  }

  const drawPlace = (place) => {
    const figure = window.grainfitFigure(place.dataset.figure);
    if (figure && !drawn.has(place)) {
      window.grainfitDraw(place, { ...figure, height: index[place.dataset.figure].height });
    }
  };

  // One at a time, from the top, so that the page stays responsive; all, so that a picture of the
  // whole page shows them. What is folded is drawn when it is unfolded.
  const waiting = new Map();
  const next = () => {
    const place = [...waiting.keys()].find((one) => one.checkVisibility());
    if (place) {
      const draw = waiting.get(place);
      waiting.delete(place);
      draw(place);
      setTimeout(next);
    }
  };
  window.grainfitWhenSeen = (place, draw) => {
    waiting.set(place, draw);
  };
  places.forEach((place) => window.grainfitWhenSeen(place, drawPlace));
  addEventListener("load", next);
  document.addEventListener("toggle", next, { capture: true });

  // --- Folded sections: unfolded when a link leads into them -------------------------------------

  const unfold = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const folded = target?.querySelector(":scope > .folded") ?? target?.closest("details");
    if (folded && !folded.open) {
      folded.open = true;
      target.scrollIntoView();
    }
  };
  addEventListener("hashchange", unfold);
  document.addEventListener("click", ({ target }) => {
    if (target instanceof Element && target.closest(`a[href="${CSS.escape(location.hash)}"]`)) {
      unfold();
    }
  });
  unfold();

  // --- Light and dark, and paper ---------------------------------------------------------------

  const repaint = () => {
    for (const element of drawn) {
      window.Plotly.relayout(element, themed(element.layout));
    }
    document.dispatchEvent(new CustomEvent("grainfit:theme"));
  };
  dark.addEventListener("change", repaint);

  let opened = [];
  const prepare = () => {
    // The page as wide as paper, so that figures are drawn as large as they will be.
    root.dataset.theme = "light";
    root.classList.add("printing");
    opened = [...document.querySelectorAll("details[data-print]:not([open])")];
    opened.forEach((details) => {
      details.open = true;
    });
  };
  // Before sections draw what only paper has.
  addEventListener("beforeprint", prepare, { capture: true });
  addEventListener("beforeprint", () => {
    places.forEach(drawPlace);
    repaint();
    for (const element of drawn) {
      if (element.clientWidth) {
        fitPaper(element);
      }
    }
  });
  addEventListener("afterprint", () => {
    delete root.dataset.theme;
    root.classList.remove("printing");
    opened.forEach((details) => {
      details.open = false;
    });
    repaint();
    for (const element of drawn) {
      if (element.isConnected) {
        const height = heights.get(element);
        window.Plotly.relayout(element, { width: null, height, autosize: true });
      } else {
        drawn.delete(element);
        heights.delete(element);
      }
    }
  });

  // --- Contents: where the reader is -----------------------------------------------------------

  const links = new Map(
    [...document.querySelectorAll(".contents a")].map((link) => [link.hash.slice(1), link]),
  );
  const visible = new Set();
  const reader = new IntersectionObserver(
    (entries) => {
      for (const { target, isIntersecting } of entries) {
        isIntersecting ? visible.add(target.id) : visible.delete(target.id);
      }
      const current = [...links.keys()].find((id) => visible.has(id));
      if (current) {
        links.forEach((link, id) => {
          id === current
            ? link.setAttribute("aria-current", "true")
            : link.removeAttribute("aria-current");
        });
      }
    },
    { rootMargin: "-10% 0px -60% 0px" },
  );
  document.querySelectorAll("main > section").forEach((section) => reader.observe(section));

  // --- Explanations: by mouse, keyboard and finger ---------------------------------------------

  const tip = document.createElement("div");
  tip.id = "explanation";
  tip.className = "explanation";
  tip.setAttribute("role", "tooltip");
  tip.hidden = true;
  document.body.append(tip);
  let explained = null;

  const hide = () => {
    explained?.removeAttribute("aria-describedby");
    explained = null;
    tip.hidden = true;
  };
  const explain = (element) => {
    hide();
    explained = element;
    tip.textContent = element.dataset.explanation;
    tip.hidden = false;
    element.setAttribute("aria-describedby", tip.id);
    const place = element.getBoundingClientRect();
    const width = tip.offsetWidth;
    const left = Math.min(Math.max(8, place.left), root.clientWidth - width - 8);
    const below = place.bottom + 6 + tip.offsetHeight < innerHeight;
    tip.style.left = `${left + scrollX}px`;
    tip.style.top = below
      ? `${place.bottom + 6 + scrollY}px`
      : `${place.top - tip.offsetHeight - 6 + scrollY}px`;
  };
  // Elements that a script adds later are explained too: everything is listened to from above.
  const owner = (event) => {
    const found = event.target instanceof Element ? event.target.closest("abbr[title]") : null;
    if (found) {
      // Or the browser would show its own besides.
      found.dataset.explanation = found.title;
      found.removeAttribute("title");
    }
    return event.target instanceof Element
      ? event.target.closest("[data-explanation]") ??
          event.target.closest("button")?.querySelector("[data-explanation], abbr[title]")
      : null;
  };
  const onto = (event) => {
    const element = owner(event);
    if (element) {
      element.dataset.explanation ??= element.title;
      explain(element);
    }
  };
  // The same explanation is a stop of the keyboard once, where it comes first.
  const stops = new Set();
  for (const abbreviation of document.querySelectorAll("abbr[title]")) {
    const { title } = abbreviation;
    if (stops.has(title) || abbreviation.closest("button, a, summary, label, details:not(.folded)")) {
      continue;
    }
    stops.add(title);
    // The meaning of a row's symbol stands beside it.
    if (!abbreviation.closest("th[scope=row]")) {
      abbreviation.tabIndex = 0;
    }
  }
  // One stop of the keyboard for a row of equals; the arrow keys go from one to the next.
  for (const group of document.querySelectorAll("[data-roving]")) {
    const items = () => [...group.querySelectorAll("a, button")];
    items().forEach((item, i) => {
      item.tabIndex = i === 0 ? 0 : -1;
    });
    group.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      const all = items();
      const next = step && all[all.indexOf(document.activeElement) + step];
      if (next) {
        event.preventDefault();
        all.forEach((item) => {
          item.tabIndex = item === next ? 0 : -1;
        });
        next.focus();
      }
    });
  }
  document.addEventListener("pointerover", (event) => {
    if (event.pointerType === "mouse") {
      owner(event) ? onto(event) : hide();
    }
  });
  document.addEventListener("focusin", onto);
  document.addEventListener("focusout", hide);
  document.addEventListener("click", (event) => {
    owner(event) ? onto(event) : hide();
  });
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      hide();
    }
  });

  // --- Wide tables and long lines: stops of the keyboard while they scroll -----------------------

  const SCROLLING = ".table-wrap:not([tabindex]), pre:not([tabindex])";
  const reach = (element) => {
    const scrolls =
      element.scrollWidth > element.clientWidth || element.scrollHeight > element.clientHeight;
    if (!scrolls) {
      ["tabindex", "role", "aria-label"].forEach((name) => element.removeAttribute(name));
      return;
    }
    const caption = element.querySelector("caption")?.textContent;
    const words = caption ?? (element.matches("pre") ? "Text" : "Table");
    element.tabIndex = 0;
    element.setAttribute("role", "group");
    element.setAttribute("aria-label", `${words}, scrolls`);
  };
  const resized = new ResizeObserver((entries) => {
    new Set(entries.map(({ target }) => target.closest("[data-scrolls]"))).forEach(reach);
  });
  window.grainfitScrolls = (part) => {
    for (const element of part.querySelectorAll(SCROLLING)) {
      element.dataset.scrolls = "";
      [element, ...element.children].forEach((one) => resized.observe(one));
      // Its observer reports a moment later, in which the keyboard could not reach it.
      reach(element);
    }
  };
  window.grainfitScrolls(document);
})();

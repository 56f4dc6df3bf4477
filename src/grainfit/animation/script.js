// Plays the frames of a run: by the time of the simulation, at a speed over it.
(() => {
  "use strict";

  const film = window.grainfitData("film");
  const at = (id) => document.getElementById(`film-${id}`);
  const { times, stages } = film;
  const last = times.length - 1;
  const draw = window.grainfitParticles(document.getElementById("film"), film);
  const calm = matchMedia("(prefers-reduced-motion: reduce)");

  // --- One moment ------------------------------------------------------------------------------

  let frame = 0;
  const stageAt = (time) => {
    const begun = stages.filter(({ begin }, i) => i === 0 || begin < time);
    return begun.length - 1;
  };
  const digits = Math.max(0, 2 - Math.floor(Math.log10(times[last] || 1)));
  const show = (wanted) => {
    frame = Math.min(last, Math.max(0, wanted));
    draw.move(
      window.grainfitUnpack(film.frames[frame]),
      film.walls.map(({ places }) => places[frame]),
    );
    const current = stageAt(times[frame]);
    const { name, remark } = stages[current];
    const time = `${times[frame].toFixed(digits)} s`;
    at("time").textContent = time;
    at("stage").textContent = name;
    at("remark").textContent = remark;
    at("frame").value = frame;
    at("frame").setAttribute("aria-valuetext", `${time}, ${name}`);
    [...at("stages").children].forEach((item, i) => {
      i === current ? item.setAttribute("aria-current", "step") : item.removeAttribute("aria-current");
    });
  };

  // --- Playing ---------------------------------------------------------------------------------

  // The usual speed shows the whole run in about this time, s.
  const USUAL = 8;
  const usual = 2 ** Math.round(Math.log2((times[last] || 1) / USUAL));
  const named = (speed) => {
    if (speed === 1) {
      return "real time";
    }
    return speed > 1 ? `${speed} × real time` : `1/${1 / speed} of real time`;
  };
  for (const factor of [1 / 4, 1 / 2, 1, 2, 4]) {
    const option = new Option(named(usual * factor), usual * factor, factor === 1, factor === 1);
    at("speed").append(option);
  }

  let playing = null;
  let time = 0;
  const stop = () => {
    cancelAnimationFrame(playing);
    playing = null;
    at("play").textContent = "Play";
  };
  const play = () => {
    if (frame === last) {
      show(0);
    }
    time = times[frame];
    let before = performance.now();
    const go = (now) => {
      // A page that was in the background does not jump.
      time += Math.min(0.25, (now - before) / 1000) * Number(at("speed").value);
      before = now;
      let next = frame;
      while (next < last && times[next + 1] <= time) {
        next += 1;
      }
      if (next !== frame) {
        show(next);
      }
      if (frame === last) {
        stop();
      } else {
        playing = requestAnimationFrame(go);
      }
    };
    playing = requestAnimationFrame(go);
    at("play").textContent = "Pause";
  };
  const toggle = () => (playing === null ? play() : stop());
  const goTo = (number) => {
    stop();
    show(number);
  };

  // --- Controls --------------------------------------------------------------------------------

  at("frame").max = last;
  at("play").addEventListener("click", toggle);
  at("back").addEventListener("click", () => goTo(frame - 1));
  at("on").addEventListener("click", () => goTo(frame + 1));
  at("frame").addEventListener("input", () => goTo(Number(at("frame").value)));
  [...at("stages").children].forEach((item, i) => {
    const begun = times.findIndex((moment) => moment > stages[i].begin);
    item.querySelector("button").addEventListener("click", () => goTo(i === 0 ? 0 : begun < 0 ? last : begun));
  });
  const keys = {
    " ": toggle,
    ",": () => goTo(frame - 1),
    ".": () => goTo(frame + 1),
    Home: () => goTo(0),
    End: () => goTo(last),
  };
  document.addEventListener("keydown", (event) => {
    const own = event.target instanceof Element && event.target.closest("button, select, input");
    const isTheirs = own && (event.key === " " || own.matches("select"));
    if (keys[event.key] && !isTheirs && !event.ctrlKey && !event.altKey && !event.metaKey) {
      event.preventDefault();
      keys[event.key]();
    }
  });

  show(0);
  if (!calm.matches) {
    play();
  }
})();

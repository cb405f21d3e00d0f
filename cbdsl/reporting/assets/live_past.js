// Earlier states of the episode, which the page has kept, and the return of the run to one of them.
const MOST_FRAMES = 8000;

function makePast(askFor, refused, draw) {
  let frames = [], chosen = null;
  const slider = byId("past"), back = byId("back"), now = byId("to-now");
  back.disabled = true;

  function show() {
    slider.max = Math.max(frames.length - 1, 0);
    if (chosen === null) slider.value = slider.max;
    const time = chosen === null ? "" : `${frames[chosen].time.toFixed(2)} s, earlier`;
    byId("past-time").textContent = time;
    now.hidden = chosen === null;
    back.disabled = chosen === null || "back" in refused;
    back.title = refused.back ?? "Run this seed again up to the shown state, and pause there";
    document.body.classList.toggle("earlier", chosen !== null);
  }

  slider.addEventListener("input", () => {
    const index = Number(slider.value);
    chosen = index < frames.length - 1 ? index : null;
    show();
    if (frames.length) draw(frames[index]);
  });
  now.addEventListener("click", () => {
    chosen = null;
    show();
    draw(frames.at(-1));
  });
  back.addEventListener("click", () => askFor({ do: "back", time: frames[chosen].time }));

  return {
    get isShown() {
      return chosen !== null;
    },
    clear() {
      frames = [];
      chosen = null;
      show();
    },
    add(frame) {
      frames.push(frame);
      if (frames.length > MOST_FRAMES && chosen === null) frames = frames.filter((_, index) => index % 2);
      show();
    },
  };
}

const FRAME = 1 / 30;
const SECOND = 1;

/** Play, scrub, speed, and the same from the keyboard. */
export class TimeControls {
  constructor(clock) {
    this.clock = clock;
    this.button = document.getElementById("play");
    this.slider = document.getElementById("time");
    this.reading = document.getElementById("reading");
    this.speed = document.getElementById("speed");
    this.slider.min = clock.start;
    this.slider.max = clock.end;
    this.button.addEventListener("click", () => clock.toggle());
    this.slider.addEventListener("input", () => clock.seek(Number(this.slider.value)));
    this.slider.addEventListener("pointerdown", () => clock.pause());
    this.speed.addEventListener("change", () => (clock.speed = Number(this.speed.value)));
    document.addEventListener("keydown", (event) => this.press(event));
  }

  press(event) {
    const moves = {
      ArrowLeft: event.shiftKey ? -SECOND : -FRAME,
      ArrowRight: event.shiftKey ? SECOND : FRAME,
      Home: -Infinity,
      End: Infinity,
    };
    const elsewhere = event.target !== this.slider && event.target.closest?.("button, input, select");
    if (elsewhere || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === " ") this.clock.toggle();
    else if (event.key in moves) {
      this.clock.pause();
      this.clock.seek(this.clock.time + moves[event.key]);
    } else return;
    event.preventDefault();
  }

  show({ time, end, playing }) {
    const text = playing ? "Pause" : "Play";
    if (this.button.textContent !== text) this.button.textContent = text;
    this.slider.value = time;
    this.reading.textContent = `${time.toFixed(2)} / ${end.toFixed(2)} s`;
    this.slider.setAttribute("aria-valuetext", `${time.toFixed(2)} s`);
  }
}

/** Check boxes for what is shown, and one choice among skins over the same bones. */
export function addSwitches(world, run) {
  const shown = document.getElementById("shown");
  const toggle = (name, objects) => {
    const box = choice(shown, "checkbox", name, name);
    box.checked = true;
    box.addEventListener("change", () => set(world, objects, box.checked));
  };
  for (const name of run.parts) toggle(name, [world.objects.get(name)]);
  for (const { name, beam, echoes } of world.sensors) {
    toggle(`${name}: beam`, [beam]);
    toggle(`${name}: echoes`, echoes);
  }
  for (const group of run.skins) {
    if (group.length === 1) toggle(group[0].name, [world.objects.get(group[0].name)]);
    else addMethods(world, group);
  }
  toggle("grid", [world.grid]);
}

function addMethods(world, group) {
  const place = document.getElementById("methods");
  const field = place.appendChild(document.createElement("fieldset"));
  field.appendChild(document.createElement("legend")).textContent = "Skin";
  const meshes = group.map(({ name }) => world.objects.get(name));
  const choose = (chosen) => meshes.forEach((mesh, k) => set(world, [mesh], k === chosen));
  group.forEach(({ name, method }, k) => {
    const button = choice(field, "radio", name, method.replaceAll("_", " "), group[0].name);
    button.checked = k === group.length - 1;
    button.addEventListener("change", () => choose(k));
  });
  choose(group.length - 1);
}

function choice(place, type, value, text, name = "") {
  const row = place.appendChild(document.createElement("label"));
  const input = row.appendChild(document.createElement("input"));
  Object.assign(input, { type, value, name });
  row.append(text);
  return input;
}

/** Shows or hides things, but not what hangs on them: by their layer, of which the camera sees number 0. */
function set(world, objects, visible) {
  for (const object of objects) object.layers.set(visible ? 0 : 1);
  world.draw();
}

/** Which part the camera goes along with, and the way back to where it was. */
export function addView(world, run) {
  const select = document.getElementById("follow");
  for (const name of run.parts) select.append(new Option(name, name));
  select.addEventListener("change", () => world.follow(select.value || null));
  document.getElementById("reset").addEventListener("click", () => world.resetView());
  document.getElementById("scale").textContent = `grid ${world.cell < 1 ? world.cell.toPrecision(1) : world.cell} m`;
}

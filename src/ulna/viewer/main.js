import { Clock } from "./clock.js";
import { addSwitches, addView, TimeControls } from "./controls.js";
import { bytes, read } from "./data.js";
import { Plots } from "./plots.js";
import { Sensor } from "./sensor.js";
import { World } from "./world.js";

const run = read("run");
const clock = new Clock(run.start, run.end);
const controls = new TimeControls(clock);
const plots = new Plots(document.getElementById("plots"), run.panels, clock);
clock.listeners.push(() => controls.show(clock), () => plots.show(clock.time));

/** For the browser's console: `ulna.clock.seek(1.5)`, `(await ulna.world).vertices("arm")`. */
window.ulna = { run, clock, world: addWorld() };

clock.tell();
if (!matchMedia("(prefers-reduced-motion: reduce)").matches) clock.play();

async function addWorld() {
  try {
    const glb = bytes(document.getElementById("glb").textContent);
    const world = await World.load(document.getElementById("canvas"), glb, run.start);
    world.sensors = run.sensors.map((sensor) => new Sensor(world, sensor));
    addSwitches(world, run);
    addView(world, run);
    clock.listeners.push(() => world.show(clock.time));
    clock.tell();
    return world;
  } catch (error) {
    const message = document.getElementById("message");
    message.textContent = `No 3-D view: ${error.message}. It needs WebGL 2; the plots do not.`;
    message.hidden = false;
    throw error;
  }
}

import {
  BufferAttribute,
  BufferGeometry,
  CylinderGeometry,
  DoubleSide,
  InstancedMesh,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  SphereGeometry,
  Vector3,
} from "three";
import { color, lastBefore, numbers } from "./data.js";

const SIDES = 64;
const TRAIL = 16;
const COLUMNS = 8;
const UP = new Vector3(0, 1, 0);

/** What a sensor does not show by itself: its beam, and how far away the last echoes came from. */
export class Sensor {
  constructor(world, data) {
    this.name = data.name;
    this.pings = numbers(data.pings);
    this.count = this.pings.length / COLUMNS;
    const size = world.radius();
    this.beam = beam(data.half_angle, data.range);
    world.objects.get(data.name).add(this.beam);
    this.ray = new Mesh(new CylinderGeometry(0.002 * size, 0.002 * size, 1, 8), new MeshBasicMaterial());
    this.trail = new InstancedMesh(new SphereGeometry(0.009 * size, 16, 12), new MeshBasicMaterial(), TRAIL);
    this.trail.frustumCulled = false;
    this.echoes = [this.ray, this.trail];
    world.upright.add(...this.echoes);
  }

  /** The last ping that was finished at a time; undefined before the first. */
  ping(time) {
    const last = lastBefore(time, this.count, (k) => this.pings[k * COLUMNS]);
    return last < 0 ? undefined : this.row(last);
  }

  row(index) {
    const [time, heard, ...ends] = this.pings.subarray(index * COLUMNS, (index + 1) * COLUMNS);
    return { index, time, heard: heard > 0, from: new Vector3(...ends), to: new Vector3(...ends.slice(3)) };
  }

  show(time) {
    const ping = this.ping(time);
    this.beam.material.color.set(color("--beam"));
    this.ray.scale.setScalar(0);
    if (ping) {
      const way = ping.to.clone().sub(ping.from);
      this.ray.position.copy(ping.from).addScaledVector(way, 0.5);
      this.ray.quaternion.setFromUnitVectors(UP, way.clone().normalize());
      this.ray.scale.set(1, way.length(), 1);
      this.ray.material.color.set(color(ping.heard ? "--heard" : "--silent"));
    }
    this.trail.material.color.set(color("--heard"));
    for (let age = 0; age < TRAIL; age++) {
      const old = ping && ping.index >= age ? this.row(ping.index - age) : undefined;
      const size = old?.heard ? 1 - age / TRAIL : 0;
      const place = old?.to ?? new Vector3();
      this.trail.setMatrixAt(age, new Matrix4().makeScale(size, size, size).setPosition(place));
    }
    this.trail.instanceMatrix.needsUpdate = true;
  }
}

/** A cone about +x that fades out with the distance. */
function beam(halfAngle, range) {
  const points = [0, 0, 0];
  const shades = [1, 1, 1, 0.32];
  const faces = [];
  for (let side = 0; side < SIDES; side++) {
    const around = (2 * Math.PI * side) / SIDES;
    const radius = range * Math.sin(halfAngle);
    points.push(range * Math.cos(halfAngle), radius * Math.cos(around), radius * Math.sin(around));
    shades.push(1, 1, 1, 0);
    faces.push(0, 1 + side, 1 + ((side + 1) % SIDES));
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  geometry.setAttribute("color", new BufferAttribute(new Float32Array(shades), 4));
  geometry.setIndex(faces);
  const material = new MeshBasicMaterial({
    transparent: true,
    vertexColors: true,
    depthWrite: false,
    side: DoubleSide,
  });
  return new Mesh(geometry, material);
}

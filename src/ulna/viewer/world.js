import {
  AnimationMixer,
  Box3,
  DirectionalLight,
  GridHelper,
  HemisphereLight,
  Mesh,
  PerspectiveCamera,
  PlaneGeometry,
  Scene,
  ShadowMaterial,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { color } from "./data.js";

const FIELD_OF_VIEW = 32;
/** Towards the viewer: from the side, a little above and aside; y is up. */
const VIEWER = new Vector3(0.28, 0.3, 1).normalize();
const SAMPLES = 25;
/** Share of the time. */
const SELDOM = 0.15;

/** The 3-D scene: what the glTF file holds, at a time. */
export class World {
  scene = new Scene();
  camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
  followed = null;
  sensors = [];

  static async load(canvas, glb, start) {
    return new World(canvas, await new GLTFLoader().parseAsync(glb.buffer, ""), start);
  }

  constructor(canvas, gltf, start) {
    this.start = start;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.shadowMap.enabled = true;
    this.scene.add(gltf.scene);
    this.objects = new Map();
    gltf.scene.traverse((object) => {
      this.objects.set(object.userData.name ?? object.name, object);
      object.castShadow = object.isMesh === true;
      // the bounds of a skin are those at rest
      if (object.isSkinnedMesh) object.frustumCulled = false;
    });
    this.upright = this.objects.get("world, z up");
    this.mixer = new AnimationMixer(gltf.scene);
    this.actions = gltf.animations.map((clip) => this.mixer.clipAction(clip).play());
    const boxes = this.boxesOfMotion();
    this.bounds = boxes.reduce((all, box) => all.union(box), boxes[0].clone());
    this.usualBounds = usual(boxes);
    this.addLightAndGround();
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.controls.addEventListener("start", () => (this.turned = true));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.fitCanvas()).observe(canvas.parentElement);
    this.fitCanvas();
  }

  /** Moves everything to a time of the run, s. */
  show(time) {
    // set, not advanced: an action that reaches its end would stop
    for (const action of this.actions) action.time = time - this.start;
    this.mixer.update(0);
    this.scene.updateMatrixWorld(true);
    for (const sensor of this.sensors) sensor.show(time);
    if (this.followed) this.keepInView(this.followed);
    this.draw();
  }

  /** Draws once before the next frame, however often it is asked. */
  draw() {
    this.frame ??= requestAnimationFrame(() => {
      this.frame = undefined;
      this.grid.material.color.set(color("--grid"));
      this.renderer.render(this.scene, this.camera);
    });
  }

  /** The camera goes along with a part from now on; with null it stays. */
  follow(name) {
    this.followed = name === null ? null : { object: this.objects.get(name) };
    if (this.followed) this.followed.place = this.followed.object.getWorldPosition(new Vector3());
  }

  keepInView(followed) {
    const place = followed.object.getWorldPosition(new Vector3());
    const move = place.clone().sub(followed.place);
    followed.place = place;
    this.camera.position.add(move);
    this.controls.target.add(move);
    this.controls.update();
  }

  /** As near as shows most of the motion. */
  resetView() {
    this.turned = false;
    const center = this.usualBounds.getCenter(new Vector3());
    const right = new Vector3(0, 1, 0).cross(VIEWER).normalize();
    const up = VIEWER.clone().cross(right);
    const vertical = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const horizontal = vertical * this.camera.aspect;
    const distances = corners(this.usualBounds).map((corner) => {
      const from = corner.sub(center);
      const aside = Math.max(Math.abs(from.dot(right)) / horizontal, Math.abs(from.dot(up)) / vertical);
      return aside + from.dot(VIEWER);
    });
    const distance = 1.06 * Math.max(...distances);
    this.camera.near = distance / 100;
    this.camera.far = distance * 30;
    this.camera.updateProjectionMatrix();
    this.camera.position.copy(center).addScaledVector(VIEWER, distance);
    this.controls.target.copy(center);
    this.controls.update();
    if (this.followed) this.followed.place = this.followed.object.getWorldPosition(new Vector3());
    this.draw();
  }

  fitCanvas() {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    // a view that somebody chose stays
    if (!this.turned) this.resetView();
    this.draw();
  }

  /** The bounds of everything that is drawn, at some times. */
  boxesOfMotion() {
    const duration = Math.max(0, ...this.actions.map((action) => action.getClip().duration));
    const meshes = [...this.objects.values()].filter((object) => object.isMesh);
    return Array.from({ length: SAMPLES }, (_, sample) => {
      for (const action of this.actions) action.time = (duration * sample) / (SAMPLES - 1);
      this.mixer.update(0);
      this.scene.updateMatrixWorld(true);
      const box = new Box3();
      for (const mesh of meshes) expand(box, mesh);
      return box.isEmpty() ? box.setFromCenterAndSize(new Vector3(), new Vector3(1, 1, 1)) : box;
    });
  }

  /** Half of the length of the motion's bounds, m. */
  radius() {
    return this.bounds.getSize(new Vector3()).length() / 2;
  }

  addLightAndGround() {
    const center = this.bounds.getCenter(new Vector3());
    const radius = this.radius();
    const sun = new DirectionalLight(0xffffff, 2);
    sun.position.copy(center).add(new Vector3(0.35, 1, 0.55).normalize().multiplyScalar(3 * radius));
    sun.target.position.copy(center);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    const view = sun.shadow.camera;
    [view.left, view.right, view.bottom, view.top] = [-radius, radius, -radius, radius].map((side) => 1.2 * side);
    [view.near, view.far] = [radius, 6 * radius];
    this.scene.add(sun, sun.target, new HemisphereLight(0xffffff, 0x70757d, 1.1));

    // cells of a power of ten, a few dozen of them
    this.cell = 10 ** Math.floor(Math.log10(radius / 2));
    const cells = 2 * Math.ceil((1.6 * radius) / this.cell);
    this.grid = new GridHelper(cells * this.cell, cells, 0xffffff, 0xffffff);
    const shadow = new Mesh(
      new PlaneGeometry(cells * this.cell, cells * this.cell).rotateX(-Math.PI / 2),
      new ShadowMaterial({ opacity: 0.22 }),
    );
    shadow.receiveShadow = true;
    const ground = this.bounds.min.y - 0.02 * radius;
    const onGrid = (x) => Math.round(x / this.cell) * this.cell;
    for (const flat of [this.grid, shadow]) flat.position.set(onGrid(center.x), ground, onGrid(center.z));
    shadow.position.y -= 0.002 * radius;
    this.scene.add(this.grid, shadow);
  }

  /** Positions of a mesh's vertices as they are shown, in the world with z up, m: x, y, z, x, y, z... */
  vertices(name) {
    const mesh = this.objects.get(name);
    const place = new Vector3();
    return Array.from({ length: mesh.geometry.attributes.position.count }, (_, index) => {
      mesh.getVertexPosition(index, place).applyMatrix4(mesh.matrixWorld);
      return [place.x, -place.z, place.y];
    }).flat();
  }

  /** Pose of a part as it is shown, in the world with z up: 4 x 4, by columns. */
  pose(name) {
    const toUpright = this.upright.matrixWorld.clone().invert();
    return toUpright.multiply(this.objects.get(name).matrixWorld).toArray();
  }
}

function corners({ min, max }) {
  return Array.from({ length: 8 }, (_, k) => new Vector3(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z));
}

/** The bounds that the motion leaves seldom: a thing that comes from afar makes all else small. */
function usual(boxes) {
  const nth = (values, share) => values.sort((a, b) => a - b)[Math.round(share * (values.length - 1))];
  const side = (end, share) => new Vector3(...["x", "y", "z"].map((axis) => nth(boxes.map((box) => box[end][axis]), share)));
  return new Box3(side("min", SELDOM), side("max", 1 - SELDOM));
}

/** Takes a mesh into a box; of a skin a few hundred vertices, which is near enough. */
function expand(bounds, mesh) {
  const place = new Vector3();
  if (!mesh.isSkinnedMesh) {
    mesh.geometry.computeBoundingBox();
    for (const corner of corners(mesh.geometry.boundingBox)) bounds.expandByPoint(corner.applyMatrix4(mesh.matrixWorld));
    return;
  }
  const count = mesh.geometry.attributes.position.count;
  for (let index = 0; index < count; index += Math.ceil(count / 256)) {
    bounds.expandByPoint(mesh.getVertexPosition(index, place).applyMatrix4(mesh.matrixWorld));
  }
}

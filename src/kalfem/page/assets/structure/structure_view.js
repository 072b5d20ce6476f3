// SPDX-License-Identifier: Apache-2.0
// A structure on the page: it turns, takes the shapes of its modes and plays its motions. It is drawn only when something
// has changed or moves, and only while it is on the screen.

import {AmbientLight, DirectionalLight, Scene, WebGLRenderer} from "three";
import {isPrinting, make, prefersDark, prefersStill} from "../dom.js";
import {count} from "../tally.js";
import {colorByLength} from "./color_scale.js";
import {Controls, amplitudes, speeds} from "./controls.js";
import {Field} from "./field.js";
import {Key} from "./key.js";
import {Marks} from "./marks.js";
import {OrbitCamera} from "./orbit_camera.js";
import {unpackedStructure} from "./structure_data.js";
import {StructureMesh} from "./structure_mesh.js";

const hint = "Drag to turn, Shift and drag to move, wheel or pinch to zoom. With the keyboard: arrows turn, with Shift " +
             "they move, + and \u2212 zoom, 0 returns, the space bar plays.";

const mostEdgesAtFirst = 6000;  // of elements; more would cover the colours

export class StructureView {
  constructor(room, scene, title) {
    this.renderer = new WebGLRenderer({antialias: true, alpha: true});
    this.structure = unpackedStructure(scene);
    this.fields = scene.fields.map(field => new Field(field));
    this.mesh = new StructureMesh(this.structure, scene.lines);
    const showsEdges = this.structure.edges.length < 2 * mostEdgesAtFirst;
    this.mesh.setEdges(showsEdges);
    this.marks = new Marks(scene.marks);
    this.key = new Key(scene.regions, scene.marks);
    this.controls = new Controls(this.fields, showsEdges, this.actions());
    this.displacement = new Float32Array(this.structure.places.length);
    Object.assign(this, {field: null, time: 0, playing: false, speed: speeds["1/4 speed"], amplitude: amplitudes.value,
                         onScreen: true});
    const description = `${title}. ${this.fields.map(field => field.name).join("; ")}. ${hint}`;
    this.stage = make("div", {class: "stage", tabindex: "0", role: "application", "aria-roledescription": "structure",
                              "aria-label": description, title: hint},
                      this.renderer.domElement, this.marks.node);
    room.replaceChildren(this.controls.node, this.stage, this.key.node);
    this.buildScene();
    this.orbit = new OrbitCamera(this.structure, () => this.request());
    this.listen();
    this.fit();
    if (isPrinting()) this.replaceByPicture();
  }

  buildScene() {
    this.scene = new Scene();
    this.light = new DirectionalLight("white", 2.2);
    this.scene.add(this.mesh.group, new AmbientLight("white", 1.6), this.light, this.light.target);
  }

  actions() {
    return {
      shape: index => this.show(this.fields[index] || null),
      play: () => this.setPlaying(!this.playing),
      time: time => { this.setPlaying(false); this.setTime(time); },
      speed: speed => { this.speed = speed; },
      amplitude: amplitude => { this.amplitude = amplitude; this.deform(); },
      edges: shown => { this.mesh.setEdges(shown); this.request(); },
      names: shown => this.marks.showNames(shown),
      fit: () => this.orbit.fit(),
    };
  }

  listen() {
    this.orbit.listen(this.stage);
    this.stage.addEventListener("keydown", event => {
      if (event.key !== " " || !this.field) return;
      event.preventDefault();
      this.setPlaying(!this.playing);
    });
    new ResizeObserver(() => { if (!isPrinting()) this.fit(); }).observe(this.stage);
    new IntersectionObserver(([entry]) => { this.onScreen = entry.isIntersecting; this.request(); }).observe(this.stage);
    prefersDark.addEventListener("change", () => { this.mesh.takePageColors(); this.request(); });
    addEventListener("beforeprint", () => this.replaceByPicture());
    addEventListener("afterprint", () => { this.picture.remove(); this.mesh.takePageColors(); this.request(); });
  }

  // ---- shape and time

  // Takes the shape of a mode or a motion, null for none.
  show(field) {
    this.field = field;
    this.controls.showFor(field);
    this.marks.showMeasured(Boolean(field?.isMeasured));
    this.setPlaying(Boolean(field) && !prefersStill.matches);
    this.setTime(field ? field.stillAt : 0);
    this.deform();
  }

  setPlaying(playing) {
    this.playing = playing;
    this.before = null;
    this.controls.showPlaying(playing);
    this.request();
  }

  setTime(time) {
    this.time = time;
    this.controls.showTime(time);
    this.deform();
  }

  advance(now) {
    const {begin, end, isMode} = this.field;
    const elapsed = this.before === null ? 0 : (now - this.before) / 1000 * (isMode ? 1 : this.speed);
    this.before = now;
    this.setTime(this.time + elapsed < end ? this.time + elapsed : begin);
  }

  // A mode keeps the colours of its shape; those of a motion follow it.
  deform() {
    this.request();
    const {field, displacement} = this;
    if (!field) { this.key.showFor(null); return this.mesh.showUndeformed(); }
    const enlarged = this.amplitude * this.structure.size / field.peak;
    this.key.showFor(field, enlarged);
    const coordinates = field.coordinatesAt(this.time);
    field.displacement(field.isMode ? [1] : coordinates, displacement);
    this.mesh.showDisplaced(displacement, enlarged * (field.isMode ? coordinates[0] : 1),
                            colors => colorByLength(displacement, field.peak, colors), field.isMeasured);
  }

  // ---- drawing

  fit() {
    const {clientWidth: width, clientHeight: height} = this.stage;
    if (!width) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.orbit.setAspect(width / height);
  }

  request() {
    if (!this.onScreen || this.requested) return;
    this.requested = requestAnimationFrame(now => {
      this.requested = null;
      if (this.playing) this.advance(now);
      this.draw();
      if (this.playing) this.request();
    });
  }

  draw() {
    const {camera} = this.orbit;
    this.light.position.copy(camera.position);
    this.light.target.position.copy(this.orbit.target);
    this.renderer.render(this.scene, camera);
    this.marks.update(this.mesh.places.array, camera);
    if (this.counted) return;
    this.counted = true;
    count("scenes");
  }

  // A canvas of WebGL may print empty, so paper gets a picture of it, in the colours of paper.
  replaceByPicture() {
    this.mesh.takePageColors();
    this.draw();
    this.picture = make("img", {class: "printed", src: this.renderer.domElement.toDataURL(), alt: ""});
    this.renderer.domElement.after(this.picture);
  }
}

// SPDX-License-Identifier: Apache-2.0
// The structure as objects of three.js. All of them share one list of places, so that they deform together.

import {BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, Group, LineBasicMaterial, LineDashedMaterial,
        LineSegments, Mesh, MeshLambertMaterial} from "three";
import {LineMaterial} from "three/addons/lines/LineMaterial.js";
import {LineSegments2} from "three/addons/lines/LineSegments2.js";
import {LineSegmentsGeometry} from "three/addons/lines/LineSegmentsGeometry.js";
import {cssColor} from "../dom.js";

const beamWidth = 3.5;  // pixels
const dashes = 40;      // across the whole structure

export class StructureMesh {
  constructor(structure, lines) {
    this.resting = structure.places;
    this.places = new BufferAttribute(structure.places.slice(), 3).setUsage(DynamicDrawUsage);
    this.colors = new BufferAttribute(new Float32Array(structure.places.length), 3).setUsage(DynamicDrawUsage);
    this.group = new Group();
    this.addFaces(structure);
    this.beams = structure.regions.map(({colour}, region) => this.addBeams(structure.beamsByRegion[region], colour));
    this.measured = this.addBeams(lines.filter(line => line.measured).flatMap(line => line.places), "white");
    this.edges = this.addLines(structure.edges, new LineBasicMaterial({transparent: true}));
    this.creases = this.addLines(structure.creases, new LineBasicMaterial({transparent: true}));
    this.links = this.addLines(endsOf(lines, false), new LineBasicMaterial({transparent: true}));
    this.connectors = this.addDashed(endsOf(lines, true), structure.size / dashes);
    this.outline = this.addLines([...structure.creases, ...structure.beamsByRegion.flat()],
                                 new LineBasicMaterial({transparent: true}), new BufferAttribute(this.resting, 3));
    this.takePageColors();
    this.showUndeformed();
  }

  addFaces({trianglesByRegion, regions}) {
    const geometry = this.geometry(trianglesByRegion.flat());
    geometry.setAttribute("color", this.colors);
    let start = 0;
    trianglesByRegion.forEach((corners, region) => {
      geometry.addGroup(start, corners.length, region);
      start += corners.length;
    });
    const material = more => new MeshLambertMaterial({side: DoubleSide, flatShading: true, polygonOffset: true,
                                                      polygonOffsetFactor: 1, polygonOffsetUnits: 1, ...more});
    this.byRegion = regions.map(({colour}) => material({color: colour}));
    this.byDisplacement = material({vertexColors: true});
    this.faces = this.add(new Mesh(geometry, this.byRegion));
  }

  // Lines of some width, which have lists of their own to keep.
  addBeams(ends, color) {
    const material = new LineMaterial({linewidth: beamWidth, color});
    const object = new LineSegments2(new LineSegmentsGeometry(), material);
    object.geometry.setPositions(new Float32Array(3 * ends.length));
    object.geometry.setColors(new Float32Array(3 * ends.length));
    object.visible = ends.length > 0;
    return {ends, object: this.add(object), material, color};
  }

  addLines(ends, material, places = this.places) {
    return this.add(new LineSegments(this.geometry(ends, places), material));
  }

  // Dashes need lengths along each line, so the ends are copied.
  addDashed(ends, length) {
    const places = new BufferAttribute(new Float32Array(3 * ends.length), 3);
    const geometry = new BufferGeometry().setAttribute("position", places);
    const material = new LineDashedMaterial({dashSize: 0.6 * length, gapSize: 0.4 * length});
    return Object.assign(this.add(new LineSegments(geometry, material)), {ends, visible: ends.length > 0});
  }

  geometry(indices, places = this.places) {
    return new BufferGeometry().setAttribute("position", places).setIndex(indices);
  }

  // Objects that deform leave the box that three.js would take them to fill.
  add(object) {
    object.frustumCulled = false;
    this.group.add(object);
    return object;
  }

  takePageColors() {
    const ink = cssColor("--text");
    for (const {material} of [this.edges, this.creases, this.links]) material.color.set(ink);
    this.edges.material.opacity = 0.22;
    this.creases.material.opacity = 0.55;
    this.links.material.opacity = 0.35;
    this.connectors.material.color.set(cssColor("--initial"));
    this.measured.material.color.set(cssColor("--predicted"));
    this.outline.material.color.set(cssColor("--muted"));
    this.outline.material.opacity = 0.45;
  }

  setEdges(shown) { this.edges.visible = shown; }

  // At rest, a colour for each region.
  showUndeformed() {
    this.places.array.set(this.resting);
    this.faces.material = this.byRegion;
    this.outline.visible = false;
    this.measured.object.visible = false;
    this.update();
    for (const {material, color} of this.beams) {
      material.vertexColors = false;
      material.color.set(color);
      material.needsUpdate = true;
    }
  }

  // Displaced and coloured; the outline stays where it was.
  showDisplaced(displacement, factor, paint, measured) {
    const {array} = this.places;
    for (let k = 0; k < array.length; ++k) array[k] = this.resting[k] + factor * displacement[k];
    paint(this.colors.array);
    this.colors.needsUpdate = true;
    this.faces.material = this.byDisplacement;
    this.outline.visible = true;
    this.measured.object.visible = measured;
    this.update();
    for (const {object, material, ends} of this.beams) {
      copyRows(this.colors.array, ends, object.geometry.attributes.instanceColorStart.data);
      if (material.vertexColors) continue;
      material.vertexColors = true;
      material.color.set("white");
      material.needsUpdate = true;
    }
  }

  update() {
    this.places.needsUpdate = true;
    for (const {object, ends} of [...this.beams, this.measured])
      copyRows(this.places.array, ends, object.geometry.attributes.instanceStart.data);
    copyRows(this.places.array, this.connectors.ends, this.connectors.geometry.attributes.position);
    this.connectors.computeLineDistances();
  }
}

const endsOf = (lines, dashed) => lines.filter(line => line.dashed === dashed && !line.measured).flatMap(line => line.places);

function copyRows(from, rows, to) {
  rows.forEach((row, i) => {
    for (let k = 0; k < 3; ++k) to.array[3 * i + k] = from[3 * row + k];
  });
  to.needsUpdate = true;
}

// SPDX-License-Identifier: Apache-2.0
// A scene as the page's JSON holds it, unpacked: places, triangles by region, lines, edges.

const creaseCosine = 0.82;  // of the angle above which two faces meet in an edge of the outline

export function unpackedStructure(scene) {
  const places = numbers(Float32Array, scene.places);
  const faces = unpackedFaces(numbers(Int32Array, scene.faces), scene.regions.length);
  const sides = sidesOf(places, faces.flatMap((list, region) => list.filter(face => face.length > 2)
                                                                    .map(corners => ({corners, region}))));
  const trianglesByRegion = faces.map(list => list.flatMap(triangles));
  return {
    places, ...boxOf(places), regions: scene.regions, trianglesByRegion,
    beamsByRegion: faces.map(list => list.filter(face => face.length === 2).flat()),
    edges: sides.flatMap(side => side.ends),
    creases: sides.filter(side => isCrease(side.faces)).flatMap(side => side.ends),
  };
}

// The numbers in a base64 text, as an array of that type.
export function numbers(Type, text) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  return new Type(bytes.buffer);
}

// Centre of the box around all places, and its diagonal.
function boxOf(places) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  places.forEach((value, k) => {
    low[k % 3] = Math.min(low[k % 3], value);
    high[k % 3] = Math.max(high[k % 3], value);
  });
  return {center: low.map((value, i) => (value + high[i]) / 2), size: Math.hypot(...low.map((value, i) => high[i] - value))};
}

// Lists of corners, by region. The packed form is: region, number of corners, corners; face after face.
function unpackedFaces(packed, regions) {
  const faces = Array.from({length: regions}, () => []);
  for (let i = 0; i < packed.length;) {
    const region = packed[i], count = packed[i + 1];
    faces[region].push(Array.from(packed.subarray(i + 2, i + 2 + count)));
    i += 2 + count;
  }
  return faces;
}

const triangles = corners => corners.length < 3 ? []
                           : corners.slice(2).flatMap((corner, i) => [corners[0], corners[i + 1], corner]);

// Every side of a face once, with its ends and the faces that it belongs to.
function sidesOf(places, faces) {
  const sides = new Map(), count = places.length / 3;
  for (const {corners, region} of faces) {
    const face = {region, normal: normalOf(places, corners)};
    corners.forEach((from, i) => {
      const to = corners[(i + 1) % corners.length];
      const key = Math.min(from, to) * count + Math.max(from, to);
      if (!sides.has(key)) sides.set(key, {ends: [from, to], faces: []});
      sides.get(key).faces.push(face);
    });
  }
  return [...sides.values()];
}

function isCrease(faces) {
  if (faces.length !== 2) return true;
  const [{normal: a, region}, {normal: b, region: other}] = faces;
  return region !== other || Math.abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) < creaseCosine;
}

// Of a quadrilateral by its diagonals.
function normalOf(places, corners) {
  const at = (corner, i) => places[3 * corner + i];
  const [a, b, c, d] = corners.length === 4 ? [corners[0], corners[2], corners[1], corners[3]]
                                            : [corners[0], corners[1], corners[0], corners[2]];
  const u = [0, 1, 2].map(i => at(b, i) - at(a, i)), v = [0, 1, 2].map(i => at(d, i) - at(c, i));
  const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...normal) || 1;
  return normal.map(value => value / length);
}
